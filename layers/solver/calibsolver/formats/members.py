"""Members of parsed files by their names, however they are spelt: `Camera_Matrix`, `cameraMatrix`."""

import re
from collections.abc import Mapping, Sequence
from typing import Any

from . import text


def words(names: str) -> tuple[str, ...]:
    """Split names at blanks."""
    return tuple(names.split())


def _pairs(names: str) -> tuple[tuple[str, str], ...]:
    return tuple((x, y) for x, y in (pair.split(",") for pair in names.split()))


EXPLICIT_MATRIX = ("cameramatrix", "cameramat", "cammatrix")
"""Names that nothing but a camera matrix has."""
MATRIX = (
    *EXPLICIT_MATRIX,
    *words(
        "cameramtx mtx k kmatrix matrixk intrinsicmatrix intrinsicsmatrix cameraintrinsicmatrix "
        "cameraintrinsics intrinsics intrinsic intrinsicmat intrinsicparameters calibrationmatrix "
        "cameracalibrationmatrix cameraintrinsic m a matrix"
    ),
)
DISTORTION = words(
    "distortioncoefficients distortioncoeffs distortioncoeff distortioncoefs distortioncoef "
    "distcoeffs distcoeff distcoefs distcoef distcoefficients distortioncoefficient distortion "
    "distortions dist d distortionvector distortionparameters distortionparams cameradistortion "
    "distortionmatrix lensdistortion coeffs coefficients kc distvec distortionvalues dists "
    "distortionarray distparams cameradistcoeffs"
)
COEFFICIENTS = words("k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4 tx ty")
"""Coefficients that have a name each, in OpenCV's order."""
FISHEYE_COEFFICIENTS = ("k1", "k2", "k3", "k4", "k5")
FOCAL = _pairs(
    "fx,fy fu,fv gamma1,gamma2 mu,mv flx,fly focalx,focaly focallengthx,focallengthy alphax,alphay "
    "alphau,alphav au,av ax,ay focalxpx,focalypx"
)
CENTRE = _pairs(
    "cx,cy cu,cv pu,pv u0,v0 ppx,ppy px,py x0,y0 principalpointx,principalpointy centerx,centery "
    "ox,oy cenx,ceny"
)
FOCAL_PAIRS = words("focallength fc focallengths focal f focallengthpx")
CENTRE_PAIRS = words("principalpoint cc opticalcenter opticalcentre principal center c pp")
NESTED = words(
    "projectionparameters distortionparameters mirrorparameters intrinsics intrinsic camera "
    "parameters params distortion distortioncoefficients distcoeffs distortionparams lens projection "
    "cameraparameters intrinsicparameters coefficients distortioncoeffs cameraintrinsics "
    "radialdistortion tangentialdistortion radial tangential dist cameramatrix focallength "
    "principalpoint"
)
"""Members whose own members count as the camera's."""
SIDES = _pairs(
    "imagewidth,imageheight imgwidth,imgheight width,height imwidth,imheight framewidth,frameheight "
    "camerawidth,cameraheight imagesizewidth,imagesizeheight resolutionwidth,resolutionheight "
    "resolutionx,resolutiony widthpx,heightpx imagecols,imagerows imgw,imgh xres,yres resx,resy w,h "
    "nx,ny"
)
SIZE = words(
    "imgsize imagesize resolution cameraresolution imsize imageresolution framesize calibdimension "
    "calibrationresolution imagedimensions imagesizes dimensions size resolutions viewport"
)
"""Width and height in one."""
SHAPE = ("imageshape", "imgshape", "shape", "frameshape")
"""Sizes in numpy's order, height first."""

MODEL_NAMES = {
    "rectilinear": words(
        "plumbbob radtan radialtangential brown brownconrady opencv opencv4 opencv5 opencvstandard "
        "opencvpinhole opencvradtan rectilinear standard perspective pinhole pinholeradtan "
        "pinholebrown simplepinhole simpleradial radial rectified none noop nodistortion pinholecamera"
    ),
    "rational": words("rationalpolynomial rational opencv8 fullopencv pinholefull radtan8 pinholeradtan8"),
    "fisheye": words(
        "equidistant equi fisheye opencvfisheye fisheyeopencv kannalabrandt kb kb4 kannalabrandt4 "
        "kannalabrandt8 kb8 pinholeequi pinholeequidistant equidistant4 kannalabrandtcamera "
        "fisheyecamera pinholefisheye"
    ),
    "omnidirectional": words(
        "omni mei omnidir omnidirectional unified ucm omniradtan catadioptric cata meicamera catacamera"
    ),
}
"""Names, normalised, by our model."""

FOREIGN_NAMES = words(
    "fov atan ds doublesphere eucm extendedunified scaramuzza ocam ocamcalib cahvor cahvore poly3 "
    "poly5 ptlens thinprismfisheye thinprism ftheta spherical inversebrownconrady modifiedbrownconrady "
    "equirectangular cylindrical kannalabrandt6 division simpledivision stereographic lonlat latlon "
    "radtanthinprismfisheye fisheye624 fisheye62 splined genericpolynomial pinholefov omnifov "
    "orthographic equisolid equisolidangle omnieucm radialfisheye simpleradialfisheye"
)
"""Names of models that none of ours is, normalised. Other words in members such as `model` are ignored."""

_STATED = words("distortionmodel modeltype distortiontype distmodel projectionmodel projectiontype")
_CAMERA = words("cameramodel cameratype type model intrinsicstype lensmodel lens cameramodeltype")
_FLAGS = words("fisheyemodel fisheye isfisheye usefisheye useopencvfisheye fisheyelens")
MAX_MEMBERS = 10_000


def normalise(name: object) -> str:
    """Write a member's name in lower case, only letters and digits."""
    return re.sub(r"[^a-z0-9]+", "", str(name)[:200].lower())


class Members:
    """A mapping looked up by normalised names; of two that are alike, the first counts."""

    def __init__(self, data: Mapping[Any, Any]) -> None:
        self._found: dict[str, tuple[str, Any]] = {}
        for key, value in list(data.items())[:MAX_MEMBERS]:
            self._found.setdefault(normalise(key), (str(key), value))

    def __contains__(self, name: str) -> bool:
        """True if the member exists and is not empty."""
        return self.get(name) is not None

    def get(self, *names: str) -> Any:
        """Return the first of `names` that is there and not empty (null, ``""``, ``[]``); else None."""
        for name in names:
            value = self._found.get(name, ("", None))[1]
            if value is not None and value not in ("", [], {}):
                return value
        return None

    def spelling(self, name: str) -> str:
        """Return the name as the file writes it."""
        return self._found.get(name, (name, None))[0]

    def items(self) -> list[tuple[str, Any]]:
        """Return normalised names and values, in the file's order."""
        return [(name, value) for name, (_, value) in self._found.items()]


def image_size(members: Members, index: int = 0) -> tuple[int, int] | None:
    """Return width and height that a mapping states under any of their names; None if it does not.

    `index` is the camera's place in a list: some files have a list of sizes next to it. Raises
    CalibrationError ``malformed`` for a size that no picture has.
    """
    if size := _sides(members, SIDES):
        return size
    for name in (*SIZE, *SHAPE):
        value = members.get(name)
        if value is None:
            continue
        size = _pair(value, members.spelling(name), index)
        if size:
            return (size[1], size[0]) if name in SHAPE else size
    return None


def _sides(members: Members, sides: Sequence[tuple[str, str]], path: str = "") -> tuple[int, int] | None:
    for wide, high in sides:
        if wide in members and high in members:
            names = (path + members.spelling(wide), path + members.spelling(high))
            return text.width_height((members.get(wide), members.get(high)), names)
    return None


def _pair(value: Any, name: str, index: int) -> tuple[int, int] | None:
    if isinstance(value, Mapping):
        if "data" in value:
            return _pair(value["data"], name, index)
        inner = Members(value)
        return _sides(inner, (*SIDES, ("x", "y")), f"{name}.")
    if isinstance(value, str):
        is_size = re.fullmatch(r"[\s\d.,xX*×;()\[\]]{3,60}", value)
        parts = re.findall(r"\d+(?:\.0*)?", value) if is_size else []
        return text.width_height(map(float, parts), (name, name)) if len(parts) == 2 else None
    if isinstance(value, Sequence) and value:
        if isinstance(value[0], Sequence | Mapping) and not isinstance(value[0], str) and len(value) > index:
            return _pair(value[index], name, 0)
        if len(value) in (2, 3):
            return text.width_height(value[:2], (name, name))
    return None


def stated_model(members: Members, *, distorted: bool = True) -> str | None:
    """Return our model that a camera's members name; None if they name none.

    Without distortion the variants of Brown's model are all the same. Raises CalibrationError ``malformed``
    for a model that calibsolver does not have.
    """
    distortion = _our_named_model(members, _STATED, strict=True, distorted=distorted)
    camera = _our_named_model(members, _CAMERA, strict=False, distorted=distorted)
    if camera == "omnidirectional" and distortion not in (None, camera):
        if distortion == "rectilinear":  # the mirror's model, radial and tangential terms after it
            return camera
        raise text.refuse(f"an omnidirectional camera with {distortion} distortion is not supported")
    if distortion == "rectilinear" and camera is not None:
        return camera
    if distortion or camera:
        return distortion or camera
    flag = members.get(*_FLAGS)
    if isinstance(flag, int | float | str) and str(flag).strip().lower() in ("1", "1.0", "true", "yes"):
        return "fisheye"
    return None


def _plain(name: str) -> str:
    plain = normalise(name)
    for prefix in ("distortion", "lensmodel"):
        plain = plain.removeprefix(prefix)
    return plain.removesuffix("model").removesuffix("distortion")


def _our_named_model(members: Members, keys: tuple[str, ...], *, strict: bool, distorted: bool) -> str | None:
    for key in keys:
        value = members.get(key)
        if not isinstance(value, str) or not value.strip():
            continue
        plain = _plain(value)
        model = next((model for model, names in MODEL_NAMES.items() if plain in names), None)
        if model is None and not distorted and plain.endswith("brownconrady"):
            model = "rectilinear"
        if model:
            return model
        if strict or plain in FOREIGN_NAMES or plain.startswith("splined"):
            raise text.refuse(
                f"{members.spelling(key)} {value[:60]!r} is not supported; rectilinear (plumb_bob, radtan), "
                "rational, fisheye (equidistant, Kannala-Brandt) and omnidirectional (Mei) are"
            )
    return None
