"""Public copies of stored documents: under a licence, and without anything that names a person."""

from __future__ import annotations

import hashlib
import hmac
from collections.abc import Callable
from typing import TypeVar

from calibdb.camera_key import public_label, public_platform
from calibdb.schema.documents import GivenDocument

Alias = Callable[[str], str]
Document = TypeVar("Document", bound=GivenDocument)


def aliases(key: str) -> Alias:
    """Return the names that contributors have in one dump: keyed hashes, of a key that is thrown away."""
    return lambda contributor: hmac.new(key.encode(), contributor.encode(), hashlib.sha256).hexdigest()


def public_copy(document: Document, alias: Alias) -> Document | None:
    """Copy what may be given away of a document; None of one that was given without a licence."""
    return None if document.licence is None else unnamed_copy(document, alias)


def unnamed_copy(document: Document, alias: Alias) -> Document:
    """Return a document without names of people; labels are cleaned by today's rules."""
    changed = {
        "camera": public_label(document.camera),
        "platform": public_platform(document.platform),
        "contributor": alias(document.contributor),
        "source": document.source and alias(document.source),
    }
    return document.model_copy(update=changed)
