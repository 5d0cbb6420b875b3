"""In whatever order things happen, the table says what the bucket says; `CALIBDB_ROUNDS` times (2)."""

import os
import random
from pathlib import Path

from calibdb import schema
from calibdb.store.names import with_current_key
from infra.ops import withdrawal
from infra.ops.dump import dump
from infra.ops.reindex import reindex
from infra.ops.restore import load
from infra.server.server import Server
from tests.helpers.service.client import Truth
from tests.helpers.service.index_items import items, remove
from tests.helpers.service.published import asked, calibration, held, mode_of, store
from tests.helpers.service.strangers import context

ROUNDS = int(os.environ.get("CALIBDB_ROUNDS", "2"))
LABELS = "Webcam Z77 (1111:0001)", "Webcam Z77 (1111:0002)", "Webcam Z77", "Integrated Camera (2222:0003)"
RULES = {"MIN_CALIBRATIONS": "2", "MIN_CONTRIBUTORS": "2", "CONTRIBUTOR_PERIOD": "86400"}


def candidates() -> list[schema.CalibrationDocument]:
    found = []
    for label in LABELS:
        one, two = (calibration(label, n) for n in range(2))
        key = "c1-webcam-0123456789ab" if "Webcam" in label else "c1-integrated-0123456789ab"
        old = {"camera_key": key, "id": two.id.replace(two.camera_key, key), "contributor": "of old"}
        found += [one, two, two.model_copy(update=old)]
    return found


def vote(of: schema.CalibrationDocument, rng: random.Random) -> schema.VoteDocument:
    seen = held(Truth(seed=rng.randrange(9)), 3)
    views = tuple(
        schema.ViewDocument(index=i, ids=ids, points=points) for i, (ids, points) in enumerate(seen)
    )
    changed = {"id": f"6553f1{rng.randrange(16**14):014x}", "views": views, "source": f"v{rng.randrange(5)}"}
    return schema.VoteDocument(**{**of.model_dump(exclude={"fits"}), **changed}, noise=0.2)


def counted(stack: Server) -> list[schema.CalibrationDocument | schema.VoteDocument]:
    known = store(stack).calibrations
    kept = [*(one for one in known.all() if not known.withdrawal(one)), *store(stack).votes.all()]
    nameless = {"contributor": "", "source": ""}
    return sorted((one.model_copy(update=nameless) for one in kept), key=lambda one: one.id)


def test_random_history_reindexes_to_the_same_table(tmp_path: Path) -> None:
    """And a private dump, loaded elsewhere, has what counts."""
    rng, documents = random.Random(3), candidates()
    done: set[str] = set()
    with Server(environment=RULES) as stack:
        operator = context(stack)
        for number in range(ROUNDS):
            for document in rng.choices(documents, k=4):
                what = rng.choice(("publish", "publish", "withdraw", "restore", "vote"))
                if what == "publish":
                    operator.store.calibrations.publish(document)
                    done.add(document.id)
                elif what == "vote":
                    store(stack).votes.cast(vote(document, rng))
                elif document.id in done and what == "withdraw":
                    withdrawal.withdraw(operator, document.id, "wrong")
                elif document.id in done and operator.store.calibrations.withdrawal(document):
                    withdrawal.restore(operator, document.id)
                operator.store.refit.now(asked(mode_of(with_current_key(document))))
            before = items(stack)
            if number == ROUNDS - 1:
                remove(stack, *before)
            assert reindex(operator).failed == 0
            assert items(stack) == before
        dump(operator, tmp_path / "dump", private=True)
        expected = counted(stack)
    with Server(environment=RULES) as stack:
        load(context(stack), tmp_path / "dump")
        assert counted(stack) == expected
