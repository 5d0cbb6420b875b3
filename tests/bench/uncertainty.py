"""`make bench DOCS=uncertainty`: predicted errors against those that happen; `ONLY=noise,hands`."""

from dataclasses import replace

import numpy as np

from calibsolver import models
from calibsolver.quality.systematic import probable_cause
from infra.console import track
from tests.bench import document
from tests.bench.corners import try_fit
from tests.bench.honesty import predicted, white
from tests.helpers.solver import hands, populations, synthetic

CAPTURES = 200
BENT, MOTION = "board_bent", "motion"
HANDS: dict[str, tuple[hands.Hand, set[str | None]]] = {
    "steady, nothing to name": (hands.STEADY, {None}),
    "bent": (hands.BENT, {BENT}),
    "moving": (hands.MOVING, {MOTION}),
    "both": (hands.MOVING_AND_BENT, {BENT, MOTION}),
    "bent by 0.1 %": (replace(hands.BENT, sag_boards=0.001), {BENT}),
    "moving at half the speed": (replace(hands.MOVING, speed_cm_s=2.5, turn_deg_s=5.0), {MOTION}),
    "moving at twice the speed": (replace(hands.MOVING, speed_cm_s=10.0, turn_deg_s=20.0), {MOTION}),
}
"""What a hand does, and the causes of systematic residuals that are to be named."""
HANDS_CAPTURES, HANDS_VIEWS = 24, (4, 6, 10, 15)


def main() -> None:
    if document.is_chosen("noise"):
        document.replace("error bars", noise())
    if document.is_chosen("hands"):
        document.replace("error bars in hands", in_hands())


def in_hands() -> str:
    """Error / predicted error in hands that move, with boards that bend, and captures that name the cause."""
    rows = []
    for name, (hand, causes) in HANDS.items():
        ours, plain = [], []
        named: dict[int, list[bool]] = {count: [] for count in HANDS_VIEWS}
        for count in HANDS_VIEWS:
            rng = np.random.default_rng(count)
            for camera in synthetic.rectilinear_cameras(HANDS_CAPTURES, seed=count):
                views = populations.views(camera, rng, 0.2, count, hand)
                found = try_fit(views, camera.img_size, "rectilinear")
                if found is None:
                    continue
                cause = probable_cause(found, views)
                named[count].append((cause.code if cause else None) in causes)
                square = float(np.mean(synthetic.projection_error(camera, found.camera) ** 2))
                ours.append(np.sqrt(square / predicted(found, np.asarray(found.covariance))))
                plain.append(np.sqrt(square / predicted(found, white(found))))
        shares = ", ".join(f"{np.mean(each):.0%}" for each in named.values())
        for covariance, ratios, share in (("calibDB", ours, shares), ("white noise", plain, "")):
            above = f"{np.mean(np.array(ratios) > 2):.0%}"
            rows.append([name, covariance, str(len(ratios)), f"{np.median(ratios):.2f}", above, share])
    views_of = ", ".join(map(str, HANDS_VIEWS))
    header = ["hand", "covariance", "captures", "error / predicted, median", "above 2"]
    return document.table([*header, f"cause named, of {views_of} views"], rows)


def noise() -> str:
    """Ratios and coverage under white noise."""
    rows = []
    for model in track(models.NAMES, "models", len(models.NAMES)):
        for views in (5, 8):
            found = populations.measure(model, CAPTURES, views)
            cover = dict(
                zip(("fx", "fy", "cx", "cy", *models.get(model).coefficients), found.coverage, strict=True)
            )
            low, high = min(cover, key=cover.__getitem__), max(cover, key=cover.__getitem__)
            rows.append(
                [
                    model,
                    str(views),
                    f"{found.projection:.2f}",
                    f"{np.quantile(found.ratio, 0.95):.2f}",
                    f"{np.mean(found.coverage):.1%}",
                    f"{cover[low]:.1%} ({low}) to {cover[high]:.1%} ({high})",
                    str(found.out_of_domain),
                    str(found.failed),
                ]
            )
    header = ["model", "views", "actual / predicted projection error, rms", "95th percentile"]
    header += ["coverage of 95 % intervals", "by parameter", "out-of-domain corner", "failed"]
    return document.table(header, rows)


if __name__ == "__main__":
    main()
