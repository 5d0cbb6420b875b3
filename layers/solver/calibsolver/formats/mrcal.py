"""mrcal: the camera model with all that it was made from, and the table of detected corners."""

import ast
import base64
import io
import math
import zipfile
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from .. import rotation
from ..arrays import Array, Mask
from ..board import Board
from ..camera import Camera
from ..errors import CalibrationError
from ..fitting.fit import refine
from ..fitting.resection import reprojection_score
from ..view import View
from . import text
from .base import ANY_MODEL, Conversion, ExportSource, ImportedFile, ModelConstraint
from .coefficients import camera_from_opencv, matrix_of
from .convert import all_points, compare, fit_constrained
from .format import Format

SIZES = {
    "LENSMODEL_PINHOLE": 0,
    "LENSMODEL_OPENCV4": 4,
    "LENSMODEL_OPENCV5": 5,
    "LENSMODEL_OPENCV8": 8,
    "LENSMODEL_OPENCV12": 12,  # where the thin prism's four are zero
}
OLD_NAMES = {
    "distortion_model": "lensmodel",
    "lens_model": "lensmodel",
    "icam_intrinsics_optimization_inputs": "icam_intrinsics",
}
"""Members by the names that mrcal 1 gave them."""
MIN_NOTED_INFLATION = 1.2
"""Inflation from which mrcal's own uncertainty, which is that of white noise, is a tenth too small."""
MAX_UNZIPPED_BYTES = 64_000_000
MIN_USED_POINTS = 6
"""Points of a view with which it counts."""


class Mrcal(Format):
    """A .cameramodel: a Python dictionary as text. The optimisation inputs are an npz in base 85.

    With these mrcal's own tools work on the file: residuals, projection uncertainty, refitting. Pixel centres
    are at whole numbers, as ours; a board's origin is its first corner, ours the board's edge.
    """

    name = "mrcal"
    suffix = ".cameramodel"
    constraints = (ModelConstraint("rectilinear"), ModelConstraint("rational"))

    def convert(self, source: ExportSource) -> Conversion:
        conversion = super().convert(source)
        return _at_optimum(source, conversion) if source.views and source.board else conversion

    def write(self, source: ExportSource, conversion: Conversion) -> bytes:
        c = conversion.camera
        lens_model = f"LENSMODEL_OPENCV{len(c.distortion)}"
        body = [
            "{",
            f"    'lensmodel':  '{lens_model}',",
            "    # fx,fy,cx,cy,distortion0,distortion1,...",
            f"    'intrinsics': [ {text.numbers(c.intrinsics)}],",
            # the name that 2.5 and later write, and the one that every reader knows
            "    'rt_cam_ref': [ 0, 0, 0, 0, 0, 0,],",
            "    'extrinsics': [ 0, 0, 0, 0, 0, 0,],",
            f"    'imagersize': [ {c.img_size[0]}, {c.img_size[1]},],",
        ]
        if source.views and source.board and source.board.kind != "aprilgrid":
            packed = self._inputs(source, conversion, source.board, lens_model)
            body += ["    'icam_intrinsics': 0,", f"    'optimization_inputs': {packed!r},"]
        return text.lines(self.comment(source, conversion), _white_noise_note(source), body, "}")

    @staticmethod
    def _inputs(source: ExportSource, conversion: Conversion, board: Board, lens_model: str) -> bytes:
        """Pack the arguments of mrcal.optimize() at the optimum."""
        across, down = board.squares[0] - 1, board.squares[1] - 1
        # Corners that were not seen have a negative weight: mrcal's mark of a point to be left out.
        used = conversion.used or all_points(source.views)
        # A frame without points would have no pose.
        usable = [i for i, mask in enumerate(used) if mask.sum() >= MIN_USED_POINTS]
        views, used = [source.views[i] for i in usable], tuple(used[i] for i in usable)
        observed = np.full((len(views), down, across, 3), (0.0, 0.0, -1.0))
        for grid, view, mask in zip(observed, views, used, strict=True):
            column, row = (view.object_points[:, :2].round().astype(int) - 1).T
            grid[row, column, :2], grid[row, column, 2] = view.image_points, np.where(mask, 1.0, -1.0)
        points = [view.subset(mask) for view, mask in zip(views, used, strict=True)]
        poses = np.array(reprojection_score(conversion.camera, points).poses)
        poses[:, 3:] += rotation.matrix(poses[:, :3]) @ np.array([1.0, 1.0, 0.0])
        n = len(views)
        indices = np.stack([np.arange(n), np.zeros(n), np.full(n, -1)], axis=1).astype(np.int32)
        inputs: dict[str, Any] = {
            "intrinsics": conversion.camera.intrinsics[None],
            "extrinsics_rt_fromref": np.zeros((0, 6)),
            "frames_rt_toref": poses,
            "points": "",
            "observations_board": observed,
            "indices_frame_camintrinsics_camextrinsics": indices,
            "observations_point": "",
            "indices_point_camintrinsics_camextrinsics": "",
            "lensmodel": lens_model,
            "imagersizes": np.array([conversion.camera.img_size], dtype=np.int32),
            "calobject_warp": np.zeros(2),
            "do_optimize_intrinsics_core": True,
            "do_optimize_intrinsics_distortions": True,
            "do_optimize_extrinsics": True,
            "do_optimize_frames": True,
            "do_optimize_calobject_warp": False,
            "calibration_object_spacing": 1.0,
            "do_apply_regularization": False,
            "do_apply_outlier_rejection": False,
            "imagepaths": np.array([f"view{i:03d}" for i in usable]),
        }
        packed = io.BytesIO()
        np.savez_compressed(packed, allow_pickle=False, **inputs)
        return base64.b85encode(packed.getvalue())


def _at_optimum(source: ExportSource, conversion: Conversion) -> Conversion:
    """Return a conversion whose camera is the least-squares optimum of the points that `used` names.

    A camera that the file holds exactly stays as it is: its fit ended there but for a weak prior.
    """
    camera = conversion.camera
    used = conversion.used or _used_points(camera, source.views)
    if conversion.error == 0:
        return replace(conversion, used=used)
    subsets = [v.subset(m) for v, m in zip(source.views, used, strict=True)]
    views = tuple(view for view in subsets if len(view) >= MIN_USED_POINTS)
    try:
        better = fit_constrained(camera, ModelConstraint(camera.model), views, all_points(views))
        return replace(compare(source.camera, better), used=used)
    except (CalibrationError, np.linalg.LinAlgError):
        return replace(conversion, used=used)


def _used_points(camera: Camera, views: Sequence[View]) -> tuple[Mask, ...]:
    """Return for each view which points (n,) a robust fit at a camera keeps; all if it fails."""
    try:
        poses = reprojection_score(camera, views).poses
        if np.isfinite(poses).all():
            return refine(views, camera, poses).used
    except CalibrationError:
        pass
    return all_points(views)


def _white_noise_note(source: ExportSource) -> list[str]:
    """Say by what mrcal's uncertainty falls short: it is that of white noise, whatever the weights."""
    inflation = source.record.get("systematic")
    if not source.views or inflation is None or inflation < MIN_NOTED_INFLATION:
        return []
    factor = f"{math.sqrt(inflation):.2g}"
    return [f"# mrcal takes errors of corners for independent: multiply its uncertainty by {factor}"]


class CornersVnl(Format):
    """The table of corners that mrcal-calibrate-cameras reads: a line for every corner of every view."""

    name = "corners-vnl"
    suffix = ".vnl"
    constraints = ANY_MODEL

    def write(self, source: ExportSource, conversion: Conversion) -> bytes:
        board = source.board
        if board is None or not source.views or board.kind == "aprilgrid":
            raise CalibrationError(
                "not_representable", "there are no keypoints of one board of squares to write"
            )
        body = [
            f"# {board.squares[0] - 1} x {board.squares[1] - 1} corners, one square apart",
            "# filename x y level",
        ]
        for i, view in enumerate(source.views):
            column, row = (view.object_points[:, :2].round().astype(int) - 1).T
            numbers = row * (board.squares[0] - 1) + column
            corners = dict(zip(numbers.tolist(), view.image_points, strict=True))
            for corner in range(board.corner_count):
                at = corners.get(corner)
                place = "- - -" if at is None else f"{text.number(at[0])} {text.number(at[1])} 0"
                body.append(f"view{i:03d}.png {place}")
        return text.lines(self.comment(source, conversion), body)


def is_model(content: str) -> bool:
    """True if it is a .cameramodel: a Python dictionary with a lens model, under today's or an older name."""
    names = ("lensmodel", "lens_model", "distortion_model")
    return any(f"'{name}'" in content for name in names) or '"lensmodel":  ' in content


def read(content: str) -> ImportedFile:
    """Read a .cameramodel, with its keypoints where it has them; CalibrationError ``malformed``."""
    lines = (line for line in content.splitlines() if not line.lstrip().startswith("#"))
    try:
        data = ast.literal_eval("\n".join(lines))
    except (ValueError, TypeError, SyntaxError, MemoryError, RecursionError) as error:
        raise text.refuse(f"the file is not a Python dictionary: {type(error).__name__}") from None
    if isinstance(data, dict):  # what versions up to 1 called them
        data = {OLD_NAMES.get(key, key): value for key, value in data.items() if isinstance(key, str)}
    lens_model = str(text.member(data, "lensmodel")).replace("DISTORTION_", "LENSMODEL_")
    lens_model = lens_model.replace("LENSMODEL_NONE", "LENSMODEL_PINHOLE")
    if lens_model not in SIZES:
        raise text.refuse(f"lensmodel {lens_model[:60]!r} is none of {', '.join(SIZES)}")
    count = 4 + SIZES[lens_model]
    k = text.floats(text.member(data, "intrinsics"), "intrinsics", count, count)
    w, h = text.floats(text.member(data, "imagersize"), "imagersize", 2, 2)
    matrix = matrix_of(*k[:4])
    camera = camera_from_opencv(matrix, k[4:], (int(w), int(h)), fisheye=False)
    packed = data.get("optimization_inputs")
    number = data.get("icam_intrinsics", 0)
    views = _views(packed, number if isinstance(number, int) else 0) if isinstance(packed, bytes) else ()
    return ImportedFile(camera, views)


def _views(packed: bytes, number: int) -> tuple[View, ...]:
    """Unpack the board observations of camera `number`; no pickles, and no more than fits."""
    try:
        archive = io.BytesIO(base64.b85decode(packed))
        with zipfile.ZipFile(archive) as files:
            if sum(info.file_size for info in files.infolist()) > MAX_UNZIPPED_BYTES:
                raise text.refuse("optimization_inputs unpack to too much")
        with np.load(archive, allow_pickle=False) as arrays:
            observed = arrays["observations_board"]
            indices = arrays["indices_frame_camintrinsics_camextrinsics"]
            spacing = float(arrays["calibration_object_spacing"])
    except CalibrationError:
        raise
    except Exception as error:  # noqa: BLE001 - parsers of ZIP, deflate and Python raise a dozen types
        raise text.refuse(f"optimization_inputs cannot be read: {type(error).__name__}") from None
    is_shaped = observed.ndim == 4 and observed.shape[3] == 3 and indices.shape == (len(observed), 3)
    if not (is_shaped and math.isfinite(spacing)):
        raise text.refuse("optimization_inputs have arrays of a wrong shape")
    column, row = np.meshgrid(np.arange(observed.shape[2]), np.arange(observed.shape[1]))
    points = np.stack([column + 1, row + 1, np.zeros_like(row)], axis=2).reshape(-1, 3) * (spacing or 1.0)
    views = []
    for grid, index in zip(observed.astype(np.float64), indices, strict=True):
        flat = grid.reshape(-1, 3)
        good = (flat[:, 2] >= 0) & np.isfinite(flat).all(axis=1)
        if index[1] == number and good.any():
            views.append(View(points[good], flat[good, :2]))
    return tuple(views)


def read_corners(content: str, squares: tuple[int, int]) -> ImportedFile:
    """Read a corners.vnl of a board of so many squares; CalibrationError ``malformed``."""
    pictures: defaultdict[str, list[Array | None]] = defaultdict(list)
    board = Board(squares)
    for fields in _rows(content):
        if len(fields) < 3:
            raise text.refuse(f"a line has {len(fields)} fields, filename, x and y are needed")
        corners = pictures[fields[0]]
        if "-" in fields[1:3] or (len(fields) > 3 and fields[3] in ("-", "-1")):
            corners.append(None)
            continue
        try:
            corners.append(text.floats([float(fields[1]), float(fields[2])], "a corner", 2, 2))
        except ValueError:
            raise text.refuse(f"{fields[1]} {fields[2]} are not pixels") from None
    # A picture without a board is a single line `img.jpg - - -`.
    with_board = [each for each in pictures.values() if len(each) > 1 or each[0] is not None]
    if not pictures or any(len(each) != board.corner_count for each in with_board):
        raise text.refuse(
            f"every picture must have {board.corner_count} lines, one for each corner of the board"
        )
    views = []
    for corners in with_board:
        seen = {i: q for i, q in enumerate(corners) if q is not None}
        if seen:
            views.append(board.view(list(seen), np.array(list(seen.values()))))
    return ImportedFile(None, tuple(views))


def is_corners(content: str) -> bool:
    """True if it looks like a table of corners: the first line with content has a name and a position."""
    fields = next(_rows(content), [])
    return len(fields) in (3, 4) and all(f == "-" or text.number_list(f) is not None for f in fields[1:])


def _rows(content: str) -> Iterator[list[str]]:
    """Yield the fields of each line with content."""
    for line in content.splitlines():
        fields = line.split()
        if fields and not fields[0].startswith("#"):
            yield fields
