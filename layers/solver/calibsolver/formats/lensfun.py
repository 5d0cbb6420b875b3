"""Lensfun's lens database: an XML file with the camera, the lens, and its distortion as `ptlens`."""

import math
import re
from collections.abc import Callable, Mapping
from typing import Any
from xml.sax.saxutils import escape

import numpy as np

from ..arrays import Array
from ..camera import Camera
from ..errors import CalibrationError
from . import text
from .base import Conversion, ExportSource, ImportedFile, ModelConstraint, ReaderOptions
from .convert import convert_in_image, differences
from .foreign_models import closest_camera, radial_corrected
from .format import Format
from .members import Members

DIAGONAL = math.hypot(36, 24)
"""mm: the frame to which crop factors refer. Ours is 1: only the ratio of frame and focal length is known."""
RADIAL = ("p1", "p2")
NO_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""What XML 1.0 cannot hold, not even escaped. Source: XML 1.0 (Fifth Edition), production 2, Char."""


class Lensfun(Format):
    """`ptlens`: distorted radius = a r^4 + b r^3 + c r^2 + (1 - a - b - c) r of the corrected one.

    Radii are in units of half the picture's smaller side, the axis is `center`. The scale of the corrected
    picture is free, and chosen so that the four terms are least squares over the picture. It has no
    tangential distortion and one focal length.
    """

    name = "lensfun"
    suffix = ".xml"
    constraints = (
        ModelConstraint("rectilinear", zero=RADIAL, equal_focal=True),
        ModelConstraint("fisheye", equal_focal=True),
    )

    def convert(self, source: ExportSource) -> Conversion:
        radial = convert_in_image(source, self.constraints).camera
        a, b, c, s = polynomial(radial)

        def project(rays: Array) -> Array:
            r = s * _corrected_radii(radial, rays)
            distorted = half(radial) * (a * r**4 + b * r**3 + c * r**2 + (1 - a - b - c) * r)
            side = np.hypot(rays[:, 0], rays[:, 1])
            scale = distorted / np.maximum(side, 1e-300)
            return np.asarray(radial.matrix[:2, 2] + rays[:, :2] * scale[:, None])

        return Conversion(radial, *differences(source.camera, project, _max_angle(radial)))

    def write(self, source: ExportSource, conversion: Conversion) -> bytes:
        c = conversion.camera
        (w, h), (f, _, cx, cy) = c.img_size, c.intrinsics[:4].tolist()
        unit = half(c)
        a, b, c2 = polynomial(c)[:3].tolist()
        focal = f * DIAGONAL / math.hypot(w, h)
        name = escape(NO_XML.sub("", source.name).strip() or "camera", {'"': "&quot;"})
        kind = "\n        <type>fisheye</type>" if c.model == "fisheye" else ""
        center = f'x="{(cx - (w - 1) / 2) / unit!r}" y="{(cy - (h - 1) / 2) / unit!r}"'
        note = f"\n<!-- {conversion.warning} -->" if conversion.warning else ""
        model = f'model="ptlens" focal="{focal!r}" a="{a!r}" b="{b!r}" c="{c2!r}"'
        return f"""<?xml version="1.0" encoding="utf-8"?>{note}
<lensdatabase version="1">
    <mount>
        <name>calibDB</name>
    </mount>
    <camera>
        <maker>calibDB</maker>
        <model>{name}</model>
        <mount>calibDB</mount>
        <cropfactor>1</cropfactor>
    </camera>
    <lens>
        <maker>calibDB</maker>
        <model>{name}</model>
        <mount>calibDB</mount>{kind}
        <cropfactor>1</cropfactor>
        <aspect-ratio>{(max(w, h) - 1) / (min(w, h) - 1)!r}</aspect-ratio>
        <center {center}/>
        <calibration>
            <distortion {model}/>
        </calibration>
    </lens>
</lensdatabase>
""".encode()


def half(camera: Camera) -> float:
    """Lensfun's unit of length, px: from the middle of the picture to the centre of its outermost pixels."""
    return (min(camera.img_size) - 1) / 2


def polynomial(camera: Camera) -> Array:
    """Fit a, b, c, and the scale s of the corrected picture against the camera's focal length, (4,).

    With rho = f g(angle) / unit, g the tangent or for a fisheye the angle itself, distorted radii are fitted
    by A rho^4 + B rho^3 + C rho^2 + D rho; then r = s rho makes the coefficients sum to one where
    s^4 - D s^3 - C s^2 - B s - A = 0.
    """
    (w, h), (cx, cy) = camera.img_size, camera.matrix[:2, 2]
    reach = math.hypot(max(cx, w - 1 - cx), max(cy, h - 1 - cy))
    radius = np.linspace(0, reach, 400)[1:]
    rays = camera.unproject(np.stack([cx + radius, np.full_like(radius, cy)], axis=1))
    radii = _corrected_radii(camera, rays)
    visible = np.isfinite(radii)
    if visible.sum() < 10:
        raise CalibrationError("not_representable", "too little of the image can be corrected")
    rho = radii[visible]
    terms = np.stack([rho**4, rho**3, rho**2, rho], axis=1)
    # every ring of the picture counts by its area
    weight = np.sqrt(radius[visible])
    fitted = np.linalg.lstsq(terms * weight[:, None], radius[visible] / half(camera) * weight, rcond=None)[0]
    roots = np.roots([1.0, *-fitted[::-1]])
    real = roots.real[(np.abs(roots.imag) < 1e-9) & (roots.real > 0)]
    if not len(real):
        raise CalibrationError("not_representable", "ptlens cannot express this distortion")
    s = float(real[np.argmin(np.abs(real - 1))])
    result: Array = np.array([fitted[0] / s**4, fitted[1] / s**3, fitted[2] / s**2, s])
    return result


def _max_angle(camera: Camera) -> float:
    """Angle from the axis, radians, up to which the corrected picture shows rays."""
    return np.pi if camera.model == "fisheye" else 1.5


def _corrected_radii(camera: Camera, rays: Array) -> Array:
    """Radii (n,) of rays (n, 3) in the corrected picture, rho of `polynomial`; NaN where it shows none."""
    angle = np.arctan2(np.hypot(rays[:, 0], rays[:, 1]), rays[:, 2])
    angle = np.where(angle < _max_angle(camera), angle, np.nan)
    radii = angle if camera.model == "fisheye" else np.tan(angle)
    return np.asarray(camera.matrix[0, 0] * radii / half(camera))


def is_lens(members: Members) -> bool:
    """True if a mapping is a lens of a database, with what was measured of it."""
    calibration = members.get("calibration")
    return isinstance(calibration, Mapping) and "distortion" in calibration


def distortions(data: Mapping[Any, Any]) -> list[Mapping[Any, Any]]:
    """Return the distortions of a lens, one per focal length."""
    measured = data["calibration"]["distortion"]
    several = measured if isinstance(measured, list) else [measured]
    return [each for each in several if isinstance(each, Mapping)]


def lens_name(data: Mapping[Any, Any], measured: Mapping[Any, Any]) -> str:
    """Return maker, model and focal length of a lens's distortion."""
    parts = [data.get("maker"), data.get("model"), f"{measured.get('focal')} mm"]
    words = (each[0] if isinstance(each, list) and each else each for each in parts)
    return " ".join(str(each) for each in words if isinstance(each, str))


def read(data: Mapping[Any, Any], measured: Mapping[Any, Any], options: ReaderOptions) -> ImportedFile:
    """Read a distortion of a lens: the closest camera for a picture; CalibrationError ``malformed``.

    Source: Lensfun's manual, "Lens distortion models". Focal length and crop factor say how large the unit
    is.
    """
    if options.img_size is None:
        raise text.refuse("a lens database knows no pictures: give their size (--img-size 6000x4000)")
    kind = data.get("type", "rectilinear")
    if kind not in ("rectilinear", ""):
        raise text.refuse(f"Lensfun's {str(kind)[:40]} lenses are not supported, rectilinear ones are")
    values, model = Members(measured), str(measured.get("model"))

    def value(name: str, default: float | None = None) -> float:
        held = values.get(name)
        return text.scalar(default if held is None else held, name)

    distort: Callable[[Array], Array]
    if model == "ptlens":
        a, b, c = value("a", 0.0), value("b", 0.0), value("c", 0.0)
        distort = lambda r: a * r**4 + b * r**3 + c * r**2 + (1 - a - b - c) * r  # noqa: E731
    elif model == "poly3":
        k1 = value("k1", 0.0)
        distort = lambda r: k1 * r**3 + (1 - k1) * r  # noqa: E731
    elif model == "poly5":
        k1, k2 = value("k1", 0.0), value("k2", 0.0)
        distort = lambda r: k2 * r**5 + k1 * r**3 + r  # noqa: E731
    else:
        raise text.refuse(f"Lensfun's model {model[:40]!r} is not supported; ptlens, poly3 and poly5 are")
    lens = Members(data)
    crop = text.scalar(lens.get("cropfactor") or 1.0, "cropfactor")
    w, h = options.img_size
    focal, unit = value("focal"), (min(w, h) - 1) / 2
    if not (focal > 0 and crop > 0):
        raise text.refuse("focal length and crop factor must be positive")
    f = focal / (DIAGONAL / crop) * math.hypot(w - 1, h - 1) / unit
    shift = lens.get("center") if isinstance(lens.get("center"), Mapping) else {}
    x, y = (text.scalar(shift.get(axis, 0.0), axis) for axis in ("x", "y"))
    centre = ((w - 1) / 2 + x * unit, (h - 1) / 2 + y * unit)
    return closest_camera(radial_corrected(distort, unit, f, centre), (w, h), lens_name(data, measured))
