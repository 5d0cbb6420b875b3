"""`make bench DOCS=extrapolation`: errors where no board has been, on real sets.

Half of the views of a set are fitted with each model. The reference is the fit of all views with the model
that predicts them best. Cameras are compared at the centres of 40 x 30 cells of the image, the rotation that
fits best in the hull of the fitted corners removed. A pair of set and model counts as covered if the largest
error outside that hull is below the maximum that the fit of the half states.
"""

from dataclasses import dataclass

import numpy as np

from calibsolver import Calibration, Camera, View, fit, models, rotation
from calibsolver.camera import pixel_grid
from calibsolver.fitting.coverage import COVERAGE_GRID, hull
from calibsolver.quality.model_selection import suggest_model
from calibsolver.quality.rivals import with_rivals
from tests.bench import corners, document


@dataclass(frozen=True)
class Row:
    """Half of a set with a model: px, largest error outside the hull, and the maxima stated."""

    model: str
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
        for part in (views[::2], views[1::2]):
            plain = corners.try_fit(part, size, model, board_shape=True)
            if plain is None:
                continue
            outside = ~corner_hull(part, plain)
            error = float(np.nanmax(errors(reference, plain.camera, ~outside)[outside]))
            stated = with_rivals(plain, part).uncertainty().max
            out.append(Row(model, error, stated, float(np.nanmax(plain.projection_std(COVERAGE_GRID)))))
    return out


def main() -> None:
    rows = [row for name in corners.NAMES for row in rows_of(name)]
    cells = []
    for model in models.NAMES:
        own = [row for row in rows if row.model == model]
        error, stated = np.median([(row.error, row.stated) for row in own], axis=0)
        cells.append([model, str(len(own)), *covered(own), f"{error:.1f}, {stated:.1f}"])
    header = ["model", "halves of sets", "covered", "by the covariance only", "median error, stated, px"]
    total, without = covered(rows)
    summary = f"Covered: {total} of {len(rows)}; {without} by the covariance only."
    document.replace("extrapolation", f"{document.table(header, cells)}\n\n{summary}")


def covered(rows: list[Row]) -> tuple[str, str]:
    """Share of the rows that are covered, and that the covariance only would cover."""
    whole = np.mean([row.error < row.stated for row in rows])
    return f"{whole:.0%}", f"{np.mean([row.error < row.stated_by_model for row in rows]):.0%}"


if __name__ == "__main__":
    main()
