"""Lookup schema: a query says what a body says."""

import pytest

from calibdb.schema import LookupRequest


@pytest.mark.parametrize("separator", ["x", "×", ","])
def test_query_equals_body(separator: str) -> None:
    camera = {"camera": "a", "platform": "b"}
    query = LookupRequest.model_validate({**camera, "imsize": f"640{separator}480", "zoom": "1.500000"})
    body = LookupRequest.model_validate({**camera, "img_size": [640, 480], "zoom": 1.5})
    assert query == body
