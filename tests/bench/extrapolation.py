"""`make bench DOCS=extrapolation`: errors where no board has been, on real sets; writes to docs/accuracy.md.

Half of the views of a set are fitted with each model. The reference is the fit of all views with the model
that predicts them best. Cameras are compared at the centres of 40 x 30 cells of the image, the rotation that
fits best in the hull of the fitted corners removed. A pair of set and model counts as covered if the largest
error outside that hull is below the maximum that the fit of the half states.
"""

from dataclasses import dataclass

import numpy as np

from calibsolver import Calibration, CalibrationError, Camera, View, fit, models, rotation
from calibsolver.camera import pixel_grid
from calibsolver.fitting.coverage import COVERAGE_GRID, hull
from calibsolver.quality.model_selection import suggest_model
from calibsolver.quality.rivals import with_rivals
from tests.bench import corners, document


@dataclass(frozen=True)
class Row:
    """Half of a set with a model: px, largest error outside the hull, and the maxima stated."""

    name: str
    model: str
    half: int
    error: float
    stated: float
    stated_by_model: float
    """Without the rivals."""


def errors(reference: Camera, camera: Camera, inside: np.ndarray) -> np.ndarray:
    """Distances (n,) px of projections at the cells of the image, aligned in those `inside` (n,)."""
    q = pixel_grid(camera.img_size, COVERAGE_GRID).reshape(2, -1).T
    rays, theirs = camera.unproject(q), reference.unproject(q)
    both = inside & np.isfinite(rays[:, 0]) & np.isfinite(theirs[:, 0])
    turn = rotation.nearest(rays[both].T @ theirs[both])
    away: np.ndarray = np.linalg.norm(camera.project(theirs @ turn.T) - q, axis=1)
    return away


def corner_hull(views: list[View], calibration: Calibration) -> np.ndarray:
    pairs = zip(views, calibration.used, strict=True)
    return hull(np.concatenate([v.image_points[used] for v, used in pairs]), calibration.camera.img_size)


def rows_of(name: str) -> list[Row]:
    data = corners.load(name)
    views, size = list(data.views), data.img_size
    reference = fit(views, size, suggest_model(views, size).model).camera
    out = []
    for model in models.NAMES:
        for half in (0, 1):
            part = views[half::2]
            try:
                plain = fit(part, size, model)
            except CalibrationError:
                continue
            outside = ~corner_hull(part, plain)
            error = float(np.nanmax(errors(reference, plain.camera, ~outside)[outside]))
            whole = with_rivals(plain, part)
            by_model = float(np.nanmax(plain.projection_std(COVERAGE_GRID)))
            out.append(Row(name, model, half, error, whole.uncertainty().max, by_model))
    return out


def main() -> None:
    rows = [row for name in corners.NAMES for row in rows_of(name)]
    cells = []
    for model in models.NAMES:
        of = [row for row in rows if row.model == model]
        error, stated, by_model = (
            np.array([getattr(row, name) for row in of]) for name in ("error", "stated", "stated_by_model")
        )
        cells.append(
            [
                model,
                str(len(of)),
                f"{np.mean(error < stated):.0%}",
                f"{np.mean(error < by_model):.0%}",
                f"{np.median(error):.1f}, {np.median(stated):.1f}",
            ]
        )
    total = np.mean([row.error < row.stated for row in rows])
    without = np.mean([row.error < row.stated_by_model for row in rows])
    header = ["model", "halves of sets", "covered", "by the covariance only", "median error, stated, px"]
    told = f"Covered: {total:.0%} of {len(rows)}; {without:.0%} by the covariance only."
    document.replace("extrapolation", f"{document.table(header, cells)}\n\n{told}")


if __name__ == "__main__":
    main()
