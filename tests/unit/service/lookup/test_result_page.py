"""Head of a result's page: what messengers show, and that a label stays text."""

from html.parser import HTMLParser

import pytest

from calibdb.lookup.result_page import facts, title, with_head
from calibdb.schema import Calibration
from tests.helpers.service.known import consensus, fit

PAGE = """<html><head><title data-t="result.title">Calibration result</title>
<meta name="description" data-t-content="result.description" content="A camera calibration.">
<meta property="og:title" content="Calibration result">
<meta property="og:description" content="A camera calibration.">
<script src="/language.js"></script></head></html>"""


def calibration(camera: str, uncertainty: float = 0.2) -> Calibration:
    made = consensus(fit(uncertainty=uncertainty), camera=camera).calibration
    assert made is not None
    return made


class Parts(HTMLParser):
    """Tags, and texts between them."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, list[tuple[str, str | None]]]] = []
        self.texts: list[str] = []
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, attrs))

    def handle_data(self, data: str) -> None:
        self.texts.append(data)


def test_title_names_camera_size_and_error_in_no_language() -> None:
    assert title(calibration("C920 (046d:082d)", 0.042)) == "C920 · 1280 × 720 · ± 0.04 px"
    assert facts(calibration("C920")).endswith(" · rectilinear · 1970-01-01.")


@pytest.mark.parametrize(
    "label", ['<script>alert("1")</script>', "a & b", "\\1", "x\" onload='y", "</title>"]
)
def test_label_in_a_head_is_text_and_nothing_else(label: str) -> None:
    labelled = calibration(label)
    parts = Parts(with_head(PAGE, labelled))
    shape = [(tag, [name for name, _ in attributes]) for tag, attributes in parts.tags]
    assert shape == [(tag, [name for name, _ in attributes]) for tag, attributes in Parts(PAGE).tags]
    contents = [dict(attributes).get("content") for tag, attributes in parts.tags if tag == "meta"]
    shown = f"{title(labelled)} · calibDB"
    assert "".join(parts.texts).strip() == shown
    described = f"{facts(labelled)} A camera calibration."
    assert contents == [described, shown, described]
