"""Content of the answers at the edge: which objects an alias has, and what they say. Reads only.

Only what is stored has objects: reliable consensuses at their own size and zoom. An alias with a USB id has
them where the camera is known under that very id, and a name alone where it is known under the name, or under
the id that the name means on every computer. So what an alias has follows from the entries under its own key
and under the ids of its name, and from nothing else.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Iterator

from calibdb.camera_key import Identity, identify, public_label, public_platform
from calibdb.lookup.calibration_lookup import LookupQuery, find
from calibdb.schema import ConsensusDocument, LookupAnswer
from calibdb.schema.fields import size_text, zoom_text
from calibdb.store import CameraRecords, Store
from calibdb.store.keys import answer_object

Name = tuple[str, str]  # label, platform
Read = Callable[[str], CameraRecords]
Answers = dict[str, tuple[str, bytes]]  # text of size, zoom and model -> name of the object, its content


def reader(store: Store) -> Read:
    """Return a function that reads what is known under a camera key at this moment, once for each key."""
    return functools.cache(functools.partial(store.cameras.known, consistent=True))


def answers(read: Read, name: Name, *, private: bool) -> Answers:
    """Return the objects that an alias has.

    Parameters
    ----------
    read
        Returns what is known under a camera key.
    name
        Label and platform.
    private
        As in `find`.
    """
    found: Answers = {}
    for wanted, answer in _hits(read, name, private=private):
        if answer.exact_size:
            mode = f"{size_text(wanted.img_size)}#{zoom_text(wanted.zoom)}#{wanted.model}"
            found[mode] = (object_of(name, mode), answer.model_dump_json().encode())
    return found


def has_hit(read: Read, name: Name, *, private: bool) -> bool:
    """Tell whether a lookup under the alias hits in a way that objects can stand for."""
    return next(_hits(read, name, private=private), None) is not None


def object_of(name: Name, mode: str) -> str:
    """Return the name of an alias's object for a text such as `1280x720#0#rectilinear`."""
    size, zoom, model = mode.split("#")
    width, _, height = size.partition("x")
    return answer_object(*name, (int(width), int(height)), float(zoom), model)


def is_public(name: Name) -> bool:
    """Tell whether a label holds nothing of a person, so that it may be stored."""
    label, platform = name
    return public_label(label) == label and public_platform(platform) == platform


def name_keys(names: Iterable[Name]) -> set[str]:
    """Return the keys of bare names whose lookups may be answered by the camera that bears these names."""
    identities = (identify(*name) for name in names)
    return {key for one in identities if one.usb_id is not None for key in one.name_keys}


def _hits(read: Read, name: Name, *, private: bool) -> Iterator[tuple[LookupQuery, LookupAnswer]]:
    identity = identify(*name)
    stored = list(_stored_consensuses(read, identity))
    modes = {(c.img_size, c.zoom, c.distortion_model) for c in stored if c.reliable}
    for img_size, zoom, model in sorted(modes):
        wanted = LookupQuery(*name, img_size, zoom, model)
        found = find(read, wanted, private=private, compute=_never)
        if found.answer is not None and (found.key == identity.key or _travels(identity)):
            yield wanted, found.answer


def _stored_consensuses(read: Read, identity: Identity) -> Iterator[ConsensusDocument]:
    known = read(identity.key)
    yield from known.consensuses
    if _travels(identity):
        for other in sorted({*known.same_as, *known.well_known}):
            yield from read(other).consensuses


def _travels(identity: Identity) -> bool:
    """Tell whether it is a name alone, and means the same camera on every computer."""
    return identity.usb_id is None and len(identity.name_keys) > 1


def _never(_key: str, _size: tuple[int, int]) -> None:
    """Compute nothing: what nobody asked for yet has no object."""
