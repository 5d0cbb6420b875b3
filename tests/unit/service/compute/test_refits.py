"""Refits: stale consensuses by the digests of their inputs."""

from dataclasses import fields, replace
from typing import Any

import pytest

from calibdb.compute import refits
from calibdb.compute.refits import input_digest, pool_digest
from calibdb.settings import Thresholds
from infra.server.server import Server
from tests.helpers.service.known import vote
from tests.helpers.service.published import NOW, asked, calibration, mode_of, publish, store


def test_stale_parts_only_are_computed(monkeypatch: pytest.MonkeyPatch) -> None:
    steps: list[str] = []

    def record(name: str) -> None:
        compute = getattr(refits, name)

        def recorded(*given: Any) -> Any:
            steps.append(name)
            return compute(*given)

        monkeypatch.setattr(refits, name, recorded)

    record("pool")
    record("count")
    made, other = (calibration("Recounted", n) for n in range(2))
    with Server(worker=1) as stack:
        publish(stack, made)
        other_source = {"id": f"{NOW:08x}{'0' * 12}", "source": "elsewhere"}
        store(stack).votes.cast(vote(made, fit=made.fits["rectilinear"], **other_source))
        for _ in range(2):
            recounted = store(stack).refit.now(asked(mode_of(made), "rectilinear")).models["rectilinear"]
            assert recounted is not None
            assert recounted.votes.agree == 1
        assert steps == ["pool", "count", "count"]
        publish(stack, other)
    assert steps[3:] == ["pool", "count"]


def test_digest_of_the_default_thresholds_is_the_stored_one() -> None:
    """Computed by version 0.1.0: another value would have every stored consensus computed anew."""
    stored_digest = "7d37097fcc75566ccde668aff701711c92295859ea823e73567a290589173bdc"
    assert pool_digest(3, ["a", "b"], Thresholds(), "1.0.0") == stored_digest


def test_digests_differ_by_thresholds_method_calibrations_version_and_votes() -> None:
    rules = Thresholds()
    changed = [replace(rules, **{each.name: getattr(rules, each.name) + 1}) for each in fields(Thresholds)]
    digests = {
        pool_digest(3, ["a"], rules, "1"),
        pool_digest(4, ["a"], rules, "1"),
        pool_digest(3, ["a", "b"], rules, "1"),
        pool_digest(3, ["a"], rules, "2"),
        *(pool_digest(3, ["a"], other, "1") for other in changed),
        input_digest("p", []),
        input_digest("p", ["v"]),
        input_digest("q", ["v"]),
    }
    assert len(digests) == 7 + len(changed)
