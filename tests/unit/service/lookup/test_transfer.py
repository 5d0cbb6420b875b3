"""Transfer to a size or zoom that was not calibrated: verified relations only."""

from typing import Any

import numpy as np
import pytest

from calibdb.lookup.transfer import Window, bracketing_zooms, build_answer, relate, transfer_intrinsics
from calibdb.schema import Calibration, ConsensusDocument, FitRecord
from calibsolver import fit as solve
from tests.helpers.data import corner_views, external_data
from tests.helpers.service.known import consensus, fit

Size = tuple[int, int]
F = 900.0  # px at 1280


def at(size: Size, s: float | None = None, **options: object) -> ConsensusDocument:
    """The camera at a size, its picture scaled by width or by `s`."""
    return consensus(fit(size, F * (size[0] / 1280 if s is None else s), uncertainty=0.1), **options)


SMALL, HD, FULL_HD = (640, 360), (1280, 720), (1920, 1080)


@pytest.mark.parametrize(
    ("known", "size", "relation", "focal"),
    [
        pytest.param([at(SMALL), at((960, 540))], FULL_HD, "scale", None, id="above the known sizes"),
        pytest.param([at(SMALL), at((960, 540))], (320, 180), "scale", None, id="below the known sizes"),
        pytest.param([at(SMALL), at(FULL_HD)], (1280, 960), "scale", None, id="another aspect"),
        pytest.param([at(SMALL), at(FULL_HD, s=1.9)], HD, "scale+crop", None, id="between unrelated sizes"),
        pytest.param(
            [at((1280, 960)), at((640, 480), reason="too_few", calibrations=2)], (640, 480), "scale", F / 2,
            id="two calibrations there",
        ),
        *(
            pytest.param([at(SMALL), at(FULL_HD), at(HD, reason=reason, calibrations=n)], HD, None, None)
            for reason, n in (("too_few", 1), ("disagree", 6))
        ),
        pytest.param(
            [at(FULL_HD), at(SMALL), at(HD, s=1.3, reason="too_few", calibrations=3)],
            *(HD, "scale+crop", 1.3 * F),
            id="evidence there outweighs sizes around",
        ),
    ],
)  # fmt: skip
def test_only_verified_relations_adapt_the_intrinsics(
    known: list[ConsensusDocument], size: Size, relation: str | None, focal: float | None
) -> None:
    answer = build_answer(known[0].calibration, known, size)
    assert answer.relation == relation
    if focal is None or answer.adapted is None:
        assert answer.adapted is focal
    else:
        assert answer.adapted.camera_matrix[0][0] == pytest.approx(focal, rel=1e-3)


def zoomed(*focal: tuple[float, float]) -> list[ConsensusDocument]:
    return [consensus(fit(f=f), zoom=zoom) for zoom, f in focal]


@pytest.mark.parametrize(
    ("known", "zoom"),
    [
        (((1.0, 900.0), (2.0, 1700.0)), 0.0),
        (((1.0, 900.0), (2.0, 1700.0), (3.0, 1600.0)), 1.5),  # not growing everywhere
        (((1.0, 900.0), (4.0, 3600.0)), 2.0),  # too far apart
        (((0.0, 900.0), (2.0, 1700.0)), 1.0),  # 0: unknown
    ],
)
def test_incomparable_zooms_are_not_interpolated(known: tuple[tuple[float, float], ...], zoom: float) -> None:
    assert bracketing_zooms(zoomed(*known), (1280, 720), zoom, "rectilinear") is None


def omnidirectional(zoom: float, f: float, xi: float) -> ConsensusDocument:
    return consensus(fit(f=(1 + xi) * f, distortion=(xi, 0, 0, 0, 0), model="omnidirectional"), zoom=zoom)


@pytest.mark.parametrize(
    ("known", "interpolated"),
    [
        (((900.0, 2.0), (1500.0, 0.5)), True),  # grows 1.7 times; its fx shrink from 2700 to 2250
        (((900.0, 0.5), (850.0, 2.0)), False),  # shrinks; its fx grow from 1350 to 2550
        (((900.0, 0.6), (2000.0, 0.0)), False),  # grows 2.2 times, too far; its fx 1.4 times
    ],
)
def test_zoom_interpolation_is_gated_by_focal_lengths_at_the_axis(
    known: tuple[tuple[float, float], ...], interpolated: bool
) -> None:
    documents = [omnidirectional(float(n), f, xi) for n, (f, xi) in enumerate(known, 1)]
    assert (bracketing_zooms(documents, (1280, 720), 1.5, "omnidirectional") is not None) is interpolated


def test_only_reliable_calibrations_are_interpolated_and_none_contradicted() -> None:
    known = zoomed((1.0, 900.0), (2.0, 1500.0))
    unreliable = consensus(fit(f=1500.0), zoom=2.0, reason="too_few")
    assert bracketing_zooms([known[0], unreliable], (1280, 720), 1.5, "rectilinear") is None
    too_few = consensus(fit(f=1200.0), zoom=1.5, reason="too_few", calibrations=1)
    assert bracketing_zooms([*known, too_few], (1280, 720), 1.5, "rectilinear") is not None
    at_odds = consensus(fit(f=1000.0), zoom=1.5, reason="disagree")
    assert bracketing_zooms([*known, at_odds], (1280, 720), 1.5, "rectilinear") is None
    assert bracketing_zooms([*known, at_odds], (1280, 720), 1.6, "rectilinear") is not None


def camera(*parameters: Any, **named: Any) -> Calibration:
    return consensus(fit(*parameters, **named)).calibration


def made(size: Size, s: float, of: Calibration, off: float = 1.0) -> Calibration:
    """The camera that draws `of`'s picture scaled by `s` and cut to `size`; `off`: of focal length."""
    (f, _, x), (_, _, y), _ = of.camera_matrix
    w, h = of.img_size
    center = (
        s * (x + 0.5) - 0.5 - (s * w - size[0]) / 2,
        s * (y + 0.5) - 0.5 - (s * h - size[1]) / 2,
    )
    return camera(size, f * s * off, center, uncertainty=0.1 * s)


FULL = camera((1920, 1080), 1400.0, (970.0, 531.0))


@pytest.mark.parametrize(
    ("size", "s", "relation"),
    [
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
    matrix, distortion = transfer_intrinsics(FULL, window)
    exact = np.array(made(size, s, FULL).camera_matrix)
    assert np.abs(np.array(matrix) - exact).max() < 0.002 * exact[0, 0]
    assert distortion == FULL.distortion_coefficients
    back, cannot = relate(other, FULL)
    assert back == relation
    assert (cannot is None) == (relation != "scale")  # of what was cut off nothing is known


def test_half_a_pixel_is_kept() -> None:
    """The middle of the picture stays the middle: c' = (c + ½) s − ½."""
    of = camera((1280, 720), 900.0, (639.5, 359.5))
    (_, _, x), (_, _, y), _ = transfer_intrinsics(of, Window(0.5, 0.5, (640, 360)))[0]
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


def test_another_bend_is_another_lens() -> None:
    other = camera((960, 540), 700.0, (484.75, 265.25), (-0.3, 0.05, 0, 0, 0))
    assert relate(FULL, other) == ("neither", None)


def test_uncertain_calibrations_neither_verify_nor_refute() -> None:
    vague = camera((960, 540), 700.0, uncertainty=3.0)
    assert relate(FULL, vague) == (None, None)
    assert relate(vague, FULL) == (None, None)


@external_data
@pytest.mark.parametrize(
    ("one", "other", "ratio"),
    [("pv_charuco_1280", "pv_charuco_480", 1.06 / 0.88), ("pv_picam_1920", "pv_picam_960", 1.0 / 1.43)],
)
def test_real_cameras_whose_field_of_view_differs_between_sizes(one: str, other: str, ratio: float) -> None:
    records = (FitRecord.model_validate(solve(*corner_views(name)).record()) for name in (one, other))
    a, b = (consensus(record).calibration for record in records)
    widths = [c.camera_matrix[0][0] / c.img_size[0] for c in (a, b)]
    assert widths[1] / widths[0] == pytest.approx(ratio, rel=0.01)
    for pair in ((a, b), (b, a)):
        relation, window = relate(*pair)
        assert relation in (None, "neither")
        assert window is None
