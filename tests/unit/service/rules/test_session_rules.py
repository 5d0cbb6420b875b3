"""The rules of a capture on its document alone."""

from contextlib import nullcontext
from typing import Any

import pytest

from calibdb.errors import ConflictError, InvalidError
from calibdb.rules import session_result, session_rules
from calibdb.schema import EstimateDocument, SessionDocument, SessionRequest, ViewDocument

NOW = 1_700_000_000
SID = "6553f1000123456789abcdef"
REQUEST = SessionRequest(camera="Sam’s iPhone Camera", platform="iPhone", img_size=(1280, 720))
DOCUMENT = session_rules.begin(REQUEST, SID, 1, NOW)


def view(index: int, points: tuple[tuple[float, float], ...] = ((1.0, 2.0), (3.0, 4.0))) -> ViewDocument:
    return ViewDocument(index=index, ids=tuple(range(len(points))), points=points)


def accept(document: SessionDocument, index: int, progress: float) -> SessionDocument:
    views = (*document.views, view(index))
    return session_rules.with_view(document, views, EstimateDocument(progress=progress), {})


def test_no_persons_name_enters_a_document() -> None:
    assert "Sam" not in DOCUMENT.model_dump_json()


@pytest.mark.parametrize(
    ("point", "inside"),
    [
        ((-0.5, -0.5), True),
        ((1279.5, 719.5), True),
        ((-0.51, 0.0), False),
        ((0.0, -0.51), False),
        ((0.0, 719.51), False),
    ],
)
def test_the_image_ends_half_a_pixel_beyond_its_centres(point: tuple[float, float], inside: bool) -> None:
    with nullcontext() if inside else pytest.raises(InvalidError, match=r"points\.0"):
        session_rules.validate_view(DOCUMENT, view(0, (point,)))


@pytest.mark.parametrize(
    "changed",
    [
        {"camera": "Another"},
        {"zoom": 2.0},
        {"guidance": "pose-selection"},
        {"track": {"frameRate": 30}},
        {"capture": "recorded"},
        {"licence": "CC0-1.0"},
        {"licence": "CC0-1.0", "licence_version": "2026-11-22"},
    ],
)
def test_start_with_other_content_is_another_session(changed: dict[str, Any]) -> None:
    asked = SessionRequest.model_validate({**REQUEST.model_dump(), **changed})
    assert not session_rules.is_same_start(DOCUMENT, session_rules.begin(asked, SID, 1, NOW))
    assert session_rules.is_same_start(DOCUMENT, session_rules.begin(REQUEST, SID, 2, NOW + 1))


def test_indices_go_up_by_one_and_are_not_used_again() -> None:
    document = accept(accept(DOCUMENT, 0, 0.2), 1, 0.4)
    assert document.next_index == 2
    assert session_rules.is_idempotent_replay(document, view(1)) is True
    assert session_rules.is_idempotent_replay(document, view(2)) is False
    for index in (3, 77):
        with pytest.raises(ConflictError):
            session_rules.is_idempotent_replay(document, view(index))
    left = session_rules.without_view(document, 1)
    undone = session_rules.with_views(document, left, EstimateDocument(), {})
    assert undone.next_index == 2
    with pytest.raises(ConflictError):
        session_rules.is_idempotent_replay(undone, view(1))
    assert session_rules.without_view(undone, 1) is None


def test_progress_grows_and_an_undo_takes_it_back() -> None:
    document = accept(accept(DOCUMENT, 0, 0.5), 1, 0.4)
    assert document.estimate.progress == 0.5
    undone = session_rules.with_views(document, document.views[:1], EstimateDocument(progress=0.3), {})
    assert undone.estimate.progress == 0.3


def test_next_view_forgets_skipped_targets() -> None:
    document = session_rules.without_target(session_rules.with_target(DOCUMENT, {"n": 1}))
    accepted = accept(document, 0, 0.1)
    assert (document.skipped, accepted.skipped, accepted.unreached) == (({"n": 1},), (), ({"n": 1},))


def test_the_calibrations_id_follows_from_the_session() -> None:
    def identify(document: SessionDocument, now: int) -> str:
        return session_result.with_finish(document, now, "contributor", "0.1.0").finish.calibration_id

    assert identify(DOCUMENT, NOW) == identify(DOCUMENT, NOW + 9)
    day = int(SID[:8], 16) // 86_400 * 86_400
    assert identify(DOCUMENT, NOW).startswith(f"{DOCUMENT.camera_key}-{day:08x}"), "not the second"
    assert identify(session_rules.begin(REQUEST, SID, 5, NOW), NOW) != identify(DOCUMENT, NOW)
    with pytest.raises(ValueError, match="converged"):
        session_result.to_calibration(DOCUMENT)


def test_bound_of_points_is_the_solvers() -> None:
    from calibsolver.capture import rules

    assert session_rules.MAX_POINTS == rules.MAX_POINTS
