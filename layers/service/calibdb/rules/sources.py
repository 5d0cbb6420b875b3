"""Counting of sources: how many lines of the network they are at least.

One line of the network commonly has an IPv4 and an IPv6 address, and nothing shows which belong together. So
of the sources of the two families only those of the larger one count: no line is counted twice.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

from calibdb.schema.fields import IPV6_SOURCE


def family(source: str) -> str:
    """Return the address family of a source."""
    return "ipv6" if source.startswith(IPV6_SOURCE) else "ipv4"


def count_lines(sources: Iterable[str]) -> int:
    """Count different sources, only those of the larger family."""
    return max(Counter(map(family, set(sources))).values(), default=0)
