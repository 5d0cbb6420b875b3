"""Files in the spellings, nestings and encodings of many tools, our own among them, are read or refused."""

import codecs
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from calibsolver import CalibrationError, View, formats
from calibsolver.formats import ImportedFile
from calibsolver.formats.base import ReaderOptions
from calibsolver.formats.grid import grid
from calibsolver.formats.reading import read_bytes
from tests.helpers.data import ROOT, corner_set, corner_views, data_dir, external_data
from tests.helpers.marks import corner_sets, thorough
from tests.helpers.solver.export_sources import IMG_SIZE as SIZE
from tests.helpers.solver.export_sources import subject, written

NESTED = [[900.0, 0.0, 630.0], [0.0, 905.0, 350.0], [0.0, 0.0, 1.0]]
D = [-0.2, 0.05, 0.001, -0.001, 0.01]
FISHEYE = [0.02, -0.01, 0.003, -0.001]
INTRINSICS = [900.0, 905.0, 630.0, 350.0]
BOARD = ReaderOptions(squares=(9, 6))
SIZED = ReaderOptions(img_size=SIZE)
NONE = ReaderOptions()


def imported(name: str, content: str | bytes, options: ReaderOptions = NONE) -> ImportedFile:
    raw = content if isinstance(content, bytes) else content.encode()
    return read_bytes(raw, Path(name).suffix, options)


def read_file(path: Path, options: ReaderOptions = NONE) -> ImportedFile:
    return imported(path.name, path.read_bytes(), options)


def holds(found: ImportedFile, model: str, d: list[float]) -> None:
    assert found.camera is not None
    assert (found.camera.model, found.camera.img_size) == (model, SIZE)
    assert np.allclose(found.camera.intrinsics[:4], INTRINSICS, rtol=0, atol=1e-9)
    assert np.allclose(found.camera.distortion, d, rtol=0, atol=1e-12)


FILES = ROOT / "tests" / "data" / "imports"
EIGHT = ("cameras.txt", "webcam.xml")
"""Files of eight coefficients, the last three zero."""
MODELS = {
    "rectilinear": D,
    "fisheye": FISHEYE,
    "omnidirectional": [1.2, *D[:4]],
    "rational": [0.5, -0.1, 0.001, -0.001, 0.01, 0.8, -0.05, 0.02],
}


@pytest.mark.parametrize(
    ("model", "name"), [(model, path.name) for model in MODELS for path in sorted((FILES / model).iterdir())]
)
def test_camera_in_any_spelling_and_nesting_is_read(model: str, name: str) -> None:
    found = read_file(FILES / model / name)
    if name in EIGHT:
        holds(found, "rational", [*D, 0, 0, 0])
    else:
        holds(found, model, MODELS[model])


@pytest.mark.parametrize(
    "encode",
    [
        lambda s: codecs.BOM_UTF8 + s.encode(),
        lambda s: codecs.BOM_UTF16_LE + s.encode("utf-16-le"),
        lambda s: codecs.BOM_UTF16_BE + s.encode("utf-16-be"),
        lambda s: s.encode("utf-16-le"),
        lambda s: s.replace("\n", "\r\n").encode(),
        lambda s: s.replace("\n", "\r").encode(),
        lambda s: s.replace("a remark", "Maßstab in µm").encode("cp1252"),
    ],
    ids=["bom", "utf-16-le", "utf-16-be", "utf-16", "crlf", "cr", "cp1252"],
)
def test_encodings_and_line_ends_make_no_difference(encode: Callable[[str], bytes]) -> None:
    for name in ("tabs.yaml", "tutorial.json", "out_camera_data.xml", "ost.txt"):
        holds(imported(name, encode((FILES / "rectilinear" / name).read_text())), "rectilinear", D)


def test_archive_of_arrays_is_read_with_the_size_given(tmp_path: Path) -> None:
    path = tmp_path / "calibration.npz"
    views = np.empty(2, dtype=object)
    np.savez(path, mtx=NESTED, dist=[D], rvecs=views, tvecs=np.zeros((2, 3, 1)))
    with pytest.raises(CalibrationError, match="--img-size"):
        read_file(path)
    holds(read_file(path, SIZED), "rectilinear", D)
    np.savez(path, mtx=views)
    with pytest.raises(CalibrationError, match="pickled"):
        read_file(path)


def test_matrix_of_numbers_alone_is_read() -> None:
    content = "9.0e+02 0.0e+00 6.3e+02\n0 905 350\n0 0 1\n-0.2 0.05 0.001 -0.001 0.01\n"
    holds(imported("k.txt", content, SIZED), "rectilinear", D)


def test_coefficients_without_a_name_are_of_the_model_asked_for() -> None:
    content = json.dumps({"K": NESTED, "D": FISHEYE, "size": SIZE})
    holds(imported("c.json", content), "rectilinear", [*FISHEYE, 0])
    holds(imported("c.json", content, ReaderOptions(model="fisheye")), "fisheye", FISHEYE)


SEVERAL = {
    "chain.yaml": (("cam0", "cam1", "cam10"), [900, 901, 910]),
    "stereo.yml": (("1", "2"), [901, 902]),
    "sides.json": (("left", "right"), [900, 910]),
    "list.json": (("cameras.0", "cameras.1", "cameras.2"), [900, 901, 902]),
    "colmap.txt": (("0", "1"), [900, 901]),
    "ost.txt": (("0", "1"), [900, 905]),
}


@pytest.mark.parametrize("name", SEVERAL)
def test_cameras_of_one_file_are_asked_for_by_number(name: str) -> None:
    names, focals = SEVERAL[name]
    size = SIZE if name == "stereo.yml" else None
    for number, focal in enumerate(focals):
        found = read_file(FILES / "several" / name, ReaderOptions(number=number, img_size=size))
        assert found.cameras == names
        assert found.camera is not None
        assert (found.camera.img_size, found.camera.matrix[0, 0]) == (SIZE, focal)
    with pytest.raises(CalibrationError, match=f"no camera {len(focals)}.*counted from 0"):
        read_file(FILES / "several" / name, ReaderOptions(number=len(focals), img_size=size))


READABLE = {
    "calibdb": ".json",
    "opencv-yaml": ".yml",
    "opencv-json": ".json",
    "ros": ".yaml",
    "kalibr": ".yaml",
    "opensfm": ".json",
    "mrcal": ".cameramodel",
    "gyroflow": ".json",
    "photonvision": ".json",
}


@pytest.mark.parametrize("model", ["rectilinear", "fisheye", *thorough("rational", "omnidirectional")])
@pytest.mark.parametrize("name", READABLE)
def test_written_files_round_trip(name: str, model: str) -> None:
    mine = subject(model)
    held = formats.FORMATS[name].convert(mine).camera
    found = imported(READABLE[name], written(model, name).content)
    assert found.camera is not None
    assert found.camera.model == held.model
    assert found.camera.img_size == SIZE
    assert np.allclose(found.camera.intrinsics, held.intrinsics, rtol=1e-9, atol=0)
    if name in ("mrcal", "photonvision"):
        same_keypoints(found.views, mine.views)


def same_keypoints(found: tuple[View, ...], sent: tuple[View, ...]) -> None:
    recognised = grid(found)
    assert recognised.squares == (9, 6)
    assert len(found) == len(sent)
    for ids, back, view in zip(recognised.ids, found, sent, strict=True):
        p = np.array([[i % 8 + 1, i // 8 + 1] for i in ids])
        assert np.array_equal(p, view.object_points[:, :2])
        assert np.array_equal(back.image_points, view.image_points)


def test_table_of_corners_is_read() -> None:
    """Pictures without a board have one line."""
    content = written("rectilinear", "corners-vnl").content
    legend, *rows = content.decode().partition("# filename")[2].splitlines()
    assert legend == " x y level"
    assert {len(row.split()) for row in rows} == {4}, "as mrcal requires"
    content += b"empty.png - - -\n"
    same_keypoints(imported("corners.vnl", content, BOARD).views, subject("rectilinear").views)
    for options, reason in ((NONE, "squares"), (ReaderOptions(squares=(11, 8)), "70 lines")):
        with pytest.raises(CalibrationError, match=reason):
            imported("corners.vnl", content, options)
    with pytest.raises(CalibrationError, match="not pixels"):
        imported("corners.vnl", "img.jpg a b\n", BOARD)


@pytest.mark.parametrize("unit", [0.0254, 3.0])
def test_board_is_recognised_in_any_unit_from_any_corner(unit: float) -> None:
    sent = subject("rectilinear").views
    moved = [View((v.object_points - (1, 1, 0)) * unit + (7, -2, 0), v.image_points) for v in sent]
    assert grid(moved) == grid(sent)
    bent = [View(v.object_points + (0, 0, 0.2) * (v.object_points[:, :1] > 4), v.image_points) for v in sent]
    with pytest.raises(CalibrationError, match="flat"):
        grid(bent)
    scattered = [View(v.object_points * (1, 1.07, 0), v.image_points) for v in sent]
    with pytest.raises(CalibrationError, match="rows and columns"):
        grid(scattered)


SQUARES = {"opencv_left": (10, 7), "pv_charuco_1280": (8, 8)}


@pytest.mark.parametrize("name", corner_sets(SQUARES))
def test_corners_of_real_photographs_match_their_board(name: str) -> None:
    held = corner_set(name)["views"]
    recognised = grid(tuple(corner_views(name)[0]))
    assert recognised.squares == SQUARES[name]
    expected = [list(v.get("ids", range(len(v["obj"])))) for v in held]
    assert [list(ids) for ids in recognised.ids] == expected


def test_gyroflow_anamorphic_picture_is_compressed_again() -> None:
    """Without the flag `asymmetrical` the principal point is the centre."""
    params = {"camera_matrix": [[1800, 0, 1280], [0, 905, 350], [0, 0, 1]], "distortion_coeffs": FISHEYE}
    stretch = {"input_horizontal_stretch": 2.0, "input_vertical_stretch": 0}
    profile = {"calib_dimension": {"w": 2560, "h": 720}, "fisheye_params": params, **stretch}
    found = imported("g.json", json.dumps(profile)).camera
    assert found is not None
    assert found.img_size == SIZE
    assert np.allclose(found.intrinsics[:4], [900, 905, 640, 360])


REFUSED: dict[str, str] = json.loads((FILES / "refused.json").read_text())
"""Words about the files in the folder `refused`, by name."""


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_no_camera_known_here_is_refused_in_words(name: str) -> None:
    refused(name, (FILES / "refused" / name).read_bytes(), REFUSED[name])


def refused(name: str, content: str | bytes, reason: str) -> None:
    with pytest.raises(CalibrationError, match=reason) as caught:
        imported(name, content)
    assert caught.value.code == "malformed"
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 500


def test_binary_large_and_deep_files_are_refused() -> None:
    refused("camera.pkl", b"\x80\x04\x95", "pickle")
    refused("matlab.mat", b"MATLAB 5.0 MAT-file, Platform", "MATLAB")
    refused("ros.tar.gz", b"\x1f\x8b\x08\x00", "unpack")
    refused("image.json", b"\x89PNG\r\n\xff\xfe", "no text")
    refused("deep.yaml", "a: " + "[" * 500 + "]" * 500, "nested too deeply")
    refused("deep.json", "[" * 100_000, "JSON|nested")
    refused("brackets.cameramodel", "'lensmodel'" + "(" * 5000, "not a Python dictionary")
    refused("large.yaml", "a: 1\n" * 300_000, "larger than")
    refused(
        "nines.json",
        '{"fx": 900, "fy": 900, "cx": 1, "cy": 1, "width": 9, "height": %s}' % ("9" * 400),
        "a number",
    )


@pytest.mark.parametrize(
    ("member", "value", "reason"),
    [
        ("resolution", {"width": 1280}, "resolution.height"),
        ("resolution", {"width": 1e9, "height": 720}, "resolution.width"),
        ("cameraIntrinsics", {"data": [1, 2, 3]}, "9 to 9 numbers"),
        ("cameraIntrinsics", {"data": ["a"] * 9}, "must be numbers"),
        ("cameraIntrinsics", {"data": [0.0] * 9}, "positive"),
        ("distCoeffs", {"data": [0.1] * 12}, "thin prism"),
        ("observations", "many", "list"),
        ("observations", [{}] * 2000, "at most"),
        ("observations", [{"locationInObjectSpace": [{"x": 1}]}], "has no y"),
    ],
)
def test_damaged_member_of_photonvisions_file_is_named(member: str, value: object, reason: str) -> None:
    good = json.loads(written("rectilinear", "photonvision").content)
    refused("camera.json", json.dumps({**good, member: value}), reason)


def test_size_that_contradicts_the_file_is_refused() -> None:
    with pytest.raises(CalibrationError, match="1280 x 720, not 640 x 480"):
        read_file(FILES / "rectilinear" / "camera.yml", ReaderOptions(img_size=(640, 480)))


#: genuine files that are no calibration, or of a model that is not known here
NO_CAMERA = ("configs_default", "configs_lenovo_laptop.xml", "cv2written_14", "splined", "usb_cam")


@external_data
def test_genuine_calibrations_are_accepted_and_others_refused() -> None:
    files = sorted((data_dir() / "imports").iterdir())
    refused = {}
    for path in files:
        try:
            found = read_file(path, ReaderOptions(squares=(8, 8)))
        except CalibrationError as error:
            refused[path.name] = str(error)
        else:
            assert found.camera or found.views
    assert len(files) >= 53
    assert all(any(part in name for part in NO_CAMERA) for name in refused), refused
    assert len(refused) == len(NO_CAMERA)
    assert all(len(why) < 500 and "\n" not in why for why in refused.values())
