"""Refits: stale consensuses by the digests of their inputs."""

from typing import Any

import pytest

from calibdb.compute import refits
from calibdb.schema import VoteDocument
from infra.server.server import Server
from tests.helpers.service.published import NOW, asked, calibration, mode_of, publish, store


def test_other_votes_are_recounted_without_pooling(monkeypatch: pytest.MonkeyPatch) -> None:
    pool, pooled = refits.pool, []

    def counted(mode: Any, documents: Any, *given: Any) -> Any:
        pooled.append(len(documents))
        return pool(mode, documents, *given)

    monkeypatch.setattr(refits, "pool", counted)
    made, other = (calibration("Recounted", n) for n in range(2))
    same = {**dict(made), "id": f"{NOW:08x}{'0' * 12}", "source": "elsewhere"}
    with Server(worker=1) as stack:
        publish(stack, made)
        store(stack).votes.cast(VoteDocument(**same, noise=0.1, fit=made.fits["rectilinear"]))
        for _ in range(2):
            recounted = store(stack).refit.now(asked(mode_of(made), "rectilinear")).models["rectilinear"]
            assert recounted is not None
            assert recounted.votes.agree == 1
        assert pooled == [1]
        publish(stack, other)
    assert pooled == [1, 2]
