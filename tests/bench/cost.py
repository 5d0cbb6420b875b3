"""Price of a million lookups and of a finished calibration on AWS: `make cost`.

Calls, durations and sizes are measured on a local stack; what is paid without any request is counted in the
template. Prices, and what cannot be measured here, are in `tests/bench/prices.yaml`.
"""

import json
import math
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import yaml
from botocore.awsrequest import AWSPreparedRequest

from infra.console import track
from infra.deploy.smoke_capture import observe_board
from infra.server.server import DEVELOPMENT_TOKEN
from tests.aws.emulator import LocalStack, intercept
from tests.aws.emulator.storage import Answer
from tests.bench.usage import (
    PRICES,
    Usage,
    firewall,
    fixed_costs,
    price,
    price_at_edge,
    price_preflights,
    read_units,
    write_units,
)

LOOKUPS, CALIBRATION = "a million lookups", "a finished calibration"
ALIAS = "a new label or platform of a known camera"
MAX_USD = {LOOKUPS: 2.0, CALIBRATION: 0.0006, ALIAS: 0.0001}  # USD
MAX_FIXED_USD = 12.0  # USD a month
HIT_RATE = 0.8
"""Share of lookups that the edge has cached, for which the price of a million is stated."""
MAX_EDGE_USD = 1.50
"""USD for a million lookups at that hit rate."""
_CAMERA = {"camera": "Priced camera", "platform": "X11; Linux x86_64", "img_size": [1280, 720]}
_MEASURED_ALIASES = 5
_IDLE_TIMEOUT_S = 120.0  # after which a consensus is surely computed
_READS = {"GetItem", "Query"}
_MB_PER_VCPU = 1769  # MB, AWS Lambda developer guide, "Configure Lambda function memory"


class _Storage(threading.local):
    """Processor seconds that storage took in this thread."""

    seconds = 0.0


class Meter:
    def __init__(self, stack: LocalStack) -> None:
        self._stack = stack
        self.use = Usage()
        self._gb = 0.0
        self._storage = _Storage()

    @contextmanager
    def running(self) -> Iterator[Usage]:
        self.use = Usage()
        functions = dict(self._stack.functions)
        self._stack.functions.update({name: self._wrap_with_timer(f) for name, f in functions.items()})
        try:
            with intercept.wrapping(self._around):
                yield self.use
        finally:
            self._stack.functions.update(functions)

    def ask(self, method: str, path: str, credential: str, body: object = None, query: str = "") -> bytes:
        content = json.dumps(body).encode() if body is not None else b""
        headers = {"authorization": f"Bearer {credential}"}
        answer = self._stack.request(method, path, headers, query, content)
        self.use.requests += 1
        self.use.sent += len(answer.body)
        if answer.status >= 400:
            raise RuntimeError(f"{method} {path}: {answer.status} {answer.body[:200]!r}")
        return answer.body

    def _wrap_with_timer(self, function: Any) -> Any:
        memory = function.spec.memory

        def timed(*arguments: Any) -> Any:
            self._gb = memory / 1024
            begun = time.thread_time() - self._storage.seconds
            try:
                return function(*arguments)
            finally:
                # Lambda gives a part of a processor with a part of its memory, and bills whole milliseconds.
                alone = time.thread_time() - self._storage.seconds - begun
                taken = alone / min(1, memory / _MB_PER_VCPU)
                self.use.gb_seconds += math.ceil(taken * 1e3) / 1e3 * memory / 1024
                if memory >= _MB_PER_VCPU:
                    self.use.solver_memory += memory / 1024
                else:
                    self.use.memory += memory / 1024
                self.use.invocations += 1

        timed.spec = function.spec  # type: ignore[attr-defined]  # as a Function has it
        return timed

    def _around(self, name: str, service: intercept.Service) -> intercept.Service:
        """Count requests to storage, and its time, which passes in this process and not in the function."""

        def handle(operation: str, request: AWSPreparedRequest) -> Answer:
            if name == "lambda":
                return service(operation, request)
            begun = time.thread_time()
            try:
                answer = service(operation, request)
            finally:
                self._storage.seconds += time.thread_time() - begun
            self.use.waits.append((name, self._gb))
            if name == "s3":
                self._count_object(operation, request)
            else:
                self._count_units(operation, json.loads(request.body), answer)
            return answer

        return handle

    def _count_object(self, operation: str, request: AWSPreparedRequest) -> None:
        self.use.gets += operation == "GetObject"
        self.use.puts += operation == "PutObject"
        if operation == "PutObject" and "/calibrations/" in request.url:
            self.use.kept += int(request.headers["X-Amz-Decoded-Content-Length"])  # its checksum is a trailer

    def _count_units(self, operation: str, asked: dict[str, Any], answer: Answer) -> None:
        if operation in _READS:
            consistent = asked.get("ConsistentRead", False)
            self.use.reads += read_units(len(answer.body), consistent=consistent)
            return
        together = "TransactItems" in asked
        for part in [write["Put"] for write in asked["TransactItems"]] if together else [asked]:
            self.use.writes += write_units(len(json.dumps(part.get("Item", {}))), together=together)


def run_capture(meter: Meter, seed: int) -> None:
    """Run one capture as the page does: each pose is asked for as numbers and as a picture."""
    token = DEVELOPMENT_TOKEN
    session = json.loads(meter.ask("POST", "/v1/auth", token))["session_id"]
    meter.ask("POST", "/v1/session", session, {**_CAMERA, "target_error": 1.0})
    index = 0
    for ids, points in observe_board(seed):
        for _ in range(2):
            meter.ask("GET", "/v1/session/pose", session)
        view = {"index": index, "ids": ids, "points": points}
        state = json.loads(meter.ask("POST", "/v1/session/views", session, view))
        if state["status"] == "converged":
            return
        index += state["accepted"]
    raise RuntimeError("a capture did not end")


def measure(lookups: int = 200, pooled: int = 5) -> dict[str, Usage]:
    """Measure lookups that hit, new labels, and the calibration after `pooled`, which make a consensus."""
    with LocalStack({"MIN_CALIBRATIONS": str(pooled)}) as stack:
        meter = Meter(stack)
        with meter.running():
            for seed in track(range(pooled), "captures", pooled):
                run_capture(meter, seed)
            stack.wait_until_idle(_IDLE_TIMEOUT_S)
        with meter.running() as calibration:
            run_capture(meter, pooled)
            stack.wait_until_idle(_IDLE_TIMEOUT_S)
        meter.ask("POST", "/v1/lookup", DEVELOPMENT_TOKEN, _CAMERA)
        stack.wait_until_idle(_IDLE_TIMEOUT_S)  # its label is an alias now
        with meter.running() as lookup:
            for _ in track(range(lookups), "lookups", lookups):
                meter.ask("POST", "/v1/lookup", DEVELOPMENT_TOKEN, _CAMERA)
        with meter.running() as alias:
            for number in range(_MEASURED_ALIASES):
                asked = {**_CAMERA, "platform": f"X11; Linux x86_64; rv:{number}.0"}
                meter.ask("POST", "/v1/lookup", DEVELOPMENT_TOKEN, asked)
                stack.wait_until_idle(_IDLE_TIMEOUT_S)
    return {LOOKUPS: lookup, CALIBRATION: calibration, ALIAS: alias}


def price_of(name: str, use: Usage, prices: Mapping[str, Any]) -> dict[str, float]:
    """Price what `name` stands for, USD by kind of cost."""
    times = {LOOKUPS: 1e6, ALIAS: 1.0}.get(name, use.requests) / use.requests
    parts = {part: times * usd for part, usd in price(use, prices).items()}
    if name == LOOKUPS:
        memory = (use.memory + use.solver_memory) / use.invocations
        parts["preflights"] = price_preflights(1e6, memory, prices)
    return parts


def report(uses: Mapping[str, Usage], prices: Mapping[str, Any], fixed: Mapping[str, float]) -> Iterator[str]:
    for name, use in uses.items():
        parts = price_of(name, use, prices)
        yield f"{name}: {sum(parts.values()):.6f} USD, at most {MAX_USD[name]}"
        for part, usd in parts.items():
            yield f"  {part:28} {usd:.6f}"
        if name == LOOKUPS:
            sent = 1e6 / use.requests * use.sent
            asked, known = price_at_edge(parts, sent, prices)
            enough = max(0.0, (asked - MAX_USD[name]) / (asked - known))
            yield f"  through CloudFront {asked:.2f} where it must ask, {known:.2f} where it has the answer:"
            yield f"  at most {MAX_USD[name]} where it has {math.ceil(100 * enough)} % of them"
    base, wall = sum(fixed.values()), firewall(prices)
    yield f"a month without any request: {base:.2f} USD, at most {MAX_FIXED_USD}"
    yield f"  with the firewall {base + wall:.2f}"
    yield f"  {'firewall (WafRate)':28} {wall:8.2f}"
    for what, usd in fixed.items():
        yield f"  {what:28} {usd:8.2f}"
    yield f"prices of us-east-1, {prices['sources']['month']}; not in it:"
    for left_out in prices["not_in_it"]:
        yield f"  {left_out}"


def main() -> None:
    prices = yaml.safe_load(PRICES.read_text(encoding="utf-8"))
    uses = measure()
    usd = mixed_at_edge(*at_edge(uses[LOOKUPS], prices))
    edge = f"a million lookups at the edge, {HIT_RATE:.0%} cached: {usd:.2f} USD, at most {MAX_EDGE_USD:.2f}"
    print(*report(uses, prices, fixed_costs(prices)), edge, sep="\n")


def mixed_at_edge(forwarded: float, cached: float) -> float:
    """Price a million lookups of which HIT_RATE are cached, USD."""
    return (1 - HIT_RATE) * forwarded + HIT_RATE * cached


def at_edge(lookup: Usage, prices: Mapping[str, Any]) -> tuple[float, float]:
    """Price a million cacheable lookups, which need no preflight, USD: forwarded, and cached."""
    size = lookup.sent / lookup.requests + prices["assumed"]["edge_header_bytes"]
    parts = price_of(LOOKUPS, lookup, prices)
    return price_at_edge({**parts, "preflights": 0.0}, 1e6 * size, prices)


if __name__ == "__main__":
    main()
