"""`make bench DOCS=real-contributors`: consensus of five contributors of one real camera, and of a sixth.

Each real set of at least 25 views is split at random into five contributors of four to eight views; the views
that are left give the reference. The sixth contributor brings four views of another mode, lens or phone,
scaled to the size of the others. Errors are px rms at 1280 px width over the image.

SEEDS=6 splits of each set; VIEWS=4 of the sixth; ONLY=yubin,uk.
"""

import os
from collections.abc import Iterator, Sequence

import numpy as np

from calibsolver import CalibrationError, View, fit
from calibsolver.consensus import Consensus, Member, Rule, pool
from infra.console import track
from tests.bench import document
from tests.bench.capture import Footage, footage
from tests.bench.real_views import distance

CONTRIBUTORS, MIN_VIEWS = 5, 25
EACH = (4, 8)
"""Views of a contributor: at least as many as a calibration has, 15 % of the set, and at most."""
RULE = Rule(min_contributors=3)
SIXTH_VIEWS = int(os.environ.get("VIEWS", "4"))
SIXTHS = (
    ("pv_picam_320", "pv_picam_640", "mode"),
    ("pv_picam_640", "pv_picam_320", "mode"),
    ("pv_picam_640", "pv_picam_960", "mode"),
    ("pv_picam_960", "pv_picam_640", "mode"),
    ("jy_left", "babel_ov_plane", "lens"),
    ("babel_ov_plane", "jy_left", "lens"),
    ("pv_picam_640", "pv_charuco_480", "lens"),
    ("pv_picam_640", "opencv_left", "lens"),
    ("pv_picam_1920", "pv_charuco_1280", "lens"),
    ("yubin", "uk", "phone"),
    ("uk", "yubin", "phone"),
)
"""The set of five contributors, that of the sixth, and what differs."""


def split(source: Footage, seed: int) -> tuple[list[Member], list[View]]:
    """Five contributors of a set, and the views that are left."""
    order = np.random.default_rng(seed).permutation(len(source.views))
    count = int(np.clip(len(order) * 3 // 20, *EACH))
    parts = np.split(order[: CONTRIBUTORS * count], CONTRIBUTORS)
    members = [Member(str(n), str(n), tuple(source.views[i] for i in part)) for n, part in enumerate(parts)]
    return members, [source.views[i] for i in order[CONTRIBUTORS * count :]]


def resized(views: Sequence[View], size: tuple[int, int], to: tuple[int, int]) -> list[View]:
    scale = np.array(to) / size
    return [View(view.object_points, (view.image_points + 0.5) * scale - 0.5) for view in views]


def sixth(source: Footage, size: tuple[int, int], seed: int) -> Member:
    """Contributor of another camera, whose pictures are resized."""
    drawn = np.random.default_rng(1000 + seed).permutation(len(source.views))[:SIXTH_VIEWS]
    views = resized([source.views[i] for i in drawn], source.img_size, size)
    return Member("sixth", "sixth", tuple(views))


def difference(source: Footage, other: Footage) -> list[str]:
    """Distance between the fits of all views of two cameras, and the error that both state together."""
    size, scale = source.img_size, 1280 / source.img_size[0]
    try:
        one = fit(source.views, size, source.model)
        two = fit(resized(other.views, other.img_size, size), size, source.model)
    except CalibrationError:
        return ["", ""]
    stated = np.hypot(one.uncertainty().rms, two.uncertainty().rms)
    return [f"{scale * distance(one.camera, two.camera):.1f}", f"{scale * stated:.1f}"]


def errors(source: Footage, found: Consensus, held_out: Sequence[View]) -> tuple[float, float, float]:
    """Stated error, distance from the reference, and the error that both state together."""
    reference = fit(held_out, source.img_size, source.model)
    stated, other = (c.uncertainty().rms for c in (found.calibration, reference))
    actual = distance(reference.camera, found.calibration.camera)
    scale = 1280 / source.img_size[0]
    return scale * stated, scale * actual, scale * float(np.hypot(stated, other))


def agreement(sources: Sequence[Footage], seeds: int) -> Iterator[list[str]]:
    """Rows of sets whose five contributors are pooled, and of all."""
    total = np.zeros(4, dtype=int)
    for source in sources:
        together, measured = 0, []
        for seed in track(range(seeds), source.name, seeds):
            members, held_out = split(source, seed)
            found = pool(members, source.img_size, source.model, RULE)
            together += len(found.members) == CONTRIBUTORS
            try:
                measured.append(errors(source, found, held_out))
            except CalibrationError:
                continue
        stated, actual, both = np.array(measured).T
        counts = [together, int((actual <= 2 * stated).sum()), int((actual <= 2 * both).sum()), len(measured)]
        total += counts
        yield [
            source.name,
            str(len(source.views)),
            f"{together} of {seeds}",
            f"{np.median(stated):.1f}",
            f"{np.median(actual):.1f}",
            f"{counts[1]} of {len(measured)}",
            f"{counts[2]} of {len(measured)}",
        ]
    splits = seeds * len(sources)
    yield ["all", "", f"{total[0]} of {splits}", "", "", *(f"{n} of {total[3]}" for n in total[1:3])]


def kept_out(sources: dict[str, Footage], seeds: int) -> Iterator[list[str]]:
    """Rows of sets with a sixth contributor."""
    for name, other, what in SIXTHS:
        if name not in sources or other not in sources:
            continue
        source, outside, together = sources[name], 0, 0
        for seed in track(range(seeds), f"{name}, {other}", seeds):
            members, _ = split(source, seed)
            stranger = sixth(sources[other], source.img_size, seed)
            found = pool([*members, stranger], source.img_size, source.model, RULE)
            outside += "sixth" not in found.members
            together += set(found.members) >= {member.id for member in members}
        away = difference(source, sources[other])
        yield [name, other, what, *away, f"{outside} of {seeds}", f"{together} of {seeds}"]


def main() -> None:
    seeds = int(os.environ.get("SEEDS", "6"))
    sources = {source.name: source for source in footage()}
    large = [source for source in sources.values() if len(source.views) >= MIN_VIEWS]
    header = ["set", "views", "all agree", "stated, px", "actual, px", "within twice it", "within twice both"]
    together = document.table(header, list(agreement(large, seeds)))
    header = ["five contributors", "the sixth", "another", "apart, px", "stated, px"]
    header += ["sixth kept out", "the five agree"]
    apart = document.table(header, list(kept_out(sources, seeds)))
    document.replace("real contributors", f"{together}\n\n{apart}")


if __name__ == "__main__":
    main()
