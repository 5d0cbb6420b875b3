"""Public copies of stored documents."""

import hashlib
import hmac
from collections.abc import Callable
from typing import TypeVar

from calibdb.camera_key import public_label, public_platform
from calibdb.schema.documents import GivenDocument

Alias = Callable[[str], str]
Document = TypeVar("Document", bound=GivenDocument)


def aliases(key: str) -> Alias:
    """Names of contributors in one dump: hashes under a key that is then deleted."""
    return lambda contributor: hmac.new(key.encode(), contributor.encode(), hashlib.sha256).hexdigest()


def public_copy(document: Document, alias: Alias) -> Document | None:
    """Public copy of a document; None if it was given without a licence."""
    return None if document.licence is None else unnamed_copy(document, alias)


def unnamed_copy(document: Document, alias: Alias) -> Document:
    """Document without names of people, labels by today's rules."""
    return document.model_copy(
        update={
            "camera": public_label(document.camera),
            "platform": public_platform(document.platform),
            "contributor": alias(document.contributor),
            "source": document.source and alias(document.source),
        }
    )
