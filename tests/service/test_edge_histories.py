"""Random histories, cut off at any time: the edge answers byte for byte as a lookup does, or not.

`CALIBDB_HISTORIES` random histories (4 shorter ones unless told otherwise), half of them cut off by a crash.
"""

import os
import random

import pytest

from calibdb.camera_key import identify
from tests.helpers.service.edge import aliases, differences, killed_after, let_locks_expire, objects
from tests.helpers.service.histories import QUESTIONS, History, history

HISTORIES = int(os.environ.get("CALIBDB_HISTORIES", "4"))
STEPS = 10 if HISTORIES > 4 else 6
MAX_STEPS = 60
"""Steps after which a history without a single answer at the edge would prove nothing."""


def complete(told: History) -> list[str]:
    """Aliases of calibrations that lack an object where a lookup answers exactly.

    A name with a USB id that the bare name's camera answers for has none: that is asked by POST.
    """
    lacking = []
    there = objects(told.stack)
    seen = {(i["label"]["S"], i["platform"]["S"]) for i in aliases(told.stack) if "seen" in i}
    for name, question in QUESTIONS.items():
        if (question.label, question.platform) in seen and name not in there:
            answer = question.ask(told.stack)
            if answer.status != 200 or not answer.json["exact_size"]:
                continue
            identity = identify(question.label, question.platform)
            own = identity.usb_id is None or answer.json["id"].startswith(f"{identity.key}~")
            if own and name not in objects(told.stack):
                lacking.append(f"{question} has no object")
    return lacking


@pytest.mark.parametrize("seed", range(HISTORIES // 2))
def test_every_object_is_what_a_lookup_answers_after_every_step(seed: int) -> None:
    compared = taken = 0
    with history(seed) as told:
        while taken < STEPS or (not compared and taken < MAX_STEPS):
            told.step()
            assert differences(told.stack, QUESTIONS) == [], told.done
            compared += len(objects(told.stack))
            taken += 1
        assert compared > 0, told.done
        assert complete(told) == [], told.done


@pytest.mark.parametrize("seed", range(HISTORIES // 2))
def test_a_crash_at_any_moment_leaves_nothing_that_one_reindex_does_not_mend(seed: int) -> None:
    rng = random.Random(seed)
    with history(1000 + seed) as told:
        for _ in range(STEPS // 2):
            told.step()
        told.stack.wait_until_idle(60)
        with killed_after(rng.randrange(120)):
            for _ in range(STEPS // 2):
                told.step()
        told.stack.wait_until_idle(60)
        let_locks_expire(told.stack)
        told.reindex()
        assert differences(told.stack, QUESTIONS) == [], told.done
        assert complete(told) == [], told.done
