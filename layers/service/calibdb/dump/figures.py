"""The database in figures, written with a dump."""

from __future__ import annotations

import hashlib
import heapq
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

from calibdb.camera_key.usb_vendors import vendor_of
from calibdb.dump.bundle import Source, build_bundle, names_of, rank
from calibdb.lookup.camera_search import display_name, is_listed
from calibdb.schema.dump import BundleFile, DumpDraft, Snapshot, Statistics, WantedCamera
from calibdb.store import Calibrations
from calibdb.store.cameras import Cameras
from calibdb.store.dumps import FOLDER, STATISTICS, Dumps
from calibdb.store.miss_counts import USB, MissCounts
from calibdb.store.ports import READERS

BUNDLE = "bundle.json"
MAX_BUNDLED = 500  # cameras
MAX_WANTED = 20  # cameras that are named
MAX_HISTORY = 520  # dumps, ten years of weeks
_PAGE = 200  # cameras read together


@dataclass(frozen=True)
class Figures:
    """Figures of the database, and the bundle.

    `min_contributors`: that must agree on a public value.
    """

    dumps: Dumps
    cameras: Cameras
    miss_counts: MissCounts
    calibrations: Calibrations
    min_contributors: int

    def write(self, draft: DumpDraft) -> Statistics:
        """Write the figures of a dump that is whole, and return them."""
        count, popular = self._count_known()
        tally = draft.tally
        snapshot = Snapshot(
            date=datetime.fromtimestamp(draft.started, UTC).date().isoformat(),
            cameras=len(tally.cameras),
            known=count,
            calibrations=tally.calibrations,
            contributors=len(tally.contributors),
            given=tally.given.calibrations,
        )
        previous = self.dumps.statistics()
        history = [one for one in (previous.history if previous else ()) if one.date != snapshot.date]
        statistics = Statistics(
            created=draft.started,
            history=(*history, snapshot)[-MAX_HISTORY:],
            wanted=tuple(self._most_wanted(draft.started)),
            bundle=self._bundle(popular, draft.started),
        )
        self.dumps.write(STATISTICS, statistics.model_dump_json(indent=1).encode())
        return statistics

    def _count_known(self) -> tuple[int, list[str]]:
        """Count the cameras with a reliable calibration, and choose those with the most contributors."""
        count, after = 0, None
        popular: list[tuple[Any, str]] = []
        with ThreadPoolExecutor(READERS) as readers:
            while True:
                cameras, after = self.cameras.search("", _PAGE, after)
                keys = [key for key, _ in cameras]
                for key, camera in zip(keys, readers.map(self.cameras.known, keys), strict=True):
                    reliable = [c for c in camera.consensuses if c.reliable]
                    if reliable:
                        count += 1
                        popular.append((rank(reliable), key))
                popular = heapq.nsmallest(MAX_BUNDLED, popular)
                if after is None:
                    return count, [key for _, key in popular]

    def _bundle(self, keys: Sequence[str], now: int) -> BundleFile | None:
        """Write the bundle of these cameras, under the names with which they were calibrated."""
        names = {
            key: {name for own in self.calibrations.names(key) for name in names_of(*own)} for key in keys
        }
        if not any(names.values()):
            return None
        source = Source(self.cameras.known, self.calibrations.licence, self.min_contributors == 1, now)
        made = build_bundle(source, names, MAX_BUNDLED)
        self.dumps.write(FOLDER + BUNDLE, made.content)
        digest = hashlib.sha256(made.content).hexdigest()
        return BundleFile(name=BUNDLE, cameras=len(made.cameras), size=len(made.content), sha256=digest)

    def _most_wanted(self, now: int) -> list[WantedCamera]:
        """Name the cameras most asked for that are not known.

        By a label only where two contributors calibrated it: a label is whatever its sender wrote.
        """
        result: list[WantedCamera] = []
        for camera, count in self.miss_counts.most(now):
            if len(result) == MAX_WANTED:
                break
            usb_id = camera.removeprefix(USB) if camera.startswith(USB) else None
            entry = self._unknown_product(usb_id) if usb_id else self._unknown_camera(camera)
            if entry is not None:
                result.append(entry.model_copy(update={"asked": count}))
        return result

    def _unknown_camera(self, key: str) -> WantedCamera | None:
        """Name a camera by what most contributors call it; None if it is known by now, or has no name."""
        consensuses = self.cameras.known(key).consensuses
        if any(c.reliable for c in consensuses) or not is_listed(consensuses, max(2, self.min_contributors)):
            return None
        name = display_name("", consensuses)[0]
        total = max((c.total for c in consensuses), default=0)
        return WantedCamera(key=key, camera=name, asked=0, calibrations=total)

    def _unknown_product(self, usb_id: str) -> WantedCamera | None:
        """Name a USB id by its vendor; None if there is none, or calibrations of a camera with this id."""
        vendor = vendor_of(usb_id)
        cameras, _ = self.cameras.search(usb_id.rpartition(":")[2], _PAGE, None)
        for key, _ in cameras:
            consensuses = self.cameras.known(key).consensuses
            if any(c.calibration and usb_id in c.calibration.camera for c in consensuses):
                return None  # it is counted under its key, too
        if vendor is None:
            return None
        return WantedCamera(key=None, camera=f"{vendor} ({usb_id})", asked=0, calibrations=0)
