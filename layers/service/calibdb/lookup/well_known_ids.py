"""Which USB ids are known well enough to say what a name means.

Anybody can invent an id. So one counts under its name, beside others, only once the database vouches for it,
or as many contributors as it takes for that calibrated it. Brought up to date with every consensus.
"""

from __future__ import annotations

from calibdb.camera_key import identify
from calibdb.settings import Thresholds
from calibdb.store import Store

ROUNDS = 5  # others that are overtaken, one after the other


def bring_up_to_date(store: Store, camera_key: str, thresholds: Thresholds) -> None:
    """Let the camera stand for its name, or not any more, by what is known of it at every size and zoom.

    Computations of two sizes may do this at once, and the one that has seen less may write last. So whoever
    has written looks again: what is there by then was seen by the last of them.
    """
    for _ in range(ROUNDS):
        if not _once(store, camera_key, thresholds):
            return


def _once(store: Store, camera_key: str, thresholds: Thresholds) -> bool:
    """Write down how the camera stands; False where that was written already, or nothing counts any more."""
    modes = store.calibrations.modes(camera_key)
    if not modes:
        return False  # its names are gone
    reliable, sources, some = False, set[str](), ""
    for mode in modes:
        reliable = reliable or any(known.reliable for known in store.consensuses.at(mode))
        counted = store.calibrations.newest(mode, thresholds.most_calibrations, thresholds.contributor_period)
        sources |= {calibration.source for calibration in counted}
        some = some or next((calibration.id for calibration in counted), "")
        if reliable and some:
            break
    document = store.calibrations.get(some) if some else None
    if document is None:
        return False
    identity = identify(document.camera, document.platform)
    if not (identity.usb_id and identity.distinct):
        return False
    well_known = reliable or len(sources) >= thresholds.min_contributors
    return store.cameras.stand(camera_key, identity.name_keys, well_known=well_known)
