"""Import of handlers from built layers; the arm64 job runs it on the real ones."""

from pathlib import Path

import pytest

from infra.ci.import_handlers import functions, main, sources
from tests.helpers.data import ROOT

TEMPLATE = """Resources:
  LightFunction:
    Type: AWS::Serverless::Function
    Properties:
      CodeUri: functions/light/

  HeavyFunction:
    Type: AWS::Serverless::Function
    Properties:
      CodeUri: functions/heavy/
      Layers: [!Ref SolverLayer]
"""


@pytest.fixture
def built(tmp_path: Path) -> Path:
    """Two functions and their layers, as small as they can be."""
    (tmp_path / "template.yaml").write_text(TEMPLATE)
    for name, content in (
        ("functions/light/app.py", "import shared\nhandler = shared.answer\n"),
        ("functions/heavy/app.py", "import geometry, shared\nhandler = shared.answer\n"),
        (".build/layers/service/python/shared.py", "def answer(event, context): ...\n"),
        (".build/layers/solver/python/geometry.py", ""),
    ):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content)
    return tmp_path


def test_every_handler_is_imported_from_its_layers(built: Path) -> None:
    assert main(built) == 0


@pytest.mark.parametrize(
    ("file", "content", "said"),
    [
        ("functions/light/app.py", "import geometry\n", "No module named 'geometry'"),  # has no solver
        ("functions/heavy/app.py", "import numpy\nhandler = print\n", "No module named 'numpy'"),  # ours
        ("functions/light/app.py", "handler = 3\n", "AssertionError"),
    ],
)
def test_handler_that_cannot_be_imported_fails(
    file: str, content: str, said: str, built: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (built / file).write_text(content)
    assert main(built) == 1
    assert said in capsys.readouterr().out


def test_every_function_of_the_template_is_found() -> None:
    found = dict(functions(sources(ROOT)))
    assert set(found) == {f"functions/{path.parent.name}" for path in ROOT.glob("functions/*/app.py")}
    assert found["functions/lookup"] is False
    assert found["functions/submit"] is True
