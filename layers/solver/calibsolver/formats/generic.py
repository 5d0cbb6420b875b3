"""Cameras under the names that calibration programs use: a matrix and coefficients, or single numbers.

They differ in the spelling and nesting of the same few numbers.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..arrays import Array
from . import text
from .base import ImportedFile, ReaderOptions
from .coefficients import camera_from_opencv, make_camera, matrix_of, pad_coefficients
from .foreign_models import closest_camera, named_rays
from .members import (
    CENTRE,
    CENTRE_PAIRS,
    COEFFICIENTS,
    DISTORTION,
    EXPLICIT_MATRIX,
    FISHEYE_COEFFICIENTS,
    FOCAL,
    FOCAL_PAIRS,
    MATRIX,
    NESTED,
    Members,
    image_size,
    stated_model,
)

MAX_SKEW_PX = 0.05
"""Negligible effect of a matrix's skew at the image's edge, px; cameras have no skew."""


def is_camera(members: Members) -> bool:
    """True if a mapping contains a camera."""
    return _matrix_key(members) is not None or _scalar_intrinsics(_flat(members)) is not None


def read(
    data: Mapping[Any, Any], options: ReaderOptions, size: tuple[int, int] | None = None
) -> ImportedFile:
    """Read one camera; `size` counts if the camera itself states none. CalibrationError ``malformed``."""
    members = Members(data)
    flat = _flat(members)
    size = image_size(members) or image_size(flat) or size or options.img_size
    if size is None:
        raise text.refuse("the file does not say the size of the pictures: give it (--img-size 1280x720)")
    matrix, xi = _matrix(members, flat)
    if matrix[2, 0] != 0 and matrix[0, 2] == 0:  # columns first
        matrix = matrix.T.copy()
    if "radialdistortion" in members and ("intrinsicmatrix" in members or "principalpoint" in members):
        matrix[:2, 2] -= 1  # MATLAB's: pixels are counted from 1
        size = _matlab_size(members) or size
    name = flat.get("cameraname", "name", "camera", "label")
    name = name if isinstance(name, str) else ""
    if (rays_of := named_rays(flat, matrix)) is not None:
        return closest_camera(rays_of, size, name)
    d, named = _distortion(members, flat)
    model = stated_model(flat, distorted=bool(np.any(d)) or any(named.values())) or options.model or None
    if xi is None and "xi" in flat:
        xi = text.scalar(_data(flat.get("xi")), "xi")
    _check_focal(matrix, size)
    matrix = _without_skew(matrix, size)
    d = _order_coefficients(named, model, d)
    if xi is not None:
        camera = make_camera("omnidirectional", matrix, np.concatenate([[xi], pad_coefficients(d, 4)]), size)
    elif model == "omnidirectional":
        if len(d) != 5:
            raise text.refuse("an omnidirectional camera needs xi")
        camera = make_camera(model, matrix, d, size)
    elif model == "rational" and len(d) < 8:
        camera = make_camera(model, matrix, pad_coefficients(d, 8), size)
    else:
        camera = camera_from_opencv(matrix, d, size, fisheye=model == "fisheye")
    return ImportedFile(camera, name=name)


def _data(value: Any) -> Any:
    """Unwrap the numbers of an OpenCV or ROS matrix."""
    content = (
        Members(value).get("data", "values", "value", "elements") if isinstance(value, Mapping) else None
    )
    return value if content is None else content


def _matrix_key(members: Members) -> str | None:
    """Return the name of the camera matrix: of a list of 3 x 3 numbers, or of four or five intrinsics."""
    for key in MATRIX:
        value = _data(members.get(key))
        if not isinstance(value, list | tuple | str):
            continue
        if isinstance(value, str) and text.number_list(value) is None:
            continue
        count = len(_flatten(value))
        if count in (9, 12) or (
            count in (4, 5) and key in ("intrinsics", "intrinsic", "intrinsicparameters")
        ):
            return key
        if key in EXPLICIT_MATRIX:
            return key  # called so, and not one: its reader says why
    return None


def _flatten(value: Any, depth: int = 0) -> list[Any]:
    if isinstance(value, str):
        numbers = text.number_list(value)
        return [value] if numbers is None else list(numbers)
    if not isinstance(value, list | tuple):
        return [value]
    if depth > 3 or len(value) > 100:
        return []
    return [part for item in value for part in _flatten(item, depth + 1)]


def _matrix(members: Members, flat: Members) -> tuple[Array, float | None]:
    """Camera matrix (3, 3), and xi where it stands among the intrinsics."""
    key = _matrix_key(members)
    if key is not None:
        name = members.spelling(key)
        values = text.floats(_data(members.get(key)), name, 0, 12)
        if len(values) == 9:
            return values.reshape(3, 3), None
        if len(values) == 12:  # a projection matrix [K | 0]
            return values.reshape(3, 4)[:, :3].copy(), None
        if len(values) in (4, 5) and key not in EXPLICIT_MATRIX:
            return matrix_of(*values[-4:]), float(values[0]) if len(values) == 5 else None
        raise text.refuse(f"{name} must be 9 to 9 numbers, not {len(values)}")
    intrinsics = _scalar_intrinsics(flat)
    if intrinsics is None:
        raise text.refuse("the file has no camera matrix")
    return matrix_of(*intrinsics), None


def _flat(members: Members) -> Members:
    """Return the members, and those of the members that hold parts of a camera."""
    result: dict[str, Any] = dict(members.items())
    for key in NESTED:
        inner = members.get(key)
        if isinstance(inner, Mapping):
            for name, value in Members(inner).items():
                result.setdefault(name, value)
                if isinstance(value, Mapping) and name in NESTED:
                    for deeper, number in Members(value).items():
                        result.setdefault(deeper, number)
    return Members(result)


def _scalar_intrinsics(flat: Members) -> Sequence[float] | None:
    """Find fx fy cx cy under names of their own, or in pairs."""
    focal = _two(flat, FOCAL, FOCAL_PAIRS)
    centre = _two(flat, CENTRE, CENTRE_PAIRS)
    return None if focal is None or centre is None else (*focal, *centre)


def _two(flat: Members, single: Sequence[tuple[str, str]], pairs: Sequence[str]) -> Array | None:
    for x, y in single:
        if x in flat and (y in flat or x in ("fx", "flx")):
            values = [flat.get(x), flat.get(y if y in flat else x)]
            if all(map(_is_number, values)):
                return text.floats(values, f"{flat.spelling(x)}, {flat.spelling(y)}", 2, 2)
    for key in pairs:
        value = _data(flat.get(key))
        if isinstance(value, Mapping):
            inner = Members(value)
            value = [inner.get("x", "fx", "cx", "u"), inner.get("y", "fy", "cy", "v")]
        if _is_number(value) and key in FOCAL_PAIRS:
            value = [value, value]
        if _are_numbers(value) and len(_flatten(value)) == 2:
            return text.floats(value, flat.spelling(key), 2, 2)
    return None


def _are_numbers(value: Any) -> bool:
    """True for a list, or a text, of numbers only."""
    return isinstance(value, list | tuple | str) and all(map(_is_number, _flatten(value)))


def _is_number(value: Any) -> bool:
    if isinstance(value, str):
        return len(text.number_list(value) or []) == 1
    return isinstance(value, int | float) and not isinstance(value, bool)


def _distortion(members: Members, flat: Members) -> tuple[Array, dict[str, float]]:
    """Coefficients in OpenCV's order, or by name."""
    for key in DISTORTION:
        held = _data(members.get(key))
        is_word = isinstance(held, str) and text.number_list(held) is None
        has_members = isinstance(held, list) and any(isinstance(v, Mapping) for v in held)
        if held is None or is_word or has_members or isinstance(held, Mapping | bool):
            continue
        return text.floats(held, members.spelling(key), 0, 14), {}
    radial = _data(flat.get("radialdistortion", "radial", "radialdistortioncoefficients", "kr"))
    if _are_numbers(radial) and _flatten(radial):
        k = text.floats(radial, "radial distortion", 1, 6)
        tangential = _data(
            flat.get("tangentialdistortion", "tangential", "kt", "tangentialdistortioncoefficients")
        )
        p = text.floats(tangential, "tangential distortion", 0, 2) if tangential is not None else np.zeros(2)
        return np.concatenate([pad_coefficients(k[:2], 2), pad_coefficients(p, 2), k[2:]]), {}
    named = {}
    for name in COEFFICIENTS:
        value = flat.get(name)
        if value is not None and _is_number(value):
            named[name] = text.scalar(value, flat.spelling(name))
    return np.zeros(0), named


def _order_coefficients(named: dict[str, float], model: str | None, d: Array) -> Array:
    if not named:
        return d
    names = COEFFICIENTS
    if model == "fisheye":
        # camodocal counts the powers of the angle from k2 on
        names = FISHEYE_COEFFICIENTS[1:] if "k1" not in named and "k5" in named else FISHEYE_COEFFICIENTS[:4]
    if over := [name for name, value in named.items() if name not in names and value]:
        raise text.refuse(f"a {model or 'rectilinear'} camera with a coefficient {over[0]} is not supported")
    result = np.array([named.get(name, 0.0) for name in names])
    result = result if model == "fisheye" else np.trim_zeros(result, "b")
    return pad_coefficients(result, 8) if len(result) in (6, 7) else result


def _matlab_size(members: Members) -> tuple[int, int] | None:
    """Image size as MATLAB has it: rows first."""
    size = _flatten(_data(members.get("imagesize")))
    if len(size) < 2 or not all(map(_is_number, size)):
        return None
    return text.width_height((float(size[1]), float(size[0])), ("ImageSize", "ImageSize"))


def _check_focal(matrix: Array, size: tuple[int, int]) -> None:
    """Refuse lengths in millimetres or image widths: here they are px."""
    if 0 < matrix[0, 0] < 0.02 * size[0] and 0 < matrix[1, 1] < 0.1 * size[1]:
        raise text.refuse(
            f"a focal length of {matrix[0, 0]:g} in a picture {size[0]} wide: it must be in pixels, "
            "not in millimetres or image widths"
        )


def _without_skew(matrix: Array, size: tuple[int, int]) -> Array:
    if matrix[0, 1] and matrix[1, 1] > 0 and abs(matrix[0, 1]) * size[1] / matrix[1, 1] < MAX_SKEW_PX:
        matrix = matrix.copy()
        matrix[0, 1] = 0.0
    return matrix
