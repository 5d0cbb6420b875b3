"""Counts of what passes by while a dump is written."""

from __future__ import annotations

from calibdb.camera_key import current_key
from calibdb.dump.public_copy import Alias
from calibdb.schema import CalibrationDocument, VoteDocument
from calibdb.schema.dump import DumpCounts, Tally

_DIGITS = 12  # of a digest that is counted: 48 bits, which two of a million share with a chance of 0.2 %


class Counting:
    """Tally that continues another."""

    def __init__(self, begun: Tally, alias: Alias) -> None:
        self._alias = alias
        self._calibrations = begun.calibrations
        self._given, self._votes = begun.given.calibrations, begun.given.votes
        self._contributors, self._cameras = set(begun.contributors), set(begun.cameras)
        self._givers, self._given_cameras = set(begun.givers), set(begun.given_cameras)

    def add(self, document: CalibrationDocument | VoteDocument, *, given: bool) -> None:
        """Count a document; `given`: it is in the dump."""
        contributor = self._alias(document.counted_as)[:_DIGITS]
        if given:
            self._givers.add(contributor)
        if isinstance(document, VoteDocument):
            self._votes += given
            return
        key = current_key(document.camera_key, document.camera, document.platform)
        camera = self._alias(key)[:_DIGITS]
        self._calibrations += 1
        self._contributors.add(contributor)
        self._cameras.add(camera)
        if given:
            self._given += 1
            self._given_cameras.add(camera)

    def tally(self) -> Tally:
        """Return the tally as it is now."""
        return Tally(
            calibrations=self._calibrations,
            contributors=frozenset(self._contributors),
            cameras=frozenset(self._cameras),
            given=DumpCounts(calibrations=self._given, votes=self._votes),
            givers=frozenset(self._givers),
            given_cameras=frozenset(self._given_cameras),
        )
