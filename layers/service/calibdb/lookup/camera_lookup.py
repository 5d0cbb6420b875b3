"""Lookup of a camera's key: by USB id and name; by the name alone where it says which product it is.

Never a guess: a name that many products bear answers nobody, and one that two USB ids bear neither. Since
anybody can invent an id, only those that are well known (`calibdb.lookup.well_known_ids`) rival each other.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from calibdb.camera_key import Identity
from calibdb.lookup.selection import Choice, choose
from calibdb.schema import ConsensusDocument
from calibdb.store import Known

CROPPED = "crop-and-scale"

VIRTUAL = "This is a program that poses as a camera: it has no lens of its own."
AMBIGUOUS = (
    "Many cameras go by this name: without a USB id or a device's model it cannot be told which it is."
)
SEVERAL = (
    "Several cameras bear this name: which it is, the USB id decides, which Chromium tells, or a calibration."
)
RESIZED = "The browser crops this stream; ask for it with resizeMode: none."


@dataclass(frozen=True)
class CameraMatch:
    """The key under which something was found or is missing, all that is known there, and what answers."""

    key: str
    known: Sequence[ConsensusDocument]
    choice: Choice
    several: bool = False  # the name is that of more than one camera

    @property
    def has_answer(self) -> bool:
        """True if there is an answer, or will be once it is computed."""
        return self.choice.found is not None or self.choice.missing_at is not None


def unanswerable_reason(identity: Identity, *, private: bool, resize_mode: str | None) -> str | None:
    """Return why nothing can be said of such a camera; None where the database may know it.

    `private`: the database of one person, who has few cameras, and knows which is meant.
    """
    if identity.virtual:
        return VIRTUAL
    if resize_mode == CROPPED:
        return RESIZED
    return AMBIGUOUS if identity.ambiguous and not private else None


def resolve(
    read: Callable[[str], Known],
    identity: Identity,
    img_size: tuple[int, int],
    zoom: float,
    model: str,
    *,
    private: bool,
) -> CameraMatch:
    """Return what is known of a camera.

    `read` is asked once where the camera is known under its own key, and no well known one beside it; never
    more than twice.
    """

    def at(key: str, known: Known) -> CameraMatch:
        return CameraMatch(key, known.consensuses, choose(known.consensuses, img_size, zoom, model))

    known = read(identity.key)
    own = at(identity.key, known)
    alone = identity.usb_id is None and identity.distinct and not private
    if own.has_answer and alone and len(known.well_known) == 1:
        # Few could say anything under the name alone of what many know under the id that it means.
        other = at(known.well_known[0], read(known.well_known[0]))
        return other if _outnumbers(other.choice.found, own.choice.found) else own
    if own.has_answer or not (identity.distinct or private):
        return own
    if identity.usb_id is None:
        # Calibrations that disagree under the name alone say that it is a name of several cameras.
        candidates = known.same_as if private else known.candidates
        if len(candidates) > 1:
            return replace(own, several=True)
        if not candidates or own.choice.reason == "disagree":
            return own
        other = at(candidates[0], read(candidates[0]))
    else:
        if known.consensuses:
            return own
        named = read(identity.name_key)
        if any(key != identity.key for key in (named.same_as if private else named.well_known)):
            return own
        other = at(identity.name_key, named)
    return other if other.has_answer or own.choice.reason == "unknown_camera" else own


def _outnumbers(other: ConsensusDocument | None, own: ConsensusDocument | None) -> bool:
    """Tell whether more contributors are behind `other`, of the same size."""
    if other is None or own is None or other.calibration is None or own.calibration is None:
        return False
    more = other.calibration.contributors > own.calibration.contributors
    return more and other.img_size == own.img_size
