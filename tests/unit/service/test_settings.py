"""Settings name the variable that is wrong, at the first call and not at the hundredth."""

import pytest

from calibdb.settings import Settings, SettingsError

ENVIRONMENT = {
    "TABLE_NAME": "table",
    "BUCKET_NAME": "bucket",
    "SESSION_SECRETS": "new,old",
    "CONTRIBUTOR_SECRET": "secret",
    "GUIDANCE_URL": "https://calibdb.example/calibrate/",
    "MIN_CALIBRATIONS": "5",
    "MIN_CONTRIBUTORS": "3",
    "AWS_REGION": "eu-central-1",
}


def test_read() -> None:
    settings = Settings.from_environment(ENVIRONMENT)
    assert settings.session_secrets == ("new", "old")
    assert (settings.min_calibrations, settings.min_contributors) == (5, 3)
    assert settings.refit_function is None
    assert settings.region == "eu-central-1"
    assert settings == Settings.from_environment(dict(ENVIRONMENT))


@pytest.mark.parametrize("name", [name for name in ENVIRONMENT if name != "AWS_REGION"])
@pytest.mark.parametrize("value", ["", None])
def test_missing(name: str, value: str | None) -> None:
    environment = {k: v for k, v in ENVIRONMENT.items() if k != name} | ({name: value} if value else {})
    with pytest.raises(SettingsError, match=name):
        Settings.from_environment(environment)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("MIN_CALIBRATIONS", "0"),
        ("MIN_CONTRIBUTORS", "-1"),
        ("MIN_CALIBRATIONS", "x"),
        ("SESSION_SECRETS", ","),
    ],
)
def test_nonsense(name: str, value: str) -> None:
    with pytest.raises(SettingsError, match=name):
        Settings.from_environment({**ENVIRONMENT, name: value})
