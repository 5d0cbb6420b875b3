"""Conversion of a camera to a model that a format can hold, exactly or by a fit to the same keypoints."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from .. import models
from ..arrays import Array, Mask
from ..camera import Camera
from ..errors import CalibrationError, format_px_error
from ..fitting import resection
from ..fitting.fit import fit
from ..fitting.levenberg_marquardt import Options, Problem
from ..fitting.observations import Observations
from ..fitting.plausibility import MAX_SHARE_OUTSIDE_DOMAIN
from ..fitting.validation import MAX_OUTSIDE, MIN_POINTS
from ..view import View
from .base import Conversion, ExportSource, ModelConstraint
from .ray_fit import fit_to_rays, free_directions, sampled_rays

LEAST_SQUARES = Options(with_prior=False, tolerance=1e-17, damping=1e-6)
MAX_EQUAL_RMS_RATIO, MAX_EQUAL_RMS_PX = 1.05, 1e-3
"""Ratio and px by which one constraint's rms may exceed another's before they count as different."""
MAX_LOST_COVERAGE = 0.01
"""Share of the image that one constraint may leave out beyond what the others do."""
MAX_ERROR_WIDTHS = 0.05
"""Image widths: a conversion that is further off somewhere is none."""
IMAGE_ERROR_GRID = (129, 97)
"""Columns and rows of the points of the image, its border among them, at which two cameras are compared."""
EDGE_POINTS = 1025
"""Points on each side of the image's border, and around the rim of a model's domain."""
ZOOMS = 4
"""Times that the neighbourhood of the largest difference is searched, each time four times finer."""
ERROR_MARGIN = 1e-3
"""Share by which a stated error exceeds the largest that was found between samples."""
RIM_MARGIN = 1e-6
"""Share by which what is called the rim of a model's domain lies inside it."""


def convert(source: ExportSource, constraints: tuple[ModelConstraint, ...]) -> Conversion:
    """Return the camera closest to the source's that one of `constraints` can hold.

    Its own if possible. Otherwise each constraint is fitted to the views (without any, to the rays of the
    image), and the first wins that explains them about as well as the best: what a tool is used to comes
    first. Another model is fitted to what the image shows of them.

    Raises CalibrationError ``not_representable`` if none comes near.
    """
    for constraint in constraints:
        same = _embed(source.camera, constraint.model)
        if same is not None and satisfies(same, constraint):
            return Conversion(same)
    masks = [_inside(view, source.camera.img_size) for view in source.views]
    whole, source = _in_shape(source), _in_shape(_seen(source, masks))
    candidates: list[tuple[float, Conversion]] = []
    reasons = []
    # Of what none can hold no constraint is to be chosen.
    widest = max(models.get(constraint.model).max_angle for constraint in constraints)
    for constraint in constraints:
        try:
            if _embed(source.camera, constraint.model) is None:
                camera, used = fitted(source, constraint)
                used = _of_all(used, masks)
            else:
                camera, used = fitted(whole, constraint)
            conversion = replace(compare(source.camera, camera), used=used)
            candidates.append((_rms(source, camera, widest), conversion))
        except CalibrationError as error:
            reasons.append(str(error))
    if not candidates and source.views and not all(mask.all() for mask in masks):
        return convert(replace(source, views=()), constraints)  # a crop has left too little of them
    if not candidates:
        raise CalibrationError("not_representable", f"this format cannot hold the camera: {reasons[0]}")
    enough = MAX_EQUAL_RMS_RATIO * min(rms for rms, _ in candidates) + MAX_EQUAL_RMS_PX
    near = [conversion for rms, conversion in candidates if rms <= enough]
    widest = max(conversion.coverage for conversion in near)
    conversion = next(each for each in near if each.coverage > widest - MAX_LOST_COVERAGE)
    width = source.camera.img_size[0]
    if conversion.error > MAX_ERROR_WIDTHS * width:
        away = format_px_error(conversion.error, width, 0)
        raise CalibrationError(
            "not_representable", f"the closest camera this format can hold is {away} somewhere in the image"
        )
    return conversion


def _inside(view: View, img_size: tuple[int, int]) -> Mask:
    """Mask (n,) of the points of a view that a fit to an image accepts: a crop leaves others outside."""
    half = np.array(img_size) / 2
    beyond = np.abs(view.image_points + 0.5 - half) - half
    inside = beyond.max(axis=1) <= MAX_OUTSIDE * max(img_size)
    return inside if inside.sum() >= MIN_POINTS else np.zeros(len(view), dtype=bool)


def _seen(source: ExportSource, masks: Sequence[Mask]) -> ExportSource:
    """Source with the points that `masks` (n,) name, without views that have none."""
    pairs = zip(source.views, masks, strict=True)
    return replace(source, views=tuple(view.subset(mask) for view, mask in pairs if mask.any()))


def _of_all(used: Sequence[Mask], masks: Sequence[Mask]) -> tuple[Mask, ...]:
    """Masks of the points used, among all points of all views; `used` is of those that `masks` name."""
    if not used:
        return ()
    whole = [mask.copy() for mask in masks]
    for mask, part in zip((mask for mask in whole if mask.any()), used, strict=True):
        mask[mask] = part
    return tuple(whole)


def _in_shape(source: ExportSource) -> ExportSource:
    """Replace the views by those of the board in its shape, if the camera was fitted to that."""
    camera, views = source.camera, source.views
    if not views:
        return source
    try:
        shaped = fit(views, camera.img_size, camera.model, start=camera).shaped(views)
        errors = [resection.reprojection_score(camera, each).rms for each in (shaped, views)]
    except CalibrationError:
        return source
    return replace(source, views=tuple(shaped)) if errors[0] < errors[1] else source


def _rms(source: ExportSource, camera: Camera, widest: float) -> float:
    """Rms px of the source's views, or of its rays up to `widest` radians, under a camera."""
    if source.views:
        return resection.reprojection_score(camera, source.views).rms
    rays, q = sampled_rays(source.camera, widest)
    with np.errstate(all="ignore"):  # beyond what the camera holds
        away = models.get(camera.model).project(camera.intrinsics, rays) - q
    return float(np.nan_to_num(np.sqrt(np.square(away).sum(axis=0).mean()), nan=np.inf))


def _embed(camera: Camera, model: str) -> Camera | None:
    """Return the same camera under a model of which its own is a special case; None if it is not."""
    if camera.model == model:
        return camera
    if (camera.model, model) == ("rectilinear", "rational"):
        return Camera(model, camera.matrix, np.append(camera.distortion, [0.0, 0.0, 0.0]), camera.img_size)
    return None


def satisfies(camera: Camera, constraint: ModelConstraint) -> bool:
    """True if a camera of the constraint's model satisfies it."""
    names = models.get(camera.model).coefficients
    violated = any(camera.distortion[names.index(name)] != 0 for name in constraint.zero)
    return not violated and not (constraint.equal_focal and camera.matrix[0, 0] != camera.matrix[1, 1])


def compare(camera: Camera, other: Camera) -> Conversion:
    """Projection differences of `other` from `camera`, over the rays of its image that `other` holds.

    These lie where `other` is one-to-one and, if `camera` is of a model that sees farther to the side, within
    the domain of the model of `other`: a plane's coordinates grow without end towards 90 degrees.
    """
    model = models.get(other.model)
    angle = model.domain_half_angle(other.distortion)
    if models.get(camera.model).max_angle > model.max_angle:
        angle = min(angle, model.max_angle)
    error, coverage = differences(camera, other.project, angle)
    if not (error or coverage):
        raise CalibrationError("not_representable", "nothing of the image is left")
    return Conversion(other, error, coverage)


def differences(camera: Camera, project: Callable[[Array], Array], angle: float) -> tuple[float, float]:
    """Largest distance, px, of projections from those of `camera`, and the share of its image compared.

    `project` maps rays (n, 3) to pixels (n, 2), up to an angle from the axis, radians. The border of the
    image counts, and so do the rims of both domains where they cross it: differences are largest there.
    """
    w, h = camera.img_size

    def away_of(q: Array) -> tuple[Array, Mask]:
        """Distance of the two projections of each pixel's ray, -1 outside; and which pixels have a ray."""
        rays = camera.unproject(q)
        visible = np.asarray(np.isfinite(rays).all(axis=1))
        inside = visible & (rays[:, 2] > np.cos(angle))
        away = np.full(len(q), -1.0)
        away[inside] = np.linalg.norm(project(rays[inside]) - q[inside], axis=1)
        return away, visible

    q = samples(camera.img_size)
    away, in_sight = away_of(q)
    grid = slice(IMAGE_ERROR_GRID[0] * IMAGE_ERROR_GRID[1])
    if not (away >= 0).any():
        return 0.0, 0.0
    coverage = float((away[grid][in_sight[grid]] >= 0).mean()) if in_sight[grid].any() else 0.0
    worst = float(away.max())
    centre, step = q[np.argmax(away)], np.array([w, h]) / (np.array(IMAGE_ERROR_GRID) - 1)
    for _ in range(ZOOMS):
        near = np.clip(_lattice(centre - step, centre + step, (9, 9)), -0.5, (w - 0.5, h - 0.5))
        nearby = away_of(near)[0]
        centre, step, worst = near[np.argmax(nearby)], step / 4, max(worst, float(nearby.max()))
    own = models.get(camera.model).domain_half_angle(camera.distortion)
    for rim in {angle, min(angle, own)}:
        rays = _cone(rim * (1 - RIM_MARGIN))
        there = camera.project(rays)
        met = ((there >= -0.5) & (there <= (w - 0.5, h - 0.5))).all(axis=1)
        if met.any():
            worst = max(worst, float(np.linalg.norm(project(rays[met]) - there[met], axis=1).max()))
    return worst * (1 + ERROR_MARGIN), coverage


def samples(img_size: tuple[int, int]) -> Array:
    """Points (n, 2) px of an image: those of `IMAGE_ERROR_GRID`, then its border more densely."""
    w, h = img_size
    t = np.linspace(0, 1, EDGE_POINTS)
    return np.concatenate(
        [_image_grid(img_size)]
        + [np.stack([w * t - 0.5, 0 * t + y], axis=1) for y in (-0.5, h - 0.5)]
        + [np.stack([0 * t + x, h * t - 0.5], axis=1) for x in (-0.5, w - 0.5)]
    )


def share_behind(camera: Camera) -> float:
    """Share of a fisheye's image whose rays lie at 90 degrees from the axis or beyond; 0 for other models."""
    if camera.model != "fisheye":
        return 0.0
    rays = camera.unproject(_image_grid(camera.img_size))
    depths = rays[np.isfinite(rays).all(axis=1), 2]
    return float((depths <= 0).mean()) if len(depths) else 0.0


def _image_grid(img_size: tuple[int, int]) -> Array:
    return _lattice(np.array([-0.5, -0.5]), np.array(img_size) - 0.5, IMAGE_ERROR_GRID)


def _lattice(first: Array, last: Array, count: tuple[int, int]) -> Array:
    """Points (n, 2) in columns and rows between two corners."""
    columns, rows = np.meshgrid(*(np.linspace(*ends) for ends in zip(first, last, count, strict=True)))
    return np.stack([columns.ravel(), rows.ravel()], axis=1)


def _cone(angle: float) -> Array:
    """Rays (n, 3) at an angle from the axis, all around."""
    a = np.linspace(0, 2 * np.pi, EDGE_POINTS)[:-1, None]
    return np.hstack([np.sin(angle) * np.cos(a), np.sin(angle) * np.sin(a), np.cos(angle) + 0 * a])


def convert_in_image(source: ExportSource, constraints: tuple[ModelConstraint, ...]) -> Conversion:
    """Return the camera of one of `constraints` that draws the picture most alike.

    For files that correct pictures: a turn of the camera, which a fit to keypoints is free to make, would be
    a shift of what is seen. Another model is fitted to the source's views first. Raises CalibrationError
    ``not_representable``.
    """
    whole = convert(source, tuple(ModelConstraint(constraint.model) for constraint in constraints)).camera
    constraint = next(constraint for constraint in constraints if constraint.model == whole.model)
    camera = whole if satisfies(whole, constraint) else fit_to_rays(whole, constraint)
    return Conversion(camera) if camera is source.camera else compare(source.camera, camera)


def fitted(source: ExportSource, constraint: ModelConstraint) -> tuple[Camera, tuple[Mask, ...]]:
    """Fit a camera of some constraint to the source's views, or rays; also return the points used.

    Raises CalibrationError if no believable one fits.
    """
    if not source.views:
        closest = fit_to_rays(_embed(source.camera, constraint.model) or source.camera, constraint)
        model = models.get(constraint.model)
        rays, _ = sampled_rays(source.camera, model.max_angle)
        if (~model.valid(closest.distortion, rays)).mean() > MAX_SHARE_OUTSIDE_DOMAIN:
            raise CalibrationError("not_representable", "the simpler model folds the image over")
        return closest, ()
    views = source.views
    first = _embed(source.camera, constraint.model)
    used = all_points(views)
    if first is None:
        size = source.camera.img_size
        calibration = fit(views, size, constraint.model, start=source.camera, board_shape=False)
        first, used = calibration.camera, calibration.used
        if not (constraint.zero or constraint.equal_focal):
            return first, used
    return fit_constrained(first, constraint, views, used), used


def all_points(views: Sequence[View]) -> tuple[Mask, ...]:
    """Masks (n,) of all points of views."""
    return tuple(np.ones(len(view), dtype=bool) for view in views)


def fit_constrained(
    camera: Camera, constraint: ModelConstraint, views: tuple[View, ...], used: tuple[Mask, ...]
) -> Camera:
    """Least squares over the cameras that satisfy a constraint, from a camera of its model.

    k = T a: the columns of the problem's basis T are the directions in which the intrinsics may still go.

    Raises CalibrationError ``not_representable`` if the fit diverges.
    """
    model = models.get(camera.model)
    basis = free_directions(model, constraint)
    k = basis @ np.linalg.lstsq(basis, camera.intrinsics, rcond=None)[0]
    obs = Observations.of(views)
    weights = np.zeros(obs.mask.shape)
    for row, mask in zip(weights, used, strict=True):
        row[: len(mask)] = mask
    poses, _ = resection.resect(model, k, obs)
    problem = Problem(model, obs, camera.img_size, basis)
    with np.errstate(all="ignore"):  # a step too far is tested before it is taken
        state = problem.solve(problem.at(k, poses), weights, LEAST_SQUARES)
    if not (np.isfinite(state.k).all() and np.isfinite(state.square[weights > 0]).all()):
        raise CalibrationError("not_representable", "the fit of the simpler model diverged")
    return Camera.from_intrinsics(model.name, state.k, camera.img_size)
