"""Fixed plan for a client without a server: current, easy to hold, nearly as accurate."""

import json

import numpy as np
import pytest

from calibsolver import Board
from calibsolver.guidance import FixedPlan
from infra.web_build import plan
from tests.helpers.solver import synthetic


@pytest.fixture(scope="module")
def fixed() -> FixedPlan:
    return FixedPlan(Board(), plan.IMG_SIZE)


def test_committed_plan_is_current(fixed: FixedPlan, monkeypatch: pytest.MonkeyPatch) -> None:
    """To a hundredth of a degree: the last digits differ between machines."""
    monkeypatch.setattr(plan, "FixedPlan", lambda *_: fixed)
    ours, theirs = json.loads(plan.text()), json.loads(plan.PLAN_PATH.read_text())
    assert len(ours) == len(theirs)
    advice = "run `python -m infra.web_build.plan`"
    for one, other in zip(ours, theirs, strict=True):
        np.testing.assert_allclose(one["rvec"], other["rvec"], atol=2e-4, err_msg=advice)
        np.testing.assert_allclose(one["tvec"], other["tvec"], atol=2e-3, err_msg=advice)
        assert [one[k] for k in ("purpose", "hint", "hint_code")] == [
            other[k] for k in ("purpose", "hint", "hint_code")
        ]


def test_plan_poses_are_near_and_visible(fixed: FixedPlan) -> None:
    for pose in fixed.poses:
        assert len(pose.ids) >= 0.75 * 40
        assert np.linalg.norm(pose.tvec) < 2.5 * 9


def test_skipped_pose_is_followed_by_the_next(fixed: FixedPlan) -> None:
    assert fixed.next_pose([], None) is fixed.poses[0]
    assert fixed.next_pose([], None, [fixed.poses[0]]) is fixed.poses[1]


def test_fixed_plan_error_after_four_and_six_views(fixed: FixedPlan) -> None:
    """Every fourth camera, 0.2 px of noise: mean error after 4 and 6 views."""
    sessions = [
        synthetic.run(camera, np.random.default_rng(10 * i), views=6, guide=fixed)
        for i, camera in list(enumerate(synthetic.rectilinear_cameras()))[2::4]
    ]
    assert np.median([s.mean[3] for s in sessions]) <= 0.22
    assert np.median([s.mean[5] for s in sessions]) <= 0.15
