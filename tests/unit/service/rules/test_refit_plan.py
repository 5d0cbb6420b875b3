"""Plan of a refit: stale consensuses by their digests."""

from dataclasses import fields, replace

import pytest

from calibdb.rules.refit_plan import input_digest, plan_refit, pool_digest
from calibdb.schema import ConsensusDocument
from calibdb.settings import Thresholds
from tests.helpers.service.known import consensus


def stored(pool_digest: str, input_digest: str) -> ConsensusDocument:
    return consensus().model_copy(update={"pooled": pool_digest, "basis": input_digest})


def actions(document: ConsensusDocument | None) -> list[tuple[str, str]]:
    known = {} if document is None else {"rectilinear": document}
    return [(step.model, step.action) for step in plan_refit(["fisheye", "rectilinear"], known, "p", "i")]


def test_a_consensus_of_the_same_inputs_is_kept() -> None:
    assert actions(stored("p", "i")) == [("fisheye", "pool"), ("rectilinear", "keep")]


def test_other_votes_are_recounted_without_pooling() -> None:
    assert actions(stored("p", "earlier votes")) == [("fisheye", "pool"), ("rectilinear", "recount")]


def test_other_calibrations_are_pooled() -> None:
    assert actions(stored("earlier calibrations", "earlier")) == [
        ("fisheye", "pool"),
        ("rectilinear", "pool"),
    ]
    assert actions(None) == [("fisheye", "pool"), ("rectilinear", "pool")]


def test_digest_of_the_default_thresholds_is_the_stored_one() -> None:
    """Computed by version 0.1.0: another value would have every stored consensus computed anew."""
    stored_digest = "7d37097fcc75566ccde668aff701711c92295859ea823e73567a290589173bdc"
    assert pool_digest(3, ["a", "b"], Thresholds(), "1.0.0") == stored_digest


@pytest.mark.parametrize("name", [field.name for field in fields(Thresholds)])
def test_digest_differs_by_each_threshold(name: str) -> None:
    changed = replace(Thresholds(), **{name: getattr(Thresholds(), name) + 1})
    assert pool_digest(3, ["a"], changed, "1") != pool_digest(3, ["a"], Thresholds(), "1")


def test_digests_differ_by_method_calibrations_version_and_votes() -> None:
    rules = Thresholds()
    digests = {
        pool_digest(3, ["a"], rules, "1"),
        pool_digest(4, ["a"], rules, "1"),
        pool_digest(3, ["a", "b"], rules, "1"),
        pool_digest(3, ["a"], rules, "2"),
        input_digest("p", []),
        input_digest("p", ["v"]),
        input_digest("q", ["v"]),
    }
    assert len(digests) == 7
