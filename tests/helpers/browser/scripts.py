"""JavaScript that tests run in pages."""

from pathlib import Path

#: page with the least on it, for scripts that any page of the site may run
PLAIN = "/offline.html"
FOLDER = Path(__file__).parents[2] / "browser" / "scripts"


def page_function(name: str) -> str:
    """Source of a function of a file's name; the semicolon at its end would make it a statement."""
    return (FOLDER / f"{name}.js").read_text().rstrip().removesuffix(";")
