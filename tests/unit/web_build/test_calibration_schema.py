"""The JSON Schema of a calibration document accepts every kind of them."""

import json
from typing import Any

import jsonschema
import pytest

from calibdb import schema
from infra.web_build import openapi, site
from tests.helpers.recordings import calibration_of
from tests.helpers.service.published import calibration

SERVED = json.loads(site.made_files()["docs/schema/calibration-1.json"])
VALIDATOR = jsonschema.Draft202012Validator(SERVED)


@pytest.fixture(scope="module")
def kinds(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """A document of every kind, by name."""
    folder = tmp_path_factory.mktemp("kinds")
    calibration_of("opencv_left").calibration.save(folder / "offline.json")
    document = calibration("Camera of a schema", 0)
    examples = json.loads(openapi.EXAMPLES_PATH.read_text(encoding="utf-8"))
    return {
        "offline": json.loads((folder / "offline.json").read_text(encoding="utf-8")),
        "minimal": {name: document.answer().model_dump(mode="json")[name] for name in SERVED["required"]},
        "stored": schema.ReportedCalibration(**dict(document.answer()), board=document.board).model_dump(
            mode="json"
        ),
        "looked up": examples["lookup"],
        "read, a consensus": examples["showCalibration"],
        "checked": examples["checkCalibration"]["calibration"],
    }


def test_every_kind_of_document_is_valid_and_its_members_are_described(kinds: dict[str, Any]) -> None:
    jsonschema.Draft202012Validator.check_schema(SERVED)
    described = SERVED["properties"].keys() | {"recording"}
    for name, document in kinds.items():
        errors = [f"{error.json_path}: {error.message}" for error in VALIDATOR.iter_errors(document)]
        assert errors == [], name
        assert document.keys() <= described, name


@pytest.mark.parametrize(
    "changed",
    [
        {"camera_matrix": [[950, 0, 640], [0, 950, 360]]},
        {"distortion_model": "pinhole"},
        {"uncertainty": {"rms": 0.3}},
    ],
)
def test_other_documents_are_invalid(kinds: dict[str, Any], changed: dict[str, Any]) -> None:
    assert not VALIDATOR.is_valid(kinds["stored"] | changed)


def test_address_names_the_version_and_only_what_makes_a_camera_is_required() -> None:
    assert SERVED["$id"] == f"/docs/schema/calibration-{openapi.CALIBRATION_VERSION}.json"
    assert SERVED["required"] == ["img_size", "camera_matrix", "distortion_coefficients", "distortion_model"]
