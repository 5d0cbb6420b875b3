"""One captured frame."""

from dataclasses import dataclass

import numpy as np

from .arrays import Array, frozen


@dataclass(frozen=True, eq=False)
class View:
    """Board corners and where they were seen.

    Attributes
    ----------
    object_points
        (n, 3), board frame, board units (any unit of length; it only scales the translations).
    image_points
        (n, 2), px, centre of the top-left pixel at (0, 0).

    Raises ValueError where shapes or numbers make no sense.
    """

    object_points: Array
    image_points: Array

    def __post_init__(self) -> None:
        p, q = frozen(self.object_points), frozen(self.image_points)
        if p.ndim != 2 or p.shape[1] != 3:
            raise ValueError(f"object_points must be (n, 3), not {p.shape}")
        if q.shape != (len(p), 2):
            raise ValueError(f"image_points must be ({len(p)}, 2), not {q.shape}")
        if not (np.isfinite(p).all() and np.isfinite(q).all()):
            raise ValueError("points must be finite")
        object.__setattr__(self, "object_points", p)
        object.__setattr__(self, "image_points", q)

    def __len__(self) -> int:
        return len(self.object_points)
