"""Files of tools whose models are not calibsolver's, and binary ones: the rays of pixels stay the same."""

import json
import struct

import numpy as np
import pytest

from calibsolver import CalibrationError
from calibsolver.formats import FORMATS
from calibsolver.formats.base import ReaderOptions
from calibsolver.formats.reading import read_bytes
from tests.helpers.data import ROOT
from tests.helpers.solver.export_sources import image_rays, subject, written

DS = {"fx": 158.28, "fy": 158.27, "cx": 254.96, "cy": 256.88, "xi": -0.172, "alpha": 0.593}
EUCM = {"fx": 460.0, "fy": 459.0, "cx": 370.2, "cy": 250.1, "alpha": 0.62, "beta": 1.05}
FILES = ROOT / "tests" / "data" / "imports" / "foreign"


def projected(kind: str, values: dict[str, float], rays: np.ndarray) -> np.ndarray:
    """Pixels by the models' forward formulas."""
    x, y, z = rays.T
    alpha = values["alpha"]
    if kind == "ds":
        near = np.sqrt(x * x + y * y + z * z)
        shifted = values["xi"] * near + z
        depth = alpha * np.sqrt(x * x + y * y + shifted**2) + (1 - alpha) * shifted
    else:
        depth = alpha * np.sqrt(values["beta"] * (x * x + y * y) + z * z) + (1 - alpha) * z
    return np.stack(
        [values["fx"] * x / depth + values["cx"], values["fy"] * y / depth + values["cy"]], axis=1
    )


@pytest.mark.parametrize(("kind", "values", "size"), [("ds", DS, (512, 512)), ("eucm", EUCM, (752, 480))])
def test_basalt_and_kalibr_have_the_closest_camera_with_its_error(
    kind: str, values: dict[str, float], size: tuple[int, int]
) -> None:
    basalt = {"value0": {"intrinsics": [{"camera_type": kind, "intrinsics": values}], "resolution": [size]}}
    first = [values["xi"], values["alpha"]] if kind == "ds" else [values["alpha"], values["beta"]]
    numbers = [*first, *(values[name] for name in ("fx", "fy", "cx", "cy"))]
    kalibr = {"cam0": {"camera_model": kind.upper(), "intrinsics": numbers, "resolution": size}}
    for content in (basalt, kalibr):
        result = read_bytes(json.dumps(content).encode())
        assert result.camera is not None
        rays, q = image_rays(result.camera, 23, 17)
        assert len(q) > 0.95 * 23 * 17
        off = np.linalg.norm(projected(kind, values, rays) - q, axis=1)
        assert off.max() < result.error + 0.2
        assert result.error < 1.0


@pytest.mark.parametrize(
    ("members", "reason"),
    [
        ({"camera_model": [], "distortion_model": "fov"}, "fov"),
        ({"camera_model": "ds", "intrinsics": [*DS.values()]}, "ds with radtan"),
        ({"distortion_coeffs": None}, "distortion_coeffs"),
        ({"camera_model": "omni", "intrinsics": [1, 900, 900, 640, 360], "distortion_model": "equi"}, "with"),
    ],
)
def test_other_camera_of_a_camchain_is_refused(members: dict[str, object], reason: str) -> None:
    pinhole = {"camera_model": "pinhole", "distortion_model": "radtan", "distortion_coeffs": [0.1, 0, 0, 0]}
    cam = {"intrinsics": [900, 900, 640, 360], "resolution": [1280, 720], **pinhole, **members}
    with pytest.raises(CalibrationError, match=reason) as refused:
        read_bytes(json.dumps({"cam0": cam}).encode())
    assert refused.value.code == "malformed"


def test_json_of_calibdb_without_its_coefficients_is_refused() -> None:
    matrix = [[900, 0, 640], [0, 900, 360], [0, 0, 1]]
    members = {"img_size": [1280, 720], "camera_matrix": matrix, "distortion_coefficients": None}
    with pytest.raises(CalibrationError, match="distortion_coefficients"):
        read_bytes(json.dumps(members).encode())


def test_ocamcalib_looks_along_z_and_counts_rows_first() -> None:
    result = read_bytes((FILES / "calib_results.txt").read_bytes(), ".txt")
    assert result.camera is not None
    assert result.camera.img_size == (752, 480)
    assert 1 < result.error < 2, "in the corners, 90 degrees off the axis"
    axis = result.camera.project(np.array([[0.0, 0.0, 1.0]]))[0]
    assert axis == pytest.approx([394.55, 241.8], abs=1.0)
    right = result.camera.unproject(np.array([[600.0, 241.8]]))[0]
    rho = 600 - 394.553
    z = 206.517 - 2.207161e-03 * rho**2 + 4.879622e-06 * rho**3 - 1.865656e-08 * rho**4
    assert np.arctan2(right[0], right[2]) == pytest.approx(np.arctan2(rho, z), abs=0.004)


def test_metashape_documents_have_the_adjusted_calibration() -> None:
    camera = read_bytes((FILES / "metashape.xml").read_bytes(), ".xml").camera
    assert camera is not None
    assert camera.intrinsics == pytest.approx(
        [8700.5, 8700.5, 3008 + 12.5 - 0.5, 2004 - 8.25 - 0.5, -0.05, 0.02, -0.002, 0.001, -0.01]
    )


def test_lens_database_gives_the_camera_of_each_focal_length() -> None:
    content = (FILES / "lensfun.xml").read_bytes()
    options = ReaderOptions(img_size=(6000, 4000), number=1)
    result = read_bytes(content, ".xml", options)
    assert result.camera is not None
    assert len(result.cameras) == 2
    width_mm = 36 / 1.523
    assert result.camera.focal[0] == pytest.approx(55 / width_mm * 5999, rel=0.01)
    assert result.error < 1.0
    with pytest.raises(CalibrationError, match="--img-size"):
        read_bytes(content, ".xml")
    with pytest.raises(CalibrationError, match="entities"):
        read_bytes(content.replace(b'.dtd">', b'.dtd" [<!ENTITY a "b">]>'), ".xml")


def test_meshroom_of_both_ages_is_read() -> None:
    old = {
        "intrinsicId": "1",
        "width": "1280",
        "height": "720",
        "type": "radial3",
        "pxFocalLength": "900.0",
        "principalPoint": ["650.0", "352.0"],
        "distortionParams": ["-0.2", "0.05", "0.01"],
    }
    new = {
        **{key: old[key] for key in ("intrinsicId", "width", "height", "distortionParams")},
        "sensorWidth": "36",
        "focalLength": str(900 / 1280 * 36),
        "principalPoint": ["10.0", "-8.0"],
        "distortionType": "radialk3",
    }
    for intrinsic in (old, new):
        document = {"version": ["1", "2", "6"], "intrinsics": [intrinsic]}
        camera = read_bytes(json.dumps(document).encode()).camera
        assert camera is not None
        assert camera.intrinsics == pytest.approx([900, 900, 649.5, 351.5, -0.2, 0.05, 0, 0, 0.01])


def test_artoolkits_binary_file_is_read_back() -> None:
    raw = written("rectilinear", "artoolkit").content
    result = read_bytes(raw, ".dat").camera
    assert result is not None
    held = FORMATS["artoolkit"].convert(subject("rectilinear")).camera
    assert result.intrinsics == pytest.approx(held.intrinsics)
    with pytest.raises(CalibrationError, match="versions 1 to 3"):
        read_bytes(raw[: struct.calcsize(">2i12d") + 32], ".dat")
