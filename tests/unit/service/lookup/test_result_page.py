"""Head of a result's page: what messengers show, and that a label stays text."""

from html import escape

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
