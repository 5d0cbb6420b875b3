"""Answers at the edge while the database changes: withdrawals, attacks, late writers, losses, the switch."""

import random
from typing import Any

import httpx
import pytest

from calibdb.camera_key import identify
from calibdb.errors import UnavailableError
from calibdb.lookup.publication import MAX_PENDING_PER_SOURCE, Publication
from calibdb.lookup.sightings import SightingFilter
from calibdb.schema import DISTORTION_MODELS, Sighting
from calibdb.settings import Settings
from calibdb.store import StreamMode
from calibdb.store.aliases import MAX_ALIASES
from calibsolver import consensus, deadline
from infra.local import LocalStack
from infra.ops import withdrawal
from infra.ops.context import OpsContext
from infra.ops.reindex import reindex
from tests.helpers.service.client import TOKEN, Client
from tests.helpers.service.edge import Question, aliases, differences, objects
from tests.helpers.service.histories import quick_solver
from tests.helpers.service.published import PLATFORM, asked, calibration, mode_of, store
from tests.service.test_edge import LABEL, PRIVATE, PUBLIC, SEEN, SIZE, WINDOWS, context_of, publish

FEW = 12  # aliases of a camera in these tests, which would take their time with 200


@pytest.fixture
def few_aliases(monkeypatch: pytest.MonkeyPatch) -> None:
    assert MAX_ALIASES == 200
    for module in ("calibdb.lookup.publication", "calibdb.store.aliases"):
        monkeypatch.setattr(f"{module}.MAX_ALIASES", FEW)


@pytest.mark.usefixtures("few_aliases")
def test_an_attacker_creates_no_object_and_few_aliases() -> None:
    """Labels that hit, of one source and of many; reported past the filter of `lookup`, too."""
    with quick_solver(), LocalStack(environment=PUBLIC) as stack:
        publish(stack)
        before = objects(stack)
        settings, rng = Settings.from_environment(stack.environment), random.Random(5)
        publication = Publication(store(stack), settings, lambda: 1.7e9, "test")
        for n in range(40):
            platform = f"X11; Linux x86_64; rv:{n}.0"
            source = "one" if n < 20 else f"source {rng.randrange(60)}"
            publication.record(Sighting(label=LABEL, platform=platform, source=source))
            if n == 19:
                assert len(aliases(stack)) == 1 + MAX_PENDING_PER_SOURCE
        assert len(aliases(stack)) == FEW
        assert objects(stack) == before
        sightings, key = SightingFilter(), identify(LABEL, PLATFORM).key
        reported = [sightings.admit(key, (LABEL, f"rv:{n}"), "one", 1.7e9) for n in range(100_000)]
        assert sum(reported) == MAX_PENDING_PER_SOURCE
        for n in range(20):
            answer = Question(f"Invented {n} (dead:{n:04x})", PLATFORM, SIZE, "rectilinear").ask(stack)
            assert answer.status == 404
        assert objects(stack) == before
        assert len(aliases(stack)) == FEW


@pytest.mark.usefixtures("few_aliases")
def test_a_full_camera_reports_no_more_and_forgets_what_nobody_asks_by() -> None:
    with quick_solver(), LocalStack(environment=PUBLIC) as stack:
        publish(stack)
        settings, now = Settings.from_environment(stack.environment), 1.7e9
        key = identify(LABEL, PLATFORM).key
        publication = Publication(store(stack), settings, lambda: now, "test")
        for n in range(FEW + 5):
            publication.record(Sighting(label=LABEL, platform=f"X11; Linux x86_64; rv:{n}.0", source=f"{n}"))
        assert len(aliases(stack)) == FEW
        assert not store(stack).cameras.known(key).aliases.wants("new")
        now += 8 * 86_400
        publication.refresh(StreamMode(key, SIZE, 0.0), changed=True)
        assert [item["label"]["S"] for item in aliases(stack)] == [LABEL]
        assert store(stack).cameras.known(key).aliases.wants("new")


def test_withdrawn_is_gone_when_it_is_acknowledged() -> None:
    with quick_solver(), LocalStack(environment=PUBLIC) as stack:
        publish(stack)
        context = context_of(stack)
        for source in range(3):  # the name alone, under its own key
            Question("Webcam Z77", WINDOWS, SIZE, "rectilinear").ask(stack, address=f"192.0.2.{source}")
        assert len(objects(stack)) == 2 * len(DISTORTION_MODELS)
        document = calibration(LABEL, 0, views=3)
        assert withdrawal.withdraw(context, document.id, "wrong")
        assert objects(stack) == {}
        withdrawal.restore(context, document.id)
        assert len(objects(stack)) == 2 * len(DISTORTION_MODELS)
        withdrawal.forget(context, {document.contributor})
        assert objects(stack) == {}


def test_a_late_writer_cannot_bring_back_what_was_withdrawn() -> None:
    """It waits for its turn, and reads the index again once it has it."""
    with quick_solver(), LocalStack(environment=PUBLIC) as stack:
        publish(stack)
        settings, key = Settings.from_environment(stack.environment), identify(LABEL, PLATFORM).key
        waited: list[float] = []

        def withdraw_meanwhile(seconds: float) -> None:
            waited.append(seconds)
            store(stack).locks.release(key, "another")

        assert store(stack).locks.take(key, "another", 1_700_000_000)
        late = Publication(store(stack), settings, lambda: 1.7e9, "late", withdraw_meanwhile)
        for n in range(3):
            store(stack).calibrations.withdraw(calibration(LABEL, n, views=3), "wrong", 0)
        for document in store(stack).consensuses.of(key):
            assert store(stack).consensuses.drop(document)
        late.refresh(StreamMode(key, SIZE, 0.0), changed=True)
        assert len(waited) == 1
        assert objects(stack) == {}
        # And one whose lock was taken over writes nothing more.
        assert store(stack).locks.take(key, "another", 1_700_000_000)
        stuck = Publication(store(stack), settings, lambda: 1.7e9, "stuck", lambda _: None)
        with pytest.raises(UnavailableError, match="try again"):
            stuck.refresh(StreamMode(key, SIZE, 0.0), changed=True)


def test_reindex_rebuilds_what_was_lost_changed_or_never_belonged() -> None:
    with quick_solver(), LocalStack(environment=PUBLIC) as stack:
        publish(stack)
        before = objects(stack)
        answers = store(stack).edge_answers
        names = sorted(before)
        answers.delete(names[:2])
        answers.delete([names[2]])
        assert answers.put(names[2], b"{}", None)
        assert answers.put(f"known/00/{'0' * 32}.json", b"{}", None)
        done = reindex(context_of(stack))
        assert objects(stack) == before
        assert done.answers == len(before)


def test_off_means_no_objects() -> None:
    with quick_solver(), LocalStack(environment=PUBLIC) as stack:
        publish(stack)
        assert objects(stack)
        context = OpsContext.of({**stack.environment, "EDGE_ANSWERS": "off"}, secret_known=True, echo=print)
        assert reindex(context).answers == 0
        assert objects(stack) == {}
    with quick_solver(), LocalStack(environment={**PRIVATE, "EDGE_ANSWERS": "off"}) as stack:
        publish(stack)
        assert Client(stack, api_token=TOKEN).lookup(camera=LABEL, platform=PLATFORM).status == 200
        assert objects(stack) == {}
        with stack.serve() as url:
            assert httpx.get(f"{url}/config.json", timeout=60).json()["edge_answers"] == "off"


def test_refit_that_runs_out_of_time_stores_whole_models_and_goes_on_from_there() -> None:
    """The edge says what is stored; nobody gets a half answer; what is stored is not computed again."""
    # Undone in the opposite order: of one function there are two replacements.
    with (
        quick_solver(),
        LocalStack(environment=PRIVATE) as stack,
        pytest.MonkeyPatch.context() as patch,
    ):
        at_rest, mode = store(stack), mode_of(calibration(LABEL, 0, views=3))
        pool, pooled, last = consensus.pool, [], 1

        def pool_some(*given: Any) -> Any:
            if len(pooled) == last:
                with deadline.limit(lambda: 0.0):
                    deadline.check()
            pooled.append(given[2])
            return pool(*given)

        patch.setattr(consensus, "pool", pool_some)
        with pytest.raises(UnavailableError):
            publish(stack)
        assert [known.distortion_model for known in at_rest.consensuses.at(mode)] == pooled
        assert len(objects(stack)) == len(pooled) == 1
        last = 99
        assert set(at_rest.refit.now(asked(mode)).models) == set(DISTORTION_MODELS)
        assert sorted(pooled) == sorted(DISTORTION_MODELS)
        assert set(objects(stack)) == set(SEEN)
        assert differences(stack, SEEN) == []
