"""Names that other tools give to distortion models, and the model of ours that each of them is."""

from . import text
from .members import Members, normalise
from .spellings import words

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


def stated_model(members: Members, *, distorted: bool = True) -> str | None:
    """Return the model of ours that a camera's members name; None if they name none.

    Without distortion the variants of Brown's model are all the same.
    Raises CalibrationError ``malformed`` for a model that none of ours is.
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


def our_model(name: str) -> str | None:
    """Return our model that some tool calls `name`; None if it is none that is known here."""
    plain = _plain(name)
    return next((model for model, names in MODEL_NAMES.items() if plain in names), None)


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
        model = our_model(value)
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
