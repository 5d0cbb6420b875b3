"""The server's own secrets."""

import json
import os
import re
import secrets
from dataclasses import asdict, dataclass
from pathlib import Path

_SECRET = re.compile("[0-9a-f]{64}")
_WAY_ON = (
    "put back a copy of it, or start once with NEW_SECRETS=1 to have new ones made; then captures that run "
    "end, and contributors are counted again"
)


@dataclass(frozen=True, repr=False)
class Secrets:
    """Keys that sign session ids and hash contributors."""

    session: str
    contributor: str


def generate() -> Secrets:
    """Generate new secrets."""
    return Secrets(secrets.token_hex(32), secrets.token_hex(32))


class SecretsError(Exception):
    """The file of secrets is missing or damaged."""


def load(path: Path, *, known: bool = False) -> Secrets:
    """Read the secrets of a file, which is created at the first time; only its owner may read it.

    They last: new ones would end running sessions and give every contributor another id.
    Raises SecretsError if the file is damaged, or missing although it is `known` that there was one.
    """
    if not path.exists():
        if known:
            raise SecretsError(f"{path} is missing, but the database that it belongs to is there: {_WAY_ON}")
        # Written to a file next to it, then renamed: a crash leaves either no file or all of it.
        draft = path.with_suffix(".new")
        descriptor = os.open(draft, os.O_CREAT | os.O_WRONLY | os.O_TRUNC, 0o600)
        with os.fdopen(descriptor, "w", encoding="utf-8") as file:
            json.dump(asdict(generate()), file)
            file.flush()
            os.fsync(file.fileno())
        draft.replace(path)
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        loaded = Secrets(content["session"], content["contributor"])
    except OSError as error:
        raise SecretsError(f"{path} cannot be read ({error.strerror}): {_WAY_ON}") from error
    except (ValueError, KeyError, TypeError) as error:
        raise SecretsError(f"{path} is damaged (it lacks two secrets): {_WAY_ON}") from error
    if not all(isinstance(secret, str) and _SECRET.fullmatch(secret) for secret in asdict(loaded).values()):
        raise SecretsError(f"{path} is damaged (a secret is not 64 hex digits): {_WAY_ON}")
    return loaded
