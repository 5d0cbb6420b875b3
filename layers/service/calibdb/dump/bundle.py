"""The reliable calibrations of popular cameras, as one file for lookups without a network.

Its reader only compares labels. The rules of a lookup decide here which camera each label means.
"""

import functools
import gzip
import json
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from calibdb.camera_key import public_label
from calibdb.camera_key.system import system_of
from calibdb.lookup.camera_match import choose, resolve, unanswerable_reason
from calibdb.lookup.transfer import build_answer
from calibdb.schema import ConsensusDocument
from calibdb.schema.fields import ImgSize, StreamKey
from calibdb.store import CameraRecords

#: one platform of each system to which cameras can be attached
DESKTOP_PLATFORMS = {
    "linux": "X11; Linux x86_64",
    "windows": "Windows NT 10.0; Win64; x64",
    "macos": "Macintosh; Intel Mac OS X 10_15_7",
    "chromeos": "X11; CrOS x86_64 14541.0.0",
}
#: sizes that applications use; the answers for them are precomputed
COMMON_SIZES: tuple[ImgSize, ...] = (
    *((320, 180), (320, 240), (480, 270), (640, 360), (640, 480), (800, 450), (800, 600), (854, 480)),
    *((960, 540), (960, 720), (1024, 576), (1024, 768), (1280, 720), (1280, 960), (1600, 900)),
    *((1600, 1200), (1920, 1080), (2560, 1440), (3840, 2160)),
)
COLUMNS = (
    *("img_size", "zoom", "distortion_model", "intrinsics", "distortion_coefficients"),
    *("avg_reprojection_error", "uncertainty", "spread", "held_out_error", "systematic"),
    *("calibrations", "contributors", "basis", "calibration_time", "id", "relation", "at"),
)
Name = tuple[str, str]
"""Label and platform."""
_SIGNIFICANT_DIGITS = 9  # a thousandth of a pixel is the seventh


@dataclass(frozen=True)
class Bundle:
    """Content of a bundle, and its counts and sizes."""

    content: bytes
    cameras: dict[str, int]  # bytes of each, by its label
    calibrations: int
    labels: int

    @property
    def compressed(self) -> int:
        """Bytes that a web server sends."""
        return len(gzip.compress(self.content))


@dataclass(frozen=True)
class Source:
    """Database that a bundle is made of."""

    read: Callable[[str], CameraRecords]  # under a camera key
    licence: Callable[[str], str | None]  # of every calibration of a camera; None if one has none
    private: bool  # the database of one person with few cameras
    created: int  # unix seconds
    track: Callable[..., Iterable[Any]] = lambda items, *_: items  # shows the progress of a loop


def build_bundle(source: Source, names: Mapping[str, set[Name]], max_cameras: int) -> Bundle:
    """Build a bundle of the cameras with the most contributors; `names`: labels and platforms by key."""
    read = functools.cache(source.read)
    reliable = {
        key: [c for c in read(key).consensuses if c.reliable]
        for key in source.track(names, "consensuses", len(names))
    }
    popular = sorted(
        (key for key, members in reliable.items() if members), key=lambda k: (rank(reliable[k]), k)
    )
    chosen = popular[:max_cameras]
    labels: dict[str, int] = {}
    places: defaultdict[str, dict[str, int]] = defaultdict(dict)
    meant = _meanings(source, read, {key: (names[key], reliable[key]) for key in chosen})
    for label, by_place in sorted(meant.items()):
        everywhere = {by_place.get(place) for place in DESKTOP_PLATFORMS}
        if len(everywhere) == 1 and (key := everywhere.pop()):
            labels[label] = chosen.index(key)
        for place, key in sorted(by_place.items()):
            if label not in labels or place not in DESKTOP_PLATFORMS:
                places[place][label] = chosen.index(key)
    cameras = [_camera(read(key).consensuses, source.licence(key)) for key in chosen]
    document = {"format": "calibdb-bundle", "version": 1, "created": source.created, "columns": COLUMNS}
    return Bundle(
        content=_json({**document, "cameras": cameras, "labels": labels, "places": places}),
        cameras={f"{c['camera']} ({key})": len(_json(c)) for key, c in zip(chosen, cameras, strict=True)},
        calibrations=sum(len(c["rows"]) for c in cameras),
        labels=len(labels.keys() | {label for members in places.values() for label in members}),
    )


def names_of(label: str, platform: str) -> set[Name]:
    """Public label with and without its USB id."""
    public = public_label(label)
    return {(public, platform), (public.rpartition(" (")[0] or public, platform)}


def _meanings(
    source: Source,
    read: Callable[[str], CameraRecords],
    cameras: dict[str, tuple[set[Name], list[ConsensusDocument]]],
) -> dict[str, dict[str, str]]:
    """Map label and platform to the camera that a lookup finds, if it finds one."""
    private = source.private
    meant: defaultdict[str, defaultdict[str, set[str]]] = defaultdict(lambda: defaultdict(set))

    def found(label: str, platform: str, c: ConsensusDocument) -> str | None:
        # Documents of earlier versions may have labels that no request may have any more.
        query = StreamKey.model_construct(
            camera=label,
            platform=platform,
            img_size=c.img_size,
            zoom=c.zoom,
            distortion_model=c.distortion_model,
        )
        if unanswerable_reason(query, private=private):
            return None
        resolved = resolve(read, query, private=private)
        return resolved.key if resolved.choice.found else None

    for key, (names, reliable) in source.track(cameras.items(), "cameras", len(cameras)):
        for label, own in names:
            system = system_of(own)
            here = {system.text: own} if system.is_one_device else {}
            for place, platform in (DESKTOP_PLATFORMS | here).items():
                if all(found(label, platform, c) == key for c in reliable):
                    meant[label][place].add(key)
    return {
        label: {place: keys.pop() for place, keys in places.items() if len(keys) == 1}
        for label, places in meant.items()
    }


def _rows(consensuses: Sequence[ConsensusDocument]) -> Iterator[list[Any]]:
    for c in consensuses:
        if not c.reliable or c.calibration is None:
            continue
        exact = build_answer(c.calibration, consensuses, c.img_size)
        at = {}
        for size in sorted({*COMMON_SIZES, *(other.img_size for other in consensuses)}):
            if choose(consensuses, size, c.zoom, c.distortion_model).found is not c or size == c.img_size:
                continue
            answer = build_answer(c.calibration, consensuses, size)
            carried = _intrinsics(answer.adapted.camera_matrix) if answer.adapted else []
            if carried or answer.relation != exact.relation:
                at[f"{size[0]}x{size[1]}"] = [answer.relation, *carried]
        u = c.calibration.uncertainty
        values = {
            **dict(c.calibration),
            "intrinsics": _intrinsics(c.calibration.camera_matrix),
            "distortion_coefficients": _round_significant(c.calibration.distortion_coefficients),
            "uncertainty": _round_significant((u.rms, u.max, u.inside, u.covered)),
            "relation": exact.relation,
            "at": at,
        }
        yield [values[column] for column in COLUMNS]


def _camera(consensuses: Sequence[ConsensusDocument], licence: str | None) -> dict[str, Any]:
    reliable = (c.calibration for c in consensuses if c.reliable and c.calibration)
    newest = max(reliable, key=lambda c: c.calibration_time)
    camera = {"camera": newest.camera, "platform": newest.platform}
    if licence:
        camera["licence"] = licence
    return {**camera, "rows": list(_rows(consensuses))}


def _json(value: object) -> bytes:
    return json.dumps(value, ensure_ascii=False, separators=(",", ":")).encode()


def _intrinsics(matrix: Sequence[Sequence[float]]) -> list[float | None]:
    (fx, _, cx), (_, fy, cy), _ = matrix
    return _round_significant((fx, fy, cx, cy))


def _round_significant(values: Sequence[float | None]) -> list[float | None]:
    return [None if value is None else float(f"{value:.{_SIGNIFICANT_DIGITS}g}") for value in values]


def rank(reliable: Sequence[ConsensusDocument]) -> tuple[int, int]:
    """Rank a camera by its reliable consensuses: the smallest has the most contributors."""
    return min((-c.calibration.contributors, -c.total) for c in reliable if c.calibration)
