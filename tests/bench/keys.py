"""`make bench DOCS=keys`: does the key of a camera suffice?

Labels that browsers reported, each with its product: which ways of making a key distinguish products, and
which find a product again. Published lens profiles: how often people with one camera have one lens.
"""

import itertools
import statistics
from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from calibdb.camera_key import Identity, identify
from calibdb.camera_key.system import system_of
from calibsolver import Camera
from calibsolver.consensus.agreement import differences
from tests.bench import document
from tests.helpers.data import ROOT
from tests.helpers.service.labels import rows as label_rows
from tests.helpers.solver import populations

DOCUMENT = ROOT / "docs" / "camera-keys.md"
SAME_LENS_WIDTHS = 0.01  # of the width, rms over the image: what may pass for one lens
WAYS = ["key", "wrong pairs", "precision", "recall, evident", "recall, all"]
LENSES = ["known fields", "cameras calibrated by several people", "pairs of one lens"]
MAX_COMPARED = 12  # calibrations of one camera that are compared


@dataclass(frozen=True)
class Label:
    """A label as a browser reported it, its product, and what the key makes of it."""

    label: str
    platform: str
    product: str
    identity: Identity


def labels() -> list[Label]:
    return [
        Label(row.label, row.system, row.product, identify(row.label, row.system or "unknown"))
        for row in label_rows("external")
    ]


def resolved(asked: Identity, known: Sequence[Label]) -> str:
    """Key by which a lookup would be answered if every label with a USB id was calibrated."""
    ids = {k.identity.key for k in known if k.identity.usb_id and asked.key in k.identity.name_keys}
    return ids.pop() if not asked.usb_id and asked.distinct and len(ids) == 1 else asked.key


def ways(found: Sequence[Label]) -> list[tuple[str, Callable[[Label], str]]]:
    """Ways to make a key, each with one more hint."""
    return [
        ("raw label", lambda x: x.label),
        ("raw label and platform", lambda x: f"{x.label}|{x.platform}"),
        ("normalised name", lambda x: x.identity.name),
        ("normalised name and system", lambda x: f"{x.identity.name}|{system_of(x.platform).text}"),
        ("USB id and name, else name and system", lambda x: x.identity.key),
        ("the same, a bare name resolved to its only USB id", lambda x: resolved(x.identity, found)),
    ]


def compared(found: Sequence[Label]) -> list[list[str]]:
    """Rows: way, wrong pairs, precision, recall of pairs that share a USB id or a name, and of all."""
    real = [x for x in found if not x.identity.virtual]
    pairs = list(itertools.combinations(real, 2))
    same = [(a, b) for a, b in pairs if a.product == b.product]
    evident = [(a, b) for a, b in same if is_evident(a, b) and is_english(a) and is_english(b)]
    out = []
    for name, key in ways(real):
        wrong = sum(a.product != b.product and key(a) == key(b) for a, b in pairs)
        right = sum(key(a) == key(b) for a, b in same)
        precision = f"{right / (right + wrong):.2f}" if right + wrong else ""
        recalls = [sum(key(a) == key(b) for a, b in some) / len(some) for some in (evident, same)]
        out.append([name, str(wrong), precision, *(f"{r:.2f}" for r in recalls)])
    return out


def is_evident(a: Label, b: Label) -> bool:
    return (
        (a.identity.usb_id and a.identity.usb_id == b.identity.usb_id)
        or a.label.casefold().strip() == b.label.casefold().strip()
        or a.identity.name == b.identity.name
    )


def is_english(label: Label) -> bool:
    """True if a label is in English: most of the others are one name in seventeen languages."""
    return label.platform.partition("(")[2] in ("", "en)")


def lenses() -> list[list[str]]:
    """Rows: what is known of the camera, how many such cameras, and pairs of people who had one lens."""
    # All fields are known, so that the rows of the table are of the same calibrations.
    known = ("brand", "model", "lens", "setting")
    rows = [row for row in populations.profile_rows() if all(row[name].strip() for name in known)]
    out = []
    for name, count in (("brand and model", 2), ("brand, model, lens", 3), (", ".join(known), 4)):
        fields = known[:count]
        # One calibration of each contributor, all at one size.
        groups: dict[tuple[str, ...], dict[str, Camera]] = defaultdict(dict)
        for row in rows:
            key = tuple(row[f].strip().casefold() for f in (*fields, "w", "h"))
            if len(groups[key]) < MAX_COMPARED:
                groups[key][row["contributor"]] = populations.profile_camera(row)
        shares = []
        for group in groups.values():
            if len(group) > 1:
                limit = SAME_LENS_WIDTHS * next(iter(group.values())).img_size[0]
                away = differences(list(group.values()))
                shares.append(float(np.mean(away[np.triu_indices(len(group), 1)] < limit)))
        # Each camera counts the same, however popular.
        out.append([name, f"{len(shares):,}", f"{100 * statistics.mean(shares):.0f} %"])
    return out


def facts(found: Sequence[Label]) -> list[list[str]]:
    real = [x for x in found if not x.identity.virtual]
    names: dict[str, set[str]] = defaultdict(set)
    for x in real:
        if x.identity.usb_id:
            names[x.identity.name].add(x.identity.usb_id)
    several = {name for name, ids in names.items() if len(ids) > 1}
    guessed = sum(identify(name, "X11; Linux x86_64").distinct for name in several)
    answered = [x for x in real if not x.identity.ambiguous]
    virtual = [x for x in found if x.product == "virtual"]
    recognised = sum(x.identity.virtual for x in virtual)
    return [
        ["labels", str(len(found))],
        ["products with these labels", str(len({x.product for x in found}))],
        ["labels that identify their product", f"{len(answered)} of {len(real)}"],
        ["names shared by several USB ids", str(len(several))],
        ["of these resolved by the name only", str(guessed)],
        ["virtual cameras recognised", f"{recognised} of {len(virtual)}"],
        ["real cameras mistaken for virtual ones", str(len(found) - len(real) - len(virtual))],
    ]


def main() -> None:
    found = labels()
    for name, header, rows in (
        ("ways", WAYS, compared(found)),
        ("facts", ["", ""], facts(found)),
        ("lenses", LENSES, lenses()),
    ):
        document.replace(name, document.table(header, rows), DOCUMENT)


if __name__ == "__main__":
    main()
