"""Public addresses: those to which a proof may be fetched from.

Source: IANA IPv4 and IPv6 Special-Purpose Address Registries (RFC 6890). The lists stand here, since those of
Python's `ipaddress` differ between its versions.
"""

from __future__ import annotations

import ipaddress

_SPECIAL_IPV4 = tuple(
    map(
        ipaddress.IPv4Network,
        (
            "0.0.0.0/8",
            "10.0.0.0/8",
            "100.64.0.0/10",
            "127.0.0.0/8",
            "169.254.0.0/16",
            "172.16.0.0/12",
            "192.0.0.0/24",
            "192.0.2.0/24",
            "192.31.196.0/24",
            "192.52.193.0/24",
            "192.88.99.0/24",
            "192.168.0.0/16",
            "192.175.48.0/24",
            "198.18.0.0/15",
            "198.51.100.0/24",
            "203.0.113.0/24",
            "224.0.0.0/4",
            "240.0.0.0/4",
        ),
    )
)
_GLOBAL_UNICAST = ipaddress.IPv6Network("2000::/3")
# Within it: protocol assignments with Teredo, benchmarking and ORCHID; documentation; 6to4, which holds an
# IPv4 address. IPv4-mapped addresses and NAT64 lie outside.
_SPECIAL_IPV6 = tuple(
    map(
        ipaddress.IPv6Network,
        ("2001::/23", "2001:db8::/32", "2002::/16", "2620:4f:8000::/48", "3fff::/20"),
    )
)


def is_public(text: str) -> bool:
    """True if `text` is an address of the public internet, as a resolver or a socket writes it."""
    try:
        address = ipaddress.ip_address(text)
    except ValueError:
        return False
    if isinstance(address, ipaddress.IPv4Address):
        return not any(address in network for network in _SPECIAL_IPV4)
    return (
        address.scope_id is None
        and address in _GLOBAL_UNICAST
        and not any(address in network for network in _SPECIAL_IPV6)
    )
