"""Public dumps and statistics."""

from typing import Literal

from pydantic import ConfigDict, Field

from calibdb.schema.fields import Open, UnixTime
from calibdb.schema.licence import Licence

DumpedKind = Literal["calibrations", "votes"]


class PublicFile(Open):
    """A file for everyone."""

    name: str = Field(description="Name of the file under `/dumps/`.")
    size: int = Field(description="Bytes.")
    sha256: str = Field(pattern="^[0-9a-f]{64}$", description="SHA-256 of the file as downloaded.")


class DumpFile(PublicFile):
    """One part of a dump: JSON Lines, one document a line, compressed with gzip."""

    kind: DumpedKind = Field(description="Kind of its documents.")
    count: int = Field(description="Number of documents, one per line.")


class DumpCounts(Open):
    """Numbers of what a dump holds."""

    calibrations: int = 0
    votes: int = 0
    cameras: int = 0
    contributors: int = 0


class Dump(Open):
    """The newest dump: `/dumps/latest.json`."""

    format: Literal["calibdb-dump"] = "calibdb-dump"
    version: Literal[1] = Field(1, description="Version of this document and of those in the files.")
    name: str = Field(description="Folder of the dump: the UTC date of its start, and a number.")
    created: UnixTime
    licence: Licence = Field("CC0-1.0", description="SPDX identifier of the licence of all of it.")
    document_schema: str = Field("/data/schema.json", description="JSON Schema of this and of the documents.")
    counts: DumpCounts
    size: int = Field(description="Bytes of all files.")
    files: tuple[DumpFile, ...]


class Snapshot(Open):
    """The whole database on one day, what was given without a licence included."""

    date: str = Field(description="UTC, YYYY-MM-DD.")
    cameras: int = Field(description="Cameras with at least one calibration.")
    known: int = Field(description="Cameras with a reliable calibration at some size and model.")
    calibrations: int
    contributors: int
    given: int = Field(description="Calibrations in the dump.")


class WantedCamera(Open):
    """A camera that is asked for and not reliably known."""

    key: str | None = Field(description="Key of the camera; null: not calibrated yet.")
    camera: str = Field(
        description="Name of the camera, or its vendor and USB id until two contributors have calibrated it."
    )
    asked: int = Field(description="Lookups in the last 90 days without a reliable result.")
    calibrations: int


class BundleFile(PublicFile):
    """The bundle that was written with a dump, for lookups without a network."""

    cameras: int


class Statistics(Open):
    """The database in figures: `/dumps/statistics.json`."""

    version: Literal[1] = 1
    created: UnixTime
    history: tuple[Snapshot, ...] = Field(description="One entry per dump, oldest first.")
    wanted: tuple[WantedCamera, ...] = Field(description="Most requested first.")
    bundle: BundleFile | None = Field(
        None, description="File for offline lookups; null: the database has no reliable calibration."
    )


class Tally(Open):
    """Counts made while a dump is written, by short digests under the key of the dump; mutable."""

    model_config = ConfigDict(frozen=False)

    contributors: set[str] = Field(set())
    cameras: set[str] = Field(set())
    calibrations: int = 0
    given: DumpCounts = DumpCounts()
    givers: set[str] = Field(set())
    given_cameras: set[str] = Field(set())


class DumpDraft(Open):
    """Dump that is being written; `key` names contributors in it, and is deleted with the draft."""

    layout: Literal[1] = 1
    name: str
    started: int  # unix seconds
    key: str
    kind: DumpedKind = "calibrations"
    after: str = ""  # name of the last object that is in a part
    files: tuple[DumpFile, ...] = ()
    tally: Tally = Tally()
    complete: bool = False  # every part is written
