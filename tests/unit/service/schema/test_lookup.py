"""Lookup schema: a query says what a body says."""

from hypothesis import given
from hypothesis import strategies as st

from calibdb.schema import LookupRequest


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
