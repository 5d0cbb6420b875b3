"""`make bench DOCS=real-views`: the guidance chooses among the views of real sets.

Of a set with at least 16 views k are chosen one after the other, each by the estimate from those before it,
and fitted. The distance of that camera from a reference, px rms over the image after the best rotation, is
compared with the distances of eight random choices of k views. Three references: the fit of all other views,
which lacks what the choice took; the fit of all views; and the fit of views that were set aside at random
before the choice, which no choice can spoil or improve.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from calibsolver import Calibration, CalibrationError, Camera, View, rotation
from calibsolver.arrays import Array, symmetric_inverse, whitening
from calibsolver.camera import pixel_grid
from calibsolver.fitting import prior
from calibsolver.fitting.observations import Observations
from calibsolver.fitting.resection import resect
from calibsolver.fitting.validation import degenerate_views, pack
from calibsolver.guidance import PoseSelection
from calibsolver.guidance.overlap import estimate_outline, jaccard_index
from calibsolver.guidance.posterior import IntrinsicsPosterior
from tests.bench import corners, document
from tests.bench.corners import try_fit
from tests.helpers.data import on_board
from tests.helpers.solver import synthetic

MODELS = ("rectilinear", "fisheye")
DRAWS = 8
MIN_VIEWS, MIN_VIEWS_OF_MANY = 16, 25
SPLITS, POOL_SHARE = 4, 0.6
"""Random divisions of a set, and the share of its views that the choice is made from."""
MAX_NOISE_RATIO = 2.0
"""Noise of a model / noise of the best of a set, from which the model is not believable there."""


def distance(one: Camera, other: Camera, q: Array | None = None) -> float:
    """Difference of two cameras' projections, px rms where both have rays; infinite for less than half.

    `q` (n, 2): pixels at which they are compared; None: all over the image.
    """
    q = pixel_grid(one.img_size, (20, 15)).reshape(2, -1).T if q is None else q
    a, b = one.unproject(q), other.unproject(q)
    seen = np.isfinite(a[:, 0]) & np.isfinite(b[:, 0])
    if seen.mean() < 0.5:
        return np.inf
    a, b, q = a[seen], b[seen], q[seen]
    e = synthetic.aligned_errors(other, a, q, rotation.nearest(b.T @ a), 4)
    return float(np.sqrt(np.mean(np.sum(e[np.isfinite(e).all(axis=1)] ** 2, axis=1))))


def guided(views: Sequence[View], size: tuple[int, int], model: str, count: int) -> list[int]:
    """Choose the view that reduces the predicted projection error most, each time, as a guided capture."""
    obs = Observations.of(views)
    chosen: list[int] = []
    while len(chosen) < min(count, len(views)):
        posterior = posterior_of([views[i] for i in chosen], size, model, systematic=1.0)
        information = view_information(posterior, obs)
        total = prior.information(posterior.model, posterior.k, size) + information[chosen].sum(axis=0)
        left = others(views, chosen)
        after = symmetric_inverse(total + information[left])
        error = np.einsum("vij,ij->v", after, posterior.error_metric)
        chosen.append(left[int(np.nanargmin(error))])
    return chosen


def posterior_of(
    views: Sequence[View], size: tuple[int, int], model: str, systematic: float
) -> IntrinsicsPosterior:
    calibration = try_fit(views, size, model) if views else None
    return replace(IntrinsicsPosterior.of(model, size, calibration), systematic=systematic)


def others(views: Sequence[View], chosen: Sequence[int]) -> list[int]:
    return [i for i in range(len(views)) if i not in chosen]


def view_information(posterior: IntrinsicsPosterior, obs: Observations) -> Array:
    """Fisher information (v, p, p) of views under the posterior's camera; 0 of one that it cannot pose."""
    poses, square = resect(posterior.model, posterior.k, obs)
    with np.errstate(all="ignore"):
        s = posterior.view_information(obs, poses)
    posed = np.isfinite(square) & np.isfinite(s).all(axis=(1, 2))
    return np.where(posed[:, None, None], s, 0.0) / posterior.noise**2


def representative(views: Sequence[View], size: tuple[int, int], model: str, count: int) -> list[int]:
    """Choose the view that brings the mean information nearest to that of all, each time, by Stein's loss.

    Equal moments give equal bias of a model that is too simple (Box & Draper 1959).
    """
    obs = Observations.of(views)
    chosen: list[int] = []
    while len(chosen) < count:
        posterior = posterior_of([views[i] for i in chosen], size, model, systematic=0.0)
        information = view_information(posterior, obs)
        known = prior.information(posterior.model, posterior.k, size)
        posed = np.flatnonzero(np.abs(information).max(axis=(1, 2)) > 0).tolist()
        every = (information.sum(axis=0) + known) / max(len(posed), 1)
        left = [i for i in posed if i not in chosen] or others(views, chosen)
        mean = (information[chosen].sum(axis=0) + information[left] + known) / (len(chosen) + 1)
        t = whitening(mean)
        x = np.swapaxes(t, -1, -2) @ every @ t
        chosen.append(left[int(np.argmin(np.trace(x, axis1=-2, axis2=-1) - np.linalg.slogdet(x)[1]))])
    return chosen


def published(views: Sequence[View], size: tuple[int, int], model: str, count: int) -> list[int]:
    """Choose the view that overlaps most with the target of the published method, each time."""
    board, _, shown = on_board(views)
    outlines = [estimate_outline(board, view) for view in shown]
    guide = PoseSelection(board, size, model)
    chosen: list[int] = []
    while len(chosen) < count:
        with np.errstate(all="ignore"):
            target = guide.next_pose([shown[i] for i in chosen], None)
        overlaps = {i: jaccard_index(target.outline, outlines[i], size) for i in others(views, chosen)}
        chosen.append(max(overlaps, key=overlaps.__getitem__))
    return chosen


def distances(
    views: Sequence[View], size: tuple[int, int], model: str, chosen: Sequence[int], whole: Camera
) -> tuple[float, float]:
    """Distances of the fit of the chosen views from that of all others, and from that of all; NaN of none."""
    if not chosen:
        return np.nan, np.nan
    ours = try_fit([views[i] for i in chosen], size, model)
    rest = try_fit([views[i] for i in others(views, chosen)], size, model)
    if ours is None:
        return np.inf, np.inf
    return distance(rest.camera, ours.camera) if rest else np.nan, distance(whole, ours.camera)


def usable_views(name: str) -> tuple[list[View], tuple[int, int]]:
    """Views of a set less the degenerate ones, and the size of its images."""
    data = corners.load(name)
    flat = degenerate_views(pack(data.views, data.img_size))
    return [view for view, bad in zip(data.views, flat, strict=True) if not bad], data.img_size


def believable(views: Sequence[View], size: tuple[int, int]) -> dict[str, Calibration]:
    """Fits of all views with each model that explains them about as well as the best."""
    fits = {model: found for model in MODELS if (found := try_fit(views, size, model))}
    least = min((f.noise for f in fits.values()), default=np.nan)
    return {model: f for model, f in fits.items() if f.noise <= MAX_NOISE_RATIO * least}


def random_choices(count: int, of: int, rng: np.random.Generator) -> list[list[int]]:
    return [rng.permutation(of)[:count].tolist() for _ in range(DRAWS)]


def rows_of(name: str) -> Iterator[tuple[list[str], Array]]:
    """Set, model and number of views; distances (2, 4), px, from the fit of all others, and of all views.

    Of the choices guided, random (median), representative, published.
    """
    views, size = usable_views(name)
    if len(views) < MIN_VIEWS:
        return
    counts = (6, 10, 15) if len(views) >= MIN_VIEWS_OF_MANY else (6,)
    for model, whole in believable(views, size).items():
        sequences: list[list[int]] = []
        for choose in (guided, representative, published):
            try:
                sequences.append(choose(views, size, model, counts[-1]))
            except CalibrationError:
                sequences.append([])
        for count in counts:
            draws = random_choices(count, len(views), np.random.default_rng(0))
            chosen = [*(sequence[:count] for sequence in sequences), *draws]
            apart = [distances(views, size, model, choice, whole.camera) for choice in chosen]
            ours, typical, peer, *drawn = apart
            columns = (ours, np.nanmedian(np.array(drawn), axis=0), typical, peer)
            yield [name, model, str(count)], np.array(columns).T


def asides_of(name: str) -> Iterator[tuple[float, ...]]:
    """Distances from the fit of views set aside at random: guided, random (median), representative."""
    every, size = usable_views(name)
    if len(every) < MIN_VIEWS:
        return
    counts = (4, 6, 10) if len(every) >= MIN_VIEWS_OF_MANY else (4, 6)
    part = round(POOL_SHARE * len(every))
    for model in believable(every, size):
        for split in range(SPLITS):
            rng = np.random.default_rng(split)
            shuffled = [every[i] for i in rng.permutation(len(every))]
            views, reference = shuffled[:part], try_fit(shuffled[part:], size, model)
            if reference is None:
                continue
            sequences = [choose(views, size, model, counts[-1]) for choose in (guided, representative)]
            for count in counts:
                apart = []
                for choice in (*(s[:count] for s in sequences), *random_choices(count, part, rng)):
                    found = try_fit([views[i] for i in choice], size, model)
                    apart.append(distance(reference.camera, found.camera) if found else np.inf)
                yield apart[0], float(np.median(apart[2:])), apart[1]


def conclusion(rows: Array, asides: Array) -> str:
    parts = []
    for what, table in (
        ("the fit of all other views", rows[:, 0]),
        ("the fit of all views", rows[:, 1]),
        (f"the fit of views set aside before ({SPLITS} splits a set)", asides),
    ):
        distances = []
        for choice, column in (("guided", 0), ("representative", 2), ("published method's", 3)):
            if column < table.shape[1]:
                ratio = table[:, column] / table[:, 1]
                finite = np.isfinite(ratio) & (ratio > 0)
                mean = np.exp(np.mean(np.log(ratio[finite])))
                far = np.mean(~(ratio <= 1.5))
                distances.append(
                    f"the {choice} choice is nearer than the median random choice in "
                    f"{np.mean(ratio < 1):.0%} and more than 1.5 times as far in {far:.0%} of them "
                    f"(geometric mean of the ratio {mean:.2f})"
                )
        parts.append(f"* Distance from {what}, {len(table)} rows: {'; '.join(distances)}.")
    return "\n".join(parts)


def main() -> None:
    rows = [row for name in corners.NAMES for row in rows_of(name)]
    asides = [row for name in corners.NAMES for row in asides_of(name)]
    choices = ("guided, px", "random", "representative", "published")
    header = ["set", "model", "views", *(f"{to}: {what}" for to in ("others", "all") for what in choices)]
    cells = [
        [*about, *(f"{value:.2f}" if np.isfinite(value) else "none" for value in apart.ravel())]
        for about, apart in rows
    ]
    summary = conclusion(np.array([apart for _, apart in rows]), np.array(asides))
    document.replace("real views", f"{document.table(header, cells)}\n\n{summary}")


if __name__ == "__main__":
    main()
