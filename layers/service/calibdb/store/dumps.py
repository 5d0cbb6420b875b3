"""Dumps: public objects under `dumps/` in the bucket of the site, and the draft of the one being written.

The draft is in the private bucket, since it has the key by which contributors are named.
"""

from calibdb.schema.dump import Dump, DumpDraft, Statistics
from calibdb.store.ports import Objects, encoded, read

FOLDER = "dumps/"
LATEST, STATISTICS = f"{FOLDER}latest.json", f"{FOLDER}statistics.json"
JSON, GZIP = "application/json", "application/gzip"
NO_STATISTICS = encoded(Statistics(created=0, history=(), wanted=()))
"""Content of `STATISTICS` before the first dump."""
# A part never changes; it is removed when a contributor is forgotten.
CACHE_CONTROL = {JSON: "public, max-age=60, s-maxage=300", GZIP: "public, max-age=3600"}
_DRAFT = f"{FOLDER}draft.json"


class Dumps:
    """Store of the public dumps of one deployment: copies of private objects in the bucket of the site."""

    def __init__(self, documents: Objects, site: Objects) -> None:
        self.documents = documents
        self._public = site

    def latest(self) -> Dump | None:
        """Newest dump, None if none was written yet."""
        return read(self._public, LATEST, Dump)

    def statistics(self) -> Statistics | None:
        """Figures of the newest dump, None if there are none yet."""
        return read(self._public, STATISTICS, Statistics)

    def write(self, name: str, content: bytes, media_type: str = JSON) -> None:
        """Write a public object, replacing the one of its name."""
        self._public.put(name, content, media_type, CACHE_CONTROL[media_type])

    def names(self) -> list[str]:
        """List the names of all public objects."""
        return list(self._public.names(FOLDER))

    def purge(self, names: list[str]) -> int:
        """Remove public objects with every version."""
        return self._public.purge_all_versions(names)

    def draft(self) -> tuple[DumpDraft, str] | None:
        """Draft and the tag of its version, None if no dump is being written."""
        version = self.documents.get_version(_DRAFT)
        return None if version is None else (DumpDraft.model_validate_json(version[0]), version[1])

    def begin(self, draft: DumpDraft) -> bool:
        """Store the draft of a new dump; False if another is being written."""
        return self.documents.create(_DRAFT, encoded(draft))

    def advance(self, draft: DumpDraft, tag: str) -> str | None:
        """Store the draft over its version `tag`; return its new tag, None if another writer was faster."""
        if not self.documents.replace(_DRAFT, encoded(draft), tag):
            return None
        version = self.documents.get_version(_DRAFT)
        return None if version is None else version[1]

    def end(self) -> None:
        """Delete the draft, and with it the key."""
        self.documents.delete([_DRAFT])
