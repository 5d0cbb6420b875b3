"""Search of cameras by words, and their consensuses by size and zoom."""

import itertools
import unicodedata
from collections.abc import Iterator, Sequence

from calibdb.camera_key import VERSION, identify
from calibdb.camera_key.names import is_maker, words
from calibdb.camera_key.usb_vendors import vendor_of, vendor_words
from calibdb.rules.contributed_name import mode_names
from calibdb.schema import Calibration, ConsensusDocument
from calibdb.schema.cameras import CalibratedMode, CameraEntry, CameraMode, CameraSize, NamedCamera
from calibdb.store import Store, StreamMode

SizeAndZoom = tuple[tuple[int, int], float]
_MAX_QUERY_WORDS = 8
_MAX_MEMBERS = 200
_MIN_LISTED_CONTRIBUTORS = 2
AFTER_PRACTICE = f"{VERSION}-calibdb-virtual-camera-zzzzzzzz-ffffffffffff"  # behind the simulated ones


def query_words(query: str) -> list[str]:
    """Words of a query, the longest first, makers only if there are no others."""
    text = unicodedata.normalize("NFKC", query).casefold()
    terms = list(dict.fromkeys(words(text)))[:_MAX_QUERY_WORDS]
    named = [word for word in terms if not is_maker(word)] or terms
    return sorted(named, key=len, reverse=True)


def has_words(terms: Sequence[str], name: str, consensuses: Sequence[ConsensusDocument]) -> bool:
    """True if every term begins a word of the camera's name, labels or USB vendor."""
    labels = {c.calibration.camera for c in consensuses if c.calibration}
    text = unicodedata.normalize("NFKC", " ".join((name, *labels))).casefold()
    there = [*words(text), *vendor_words(usb_id(consensuses))]
    return all(any(word.startswith(w) for word in there) for w in terms)


def is_listed(consensuses: Sequence[ConsensusDocument], min_contributors: int) -> bool:
    """True if a search shows a camera to callers who do not know its key.

    A label is whatever its sender wrote. So a consensus must be reliable, or of two contributors, or the only
    contributor's of a private database.
    """
    enough = min(_MIN_LISTED_CONTRIBUTORS, min_contributors)
    return (enough == 1 and bool(consensuses)) or any(
        c.reliable or (c.calibration is not None and c.calibration.contributors >= enough)
        for c in consensuses
    )


def group_by_mode(
    consensuses: Sequence[ConsensusDocument],
) -> Iterator[tuple[SizeAndZoom, list[ConsensusDocument]]]:
    """Consensuses of every size and zoom, the largest picture first."""

    def order(c: ConsensusDocument) -> tuple[int, tuple[int, int], float]:
        return -c.img_size[0] * c.img_size[1], c.img_size, c.zoom

    for _, members in itertools.groupby(sorted(consensuses, key=order), key=order):
        here = list(members)
        yield (here[0].img_size, here[0].zoom), here


def best_modes(
    consensuses: Sequence[ConsensusDocument], limit: int
) -> list[tuple[SizeAndZoom, list[ConsensusDocument]]]:
    """At most `limit` groups: the reliable, then the most calibrated."""
    groups = list(group_by_mode(consensuses))
    weights = [(any(c.reliable for c in here), max(c.total for c in here)) for _, here in groups]
    ranked = sorted(range(len(groups)), key=lambda i: weights[i], reverse=True)
    return [groups[i] for i in sorted(ranked[:limit])]


def best_consensus(consensuses: Sequence[ConsensusDocument]) -> ConsensusDocument:
    """Consensus that represents a size: reliable if possible, with most calibrations."""
    return max(consensuses, key=lambda c: (c.reliable, count_agreeing(c)))


def count_agreeing(best: ConsensusDocument) -> int:
    """Number of calibrations in a consensus."""
    return best.calibration.calibrations if best.calibration else 0


def usb_id(consensuses: Sequence[ConsensusDocument]) -> str | None:
    """USB id `vid:pid` in the camera's labels, None if they have none."""
    named = ((c.calibration.camera, c.calibration.platform) for c in consensuses if c.calibration)
    return next((usb for name in named if (usb := identify(*name).usb_id)), None)


def camera_entry(
    key: str, name: str, consensuses: Sequence[ConsensusDocument], min_calibrations: int
) -> CameraEntry:
    """Camera as a search shows it; `name`: its normalised label."""
    sizes = []
    for _, here in group_by_mode(consensuses):
        best = best_consensus(here)
        calibration = best.calibration
        sizes.append(
            CameraSize(
                **dict(_calibrated_mode(here, min_calibrations)),
                models=tuple(c.distortion_model for c in here),
                reliable=best.reliable,
                fx=calibration and calibration.camera_matrix[0][0],
                uncertainty=calibration and calibration.uncertainty.rms,
                calibration_time=calibration and calibration.calibration_time,
            )
        )
    return CameraEntry(**dict(named_camera(key, name, consensuses)), sizes=tuple(sizes))


def named_camera(key: str, name: str, consensuses: Sequence[ConsensusDocument]) -> NamedCamera:
    """Camera by its names; `name`: its normalised label."""
    camera, platform = display_name(name, consensuses)
    own = usb_id(consensuses)
    return NamedCamera(key=key, camera=camera, platform=platform, usb_id=own, vendor=vendor_of(own))


def _calibrated_mode(here: Sequence[ConsensusDocument], min_calibrations: int) -> CalibratedMode:
    best = best_consensus(here)
    return CalibratedMode(
        img_size=best.img_size,
        zoom=best.zoom,
        calibrations=max(c.total for c in here),
        contributors=best.calibration.contributors if best.calibration else 0,
        agreeing=count_agreeing(best),
        required=min_calibrations,
    )


def display_name(name: str, consensuses: Sequence[ConsensusDocument]) -> tuple[str, str]:
    """Label and platform of the newest calibration, else `name`."""
    calibrations: list[Calibration] = [c.calibration for c in consensuses if c.calibration]
    if not calibrations:
        return name, ""
    newest = max(calibrations, key=lambda c: (c.calibration_time, c.camera))
    return newest.camera, newest.platform


def camera_mode(
    store: Store, min_calibrations: int, mode: StreamMode, consensuses: list[ConsensusDocument]
) -> CameraMode:
    """Describe a mode by its consensuses and the calibrations behind them."""
    best = best_consensus(consensuses)
    behind = store.consensuses.groups(best)
    groups = behind.groups if behind else ()
    members, names = store.cameras.members(mode, frozenset(groups[0] if groups else ()), _MAX_MEMBERS)
    return CameraMode(
        **dict(_calibrated_mode(consensuses, min_calibrations)),
        reason=None if best.reliable else best.reason,
        groups=groups,
        group_names=mode_names([[names[one] for one in group if one in names] for group in groups]),
        consensus={c.distortion_model: c.calibration for c in consensuses if c.calibration},
        members=tuple(members),
    )
