"""Plan of a refit: stale consensuses by their digests."""

from calibdb.rules.refit_plan import digest, plan_refit
from calibdb.schema import ConsensusDocument
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


def test_each_step_carries_what_is_stored() -> None:
    document = stored("p", "i")
    known = {"rectilinear": document}
    assert [s.stored for s in plan_refit(["fisheye", "rectilinear"], known, "p", "i")] == [None, document]


def test_digests_differ_by_any_part() -> None:
    assert len({digest(), digest(1), digest("1"), digest(1, 2), digest([1, 2])}) == 5
    assert digest(1, "a") == digest(1, "a")
