"""Other programs' calibration files in other formats, over HTTP; nothing of them is stored."""

import base64
import io
import time
import zipfile

import numpy as np
import pytest

from infra.web_build.operations import EXAMPLE_FILE
from tests.helpers.service.client import Answer, Client

JOBS = False


def huge_array() -> str:
    header = io.BytesIO()
    claim = {"descr": "<f8", "fortran_order": False, "shape": (10**12,)}
    np.lib.format.write_array_header_1_0(header, claim)
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("mtx.npy", header.getvalue() + bytes(800))
    return base64.b64encode(packed.getvalue()).decode()


HUGE_ARRAY = huge_array()


def convert(client: Client, file: str, **asked: object) -> Answer:
    return client.call("POST", "/v1/convert", {"file": file, **asked})


def refused(answer: Answer) -> tuple[str, str]:
    [field] = answer.fields
    return field, answer.json["errors"][0]["detail"]


def test_file_with_a_camera_alone_is_written_unless_the_format_needs_corners(client: Client) -> None:
    """The file says how far its camera is from that of the file given."""
    answer = convert(client, EXAMPLE_FILE, format="kalibr")
    assert answer.status == 200, answer.body
    assert ".yaml" in answer.headers["content-disposition"]
    assert float(answer.headers["x-conversion-error"]) < 64
    assert float(answer.headers["x-conversion-coverage"]) > 0.9
    field, detail = refused(convert(client, EXAMPLE_FILE, format="corners-vnl"))
    assert field == "format"
    assert "keypoints" in detail


def test_what_a_file_does_not_say_is_asked_for(client: Client) -> None:
    file = "camera_matrix: [[900, 0, 640], [0, 900, 360], [0, 0, 1]]\ndist_coeffs: [0.1, 0.0, 0.0, 0.0]\n"
    field, detail = refused(convert(client, file))
    assert field == "img_size"
    assert "--" not in detail, "nobody has a command line here"
    given = convert(client, file, img_size=[1280, 720], camera="My camera")
    assert given.status == 200, given.body
    assert given.json["camera"] == "My camera"
    assert given.json["camera_matrix"][0][0] == 900


@pytest.mark.parametrize(
    ("file", "more"),
    [
        ("", {}),
        ("a: &a [1]\nb: [*a, *a, *a]\n", {}),
        ("x" * 100_001, {}),
        ("not base64!", {"encoding": "base64"}),
        (base64.b64encode(b"\x80\x04pickle").decode(), {"encoding": "base64"}),
        (base64.b64encode(b"PK\x03\x04" + bytes(200)).decode(), {"encoding": "base64"}),
        (HUGE_ARRAY, {"encoding": "base64"}),
        (EXAMPLE_FILE, {"number": 7}),
        (EXAMPLE_FILE, {"img_size": [640, 480]}),
        (EXAMPLE_FILE.replace("952.1", "1e400"), {}),
    ],
)
def test_hostile_and_broken_files_are_refused_in_words(client: Client, file: str, more: dict) -> None:
    begun = time.process_time()
    answer = convert(client, file, **more)
    assert answer.status == 422
    assert len(answer.body) < 10_000
    assert time.process_time() - begun < 10, "no file costs more than a request may"


def test_corners_alone_are_no_camera(client: Client) -> None:
    corners = "# filename x y level\nview000.png 10 20 0\n" * 20
    assert convert(client, corners).fields == ["file"]
