"""Use of cameras at the edge, counted in CloudFront's access logs."""

from __future__ import annotations

import gzip
import json
import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from calibdb.store import Aliases
from infra.ops import OpsError

_LOOKUP_PATH = re.compile(r"/known/v1/([0-9a-f]{32})/")
UNKNOWN = "unknown"  # cameras that no lookup has found


def count_use(folder: Path, aliases: Aliases) -> Counter[str]:
    """Count the requests of `GET /known/v1/…` by camera label, in all logs below a folder."""
    digests = Counter(m[1] for path in _paths(folder) if (m := _LOOKUP_PATH.match(path)))
    use: Counter[str] = Counter()
    for digest, requests in digests.items():
        alias = aliases.get(digest)
        use[UNKNOWN if alias is None else alias.label] += requests
    return use


def _paths(folder: Path) -> Iterator[str]:
    """Yield the path of each request, from lines of JSON as CloudFront writes them."""
    logs = sorted(folder.rglob("*.gz"))
    if not logs:
        raise OpsError(f"no logs (*.gz) in {folder}: copy the bucket EdgeLogBucket there first")
    for log in logs:
        try:
            with gzip.open(log, "rt", encoding="utf-8") as lines:
                for line in lines:
                    yield str(json.loads(line).get("cs-uri-stem", ""))
        except (OSError, EOFError, ValueError, AttributeError) as error:
            raise OpsError(f"not a log of CloudFront in JSON: {log}: {error}") from error
