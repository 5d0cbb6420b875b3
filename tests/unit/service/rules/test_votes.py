"""Votes of checks on fresh views and their limits, and names that most contributors gave."""

import pytest

from calibdb.rules.contributed_name import mode_names
from calibdb.rules.votes import (
    Finding,
    OwnCamera,
    decide_reliability,
    decide_vote,
    is_explained,
    tally,
    vote_id,
    with_votes,
)
from calibdb.schema import CheckRequest, Votes
from calibdb.settings import Thresholds
from tests.helpers.service.known import consensus

NOW = 1_700_000_000
DAY = 86_400
RULE = Thresholds()


def found(*votes: tuple[str, bool], time: int = NOW) -> list[Finding]:
    return [Finding(who, time, agrees) for who, agrees in votes]


def test_views_fit_up_to_twice_their_noise() -> None:
    assert is_explained(0.39, noise=0.2, width=1280, ratio=2)
    assert not is_explained(0.41, noise=0.2, width=1280, ratio=2)
    assert is_explained(0.25, noise=0.01, width=1280, ratio=2)
    assert is_explained(1.1, noise=1.0, width=1280, ratio=2)
    assert not is_explained(1.2, noise=1.0, width=1280, ratio=2)


def test_views_vote_by_their_own_camera() -> None:
    def says(error: float, own: OwnCamera | None, *, same_model: bool = True) -> bool | None:
        return decide_vote(error, 0.2, 1280, 2.0, own, same_model=same_model)

    assert says(0.3, OwnCamera(3.0, 0.5)) is True
    assert says(0.3, OwnCamera(20.0, 0.5)) is False
    assert says(0.3, OwnCamera(20.0, 0.5), same_model=False) is None
    assert says(0.3, OwnCamera(3.0, 9.0)) is None
    assert says(0.3, OwnCamera(float("inf"), 0.5)) is None
    assert says(0.3, None) is None
    assert says(0.9, None) is False


def test_each_contributor_has_one_vote_the_newest() -> None:
    votes = found(("a", True), ("b", True), ("a", False), ("a", False))
    assert tally(votes, NOW, frozenset(), one_per_source=True) == Votes(agree=2, disagree=0)
    assert tally(votes, NOW, frozenset(), one_per_source=False) == Votes(agree=2, disagree=2)


def test_contributors_do_not_vote_on_their_calibrations() -> None:
    votes = found(("a", True), ("b", False), ("c", True))
    assert tally(votes, NOW, frozenset({"a", "b"}), one_per_source=True) == Votes(agree=1, disagree=0)
    assert tally(votes, NOW, frozenset({"a", "b"}), one_per_source=False) == Votes(agree=2, disagree=1)


def test_addresses_of_both_families_count_by_one() -> None:
    """A line of the network has two."""
    votes = found(("a", True), ("v6-a", True), ("b", True), ("v6-c", False))
    assert tally(votes, NOW, frozenset(), one_per_source=True) == Votes(agree=2, disagree=1)


@pytest.mark.parametrize(
    ("reason", "agree", "disagree", "expected"),
    [
        ("too_few", 2, 0, ("too_few", None)),
        ("too_few", 3, 0, (None, "checked")),
        ("too_few", 3, 3, ("disagree", None)),
        ("few_contributors", 3, 0, (None, "checked")),
        (None, 0, 0, (None, "consensus")),
        (None, 9, 2, (None, "consensus")),
        (None, 0, 3, ("disagree", None)),
        (None, 4, 3, (None, "consensus")),
    ],
)
def test_three_confirm_and_three_withdraw(
    reason: str | None, agree: int, disagree: int, expected: tuple[str | None, str | None]
) -> None:
    votes = Votes(agree=agree, disagree=disagree)
    assert decide_reliability(reason, votes, RULE, confirmable=True, contributors=5) == expected


def test_ten_contributors_need_four_votes_to_withdraw() -> None:
    known = consensus()
    widely = known.model_copy(
        update={"calibration": known.calibration.model_copy(update={"contributors": 10})}
    )
    assert [with_votes(widely, Votes(disagree=n), "", RULE).reliable for n in (3, 4)] == [True, False]


def test_unconfirmable_calibrations_stay_unreliable() -> None:
    found = decide_reliability("disagree", Votes(agree=100), RULE, confirmable=False, contributors=2)
    assert found == ("disagree", None)


def test_a_vote_is_one_of_its_contributor_camera_size_and_day() -> None:
    view = {"ids": (0,), "points": ((1.0, 1.0),)}
    asked = CheckRequest(camera="C", platform="P", img_size=(1280, 720), views=(view,))
    sid = f"{NOW:08x}0123456789abcdef"

    def name(
        request: CheckRequest = asked, who: str = "a", session: str = sid, now: int = NOW, period: int = DAY
    ) -> str:
        return vote_id(request, "c4-c-0123456789ab", who, session, now, period)

    midnight = NOW // DAY * DAY
    assert name() == name(session="other", now=midnight) == name(now=midnight + DAY - 1)
    others = [
        name(who="b"),
        name(now=midnight + DAY),
        name(asked.model_copy(update={"img_size": (640, 360)})),
        name(asked.model_copy(update={"zoom": 2.0})),
        name(period=0),
        name(session=f"{NOW:08x}f123456789abcdef", period=0),
    ]
    assert len({name(), *others}) == 7
    assert name() < name(now=midnight + DAY), "names sort by time"
    assert name(period=0) == name(who="b", now=NOW + 99, period=0), "of one session it is one"


def test_group_has_the_name_that_most_of_its_contributors_gave() -> None:
    def named(*names: str) -> list[tuple[str, str]]:
        return [(str(number), name) for number, name in enumerate(names)]

    on = named("Stabilisation on", "Zoomed", "stabilisation on", "")
    assert mode_names([on, named("Off"), named("")]) == ("Stabilisation on", "Off", None)
    assert mode_names([named("Wide"), named("wide")]) == (None, None), "groups of one name have none"
    assert mode_names([[*[("a", "Zoomed")] * 3, ("b", "On"), ("c", "On")]]) == ("On",)
    assert mode_names([named("<b>")]) == (None,)
