"""Badges and heads of results: what they say, and that a label stays text."""

from html import escape
from typing import Literal
from xml.etree import ElementTree as ET

import pytest

from calibdb.lookup.badge import NOT_CALIBRATED, Badge, badge_of, parse_size, svg
from calibdb.lookup.result_page import facts, title, with_head
from calibdb.schema import Calibration, ConsensusDocument
from calibdb.settings import Thresholds
from tests.helpers.service.known import consensus, fit

SIZE = (1280, 720)


def badge(*known: ConsensusDocument, camera: str = "C920 (046d:082d)", least: int = 1) -> Badge:
    return badge_of(camera, known, SIZE, Thresholds(min_contributors=least))


@pytest.mark.parametrize(
    ("known", "state", "colour"),
    [
        (consensus(fit(uncertainty=0.042)), "calibrated ± 0.04 px", "green"),
        (consensus(fit(uncertainty=0.0042)), "calibrated ± 0.004 px", "green"),
        (consensus(fit(uncertainty=1.234)), "calibrated ± 1.2 px", "green"),
        (consensus(reason="too_few", calibrations=2), "2 of 5 calibrations", "amber"),
        (consensus(fit(img_size=(640, 480))), "not calibrated", "grey"),
    ],
)
def test_badge_says_the_typical_error_or_what_is_missing(
    known: ConsensusDocument, state: str, colour: Literal["green", "amber", "grey"]
) -> None:
    assert badge(known) == Badge("C920 1280×720", state, colour)


def test_camera_that_no_search_shows_has_no_name_in_a_badge() -> None:
    assert badge() == NOT_CALIBRATED
    assert badge(consensus(reason="too_few", calibrations=1), least=3) == NOT_CALIBRATED


@pytest.mark.parametrize("label", ['<script>alert("1")</script>', "a & b", "]]>", "x\" onload='y", "ж" * 300])
def test_label_in_a_badge_is_text_and_nothing_else(label: str) -> None:
    drawn = svg(badge(consensus(), camera=label))
    root = ET.fromstring(drawn)
    elements = [element.tag.rpartition("}")[2] for element in root.iter()]
    assert elements == ["svg", "title", "rect", "path", "g", "text", "text"]
    text = root.findall(".//{*}text")[0].text or ""
    assert text == (label if len(label) <= 40 else label[:39] + "…") + " 1280×720"
    assert {name for element in root.iter() for name in element.attrib}.isdisjoint(
        {"onload", "style", "href"}
    )


def test_sizes_are_read_from_names_of_files() -> None:
    assert parse_size("1280x720.svg") == SIZE
    for name in ("1280x720", "0x720.svg", "1280x720.png", "axb.svg", "123456x1.svg", "../x.svg", ""):
        assert parse_size(name) is None


PAGE = """<html><head><title data-t="result.title">Calibration result</title>
<meta name="description" data-t-content="result.description" content="A camera calibration.">
<meta property="og:title" content="Calibration result">
<meta property="og:description" content="A camera calibration.">
<script src="/language.js"></script></head></html>"""


def calibration(camera: str, uncertainty: float = 0.2) -> Calibration:
    return consensus(fit(uncertainty=uncertainty), camera=camera).calibration


def test_title_names_camera_size_and_error_in_no_language() -> None:
    assert title(calibration("C920 (046d:082d)", 0.042)) == "C920 · 1280 × 720 · ± 0.04 px"
    assert facts(calibration("C920")).endswith(" · rectilinear · 1970-01-01.")


@pytest.mark.parametrize(
    "label", ['<script>alert("1")</script>', "a & b", "\\1", "x\" onload='y", "</title>"]
)
def test_label_in_a_head_is_text_and_nothing_else(label: str) -> None:
    labelled = calibration(label)
    shown, described = f"{title(labelled)} · calibDB", f"{facts(labelled)} A camera calibration."
    expected = PAGE.replace("Calibration result", escape(shown)).replace(
        "A camera calibration.", escape(described)
    )
    assert with_head(PAGE, labelled) == expected
