"""Exports of extreme parts of a picture: a file, or the reason why there is none."""

import contextlib
import time

import numpy as np
import pytest

from calibsolver import CalibrationError, DeadlineError, deadline, formats, image_transform
from tests.helpers.solver import synthetic


@pytest.mark.parametrize("name", formats.FORMAT_NAMES)
@pytest.mark.parametrize("size", [(1, 1), (1280, 1), (1, 720), (15, 720)])
def test_part_below_16_px_is_refused(name: str, size: tuple[int, int]) -> None:
    camera = synthetic.rectilinear_cameras()[6]
    part = image_transform.crop(camera.img_size, (0, 0), size)
    with pytest.raises(CalibrationError, match=f"{size[0]} x {size[1]} px") as refused:
        formats.write(formats.ExportSource(camera), name, part)
    assert refused.value.code == "not_representable"


@pytest.mark.parametrize("name", formats.FORMAT_NAMES)
@pytest.mark.parametrize("size", [(16, 16)])
def test_small_part_is_written_with_a_finite_error_or_refused(name: str, size: tuple[int, int]) -> None:
    camera = synthetic.rectilinear_cameras()[6]
    part = image_transform.crop(camera.img_size, (0, 0), size)
    error = coverage = 0.0
    begun = time.thread_time()
    short = deadline.limit(lambda: begun + 0.3 - time.thread_time())
    with short, contextlib.suppress(CalibrationError, DeadlineError):
        written = formats.write(formats.ExportSource(camera), name, part)
        error, coverage = written.error, written.coverage
    assert np.isfinite([error, coverage]).all()
