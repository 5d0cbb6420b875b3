"""kill -9 of the local stack amid refits: one reindex later the edge answers byte for byte as a lookup."""

import random
import threading
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path

import httpx
import pytest

from calibdb.schema import DISTORTION_MODELS
from infra.local import LocalStack
from infra.ops.__main__ import main
from tests.helpers.service.client import CAMERA
from tests.helpers.service.edge import Question, differences, objects, questions
from tests.helpers.service.published import PLATFORM, calibration, store
from tests.helpers.stack.processes import LocalProcess

KILLS = 3
LABELS = ("Webcam Z77 (1111:0001)", "Webcam Z78 (1111:0002)")
RULES = {"MIN_CALIBRATIONS": "2", "MIN_CONTRIBUTORS": "1"}
QUESTIONS = questions(LABELS, (PLATFORM,))
TOKEN = {"authorization": "Bearer cdb_dev_local"}


def ask(server: LocalProcess, question: Question) -> None:
    """Look up, which computes the consensus that is missing or stale."""
    body = {
        **CAMERA,
        "camera": question.label,
        "platform": question.platform,
        "distortion_model": question.model,
        "redirect": False,
    }
    with suppress(httpx.TransportError):
        httpx.post(f"{server.url}/v1/lookup", headers=TOKEN, json=body, timeout=60)


@pytest.mark.thorough
def test_kill_amid_refits_is_mended_by_one_reindex(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    data_dir, rng = tmp_path / "data", random.Random(7)
    for name, value in {**RULES, "DATA_DIR": str(data_dir)}.items():
        monkeypatch.setenv(name, value)
    for number in range(KILLS):
        with LocalStack(data_dir, environment=RULES) as stack:
            for label in LABELS:
                for n in range(2 * number, 2 * number + 2):
                    store(stack).calibrations.publish(calibration(label, n, views=3))
        with LocalProcess(data_dir, RULES) as server, ThreadPoolExecutor(len(QUESTIONS)) as pool:
            killer = threading.Timer(rng.uniform(0.2, 3.0), server.kill)
            killer.start()
            list(pool.map(lambda question: ask(server, question), QUESTIONS.values()))
            killer.join()
        assert main(["reindex"]) == 0
        with LocalStack(data_dir, environment=RULES) as stack:
            assert differences(stack, QUESTIONS) == []
            assert len(objects(stack)) == len(LABELS) * len(DISTORTION_MODELS)
