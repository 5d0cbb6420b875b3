"""Constraint of a fit: intrinsics that are not estimated, as OpenCV's flags CALIB_FIX_….

Names are `fx`, `fy`, `cx`, `cy`, the coefficients of the model, and three groups: `aspect` (the ratio fx /
fy), `center` (cx and cy) and `tangential` (p1 and p2). A name without a value holds that of the start of the
fit. Without a start, the principal point is the middle of the image, the ratio is 1 and a coefficient is 0; a
focal length needs a value.
"""

from collections.abc import Iterable, Mapping

import numpy as np

from ..arrays import Array
from ..camera import Camera
from ..errors import CalibrationError
from ..models import Model

Fix = str | Iterable[str] | Mapping[str, float | None]

ASPECT = "aspect"
GROUPS = {"center": ("cx", "cy"), "tangential": ("p1", "p2")}
MAX_NUMBER = 1e6


def of(
    model: Model, img_size: tuple[int, int], fix: Fix, start: Camera | None
) -> tuple[Array | None, Array | None]:
    """Free directions T (p, a) and origin k (p,) of intrinsics k + T a; None if all are free.

    Raises CalibrationError ``unknown_parameter``, or ``no_value`` if a value is missing or makes no sense.
    """
    values = _values(fix)
    if not values:
        return None, None
    names = ("fx", "fy", "cx", "cy", *model.coefficients)
    aspect, origin = ASPECT in values, np.zeros(model.size)
    ratio = values.pop(ASPECT, None)
    default = _default(model, img_size, values, start, aspect)
    if unknown := [name for name in values if name not in names]:
        possible = ", ".join((*names, ASPECT, *GROUPS))
        raise CalibrationError(
            "unknown_parameter", f"{model.name} has no {unknown[0]!r} to fix, only {possible}"
        )
    held = [i for i, name in enumerate(names) if name in values]
    for i in held:
        value = values[names[i]]
        origin[i] = _number(names[i], default[i] if value is None else value, positive=i < 2)
    basis = np.eye(model.size)
    if aspect:
        ratio = _number(ASPECT, default[0] / default[1] if ratio is None else ratio, positive=True)
        if 0 in held and 1 in held:
            raise CalibrationError("no_value", "fix two of fx, fy and aspect, not all three")
        if 0 in held or 1 in held:
            origin[1 if 0 in held else 0] = origin[0] / ratio if 0 in held else origin[1] * ratio
            held = [0, 1, *(i for i in held if i > 1)]
        else:
            basis[0, 1] = ratio  # the column of fy moves fx along
            held = [0, *held]
    basis = np.delete(basis, held, axis=1)
    if not basis.size:
        raise CalibrationError("no_value", "nothing is left to fit: `locate` finds poses by a known camera")
    return basis, origin


def names(fix: Fix) -> tuple[str, ...]:
    """Names of the fixed parameters, groups resolved."""
    return tuple(_values(fix))


def _values(fix: Fix) -> dict[str, float | None]:
    """Values, or None, by name, groups resolved."""
    given = fix if isinstance(fix, Mapping) else dict.fromkeys([fix] if isinstance(fix, str) else fix)
    out: dict[str, float | None] = {}
    for name, value in given.items():
        if name in GROUPS and value is not None:
            one, other = GROUPS[name]
            raise CalibrationError("no_value", f"{name} takes no value: pass {one} and {other}")
        out.update(dict.fromkeys(GROUPS.get(name, (name,)), value))
    return out


def _default(
    model: Model,
    img_size: tuple[int, int],
    values: Mapping[str, float | None],
    start: Camera | None,
    aspect: bool,
) -> Array:
    """Intrinsics (p,) that names without a value hold."""
    if start is None:
        if missing := [name for name in ("fx", "fy") if values.get(name, 0.0) is None]:
            raise CalibrationError("no_value", f"{missing[0]} needs a value, or a start, to be fixed")
        return model.start(1.0, img_size)
    if (aspect or None in values.values()) and (start.model != model.name or start.img_size != img_size):
        w, h = start.img_size
        raise CalibrationError(
            "no_value",
            f"the start ({start.model}, {w} x {h} px) is no {model.name} camera of this size: pass values",
        )
    return start.intrinsics


def _number(name: str, value: float, positive: bool) -> float:
    if not (
        isinstance(value, int | float | np.floating)
        and abs(value) < MAX_NUMBER
        and (value > 0 or not positive)
    ):
        wanted = "a positive number" if positive else "a number"
        raise CalibrationError("no_value", f"{name} = {value!r} makes no sense: pass {wanted}")
    return float(value)
