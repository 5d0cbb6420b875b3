"""Names of modes as they may be stored and shown."""

import pytest

from calibdb.camera_key.label import public_mode_name


@pytest.mark.parametrize(
    "name",
    ["78°", "stabilisation on", "4K, 16:9", "Linear + Horizon", "Стабілізація", "2.7K EIS", "crop 50%"],
)
def test_settings_of_cameras_are_kept(name: str) -> None:
    assert public_mode_name(name) == name


@pytest.mark.parametrize(
    ("name", "shown"),
    [
        ("  wide \u200b angle\n", "wide angle"),
        ("Anna’s wide", "wide"),
        ("wide mail@example.org", "wide"),
        ("wide +49 170 1234567", "wide"),
        ("https://example.org/wide", ""),
        ("<script>", ""),
        ("x" * 33, ""),
        ("serial 123456", ""),
    ],
)
def test_persons_addresses_and_markup_are_not(name: str, shown: str) -> None:
    assert public_mode_name(name) == shown
