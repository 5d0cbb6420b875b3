"""Plots of a calibration, by matplotlib (the extra ``plot``): each draws into an axis, `report` draws all."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from . import rotation, undistortion
from .arrays import Array
from .camera import Camera
from .fitting.calibration import Calibration
from .view import View

ARROW_SHARE = 0.05
TYPICAL_PERCENTILE = 90.0
STD_GRID = (64, 48)
LINES = 9


def residuals(axes: Any, calibration: Calibration, views: Sequence[View]) -> None:
    """Draw every residual as an arrow from its corner, lengthened: observed minus projected."""
    points = np.concatenate([view.image_points for view in views])
    vectors, used = np.concatenate(calibration.residuals), np.concatenate(calibration.used)
    lengths = np.linalg.norm(vectors, axis=1)
    finite = np.isfinite(lengths)
    typical = float(np.percentile(lengths[finite & used], TYPICAL_PERCENTILE)) if (finite & used).any() else 1
    factor = ARROW_SHARE * calibration.camera.img_size[0] / max(typical, 1e-9)
    for mask, color, name in ((used & finite, "#1f5fa8", "used"), (~used & finite, "#c8352b", "left out")):
        if mask.any():
            shown = vectors[mask] * np.minimum(1, 3 * typical / np.maximum(lengths[mask], 1e-9))[:, None]
            axes.quiver(
                *points[mask].T, *(factor * shown).T, angles="xy", scale_units="xy", scale=1,
                width=0.0016, color=color, label=f"{name} ({int(mask.sum())})",
            )  # fmt: skip
    _picture(axes, calibration.camera, f"Residuals, {factor:.0f} times as long")
    axes.legend(loc="upper right", fontsize="x-small")


def coverage(axes: Any, calibration: Calibration, views: Sequence[View]) -> None:
    """Draw the corners of all views, a colour for each view."""
    for number, view in enumerate(views):
        axes.plot(*view.image_points.T, ".", markersize=2.5, color=f"C{number % 10}")
    count = sum(len(view) for view in views)
    _picture(axes, calibration.camera, f"Corners: {count} in {len(views)} views")


def uncertainty(axes: Any, calibration: Calibration) -> Any:
    """Draw the predicted error of a projection over the picture, px; grey where the model has no ray."""
    std = calibration.projection_std(STD_GRID)
    w, h = calibration.camera.img_size
    top = float(np.nanpercentile(std, 98)) if np.isfinite(std).any() else 1.0
    axes.set_facecolor("0.75")
    image = axes.imshow(std, extent=(-0.5, w - 0.5, h - 0.5, -0.5), cmap="viridis", vmin=0, vmax=top)
    covered = 100 * calibration.camera.domain().covered
    words = "" if covered > 99.95 else f", {covered:.0f} % of the picture"
    _picture(axes, calibration.camera, f"Uncertainty, px{words}")
    axes.figure.colorbar(image, ax=axes, shrink=0.8, extend="max")
    return image


def board_poses(axes: Any, calibration: Calibration, views: Sequence[View]) -> None:
    """Draw the boards in the frame of the camera, into an axis of projection ``3d``."""
    depths = []
    for number, (view, pose) in enumerate(zip(views, calibration.poses, strict=True)):
        if not np.isfinite(pose).all():
            continue
        left, top, _ = view.object_points.min(axis=0)
        right, bottom, _ = view.object_points.max(axis=0)
        corners = [[left, top, 0], [right, top, 0], [right, bottom, 0], [left, bottom, 0]]
        outline = np.array([*corners, corners[0]])
        x, y, z = (outline @ rotation.matrix(pose[:3]).T + pose[3:]).T
        axes.plot(x, z, -y, color=f"C{number % 10}", linewidth=0.9)
        depths.append(float(z.max()))
    reach = 0.15 * max(depths, default=1.0)
    tip, a, b, c, d = np.array([[0, 0, 0], [-1, -0.7, 1], [1, -0.7, 1], [1, 0.7, 1], [-1, 0.7, 1]])
    x, y, z = (reach * np.array([tip, a, b, c, d, a, tip, b, tip, c, tip, d])).T
    axes.plot(x, z, -y, color="black", linewidth=1)
    axes.set_xlabel("x")
    axes.set_ylabel("z")
    axes.set_zlabel("-y", labelpad=-4)
    axes.set_aspect("equal")
    axes.set_title("Boards in front of the camera, board units", fontsize="small")


def before_after(before: Any, after: Any, camera: Camera, picture: Any = None) -> None:
    """Draw a picture (h, w) or (h, w, 3) and the rectified one; without one, straight lines of the scene."""
    matrix = undistortion.new_camera_matrix(camera, 1.0)
    if picture is not None:
        shown = np.asarray(picture)
        tables = undistortion.remap_tables(camera, matrix)
        columns, rows = (np.round(table).astype(int) for table in tables)
        w, h = camera.img_size
        inside = (columns >= 0) & (columns < w) & (rows >= 0) & (rows < h)
        straight = np.zeros_like(shown)
        straight[inside] = shown[rows[inside], columns[inside]]
        before.imshow(shown, cmap="gray")
        after.imshow(straight, cmap="gray")
    else:
        for line in _scene_lines(camera, matrix):
            before.plot(*camera.project(line).T, color="#1f5fa8", linewidth=0.8)
            flat = line @ matrix.T
            after.plot(*(flat[:, :2] / flat[:, 2:]).T, color="#1f5fa8", linewidth=0.8)
    _picture(before, camera, "As taken" if picture is not None else "Straight lines as the camera sees them")
    _picture(after, camera, "Rectified, alpha 1")


def report(calibration: Calibration, views: Sequence[View], title: str = "", picture: Any = None) -> Any:
    """Figure with all plots."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(16, 9.5), layout="constrained")
    axes = [figure.add_subplot(2, 3, n, projection="3d" if n == 4 else None) for n in range(1, 7)]
    residuals(axes[0], calibration, views)
    coverage(axes[1], calibration, views)
    uncertainty(axes[2], calibration)
    board_poses(axes[3], calibration, views)
    before_after(axes[4], axes[5], calibration.camera, picture)
    if title:
        figure.suptitle(title)
    return figure


def _scene_lines(camera: Camera, matrix: Array) -> list[Array]:
    """Straight lines on the plane z = 1, (n, 3) each, that fill the rectified picture."""
    w, h = camera.img_size
    inverse = np.linalg.inv(matrix)
    along, lines = np.linspace(0, 1, 200), []
    for share in np.linspace(0, 1, LINES):
        across = np.full_like(along, share)
        for u, v in ((along, across), (across, along)):
            lines.append(np.stack([u * (w - 1), v * (h - 1), np.ones_like(u)], axis=1) @ inverse.T)
    return lines


def _picture(axes: Any, camera: Camera, title: str) -> None:
    w, h = camera.img_size
    axes.set_xlim(-0.5, w - 0.5)
    axes.set_ylim(h - 0.5, -0.5)
    axes.set_aspect("equal")
    axes.set_title(title, fontsize="small")
