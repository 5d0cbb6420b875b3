"""Relation of two image sizes of a camera, inferred from calibrations at both."""

import json

import numpy as np
import pytest

from calibdb.lookup.relation import relate, scaling_window, transfer_intrinsics
from calibdb.schema import Calibration, FitRecord
from calibsolver import fit as solve
from tests.helpers.data import corner_views, external_data
from tests.helpers.service.known import consensus, fit

Size = tuple[int, int]


def camera(record: FitRecord) -> Calibration:
    found = consensus(record).calibration
    assert found is not None
    return found


def made(size: Size, s: float, of: Calibration, off: float = 1.0) -> Calibration:
    """The camera that draws `of`'s picture scaled by `s` and cut to `size`; `off`: of focal length."""
    (f, _, x), (_, _, y), _ = of.camera_matrix
    w, h = of.img_size
    center = (
        s * (x + 0.5) - 0.5 - (s * w - size[0]) / 2,
        s * (y + 0.5) - 0.5 - (s * h - size[1]) / 2,
    )
    return camera(fit(size, f * s * off, center, uncertainty=0.1 * s))


FULL = camera(fit((1920, 1080), 1400.0, (970.0, 531.0)))


@pytest.mark.parametrize(
    ("size", "s", "relation"),
    [
        ((960, 540), 0.5, "scale"),
        ((1280, 720), 2 / 3, "scale"),
        ((1440, 1080), 1.0, "crop"),
        ((640, 480), 1.0, "crop"),
        ((640, 480), 0.5, "scale+crop"),
        ((1280, 720), 0.8, "scale+crop"),  # the same aspect, but cut for stabilisation
    ],
)
def test_relation_transfers_the_intrinsics(size: Size, s: float, relation: str) -> None:
    other = made(size, s, FULL, off=1.001)  # as far as good calibrations differ
    found, window = relate(FULL, other)
    assert found == relation
    assert window is not None
    matrix, distortion = transfer_intrinsics(FULL, window)
    exact = np.array(made(size, s, FULL).camera_matrix)
    assert np.abs(np.array(matrix) - exact).max() < 0.002 * exact[0, 0]
    assert distortion == FULL.distortion_coefficients
    back, cannot = relate(other, FULL)
    assert back == relation
    assert (cannot is None) == (relation != "scale")  # of what was cut off nothing is known


@pytest.mark.parametrize("model", ["rectilinear", "fisheye"])
def test_half_a_pixel_is_kept(model: str) -> None:
    """The middle of the picture stays the middle: c' = (c + ½) s − ½."""
    of = camera(
        fit((1280, 720), 900.0, (639.5, 359.5), (0.0,) * 4 if model == "fisheye" else (0.0,) * 5, model)
    )
    (_, _, x), (_, _, y), _ = transfer_intrinsics(of, scaling_window(of, (640, 360)))[0]
    assert (x, y) == (319.5, 179.5)


@pytest.mark.parametrize(
    ("size", "s", "off"),
    [
        ((960, 540), 0.5, 1.02),  # neither scaled nor cut: another lens, by two hundredths
        ((640, 480), 0.4, 1.0),  # shows less in width, and more in height
    ],
)
def test_unrelated_sizes_have_no_relation(size: Size, s: float, off: float) -> None:
    assert relate(FULL, made(size, s, FULL, off)) == ("neither", None)


def test_relation_is_unknown_for_a_model_without_formulas() -> None:
    """Documents may hold a model that the solver knows and the lookup's projection does not."""
    half = made((960, 540), 0.5, FULL)
    fifth = [c.model_copy(update={"distortion_model": "double_sphere"}) for c in (FULL, half)]
    assert relate(fifth[0], fifth[1]) == (None, None)
    assert relate(FULL, half)[0] == "scale"


def test_another_bend_is_another_lens() -> None:
    other = camera(fit((960, 540), 700.0, (484.75, 265.25), (-0.3, 0.05, 0, 0, 0)))
    assert relate(FULL, other) == ("neither", None)


def test_uncertain_calibrations_neither_verify_nor_refute() -> None:
    vague = camera(fit((960, 540), 700.0, uncertainty=3.0))
    assert relate(FULL, vague) == (None, None)
    assert relate(vague, FULL) == (None, None)


def measured(name: str) -> Calibration:
    record = solve(*corner_views(name)).record()
    return camera(FitRecord.model_validate(json.loads(json.dumps(record))))


@external_data
@pytest.mark.parametrize(
    ("one", "other", "ratio"),
    [("pv_charuco_1280", "pv_charuco_480", 1.06 / 0.88), ("pv_picam_1920", "pv_picam_960", 1.0 / 1.43)],
)
def test_real_cameras_whose_field_of_view_differs_between_sizes(one: str, other: str, ratio: float) -> None:
    """Scaling the matrix would be wrong by a fifth, and by a third; neither is offered."""
    a, b = measured(one), measured(other)
    widths = [c.camera_matrix[0][0] / c.img_size[0] for c in (a, b)]
    assert widths[1] / widths[0] == pytest.approx(ratio, rel=0.01)
    for pair in ((a, b), (b, a)):
        relation, window = relate(*pair)
        assert relation in (None, "neither")
        assert window is None
