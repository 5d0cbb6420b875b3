"""The names under which cameras are found: other keys of the same camera, and the words that people search.

* `CAMERA#<other key>/CONSENSUS-OF#<key>`: a camera requested under the other key is known under this one. The
  other key is that of the bare name, which is all that some browsers report, or one of earlier rules. The one
  Query of a lookup returns it. If the camera counts as one of several of this name
  (`calibdb.lookup.well_known_ids`): `well_known`, its contributors, and `reliable`.
* `CAMERAS#<first letter>/<word>#<key>` and `CAMERAS#/<key>`: the search, by word, and without one.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass

from calibdb.camera_key import PATTERN, Identity, identify, public_label, public_platform
from calibdb.camera_key.names import words
from calibdb.camera_key.usb_vendors import vendor_words
from calibdb.schema import CalibrationDocument
from calibdb.store.keys import camera_pk
from calibdb.store.ports import IF_NOT_EXISTS, Item, Table

SAME_AS = "CONSENSUS-OF#"
ALL = "CAMERAS#"  # partition of all cameras; with a letter, of the words that begin with it
_MAX_NAME_WORDS = 16
_OWN_ID = re.compile(r"-[0-9a-f]{20}$")  # what a calibration's id adds to the key it was made under


@dataclass(frozen=True)
class _NamedCamera:
    key: str
    aliases: frozenset[str]
    identity: Identity


class Names:
    """The names of the cameras behind calibrations."""

    def __init__(self, table: Table) -> None:
        self._table = table
        self._written: set[_NamedCamera] = set()

    def publish(self, document: CalibrationDocument) -> None:
        """Index the names of a camera."""
        named = _name_of(document)
        # This item is written last: where it exists, all others that follow from the key exist.
        is_listed = self._table.get(ALL, named.key) is not None
        if not (is_listed and named.identity.distinct and named.aliases <= named.identity.name_keys):
            self._alias(named)
        if not is_listed:
            self._search(named)

    def index(self, document: CalibrationDocument) -> None:
        """Write every name of the camera, once for all of its calibrations."""
        named = _name_of(document)
        if named not in self._written:
            self._alias(named)
            self._search(named)
            self._written.add(named)

    def remove(self, document: CalibrationDocument, left: Sequence[str]) -> None:
        """Forget the names that only this calibration gave; `left`: ids of the others that count."""
        named = _name_of(document)
        gone = _aliases(named) if left else [*_aliases(named), *_search_items(named)]
        others = {_OWN_ID.sub("", other) for other in left}
        if left and named.identity.usb_id:
            others |= named.identity.name_keys
        for item in gone:
            if item["pk"] not in map(camera_pk, others):
                self._table.delete(item["pk"], item["sk"])
        self._written.discard(named)

    def _alias(self, named: _NamedCamera) -> None:
        for item in _aliases(named):
            self._table.put(item, IF_NOT_EXISTS)  # its support is written there later

    def _search(self, named: _NamedCamera) -> None:
        for item in _search_items(named):
            self._table.put(item)


def with_current_key(document: CalibrationDocument) -> CalibrationDocument:
    """Calibration with key and public label by today's rules."""
    key = document.current_key
    if key == document.camera_key:
        return document
    label, platform = public_label(document.camera), public_platform(document.platform)
    return document.model_copy(update={"camera_key": key, "camera": label, "platform": platform})


def _name_of(document: CalibrationDocument) -> _NamedCamera:
    identity = identify(document.camera, document.platform)
    key = document.current_key
    made_under = _OWN_ID.sub("", document.id)
    others = {document.camera_key, made_under, *(identity.name_keys if identity.usb_id else ())}
    return _NamedCamera(key, frozenset(k for k in others if k != key and PATTERN.fullmatch(k)), identity)


def _aliases(named: _NamedCamera) -> list[Item]:
    return [{"pk": camera_pk(other), "sk": SAME_AS + named.key} for other in sorted(named.aliases)]


def _search_items(named: _NamedCamera) -> list[Item]:
    parts = list(dict.fromkeys(words(named.identity.name)))[:_MAX_NAME_WORDS]
    if named.identity.usb_id:
        parts += [*named.identity.usb_id.split(":"), *vendor_words(named.identity.usb_id)]
    name = named.identity.name
    by_word: list[Item] = [
        {"pk": ALL + word[0], "sk": f"{word}#{named.key}", "name": name} for word in dict.fromkeys(parts)
    ]
    return [*by_word, {"pk": ALL, "sk": named.key, "name": name}]
