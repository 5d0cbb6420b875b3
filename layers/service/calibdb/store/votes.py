"""Votes, checks of a consensus on fresh views: immutable objects, and the items that find them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from calibdb.errors import DeniedReadError
from calibdb.schema import VoteDocument
from calibdb.store.keys import StreamMode, vote_object
from calibdb.store.ports import DocumentStore, Item, encoded, read, read_all, read_together

MAX_VOTES = 50  # the newest; more could only repeat them
_MAX_VOTES_READ = 1_000  # of a mode that are looked through for them


@dataclass(frozen=True)
class IndexedVote:
    """A vote as the index knows it."""

    id: str
    source: str  # as what its contributor is counted
    object: str  # its name in the bucket, which keeps the key that the camera had then


class Votes(DocumentStore):
    """Store of votes on a camera's consensus at one size and zoom."""

    def cast(self, document: VoteDocument) -> VoteDocument:
        """Store the vote, and return it as it is stored: the first one cast under its id."""
        name = vote_object(document.camera_key, document.id)
        stored = document
        if not self._objects.create(name, encoded(document)):
            stored = read(self._objects, name, VoteDocument) or document
        self.index(stored)
        return stored

    def index(self, document: VoteDocument) -> None:
        """Write the index item, which follows from the document."""
        mode = StreamMode(document.current_key, document.img_size, document.zoom)
        self._table.put(
            {
                "pk": mode.pk,
                "sk": f"VOTE#{mode.text}#{document.id}",
                "contributor": document.contributor,
                "source": document.counted_as,
                "time": document.time,
                "object": vote_object(document.camera_key, document.id),
            }
        )

    def newest(self, mode: StreamMode, *, one_per_source: bool) -> list[IndexedVote]:
        """Votes on a mode, newest first.

        `one_per_source`: only the newest of each source, so that daily voters do not displace others.
        """
        most = _MAX_VOTES_READ if one_per_source else MAX_VOTES
        items = self._table.query(
            mode.pk, f"VOTE#{mode.text}#", newest_first=True, limit=most, consistent=True
        )
        votes: dict[str, IndexedVote] = {}
        for cast in map(_to_indexed_vote, items):
            votes.setdefault(cast.source if one_per_source else cast.id, cast)
        return list(votes.values())[:MAX_VOTES]

    def read(self, cast: Sequence[IndexedVote]) -> list[VoteDocument]:
        """Return these votes in their order; raises DeniedReadError if one is not there."""
        documents = []
        for content in read_together(self._objects, [vote.object for vote in cast]):
            if content is None:  # an object is written before its item
                raise DeniedReadError("A vote that the index names could not be read.")
            documents.append(VoteDocument.model_validate_json(content))
        return documents

    def all(self) -> Iterator[VoteDocument]:
        """Yield every vote in the bucket: what the index is rebuilt from."""
        return read_all(self._objects, "votes/", VoteDocument)


def _to_indexed_vote(item: Item) -> IndexedVote:
    return IndexedVote(item["sk"].rpartition("#")[2], item["source"], item["object"])
