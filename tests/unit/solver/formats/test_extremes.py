"""Exports of extreme parts of a picture: a file, or the reason why there is none."""

import contextlib
import time

import numpy as np
import pytest

from calibsolver import CalibrationError, Camera, DeadlineError, deadline, formats, image_transform
from calibsolver.formats.convert import share_behind
from tests.helpers.solver import synthetic


@pytest.mark.parametrize("name", formats.FORMAT_NAMES)
@pytest.mark.parametrize("size", [(1280, 1), (15, 720)])
def test_part_below_16_px_is_refused(name: str, size: tuple[int, int]) -> None:
    camera = synthetic.rectilinear_cameras()[6]
    part = image_transform.crop(camera.img_size, (0, 0), size)
    with pytest.raises(CalibrationError, match=f"{size[0]} x {size[1]} px") as refused:
        formats.write(formats.ExportSource(camera), name, part)
    assert refused.value.code == "not_representable"


@pytest.mark.parametrize("name", formats.FORMAT_NAMES)
def test_small_part_is_written_with_a_finite_error_or_refused(name: str) -> None:
    camera = synthetic.rectilinear_cameras()[6]
    part = image_transform.crop(camera.img_size, (0, 0), (16, 16))
    error = coverage = 0.0
    begun = time.thread_time()
    short = deadline.limit(lambda: begun + 0.3 - time.thread_time())
    with short, contextlib.suppress(CalibrationError, DeadlineError):
        written = formats.write(formats.ExportSource(camera), name, part)
        error, coverage = written.error, written.coverage
    assert np.isfinite([error, coverage]).all()


def test_share_behind_of_a_fisheye_without_a_ray_is_none() -> None:
    """Of a lens that folds at once, far from its principal point, no pixel has a ray."""
    k = np.array([[0.5, 0, 1e7], [0, 0.5, 1e7], [0, 0, 1]])
    camera = Camera("fisheye", k, np.array([-9e3, 0, 0, 0]), (1280, 720))
    assert not np.isfinite(camera.unproject(np.array([[0.0, 0.0], [640.0, 360.0]]))).any()
    assert share_behind(camera) == 0.0
