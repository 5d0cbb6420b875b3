"""Fuzzing of views."""

import os

import cv2
import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from infra.server.server import Server
from tests.helpers.service.client import Client

EXAMPLES = int(os.environ.get("CASES", "100")) // 10
FUZZ = settings(
    max_examples=EXAMPLES,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)


def fine(status: int) -> bool:
    return status < 500


# Anything that passes for a view of this board and image: the solver has to live with it.
POINT = st.tuples(st.floats(-0.5, 1279.5), st.floats(-0.5, 719.5))


def board_in(quad: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Positions of the 8 x 5 corners when the outer four lie at `quad`, be it a sliver or a bow tie."""
    outer = np.array([(0, 0), (7, 0), (7, 4), (0, 4)], np.float32)
    inside = np.array([[(column, row)] for row in range(5) for column in range(8)], np.float32)
    homography = cv2.getPerspectiveTransform(outer, np.array(quad, np.float32))
    with np.errstate(all="ignore"):
        points = np.nan_to_num(cv2.perspectiveTransform(inside, homography.astype(np.float32))[:, 0])
    return [(float(x), float(y)) for x, y in np.clip(points, -0.5, [1279.5, 719.5])]


QUADS = st.lists(POINT, min_size=4, max_size=4).map(board_in)
PLACES = st.one_of(
    QUADS,
    st.lists(POINT, min_size=1, max_size=40),
    st.lists(st.sampled_from([(0.0, 0.0), (640.0, 360.0), (1279.0, 719.0)]), min_size=1, max_size=40),
    st.lists(st.integers(0, 1279).map(lambda x: (float(x), 360.0)), min_size=4, max_size=40),
)


@FUZZ
@given(
    views=st.lists(
        st.tuples(st.permutations(range(40)), PLACES) | st.tuples(st.just(list(range(40))), QUADS),
        min_size=1,
        max_size=6,
    )
)
def test_views(stack: Server, views: list[tuple[list[int], list[tuple[float, float]]]]) -> None:
    client = Client(stack)
    client.open()
    index = 0
    for ids, points in views:
        answer = client.view(index, ids[: len(points)], points)
        assert fine(answer.status)
        index += answer.status == 200 and answer.json["accepted"]
    assert client.call("GET", "/v1/session").status == 200
    assert fine(client.pose().status)
