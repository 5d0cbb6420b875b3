"""Lookup schema: any request is read or refused by field, and any answer can be read again."""

import os
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import BaseModel, ValidationError

from calibdb.lookup.transfer import build_answer
from calibdb.schema import CamerasRequest, LookupAnswer, LookupRequest
from tests.helpers.service.known import consensus

NAMES = (
    *("camera", "platform", "userAgent", "img_size", "imsize", "zoom", "distortion_model", "redirect"),
    *("resize_mode", "resizeMode", "query", "limit", "after"),
)
VALUES = (
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(max_size=12)
    | st.lists(st.integers() | st.floats(), max_size=3)
    | st.sampled_from(
        ["1280x720", "1280×720", "rectilinear", "0", "1e3", "٣", "crop-and-scale", "true", [1280, 720]]
    )
)
FUZZ = settings(max_examples=400 if os.environ.get("THOROUGH") else 100, deadline=None, derandomize=True)


def parsed(model: type[BaseModel], content: dict[str, Any]) -> tuple[BaseModel | None, list[Any]]:
    try:
        return model.model_validate(content), []
    except ValidationError as error:
        return None, error.errors()


@pytest.mark.parametrize("model", [LookupRequest, CamerasRequest])
def test_arbitrary_input_is_read_or_refused_by_field(model: type[BaseModel]) -> None:
    @FUZZ
    @given(st.dictionaries(st.sampled_from(NAMES), VALUES, max_size=8))
    def check(content: dict[str, Any]) -> None:
        found, wrong = parsed(model, content)
        assert all(problem["loc"] for problem in wrong)
        if found is not None:
            assert model.model_validate_json(found.model_dump_json()) == found

    check()


@FUZZ
@given(
    w=st.integers(16, 4096),
    h=st.integers(16, 4096),
    zoom=st.floats(0, 1e6),
    separator=st.sampled_from("x×,"),
)
def test_query_equals_body(w: int, h: int, zoom: float, separator: str) -> None:
    camera = {"camera": "a", "platform": "b"}
    if max(w, h) > 8 * min(w, h):
        return
    query = LookupRequest.model_validate({**camera, "imsize": f"{w}{separator}{h}", "zoom": f"{zoom:.6f}"})
    body = LookupRequest.model_validate({**camera, "img_size": [w, h], "zoom": round(zoom, 6)})
    assert query == body


@FUZZ
@given(size=st.tuples(st.integers(16, 4096), st.integers(16, 4096)))
def test_answer_round_trips_at_any_size(size: tuple[int, int]) -> None:
    known = consensus()
    assert known.calibration is not None
    found = build_answer(known.calibration, [known], size)
    assert LookupAnswer.model_validate_json(found.model_dump_json()) == found
    assert found.exact_size == (size == (1280, 720))
