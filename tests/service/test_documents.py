"""The code of the documentation, run as it stands there against a stack that knows the examples' camera."""

import contextlib
import io
import itertools
import json
import subprocess
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from calibdb_client import Board, session
from infra.server.server import Server
from infra.web_build import recorded_examples
from infra.web_build.docs.templates import samples
from infra.web_build.openapi import EXAMPLES_PATH
from infra.web_build.operation import TOKEN
from infra.web_build.operations import EXAMPLE_CAMERA
from infra.web_build.recorded_examples import CALIBRATIONS, CALLS, SCENARIO, fill_in, learn
from tests.helpers.board_pictures import write
from tests.helpers.documents import CODE, SITE, blocks, sources
from tests.helpers.marks import thorough
from tests.helpers.service.client import Client
from tests.helpers.service.published import calibration, publish

EXAMPLES = json.loads(EXAMPLES_PATH.read_text())
#: commands fail where the service refuses
CURL = 'curl() { command curl --fail-with-body "$@"; }\n'
#: documents whose code tests elsewhere run, by language
ELSEWHERE = {
    ("docs/webxr.md", "js"): "tests/browser/test_webxr_explainer.py",
    ("docs/webxr.md", "html"): "tests/browser/test_webxr_explainer.py",
    ("docs/quickstart.md", "html"): "tests/browser/test_documentation.py",
    ("docs/quickstart.md", "js"): "tests/browser/test_documentation.py",
    ("docs/two-cameras.md", "js"): "tests/browser/test_documentation.py",
    ("web/sdk/README.md", "html"): "tests/browser/test_documentation.py",
    ("web/sdk/README.md", "js"): "tests/browser/test_documentation.py",
    ("web/sdk/README.md", "sh"): "tests/browser/test_documentation.py",
    ("README.md", "html"): "tests/browser/test_documentation.py",
    ("layers/solver/README.md", "python"): "tests/service/test_wheels.py",
}
SHELL = ("docs/api.md", "docs/quickstart.md", "docs/limits.md", "README.md")
PYTHON = ("docs/python.md", "clients/python/README.md", "README.md")


@dataclass
class Site:
    """A stack that knows the camera of the examples, and what samples have finished by call."""

    stack: Server
    finished: dict[str, dict[str, str]] = field(default_factory=dict)

    def prepare_call(self, name: str, values: dict[str, str]) -> None:
        # What one language finished, the others finish again.
        known = dict(self.finished.get(name, {}))
        if not known:
            recorded_examples.prepare_call(self.stack, name, known)
            if name.startswith("finish"):
                self.finished[name] = known
        values |= known


@pytest.fixture(scope="module")
def site() -> Iterator[Site]:
    four = recorded_examples._poses()[:4]  # more only take longer
    with (
        pytest.MonkeyPatch.context() as patch,
        Server(environment={"NEW_TOKENS": "100"}) as stack,
        stack.serve(),
    ):
        patch.setattr(recorded_examples, "_poses", lambda: four)
        publish(stack, *(calibration(EXAMPLE_CAMERA, n) for n in range(CALIBRATIONS)))
        assert Client(stack).lookup(camera=EXAMPLE_CAMERA).status == 200
        stack.wait_until_idle(60)  # its label is an alias from here on
        yield Site(stack)


def run(command: list[str], code: str, folder: Path | None = None) -> str:
    done = subprocess.run(command, input=code, capture_output=True, text=True, cwd=folder, timeout=60)
    assert done.returncode == 0, f"{code}\n{done.stdout}{done.stderr}"
    return done.stdout


def run_python(code: str) -> str:
    with contextlib.redirect_stdout(io.StringIO()) as output:
        exec(compile(code, "sample", "exec"), {})
    return output.getvalue()


def parted(said: str) -> tuple[int, str]:
    status, _, body = said.partition(" ")
    return int(status), body.strip()


#: how a sample is run: status, where the sample prints it, and body of the answer
RUN: dict[str, Callable[[str], tuple[int | None, str]]] = {
    "curl": lambda code: (None, run(["bash", "-e"], CURL + code)),
    "python": lambda code: parted(run_python(code)),
    "fetch": lambda code: parted(run(["node", "--input-type=module"], code)),
}


@pytest.mark.parametrize("languages", ["fetch python", *thorough("fetch", "python", "curl")])
def test_every_sample_of_the_reference_is_answered_as_it_says(site: Site, languages: str) -> None:
    """Each call in the next of the languages."""
    expected = {name: min(operation.answers) for name, operation in CALLS.items()}
    assert set(SCENARIO) == set(expected), "every call has an example"
    values = {}
    for name, language in zip(SCENARIO, itertools.cycle(languages.split()), strict=False):
        site.prepare_call(name, values)
        code = fill_in(samples(CALLS[name])[language], values).replace(SITE, site.stack.url)
        status, body = RUN[language](code)
        assert status in (None, expected[name]), (name, body)
        example = EXAMPLES[name]
        if isinstance(example, dict):
            answer = json.loads(body)
            assert set(answer) == set(example), f"{name}: make .build/examples.json"
            learn(values, name, answer)


def code_of(source: str, language: str) -> list[str]:
    found = [block.code for block in blocks(source) if block.language == language and block.reason is None]
    assert found
    return found


@pytest.mark.parametrize("source", SHELL)
def test_commands_of_a_document_run_one_after_the_other(site: Site, source: str, tmp_path: Path) -> None:
    code = CURL + "\n".join(code_of(source, "sh")).replace(SITE, site.stack.url)
    run(["bash", "-euo", "pipefail"], code, tmp_path)


def test_every_block_of_code_is_run_or_says_why_not() -> None:
    code = [block for source in sources() for block in blocks(source) if block.language in CODE]
    assert len(code) >= 40
    for block in code:
        place = f"{block.source}:{block.line}"
        runs = (
            (block.source, block.language) in ELSEWHERE
            or (block.language == "sh" and block.source in SHELL)
            or (block.language == "python" and block.source in PYTHON)
        )
        if block.reason is not None:
            assert len(block.reason.split()) >= 3, f"{place} says no reason"
        else:
            assert runs, f"{place}: no test runs this {block.language}"
    skipped = [block for block in code if block.reason is not None]
    assert len(skipped) <= 20


def test_json_of_the_documents_is_json() -> None:
    for source in sources():
        for block in blocks(source):
            if block.language == "json":
                json.loads(block.code)


class FakeCamera:
    label = "HD Pro Webcam C920 (046d:082d)"
    platform = "X11; Linux x86_64"
    img_size = (1280, 720)

    def read(self) -> tuple[bool, Any]:
        return True, np.zeros((720, 1280, 3), np.uint8)


@pytest.mark.parametrize("source", PYTHON)
def test_python_of_a_document_runs(
    site: Site, source: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("calibdb_client.open_camera", lambda *_, **__: FakeCamera())
    monkeypatch.setattr(session, "chosen_model", lambda *_: ("rectilinear", None))
    monkeypatch.setenv("CALIBDB_URL", site.stack.url)
    monkeypatch.setenv("CALIBDB_TOKEN", TOKEN)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    board = Board(squares=(8, 8), marker_ratio=0.75, dictionary="DICT_4X4_1000")
    monkeypatch.setattr("calibdb_client.pictures.recognise_board", lambda *_: board)
    write(tmp_path / "photos", board, count=5)
    for code in code_of(source, "python"):
        run_python(code.replace(SITE, site.stack.url))
    assert "image_width: 1280" in (tmp_path / "camera.yaml").read_text()
