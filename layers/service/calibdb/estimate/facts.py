"""Published facts about cameras: one table, each row with its source and licence.

A row is of one model, at one size or aspect and in one mode. The columns:

* `kind`, `camera`: as of `calibdb.estimate.device.Device`.
* `words`: words of its label, lower case; alternatives separated by `;`. Empty: a sample of its kind only.
* `usb`, `devices`: USB ids and identifiers of phones (`iphone17,3`, `sm-g975f`), separated by `;`.
* `mode`: such as of a field-of-view switch; empty: the only one. Rows that differ in it are alternatives.
* `width`, `height`: size in px, or an aspect such as 16, 9.
* `quantity`, `value`, `sigma`: as of `angles.log_tan`; sigma is that of the row.
* `n`: number of its calibrations. `what`: calibration, specification, reported, measurement.
* `distortion`: `fisheye k1 k2 k3 k4`, if the lens is one.
"""

import csv
import functools
from dataclasses import dataclass
from pathlib import Path

from calibdb.camera_key.names import words
from calibdb.estimate.angles import Size, log_tan, log_tan_sigma

TABLE = Path(__file__).with_name("facts.csv")
FACT_COLUMNS = (
    *("kind", "maker", "model", "words", "usb", "devices", "camera", "mode", "width", "height"),
    *("quantity", "value", "sigma", "n", "what", "distortion", "title", "url", "licence"),
)

# A maker's diagonal angle against calibrations of six webcams, degrees: too wide by 1.75, scatter 2.5.
_SPECIFIED_BIAS, _SPECIFIED_SIGMA = 1.75, 2.5
_WEBCAMS = ("usb_webcam", "camera_module")


@dataclass(frozen=True, slots=True)
class Fact:
    """One row of the table, its value as `log_tan`."""

    kind: str
    maker: str
    model: str
    words: tuple[frozenset[str], ...]
    usb: frozenset[str]
    devices: frozenset[str]
    camera: str
    mode: str
    size: Size
    log_tan: float
    sigma: float
    n: int
    what: str
    lens: tuple[float, ...]
    title: str
    url: str


def fact_of(row: dict[str, str]) -> Fact:
    """Parse a row; raises ValueError or KeyError."""
    size = (float(row["width"]), float(row["height"]))
    quantity, value, sigma = row["quantity"], float(row["value"]), float(row["sigma"])
    if quantity == "dfov" and row["what"] == "specification" and row["kind"] in _WEBCAMS:
        value, sigma = value - _SPECIFIED_BIAS, max(sigma, _SPECIFIED_SIGMA)
    return Fact(
        **{name: row[name] for name in ("kind", "maker", "model", "camera", "mode", "what", "title", "url")},
        words=tuple(frozenset(words(text)) for text in row["words"].split(";") if text),
        usb=frozenset(filter(None, row["usb"].split(";"))),
        devices=frozenset(filter(None, row["devices"].split(";"))),
        size=size,
        log_tan=log_tan(quantity, value, size),
        sigma=log_tan_sigma(quantity, value, sigma, size),
        n=int(row["n"]),
        lens=tuple(float(k) for k in row["distortion"].split()[1:]),
    )


def rows() -> list[dict[str, str]]:
    """Read the table as text."""
    with TABLE.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


@functools.cache
def all_facts() -> tuple[Fact, ...]:
    """Read the table, once in a process."""
    return tuple(fact_of(row) for row in rows())
