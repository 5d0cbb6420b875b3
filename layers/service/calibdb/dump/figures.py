"""Statistics of the database, written with a dump."""

import hashlib
import heapq
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

from calibdb.camera_key.usb_vendors import vendor_of
from calibdb.dump.bundle import Name, Source, build_bundle, names_of, rank
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
    """Figures of the database, and the bundle."""

    dumps: Dumps
    cameras: Cameras
    miss_counts: MissCounts
    calibrations: Calibrations
    min_contributors: int  # that must agree on a public value

    def write(self, draft: DumpDraft) -> None:
        """Write the figures of a complete dump."""
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

    def _count_known(self) -> tuple[int, list[str]]:
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
        names: dict[str, set[Name]] = {key: set() for key in keys}
        for key in keys:
            for label, platform in self.calibrations.names(key):
                names[key] |= names_of(label, platform)
        if not any(names.values()):
            return None
        source = Source(self.cameras.known, self.calibrations.licence, self.min_contributors == 1, now)
        made = build_bundle(source, names, MAX_BUNDLED)
        self.dumps.write(FOLDER + BUNDLE, made.content)
        digest = hashlib.sha256(made.content).hexdigest()
        return BundleFile(name=BUNDLE, cameras=len(made.cameras), size=len(made.content), sha256=digest)

    def _most_wanted(self, now: int) -> list[WantedCamera]:
        """List the most requested unknown cameras; labels only if two contributors calibrated the camera."""
        result: list[WantedCamera] = []
        for camera, count in self.miss_counts.most(now):
            if len(result) == MAX_WANTED:
                break
            usb_id = camera.removeprefix(USB) if camera.startswith(USB) else None
            entry = self._unknown_product(usb_id, count) if usb_id else self._unknown_camera(camera, count)
            if entry is not None:
                result.append(entry)
        return result

    def _unknown_camera(self, key: str, asked: int) -> WantedCamera | None:
        """Name a camera as most contributors do; None if it is known by now, or has no public name."""
        consensuses = self.cameras.known(key).consensuses
        if any(c.reliable for c in consensuses) or not is_listed(consensuses, max(2, self.min_contributors)):
            return None
        name = display_name("", consensuses)[0]
        total = max((c.total for c in consensuses), default=0)
        return WantedCamera(key=key, camera=name, asked=asked, calibrations=total)

    def _unknown_product(self, usb_id: str, asked: int) -> WantedCamera | None:
        """Name a USB id by its vendor; None if that is unknown, or a camera with this id is calibrated."""
        vendor = vendor_of(usb_id)
        if vendor is None:
            return None
        cameras, _ = self.cameras.search(usb_id.rpartition(":")[2], _PAGE, None)
        for key, _ in cameras:
            consensuses = self.cameras.known(key).consensuses
            if any(c.calibration and usb_id in c.calibration.camera for c in consensuses):
                return None  # it is counted under its key
        return WantedCamera(key=None, camera=f"{vendor} ({usb_id})", asked=asked, calibrations=0)
