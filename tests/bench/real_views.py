"""`make bench DOCS=real-views`: the guidance chooses among the views of real sets.

Of a set with at least 16 views some are set aside at random; their fit is the reference. Of the others k are
chosen one after the other, each by the estimate from those before it, and fitted. The distance of that camera
from the reference, px rms over the image after the best rotation, is compared with the distances of eight
random choices of k views.
"""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from calibsolver import Calibration, Camera, View, rotation
from calibsolver.arrays import Array, symmetric_inverse
from calibsolver.camera import pixel_grid
from calibsolver.fitting import prior
from calibsolver.fitting.observations import Observations
from calibsolver.fitting.resection import resect
from calibsolver.fitting.validation import degenerate_views, pack
from calibsolver.guidance.posterior import IntrinsicsPosterior
from tests.bench import corners, document
from tests.bench.corners import try_fit
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
        calibration = try_fit([views[i] for i in chosen], size, model) if chosen else None
        posterior = replace(IntrinsicsPosterior.of(model, size, calibration), systematic=1.0)
        information = view_information(posterior, obs)
        total = prior.information(posterior.model, posterior.k, size) + information[chosen].sum(axis=0)
        left = [i for i in range(len(views)) if i not in chosen]
        after = symmetric_inverse(total + information[left])
        error = np.einsum("vij,ij->v", after, posterior.error_metric)
        chosen.append(left[int(np.nanargmin(error))])
    return chosen


def view_information(posterior: IntrinsicsPosterior, obs: Observations) -> Array:
    """Fisher information (v, p, p) of views under the posterior's camera; 0 of one that it cannot pose."""
    poses, square = resect(posterior.model, posterior.k, obs)
    with np.errstate(all="ignore"):
        s = posterior.view_information(obs, poses)
    posed = np.isfinite(square) & np.isfinite(s).all(axis=(1, 2))
    return np.where(posed[:, None, None], s, 0.0) / posterior.noise**2


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


def rows_of(name: str) -> Iterator[tuple[str, str, int, float, float]]:
    """Set, model and number of views; distances of the guided and of the median random choice, px."""
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
            sequence = guided(views, size, model, counts[-1])
            for count in counts:
                draws = [rng.permutation(part)[:count] for _ in range(DRAWS)]
                apart = []
                for choice in (sequence[:count], *draws):
                    found = try_fit([views[i] for i in choice], size, model)
                    apart.append(distance(reference.camera, found.camera) if found else np.inf)
                yield name, model, count, apart[0], float(np.median(apart[1:]))


def main() -> None:
    found = [row for name in corners.NAMES for row in rows_of(name)]
    groups: dict[tuple[str, str, int], list[tuple[float, float]]] = defaultdict(list)
    for name, model, count, ours, drawn in found:
        groups[name, model, count].append((ours, drawn))
    rows = []
    for (name, model, count), apart in groups.items():
        ours, drawn = np.median(apart, axis=0)
        rows.append([name, model, str(count), str(len(apart)), f"{ours:.2f}", f"{drawn:.2f}"])
    ratio = np.array([ours / drawn for *_, ours, drawn in found])
    finite = ratio[np.isfinite(ratio) & (ratio > 0)]
    summary = (
        f"In {len(found)} rows of single splits the guided choice is nearer than the median random choice in "
        f"{np.mean(ratio < 1):.0%}, and more than 1.5 times as far in {np.mean(~(ratio <= 1.5)):.0%} "
        f"(geometric mean of the ratio {np.exp(np.mean(np.log(finite))):.2f})."
    )
    header = ["set", "model", "views", "splits", "guided, px", "random, px"]
    document.replace("real views", f"{document.table(header, rows)}\n\n{summary}")


if __name__ == "__main__":
    main()
