"""Every schema under what its own JSON Schema allows, and models that are built at their first use."""

import importlib
import json
import os
import pkgutil
import re
import threading
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest
import schemathesis
from hypothesis import HealthCheck, given, settings
from pydantic import BaseModel, ValidationError
from pydantic._internal import _model_construction
from pydantic.json_schema import models_json_schema
from schemathesis import Case

from calibdb import schema
from calibdb.schema import LookupRequest, fields
from calibdb.schema.fields import Deferred, Strict
from tests.conftest import THOROUGH

FUZZ = settings(
    max_examples=int(os.environ.get("CASES", "400" if THOROUGH else "160")) // 40,
    derandomize=True,
    database=None,
    suppress_health_check=list(HealthCheck),
)
MODELS = sorted(
    {
        model
        for module in pkgutil.iter_modules(schema.__path__, "calibdb.schema.")
        for model in vars(importlib.import_module(module.name)).values()
        if isinstance(model, type) and issubclass(model, BaseModel) and model.__module__.startswith("calibdb")
    },
    key=lambda model: model.__name__,
)
SCHEMAS = models_json_schema(
    [(model, "validation") for model in MODELS], ref_template="#/components/schemas/{model}"
)[1]["$defs"]
#: calls that send each model, for which schemathesis makes bodies
CALLS = schemathesis.openapi.from_dict(
    {
        "openapi": "3.1.0",
        "info": {"title": "Schemas", "version": "1"},
        "components": {"schemas": SCHEMAS},
        "paths": {
            f"/{name}": {
                "post": {
                    "requestBody": {
                        "required": True,
                        "content": {"application/json": {"schema": {"$ref": f"#/components/schemas/{name}"}}},
                    },
                    "responses": {"200": {"description": "accepted"}},
                }
            }
            for name in SCHEMAS
        },
    }
)


#: models that are parts of another, which are read with it
PARTS = set(re.findall(r'"#/components/schemas/(\w+)"', json.dumps(SCHEMAS)))
READ = [model for model in MODELS if THOROUGH or model.__name__ not in PARTS]


@pytest.mark.parametrize("model", READ, ids=lambda model: model.__name__)
def test_described_documents_are_accepted_and_written_unchanged(model: type[BaseModel]) -> None:
    accepted = []

    @FUZZ
    @given(CALLS[f"/{model.__name__}"]["POST"].as_strategy())
    def read(case: Case) -> None:
        try:
            found = model.model_validate_json(json.dumps(case.body))
        except ValidationError:
            return
        accepted.append(found)
        written = found.model_dump_json(by_alias=True)
        json.dumps(json.loads(written), allow_nan=False)
        assert model.model_validate_json(written) == found

    read()
    assert accepted, "nothing that the schema describes is accepted"


def test_stored_members_hold_finite_numbers() -> None:
    content = """{"camera_key": "a", "camera": "a", "platform": "b", "img_size": [16, 16], "zoom": 0,
        "distortion_model": "rectilinear", "board": {}, "guidance": "projection-uncertainty",
        "track": {}, "started": 0, "target_error": 1, "session": "s",
        "target": {"x": Infinity, "y": [1, NaN, {"z": -Infinity}]}}"""
    document = schema.documents.SessionDocument.model_validate_json(content)
    assert document.target == {"x": None, "y": [1, None, {"z": None}]}


@pytest.mark.parametrize("separator", ["x", "×", ","])
def test_query_equals_body(separator: str) -> None:
    camera = {"camera": "a", "platform": "b"}
    query = LookupRequest.model_validate({**camera, "imsize": f"640{separator}480", "zoom": "1.500000"})
    body = LookupRequest.model_validate({**camera, "img_size": [640, 480], "zoom": 1.5})
    assert query == body


class Watched:
    """A lock that reports when a thread asks for it."""

    def __init__(self) -> None:
        self._lock = threading.RLock()
        self.asked = threading.Semaphore(0)

    def __enter__(self) -> None:
        self.asked.release()
        self._lock.acquire()

    def __exit__(self, *_: object) -> None:
        self._lock.release()


def test_first_use_in_two_threads_builds_the_model_once(monkeypatch: pytest.MonkeyPatch) -> None:
    class Fresh(Strict):
        number: int = 0

    lock, builds = Watched(), 0
    build = _model_construction.complete_model_class

    def build_late(*args: Any, **kwargs: Any) -> bool:
        nonlocal builds
        builds += 1
        if builds == 1:
            for _ in range(2):
                assert lock.asked.acquire(timeout=60)
        else:
            lock.asked.release()
        return build(*args, **kwargs)

    monkeypatch.setattr(_model_construction, "complete_model_class", build_late)
    monkeypatch.setattr(fields, "building", lock)
    assert not Fresh.__pydantic_complete__
    with ThreadPoolExecutor(2) as pool:
        found = pool.map(lambda number: Fresh.model_validate({"number": number}).model_dump(), (1, 2))
        assert list(found) == [{"number": 1}, {"number": 2}]
    assert builds == 1


def test_every_model_is_built_at_its_first_use() -> None:
    assert [model.__name__ for model in MODELS if not issubclass(model, Deferred)] == []
