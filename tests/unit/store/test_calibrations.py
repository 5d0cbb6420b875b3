"""Store of calibrations, votes and consensus; races leave the newest of them."""

import pytest

from calibdb.camera_key import camera_key
from calibdb.schema import (
    CalibrationDocument,
    ConsensusDocument,
    FitRecord,
    GroupsDocument,
    Track,
    Uncertainty,
)
from calibdb.store import Calibrations, Objects, StreamMode, Table
from calibdb.store.cameras import Consensuses
from calibdb.store.leases import Leases
from calibdb.store.votes import Votes
from tests.helpers.service.known import calibration, consensus, fit, mode_of, vote

NOW = 1_700_000_000
VAGUE = Uncertainty(rms=3.01, max=9.0)


@pytest.fixture
def votes(table: Table, objects: Objects) -> Votes:
    return Votes(table, objects)


def test_publishing_twice_is_publishing_once(calibrations: Calibrations) -> None:
    document = calibrated(0)
    calibrations.publish(document)
    calibrations.publish(document.model_copy(update={"time": NOW + 9}))
    assert calibrations.get(document.id) == document  # never overwritten
    assert [counted.id for counted in calibrations.newest(mode_of(document), 200)] == [document.id]
    assert list(calibrations.all()) == [document]


def test_the_newest_come_first_and_only_of_this_size_and_zoom(calibrations: Calibrations) -> None:
    documents = [calibrated(n * 86_400) for n in range(12)]
    for document in documents:
        calibrations.publish(document)
    for other in ({"img_size": (128, 72), "id": documents[0].id[:-4] + "ffff"}, {"zoom": 0.5}):
        calibrations.index(documents[0].model_copy(update=other))
    found = [counted.id for counted in calibrations.newest(mode_of(documents[0]), 5)]
    assert found == [document.id for document in documents[:-6:-1]]
    assert calibrations.read(found) == documents[:-6:-1]


def calibrated(n: int, contributor: str = "", **changes: object) -> CalibrationDocument:
    """The `n`th calibration of one camera, finished n seconds from now."""
    made = calibration("Camera", "Linux", number=NOW + n, time=0)
    return made.model_copy(update={"contributor": contributor or made.contributor, **changes})


def test_uncounted_calibrations_are_skipped(calibrations: Calibrations) -> None:
    cropped = Track(resizeMode="crop-and-scale")
    documents = [calibrated(0), calibrated(1, track=cropped), calibrated(2), calibrated(3)]
    for document in documents:
        calibrations.publish(document)
    assert calibrations.withdraw(documents[2], "a mirror", NOW + 9) is True
    assert calibrations.withdraw(documents[2], "a mirror", NOW + 9) is False
    calibrations.publish(documents[2])  # the client repeats its last view
    place = mode_of(documents[0])
    assert [c.id for c in calibrations.newest(place, 200)] == [documents[3].id, documents[0].id]
    everything = sorted(calibrations.everything(), key=lambda one: one[0].time)
    assert everything == [(document, n == 2) for n, document in enumerate(documents)]
    assert calibrations.modes(place.camera_key) == [place]


def test_source_counts_three_times_at_most(calibrations: Calibrations) -> None:
    day = 86_400
    once = calibrated(0, "honest", source="elsewhere")
    calibrations.index(once)
    busy = [calibrated(n, f"token {n}", source="one place", time=NOW + n * day) for n in range(1, 9)]
    for document in busy:
        calibrations.index(document)
    found = calibrations.newest(mode_of(once), 200, day)
    assert [c.source for c in found] == ["one place"] * 3 + ["elsewhere"]
    assert [c.id for c in found[:3]] == [d.id for d in busy[:-4:-1]], "the newest"
    assert len(calibrations.newest(mode_of(once), 200)) == 9, "without a period everything counts"


@pytest.mark.parametrize(
    "changes",
    [
        {"uncertainty": VAGUE.model_copy(update={"inside": 3.01, "covered": 0.4})},
        {"avg_reprojection_error": 3.01},
    ],
    ids=["3 px off where its board was", "of its own views"],
)
def test_calibration_that_is_no_evidence_does_not_count(
    calibrations: Calibrations, changes: dict[str, object]
) -> None:
    wide = {"img_size": (1280, 720), "target_error": 100.0}
    inside = VAGUE.model_copy(update={"inside": 2.99, "covered": 0.4})
    evidence = calibrated(0, **wide, fits=of_fit({"uncertainty": inside}))
    other = calibrated(1, **wide, fits=of_fit(changes))
    calibrations.index(evidence)
    calibrations.index(other)
    place = mode_of(evidence)
    assert [c.id for c in calibrations.newest(place, 200, 86_400)] == [evidence.id]
    assert len(calibrations.newest(place, 200)) == 2


def of_fit(changes: dict[str, object]) -> dict[str, FitRecord]:
    return {"rectilinear": fit().model_copy(update=changes)}


def rests_on(basis: str) -> ConsensusDocument:
    return consensus(key="k").model_copy(update={"basis": basis, "pooled": f"pooled {basis}"})


def behind(basis: str) -> GroupsDocument:
    return GroupsDocument(pooled=f"pooled {basis}", groups=((basis,),), errors={basis: 0.5})


def test_an_older_consensus_never_replaces_a_newer(table: Table) -> None:
    consensuses = Consensuses(table)
    assert consensuses.put(rests_on("a"), behind("a"), None)
    assert not consensuses.put(rests_on("b"), behind("b"), None)
    assert consensuses.put(rests_on("ab"), behind("ab"), "a")
    assert not consensuses.put(rests_on("a"), behind("a"), "a")
    assert not consensuses.put(rests_on("a"), None, "a")
    assert consensuses.of("k") == consensuses.at(StreamMode("k", (1280, 720), 0.0)) == [rests_on("ab")]
    assert consensuses.groups(rests_on("ab")) == behind("ab")
    assert consensuses.groups(rests_on("a")) is None
    assert not consensuses.drop(rests_on("a"))
    assert consensuses.drop(rests_on("ab"))
    assert consensuses.of("k") == []
    assert consensuses.groups(rests_on("ab")) is None


def test_lease_coalesces_concurrent_requests(table: Table) -> None:
    leases, place = Leases(table), StreamMode("k", (1280, 720), 0.0)
    assert leases.take(place, "first", NOW, NOW + 30)
    assert not leases.take(place, "second", NOW, NOW + 30)
    assert not leases.take(place, "third", NOW, NOW + 30)
    assert leases.take(StreamMode("k", (640, 360), 0.0), "third", NOW, NOW + 30)
    assert not leases.release(place, "first"), "the others wait for another round"
    assert leases.take(place, "first", NOW, NOW + 30), "it computes again"
    assert leases.release(place, "first")
    assert leases.take(place, "second", NOW, NOW + 30)
    assert leases.take(place, "second", NOW + 1, NOW + 31), "a second attempt of the same request"
    assert not leases.take(place, "third", NOW + 31, NOW + 61)
    assert leases.take(place, "third", NOW + 32, NOW + 62), "the lease has expired"
    assert leases.release(place, "second"), "it was not theirs any more"
    leases.abandon(place, "second")
    assert not leases.take(place, "first", NOW + 32, NOW + 62)
    leases.abandon(place, "third")
    assert leases.take(place, "first", NOW + 32, NOW + 62)


VOTED = calibration("K", "Linux", key="c4-k-0123456789ab")
VOTE = vote(VOTED, id="6553f100aaaaaaaaaaaa", contributor="somebody", time=NOW)


def test_first_vote_of_an_id_counts(votes: Votes) -> None:
    later = VOTE.model_copy(update={"id": "6553f200aaaaaaaaaaaa", "time": NOW + 256})
    assert votes.cast(VOTE) == VOTE
    assert votes.cast(VOTE.model_copy(update={"time": NOW + 9})) == VOTE
    assert votes.cast(later) == later
    found = votes.newest(StreamMode(VOTE.camera_key, (1280, 720), 0.0), one_per_source=False)
    assert [(cast.id, cast.source) for cast in found] == [(later.id, "somebody"), (VOTE.id, "somebody")]
    assert votes.read(found) == [later, VOTE]
    assert list(votes.all()) == [VOTE, later]


def test_daily_voter_displaces_no_other_vote(votes: Votes) -> None:
    names = {f"6553f1{day:014x}": "daily" for day in range(120)}
    names |= {"6553f00000000000000a": "first", "6553f00000000000000b": "second"}
    for name, source in names.items():
        votes.index(VOTE.model_copy(update={"id": name, "source": source}))
    mode = StreamMode(VOTE.camera_key, (1280, 720), 0.0)
    found = votes.newest(mode, one_per_source=True)
    assert [cast.source for cast in found] == ["daily", "second", "first"]
    assert found[0].id == max(names)
    assert len(votes.newest(mode, one_per_source=False)) == 50


def test_votes_follow_their_camera_to_another_key(votes: Votes) -> None:
    label, platform = "HD Pro Webcam C920 (046d:082d)", "X11; Linux x86_64"
    earlier = {"camera_key": "c1-earlier-0123456789ab", "camera": label, "platform": platform}
    vote = VOTE.model_copy(update=earlier)
    votes.cast(vote)
    today = StreamMode(camera_key(label, platform), (1280, 720), 0.0)
    assert votes.read(votes.newest(today, one_per_source=True)) == [vote]
