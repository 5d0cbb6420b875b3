"""The local stack's own secrets."""

from __future__ import annotations

import json
import os
import secrets
from dataclasses import asdict, dataclass
from pathlib import Path


@dataclass(frozen=True)
class Secrets:
    """Keys that sign session ids and hash contributors."""

    session: str
    contributor: str

    def __repr__(self) -> str:
        return "Secrets(…)"


def generate() -> Secrets:
    """Generate new secrets."""
    return Secrets(secrets.token_hex(32), secrets.token_hex(32))


def load(path: Path) -> Secrets:
    """Read the secrets of a file, which is created at the first time; only its owner may read it.

    They last, so that a restart does not end running sessions.
    """
    if not path.exists():
        # Written whole beside it, then renamed: a crash leaves either no file or all of it.
        draft = path.with_suffix(".new")
        descriptor = os.open(draft, os.O_CREAT | os.O_WRONLY | os.O_TRUNC, 0o600)
        with os.fdopen(descriptor, "w", encoding="utf-8") as file:
            json.dump(asdict(generate()), file)
            file.flush()
            os.fsync(file.fileno())
        draft.replace(path)
    return Secrets(**json.loads(path.read_text(encoding="utf-8")))
