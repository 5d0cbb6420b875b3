"""Rigs: running ones under optimistic concurrency (`Versions`), what was computed of them, and finished ones.

`rigs/<id>/<version>.json` is a running rig, `rigs/<id>/state/<digest>.json` fit and target that follow from
the views of that digest, `rig_calibrations/<id>.json` a finished rig. `RIGCODE#<keyed hash of the join code>`
names the rig until the code expires. `GUESS#<source>/WINDOW#<number>` counts guesses: each before it is
checked, so that many at once cannot exceed the limit.
"""

import re
from collections.abc import Iterator, Mapping

from calibdb.schema import RigCalibrationDocument, RigDocument, RigEstimateDocument
from calibdb.store.ports import ItemStore, Value, encoded, read, read_all
from calibdb.store.versions import Versions

RIG_CALIBRATIONS_PREFIX = "rig_calibrations/"
GUESS_WINDOW_S = 900
MAX_GUESSES = 10  # wrong codes of one source in a window
_SK = "META"
_COUNTER = "guesses"
_RIG_ID = re.compile(r"[0-9a-f]{32}")


class Rigs(Versions[RigDocument]):
    """Rigs under their ids."""

    model = RigDocument
    prefix = "rigs/"
    partition = "RIG#"
    noun = "rig"
    missing = "There is no rig with this id."
    missing_kind = "no-rig"

    def facts(self, document: RigDocument) -> Mapping[str, Value]:
        """Sessions by position, so that polling reads no object."""
        return {"sessions": [member.session if member else "" for member in document.members]}

    def forget(self, name: str, now: int) -> bool:
        """Forget a running rig and what was computed of it; False if there was nothing to forget."""
        there = super().forget(name, now)
        self._objects.delete(list(self._objects.names(_states(name))))
        return there

    def estimate(self, rig_id: str, digest: str) -> RigEstimateDocument | None:
        """Fit and target computed from the views of this digest, None if there is none yet."""
        return read(self._objects, f"{_states(rig_id)}{digest}.json", RigEstimateDocument)

    def keep_estimate(self, rig_id: str, digest: str, estimate: RigEstimateDocument) -> None:
        """Keep a fit and target; of two computed at once, the first counts."""
        self._objects.create(f"{_states(rig_id)}{digest}.json", encoded(estimate))

    def publish(self, document: RigCalibrationDocument) -> None:
        """Store a finished rig; idempotent."""
        self._objects.create(rig_calibration_object(document.id), encoded(document))

    def calibration(self, rig_id: str) -> RigCalibrationDocument | None:
        """Finished rig, None if there is none of this id."""
        if not is_rig_id(rig_id):
            return None
        return read(self._objects, rig_calibration_object(rig_id), RigCalibrationDocument)

    def calibrations(self) -> Iterator[RigCalibrationDocument]:
        """Yield every finished rig."""
        return read_all(self._objects, RIG_CALIBRATIONS_PREFIX, RigCalibrationDocument)


def is_rig_id(text: str) -> bool:
    """True if a text may be the id of a rig."""
    return _RIG_ID.fullmatch(text) is not None


def rig_calibration_object(rig_id: str) -> str:
    """Object's name of a finished rig."""
    return f"{RIG_CALIBRATIONS_PREFIX}{rig_id}.json"


def _states(rig_id: str) -> str:
    return f"{Rigs.prefix}{rig_id}/state/"


class RigCodes(ItemStore):
    """Join codes by their keyed hashes."""

    def put(self, digest: str, rig_id: str, until: int) -> None:
        """Let a code lead to a rig until a unix time."""
        self._table.put(
            {"pk": _pk(digest), "sk": _SK, "rig": rig_id, "until": until, "ttl": until + GUESS_WINDOW_S}
        )

    def find(self, digest: str, now: int) -> str | None:
        """Rig of a code, None if there is none or the code has expired."""
        item = self._table.get(_pk(digest), _SK)
        return str(item["rig"]) if item and item["until"] > now else None

    def remove(self, digest: str) -> None:
        """Let a code lead nowhere."""
        self._table.delete(_pk(digest), _SK)

    def count_guess(self, source: str, now: int) -> bool:
        """Count a code that may be a guess; False, and nothing counted, if there were too many."""
        number = now // GUESS_WINDOW_S
        ttl = (number + 2) * GUESS_WINDOW_S
        counted = self._table.add(*_guesses(source, number), _COUNTER, 1, limit=MAX_GUESSES, ttl=ttl)
        return counted is not None

    def uncount_guess(self, source: str, now: int) -> None:
        """Take back a guess that was right."""
        self._table.add(*_guesses(source, now // GUESS_WINDOW_S), _COUNTER, -1)


def _pk(digest: str) -> str:
    return f"RIGCODE#{digest}"


def _guesses(source: str, number: int) -> tuple[str, str]:
    return f"GUESS#{source}", f"WINDOW#{number}"
