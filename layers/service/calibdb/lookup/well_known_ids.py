"""Well-known USB ids, which identify the camera of a name.

Anyone can invent a USB id. So an id counts under its name only once it has a reliable consensus, or one of as
many contributors as a reliable one needs.
"""

from calibdb.camera_key import identify
from calibdb.settings import Thresholds
from calibdb.store import Store
from calibdb.store.cameras import IdSupport

_MAX_ROUNDS = 5


def refresh_well_known(store: Store, camera_key: str, thresholds: Thresholds) -> None:
    """Mark the camera as well known under its name, or not.

    Of concurrent computations the one that has seen less may write last. So each looks again after its write,
    and the last one sees everything.
    """
    for _ in range(_MAX_ROUNDS):
        if not _refresh_once(store, camera_key, thresholds):
            return


def _refresh_once(store: Store, camera_key: str, thresholds: Thresholds) -> bool:
    """Write the mark; False if it was written already, or no calibration counts."""
    modes = store.calibrations.modes(camera_key)
    if not modes:
        return False
    support, some = IdSupport(), ""
    for mode in modes:
        for consensus in store.consensuses.at(mode):
            if consensus.calibration and (consensus.reliable or consensus.reason == "too_few"):
                support = max(support, IdSupport(consensus.reliable, consensus.calibration.contributors))
        counted = store.calibrations.newest(mode, thresholds.max_calibrations, thresholds.contributor_period)
        some = some or next((calibration.id for calibration in counted), "")
    document = store.calibrations.get(some) if some else None
    if document is None:
        return False
    identity = identify(document.camera, document.platform)
    if not (identity.usb_id and identity.distinct):
        return False
    counts = support.reliable or support.contributors >= thresholds.min_contributors
    return store.cameras.set_id_support(camera_key, identity.name_keys, support if counts else None)
