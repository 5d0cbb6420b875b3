"""Exports of extreme parts of a picture: a file, or the reason why there is none."""

import numpy as np
import pytest

from calibsolver import CalibrationError, formats, image_transform
from tests.helpers.solver import synthetic


@pytest.mark.parametrize("name", formats.FORMAT_NAMES)
@pytest.mark.parametrize("size", [(1, 1), (1280, 1), (1, 720), (15, 720), (16, 16), (16, 128)])
def test_tiny_part_of_a_picture_is_written_or_refused(name: str, size: tuple[int, int]) -> None:
    camera = synthetic.rectilinear_cameras()[6]
    part = image_transform.crop(camera.img_size, (0, 0), size)
    try:
        written = formats.write(formats.ExportSource(camera), name, part)
    except CalibrationError as error:
        assert error.code == "not_representable"
        assert str(size[0]) in error.message or min(size) >= 16
    else:
        assert min(size) >= 16
        assert np.isfinite([written.error, written.coverage]).all()
