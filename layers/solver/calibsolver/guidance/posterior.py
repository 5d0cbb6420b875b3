"""What is known of a camera's intrinsics: the prior, or a calibration."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .. import models
from ..arrays import Array, symmetric_inverse
from ..camera import Camera
from ..fitting import prior, uncertainty
from ..fitting.calibration import Calibration
from ..models import Model
from .candidates import Sight

GRID = (12, 9)
NOMINAL_NOISE = 0.3 / 1280
"""Standard deviation of a corner's coordinate / image width, before anything was measured."""
LEAST_NOISE = 0.05 / 1280
"""No detector is better than this; views that fit by luck do not promise it either."""


@dataclass(frozen=True, eq=False)
class Belief:
    """What is known of the intrinsics: values (p,), information (p, p), and noise of a corner, px."""

    model: Model
    k: Array
    information: Array
    noise: float
    img_size: tuple[int, int]

    @classmethod
    def of(
        cls,
        model: str,
        img_size: tuple[int, int],
        calibration: Calibration | None,
        known: Camera | None = None,
    ) -> "Belief":
        """From a calibration, or from the model's prior alone, about a camera `known` from elsewhere if any.

        What others measured says where to begin, and no more: how sure one may be of it is not believed.
        """
        law = models.get(model)
        w = img_size[0]
        if calibration is None:
            k = law.start(law.prior.focal * w, img_size)
            if known is not None and (known.model, known.img_size) == (model, img_size):
                k = known.intrinsics
            return cls(law, k, prior.information(law, k, img_size), NOMINAL_NOISE * w, img_size)
        k = calibration.camera.intrinsics
        noise = max(calibration.noise, LEAST_NOISE * w)
        covariance = calibration.covariance * (noise / max(calibration.noise, 1e-12)) ** 2
        return cls(law, k, symmetric_inverse(covariance), noise, img_size)

    @property
    def camera(self) -> Camera:
        """The camera at the believed intrinsics."""
        return Camera.from_intrinsics(self.model.name, self.k, self.img_size)

    @cached_property
    def sight(self) -> Sight:
        """Rays over the image."""
        return Sight.of(self.model, self.k, self.img_size)

    @cached_property
    def weight(self) -> Array:
        """W (p, p), see `uncertainty.weight`."""
        return uncertainty.weight(uncertainty.sensitivity(self.model, self.k, self.img_size, GRID))

    def gain(self, information: Array) -> float:
        """Return how far views of `information` (p, p) at unit noise lower the mean square error, px^2."""
        w = self.weight
        before = symmetric_inverse(self.information)
        after = symmetric_inverse(self.information + information / self.noise**2)
        return float(np.sum((before - after) * w))
