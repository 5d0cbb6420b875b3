"""Refits: stale consensuses by the digests of their inputs."""

from typing import Any

import pytest

from calibdb.compute import refits
from calibdb.schema import VoteDocument
from infra.server.server import Server
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
    same = {**dict(made), "id": f"{NOW:08x}{'0' * 12}", "source": "elsewhere"}
    with Server(worker=1) as stack:
        publish(stack, made)
        store(stack).votes.cast(VoteDocument(**same, noise=0.1, fit=made.fits["rectilinear"]))
        for _ in range(2):
            recounted = store(stack).refit.now(asked(mode_of(made), "rectilinear")).models["rectilinear"]
            assert recounted is not None
            assert recounted.votes.agree == 1
        assert steps == ["pool", "count", "count"]
        publish(stack, other)
    assert steps[3:] == ["pool", "count"]
