"""Facts about action cameras and recorded video of phones, from the community's lens profiles (CC0).

`python -m infra.web_build.lens_facts lens_profiles.csv` replaces the rows of this source in the table
of facts (`calibdb.estimate.facts`). A row is the median over contributors for one model, mode and aspect.
"""

import csv
import math
import statistics
import sys
from collections import defaultdict
from collections.abc import Iterable, Sequence
from pathlib import Path

from calibdb.camera_key.names import words
from calibdb.estimate.facts import FACT_COLUMNS, TABLE

Row = dict[str, str]
Key = tuple[str, str, str, str, str]  # kind, maker, model, mode, aspect
TITLE, URL, LICENCE = "Gyroflow lens profiles", "https://github.com/gyroflow/lens_profiles", "CC0-1.0"
_ACTION = {
    *("aee", "akaso", "caddx", "crosstour", "dji", "eken", "firefly", "foxeer", "garmin", "gopro"),
    *("insta360", "runcam", "sargo"),
}
_PHONES = {"apple", "google", "honor", "huawei", "lg", "motorola", "oneplus", "oppo", "samsung", "xiaomi"}
# Makers of cameras with interchangeable lenses: no model says anything of a field of view, the kind does.
_PHOTO = {
    *("blackmagic", "canon", "fujifilm", "nikon", "olympus", "panasonic", "pentax", "red", "sigma", "sony")
}
_MODES = ("superview", "super", "linear", "narrow", "medium", "wide")
_MAX_RMS = 3.0  # px; profiles above it do not measure a lens
_MAX_SINGLE_RMS = 1.5  # px; of a mode with one contributor
_MAX_ANGLE, _STEP = 1.5, 0.002  # rad off the axis, up to which an edge is looked for
_MAX_STATED = 2.9  # rad: edges beyond are extrapolated by the polynomial
# Relative deviation of one contributor's profile, of a named mode and of an unnamed one; and its weight
_NAMED_SIGMA, _DEFAULT_SIGMA, _DEFAULT_COUNT = 0.08, 0.10, 4
MIN_CONTRIBUTORS, MIN_PHOTO_CONTRIBUTORS = 2, 4


def usable(rows: Iterable[Row]) -> list[tuple[Row, float]]:
    """Select the profiles that can be read; each with its horizontal field, rad."""
    selected = []
    for row in rows:
        if row["brand"].casefold() not in _ACTION | _PHONES | _PHOTO or float(row["rms"]) > _MAX_RMS:
            continue
        angle = _edge_angle(row)
        if angle is not None and 2 * angle < _MAX_STATED and float(row["w"]) > float(row["h"]):
            selected.append((row, 2 * angle))
    return selected


def identity(row: Row) -> Key:
    """Kind, maker, model, mode and aspect of a profile."""
    brand = row["brand"].casefold()
    text = f"{row['lens']} {row['setting']}".casefold()
    kind = "phone_video" if brand in _PHONES else "photo_camera" if brand in _PHOTO else "action"
    mode = next((name for name in _MODES if name in text), "") if kind == "action" else ""
    aspect = "4,3" if float(row["w"]) / float(row["h"]) < 1.56 else "16,9"
    maker = {"gopro": "GoPro", "runcam": "RunCam", "dji": "DJI", "lg": "LG"}.get(brand, brand.title())
    model = " ".join(words(row["model"].casefold()))
    return kind, maker, model, mode, aspect


def facts(profiles: Sequence[tuple[Row, float]]) -> list[Row]:
    """Summarise profiles as rows of the table, one for each model, mode and aspect."""
    groups: dict[Key, dict[str, list[tuple[Row, float]]]] = defaultdict(lambda: defaultdict(list))
    for profile in profiles:
        groups[identity(profile[0])][profile[0]["contributor"]].append(profile)
    contributors: dict[tuple[str, str], set[str]] = defaultdict(set)
    for (_, maker, model, _, _), group in groups.items():
        contributors[maker, model] |= group.keys()
    return [
        _summary(key, [statistics.median(angle for _, angle in own) for own in group.values()], group)
        for key, group in sorted(groups.items())
        if _is_enough(key, group, len(contributors[key[1:3]]))
    ]


def _is_enough(key: Key, group: dict[str, list[tuple[Row, float]]], contributors: int) -> bool:
    """True if a group has contributors enough; one does for a named mode of a model that has several."""
    kind, _, _, mode, _ = key
    if mode and len(group) == 1:
        return (
            contributors >= MIN_CONTRIBUTORS
            and min(float(row["rms"]) for own in group.values() for row, _ in own) < _MAX_SINGLE_RMS
        )
    return len(group) >= (MIN_PHOTO_CONTRIBUTORS if kind == "photo_camera" else MIN_CONTRIBUTORS)


def _summary(key: Key, angles: list[float], group: dict[str, list[tuple[Row, float]]]) -> Row:
    kind, maker, model, mode, aspect = key
    value = statistics.median(angles)
    n = len(angles)
    # Few say little of their spread: they are pulled towards that of all.
    spread = statistics.fmean((angle - value) ** 2 for angle in angles)
    usual = value * (_NAMED_SIGMA if mode else _DEFAULT_SIGMA)
    variance = (n * spread + _DEFAULT_COUNT * usual**2) / (n + _DEFAULT_COUNT)
    sigma = math.sqrt(variance * (1 + 1 / n))
    profiles = [row for own in group.values() for row, _ in own]
    lens = [statistics.median(float(row[name] or 0) for row in profiles) for name in ("k1", "k2", "k3", "k4")]
    width, height = aspect.split(",")
    label = model if kind == "phone_video" or model.startswith("hero") else f"{maker.casefold()} {model}"
    if kind == "photo_camera":
        label = ""
    return {
        "kind": kind,
        "maker": maker,
        "model": model,
        "words": label,
        "usb": "",
        "devices": "",
        "camera": "wide" if kind == "phone_video" else "",
        "mode": mode,
        "width": width,
        "height": height,
        "quantity": "hfov",
        "value": f"{math.degrees(value):.1f}",
        "sigma": f"{math.degrees(sigma):.1f}",
        "n": str(n),
        "what": "calibration",
        "distortion": " ".join(["fisheye", *(f"{k:.4g}" for k in lens)]) if kind == "action" else "",
        "title": TITLE,
        "url": URL,
        "licence": LICENCE,
    }


def _edge_angle(row: Row) -> float | None:
    """Angle off the axis at half the width, rad; None if the polynomial does not reach it."""
    target = float(row["w"]) / 2 / float(row["fx"])
    k = [float(row[name] or 0) for name in ("k1", "k2", "k3", "k4")]
    theta = before = 0.0
    while theta < _MAX_ANGLE:
        theta += _STEP
        square = theta * theta
        radius = theta * (1 + square * (k[0] + square * (k[1] + square * (k[2] + square * k[3]))))
        if radius >= target:
            return theta
        if radius < before:
            return None
        before = radius
    return None


def main(profiles: Path) -> None:
    """Replace the rows of the lens profiles in the table."""
    with profiles.open(newline="", encoding="utf-8") as file:
        rows = facts(usable(csv.DictReader(file)))
    with TABLE.open(newline="", encoding="utf-8") as file:
        others = [row for row in csv.DictReader(file) if row["title"] != TITLE]
    with TABLE.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, FACT_COLUMNS, restval="", lineterminator="\n")
        writer.writeheader()
        writer.writerows([*others, *rows])


if __name__ == "__main__":
    main(Path(sys.argv[1]))
