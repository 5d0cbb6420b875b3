"""OpenCV's FileStorage, YAML and JSON, under the names that calibration programs have long used."""

import numpy as np

from ..arrays import Array
from . import text
from .base import ANY_MODEL, Conversion, ExportSource
from .format import Format


class OpenCvYaml(Format):
    """`%YAML:1.0`, matrices as `!!opencv-matrix`; omnidirectional cameras have `xi` and four coefficients."""

    name = "opencv-yaml"
    front_readers = "cv2.fisheye"
    suffix = ".yml"
    constraints = ANY_MODEL

    def write(self, source: ExportSource, conversion: Conversion) -> bytes:
        body = [f"{key}: {_scalar(value)}" for key, value in members(source, conversion).items()]
        for key, value in matrices(conversion).items():
            body += yaml_matrix(key, value)
        return text.lines("%YAML:1.0", "---", self.comment(source, conversion), body)


class OpenCvJson(Format):
    """The same as JSON, matrices with `type_id: opencv-matrix`."""

    name = "opencv-json"
    front_readers = "cv2.fisheye"
    suffix = ".json"
    constraints = ANY_MODEL

    def write(self, source: ExportSource, conversion: Conversion) -> bytes:
        value: dict[str, object] = dict(members(source, conversion))
        for key, matrix in matrices(conversion).items():
            rows, columns = matrix.shape
            value[key] = {
                "type_id": "opencv-matrix",
                "rows": rows,
                "cols": columns,
                "dt": "d",
                "data": matrix.ravel().tolist(),
            }
        return text.dump(value, conversion.warning)


def yaml_matrix(key: str, matrix: Array) -> list[str]:
    """Return the lines of a matrix in OpenCV's YAML."""
    rows, columns = matrix.shape
    return [
        f"{key}: !!opencv-matrix",
        f"   rows: {rows}",
        f"   cols: {columns}",
        "   dt: d",
        f"   data: [ {text.numbers(matrix.ravel())} ]",
    ]


def members(source: ExportSource, conversion: Conversion) -> dict[str, str | int | float]:
    """Return the plain members of the file."""
    c, board = conversion.camera, source.board
    return {
        "calibration_time": f"{np.datetime64(source.time, 's')}Z",
        "nr_of_frames": len(source.views),
        "image_width": c.img_size[0],
        "image_height": c.img_size[1],
        "board_width": board.squares[0] if board else 0,
        "board_height": board.squares[1] if board else 0,
        "square_size": 1.0,
        "flags": 0,
        "fisheye_model": int(c.model == "fisheye"),
        "distortion_model": c.model,
        "camera_name": source.name,
        "avg_reprojection_error": source.rms,
    }


def matrices(conversion: Conversion) -> dict[str, Array]:
    """Return the matrices of the file."""
    c = conversion.camera
    result, d = {"camera_matrix": c.matrix}, c.distortion
    if c.model == "omnidirectional":
        result["xi"], d = d[:1, None], d[1:]
    # cv2.fisheye wants a column of four, everything else takes a row
    result["distortion_coefficients"] = d[:, None] if c.model == "fisheye" else d[None]
    return result


def _scalar(value: str | int | float) -> str:
    if isinstance(value, str):
        return text.quote(value)
    return str(value) if isinstance(value, int) else text.number(value)
