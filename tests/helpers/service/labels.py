"""Labels under which browsers report cameras on sale, and those that CALIBDB_DATA adds."""

import csv
from dataclasses import dataclass
from typing import Final

import pytest

from tests.helpers.data import ROOT, data_dir, external_data


@dataclass(frozen=True)
class LabelRow:
    """A label, the system that reports it ("macOS", "macOS(de)"; "" is unknown), and the product it is of."""

    label: str
    system: str
    product: str


#: parameters of a fixture that returns `rows(request.param)`
SOURCES: Final = ("typed", pytest.param("external", marks=external_data))


def rows(source: str) -> list[LabelRow]:
    folder = ROOT / "tests" / "data" if source == "typed" else data_dir()
    with (folder / "labels.csv").open(encoding="utf-8") as file:
        return [
            LabelRow(row["label"], row["platform"], row["same_device_group"])
            for row in csv.DictReader(file)
            if row["label"]
        ]
