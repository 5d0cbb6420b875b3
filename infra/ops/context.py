"""The context of a command: storage, clock and output."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

from calibdb.schema import CalibrationDocument
from calibdb.settings import Settings
from calibdb.store import Objects, Store
from calibdb.store.keys import WITHDRAWN
from calibdb.store.ports import READERS, Storage
from calibdb.store.sqlite import SqliteObjects
from calibdb.store.storage import storage_of
from infra.console import track

CALIBRATIONS_PREFIX = "calibrations/"
Key = tuple[str, str]  # pk, sk of an item


@dataclass(frozen=True)
class OpsContext:
    """One deployment's storage, from the operator's side."""

    settings: Settings
    secret_known: bool  # whether `settings.contributor_secret` is the deployment's
    store: Store
    storage: Storage
    objects: Objects
    now: int  # unix seconds
    echo: Callable[[str], None]

    @classmethod
    def of(
        cls,
        environment: Mapping[str, str],
        *,
        secret_known: bool,
        echo: Callable[[str], None] = print,
    ) -> OpsContext:
        """Make the context of the deployment that `environment` names."""
        settings = Settings.from_environment(environment)
        storage = storage_of(settings)
        objects = storage.objects
        if not isinstance(objects, SqliteObjects):
            # Not needed, and botocore not installed, elsewhere.
            from infra.ops.replica import ReplicatedObjects

            objects = ReplicatedObjects(settings.bucket_name, settings.region)
        return cls(
            settings=settings,
            secret_known=secret_known,
            store=Store.over(storage),
            storage=storage,
            objects=objects,
            now=int(time.time()),
            echo=echo,
        )

    def remove_items(self, keys: Iterable[Key]) -> None:
        """Remove the items of the table under these keys."""
        with ThreadPoolExecutor(READERS) as workers:
            list(workers.map(lambda key: self.storage.table.delete(*key), set(keys)))

    def every_calibration(self) -> Iterator[tuple[CalibrationDocument, bool]]:
        """Yield all calibrations, each with whether it is withdrawn, and show the progress."""
        names = self.objects.names
        return track(
            self.store.calibrations.everything(),
            "calibrations",
            lambda: sum(not name.endswith(WITHDRAWN) for name in names(CALIBRATIONS_PREFIX)),
        )
