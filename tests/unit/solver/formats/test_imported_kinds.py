"""Files in the spellings, nestings and encodings of other tools hold the camera that they hold."""

import codecs
import json
from pathlib import Path

import numpy as np
import pytest

from calibsolver.formats import ImportedFile
from calibsolver.formats.base import ReaderOptions
from infra.ops import OpsError
from infra.ops.imports import read_file
from tests.helpers.data import data_dir, external_data

NESTED = [[900.0, 0.0, 630.0], [0.0, 905.0, 350.0], [0.0, 0.0, 1.0]]
D = [-0.2, 0.05, 0.001, -0.001, 0.01]
FISHEYE = [0.02, -0.01, 0.003, -0.001]
SIZE = (1280, 720)
INTRINSICS = [900.0, 905.0, 630.0, 350.0]


def imported(
    tmp_path: Path, name: str, content: str | bytes, options: ReaderOptions | None = None
) -> ImportedFile:
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return read_file(path, options or ReaderOptions())


def holds(found: ImportedFile, model: str, d: list[float]) -> None:
    assert found.camera is not None
    assert (found.camera.model, found.camera.img_size) == (model, SIZE)
    assert np.allclose(found.camera.intrinsics[:4], INTRINSICS, rtol=0, atol=1e-9)
    assert np.allclose(found.camera.distortion, d, rtol=0, atol=1e-12)


FILES = Path(__file__).parents[3] / "data" / "imports"
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
def test_encodings_and_line_ends_make_no_difference(tmp_path: Path, encode: object) -> None:
    assert callable(encode)
    for name in ("tabs.yaml", "tutorial.json", "out_camera_data.xml", "ost.txt"):
        holds(imported(tmp_path, name, encode((FILES / "rectilinear" / name).read_text())), "rectilinear", D)


def test_archive_of_arrays_is_read_with_the_size_given(tmp_path: Path) -> None:
    path = tmp_path / "calibration.npz"
    views = np.empty(2, dtype=object)
    np.savez(path, mtx=NESTED, dist=[D], rvecs=views, tvecs=np.zeros((2, 3, 1)))
    with pytest.raises(OpsError, match="--img-size"):
        read_file(path)
    holds(read_file(path, ReaderOptions(img_size=SIZE)), "rectilinear", D)
    np.savez(path, mtx=views)
    with pytest.raises(OpsError, match="pickled"):
        read_file(path)


def test_matrix_of_numbers_alone_is_read(tmp_path: Path) -> None:
    content = "9.0e+02 0.0e+00 6.3e+02\n0 905 350\n0 0 1\n-0.2 0.05 0.001 -0.001 0.01\n"
    holds(imported(tmp_path, "k.txt", content, ReaderOptions(img_size=SIZE)), "rectilinear", D)


def test_coefficients_without_a_name_are_of_the_model_asked_for(tmp_path: Path) -> None:
    content = json.dumps({"K": NESTED, "D": FISHEYE, "size": SIZE})
    holds(imported(tmp_path, "c.json", content), "rectilinear", [*FISHEYE, 0])
    holds(imported(tmp_path, "c.json", content, ReaderOptions(model="fisheye")), "fisheye", FISHEYE)


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
    with pytest.raises(OpsError, match=f"no camera {len(focals)}.*counted from 0"):
        read_file(FILES / "several" / name, ReaderOptions(number=len(focals), img_size=size))


def gyroflow(**members: object) -> str:
    params = {"camera_matrix": [[1800, 0, 1280], [0, 905, 360], [0, 0, 1]], "distortion_coeffs": FISHEYE}
    return json.dumps({"calib_dimension": {"w": 2560, "h": 720}, "fisheye_params": params, **members})


def test_gyroflow_anamorphic_picture_is_compressed_again(tmp_path: Path) -> None:
    stretched = gyroflow(input_horizontal_stretch=2.0, input_vertical_stretch=0)
    found = imported(tmp_path, "g.json", stretched).camera
    assert found is not None
    assert found.img_size == SIZE
    assert np.allclose(found.intrinsics[:4], [900, 905, 640, 360])


def camera(**members: object) -> str:
    return json.dumps({"fx": 900, "fy": 905, "cx": 630, "cy": 350, "size": SIZE, **members})


REFUSED = {
    "superview.json": (gyroflow(digital_lens="gopro_superview"), "digital lens .gopro_superview"),
    "old.json": (gyroflow(is_superview=True), "digital lens"),
    "ptlens.json": (gyroflow(distortion_model="ptlens"), "ptlens"),
    "ds.json": (camera(camera_type="ds"), "'ds' is not"),
    "scaramuzza.json": (camera(model_type="scaramuzza"), "scaramuzza.* is not supported"),
    "inverse.json": (
        camera(coeffs=D, model="distortion.inverse_brown_conrady"),
        "inverse_brown_conrady",
    ),
    "fov.yaml": ((FILES / "several" / "chain.yaml").read_text().replace("equidistant", "fov"), "fov"),
    "millimetres.json": (camera(fx=3.6, fy=3.6), "millimetres"),
    "settings.xml": (
        "<opencv_storage><Settings><BoardSize_Width>9</BoardSize_Width><Calibrate_Pattern>CHESSBOARD"
        "</Calibrate_Pattern></Settings></opencv_storage>",
        "settings of a calibration program",
    ),
    "estimator.yaml": ('%YAML:1.0\nimu: 1\ncam0_calib: "cam0_mei.yaml"\n', "cam0_mei.yaml"),
    "nothing.yaml": ("", "empty"),
    "prose.txt": ("Dear reader,\nthis is no calibration.\n", "not an object|no kind"),
    "entity.xml": ('<!DOCTYPE a [<!ENTITY b "c">]><a>&b;</a>', "declares entities"),
    "cut.xml": ("<opencv_storage><K>", "not XML"),
    "pickle.pkl": (b"\x80\x04\x95", "pickle"),
    "ros.tar.gz": (b"\x1f\x8b\x08\x00", "unpack"),
    "matlab.mat": (b"MATLAB 5.0 MAT-file, Platform", "MATLAB"),
    "contradiction.json": (camera(D=list(range(1, 10))), "coefficients"),
    "numpy.yaml": (
        "mtx: !!python/object/apply:numpy.core.multiarray._reconstruct\n- !!python/name:numpy.ndarray ''\n",
        "tolist",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_no_camera_known_here_is_refused_in_words(tmp_path: Path, name: str) -> None:
    content, reason = REFUSED[name]
    with pytest.raises(OpsError, match=reason) as caught:
        imported(tmp_path, name, content)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 500


def test_size_that_contradicts_the_file_is_refused() -> None:
    with pytest.raises(OpsError, match="1280 x 720, not 640 x 480"):
        read_file(FILES / "rectilinear" / "camera.yml", ReaderOptions(img_size=(640, 480)))


@pytest.mark.parametrize(
    ("name", "member", "prefix"),
    [
        ("lens_model", "icam_intrinsics_optimization_inputs", "DISTORTION"),
        ("distortion_model", "icam_intrinsics", "LENSMODEL"),
    ],
)
def test_mrcal_1_names_are_known(tmp_path: Path, name: str, member: str, prefix: str) -> None:
    values = ", ".join(map(str, [*INTRINSICS, *D]))
    content = (
        f"# generated\n{{\n    '{name}':  '{prefix}_OPENCV5',\n\n"
        f"    # intrinsics\n    'intrinsics': [ {values},],\n"
        f"    'extrinsics': [ 0,0,0,0,0,0,],\n    'imagersize': [ 1280, 720,],\n    '{member}': 0,\n}}\n"
    )
    holds(imported(tmp_path, "c.cameramodel", content), "rectilinear", D)


def test_table_with_pictures_without_a_board_is_read(tmp_path: Path) -> None:
    rows = [f"img1.jpg {100 + 40 * (i % 7)}.5 {90 + 40 * (i // 7)} 0" for i in range(49)]
    head = ["## generated with mrgingham --gridn 7", "# filename x y level", "img0.jpg - - -"]
    content = "\n".join([*head, *rows, "img2.jpg - - -"])
    options = ReaderOptions(squares=(8, 8))
    found = imported(tmp_path, "corners.vnl", content, options)
    assert [len(view) for view in found.views] == [49]
    with pytest.raises(OpsError, match="49 lines"):
        imported(tmp_path, "corners.vnl", content.replace("img2.jpg - - -", "img2.jpg 1 2 0"), options)


#: genuine files that are no calibration, or of a model that is not known here
NO_CAMERA = ("configs_default", "configs_lenovo_laptop.xml", "cv2written_14", "splined", "usb_cam")


@external_data
def test_genuine_calibrations_are_accepted_and_others_refused() -> None:
    files = sorted((data_dir() / "imports").iterdir())
    refused = {}
    for path in files:
        try:
            found = read_file(path, ReaderOptions(squares=(8, 8)))
        except OpsError as error:
            refused[path.name] = str(error)
        else:
            assert found.camera or found.views
    assert len(files) >= 53
    assert all(any(part in name for part in NO_CAMERA) for name in refused), refused
    assert len(refused) == len(NO_CAMERA)
    assert all(len(why) < 500 and "\n" not in why for why in refused.values())


@pytest.mark.parametrize(
    "piece", ["\n", " ", "\t", "1 ", "a=", "[image]\n", "<a>", "- ", "a: ", "{", "1 OPENCV ", "# "]
)
def test_repetitive_text_is_refused(tmp_path: Path, piece: str) -> None:
    content = piece * (40_000 // len(piece))
    with pytest.raises(OpsError):
        imported(tmp_path, "long.txt", content)
