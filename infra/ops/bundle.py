"""A bundle of the whole database, with every label under which its cameras were calibrated."""

from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path

from calibdb.camera_key import current_key
from calibdb.dump.bundle import Name, Source, build_bundle, names_of
from infra.console import track
from infra.ops.context import OpsContext


@dataclass(frozen=True)
class BundleResult:
    """Counts and sizes of the written file."""

    cameras: dict[str, int]  # bytes of each, by its label
    calibrations: int
    labels: int
    size: int  # bytes
    compressed: int


def bundle(context: OpsContext, path: Path, max_cameras: int) -> BundleResult:
    """Write the cameras with the most contributors to a file; the same for the same database."""
    source = Source(
        read=context.store.cameras.known,
        licence=context.store.calibrations.licence,
        private=context.settings.thresholds.min_contributors == 1,
        created=context.now,
        track=track,
    )
    names_by_camera: defaultdict[str, set[Name]] = defaultdict(set)
    for document, withdrawn in context.every_calibration():
        if not withdrawn:
            key = current_key(document.camera_key, document.camera, document.platform)
            names_by_camera[key] |= names_of(document.camera, document.platform)
    made = build_bundle(source, names_by_camera, max_cameras)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(made.content)
    return BundleResult(made.cameras, made.calibrations, made.labels, len(made.content), made.compressed)
