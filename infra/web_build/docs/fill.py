"""Places in code that the page fills in: the address of the site, and the visitor's token."""

from __future__ import annotations

from infra.web_build.docs.samples import SITE
from infra.web_build.example_calls import TOKEN

_MARKS = {SITE: "origin", TOKEN: "token"}


def fill(html: str) -> str:
    """Mark the places in blocks of code, whose colours may not lie across them.

    Raises
    ------
    ValueError
        If a block has an address that begins otherwise, which would stay as it is.
    """
    parts = html.split("<pre")
    for index, part in enumerate(parts[1:], 1):
        block, closing, rest = part.partition("</pre>")
        if "127.0.0.1" in block.replace(SITE, ""):
            raise ValueError(f"an address is not {SITE}, or is cut by colours: {block}")
        for text, name in _MARKS.items():
            block = block.replace(text, f'<span data-fill="{name}">{text}</span>')
        parts[index] = block + closing + rest
    return "<pre".join(parts)
