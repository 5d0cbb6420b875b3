"""One captured frame."""

from dataclasses import dataclass

import numpy as np

from .arrays import Array, IntArray, Mask, frozen


@dataclass(frozen=True, eq=False)
class View:
    """Board corners and where they were seen.

    Attributes
    ----------
    object_points
        (n, 3), board frame, board units (any unit of length; it only scales the translations).
    image_points
        (n, 2), px, centre of the top-left pixel at (0, 0).
    weights
        (n,) or one number, > 0: 1 / variance, up to a factor that all views share; None is 1.
        They count in `fit` and `locate`.
    flat
        True if the board is known to be as drawn, as on a screen: `fit` then estimates no shape.

    Raises ValueError if shapes or numbers make no sense.
    """

    object_points: Array
    image_points: Array
    weights: Array | float | None = None
    flat: bool = False

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
        if self.weights is not None:
            w = np.asarray(self.weights, dtype=np.float64)
            if w.shape not in ((), (len(p),)) or not (np.isfinite(w).all() and (w > 0).all()):
                raise ValueError(f"weights must be one positive number, or {len(p)} of them")
            object.__setattr__(self, "weights", frozen(np.broadcast_to(w, len(p))))

    def __len__(self) -> int:
        return len(self.object_points)

    def subset(self, index: IntArray | Mask) -> "View":
        """View with some of its points."""
        weights = None if self.weights is None else np.asarray(self.weights)[index]
        return View(self.object_points[index], self.image_points[index], weights, self.flat)
