"""Camera models by name. A new one is a class in its own module and a line in the registry."""

from ..errors import CalibrationError
from .base import Coefficient, Model, Prior
from .fisheye import Fisheye
from .omnidirectional import Omnidirectional
from .rational import Rational
from .rectilinear import Rectilinear

REGISTRY: dict[str, Model] = {
    model.name: model for model in (Rectilinear(), Fisheye(), Rational(), Omnidirectional())
}
NAMES = tuple(REGISTRY)

__all__ = ["NAMES", "REGISTRY", "Coefficient", "Model", "Prior", "get"]


def get(name: str) -> Model:
    """Return the model called `name`; CalibrationError ``unknown_model`` where there is none."""
    try:
        return REGISTRY[name]
    except KeyError:
        raise CalibrationError("unknown_model", f"no camera model is called {name!r}") from None
