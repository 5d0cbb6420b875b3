"""Settings name the variable that is wrong, at the first call and not at the hundredth."""

from dataclasses import asdict
from pathlib import Path

import pytest

from calibdb.settings import Settings, SettingsError, Thresholds
from calibsolver.consensus import Rule
from infra.local.intrinsics import parse

ROOT = Path(__file__).parents[3]

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
    assert settings.thresholds == Thresholds()
    assert settings.refit_function is None
    assert settings.region == "eu-central-1"
    assert settings == Settings.from_environment(dict(ENVIRONMENT))


def test_every_threshold_has_its_variable() -> None:
    environment = {"MIN_CALIBRATIONS": "2", "MIN_SHARE": "0.75", "CONTRIBUTOR_PERIOD": "0", "MIN_VOTES": "7"}
    thresholds = Settings.from_environment({**ENVIRONMENT, **environment}).thresholds
    assert thresholds == Thresholds(
        min_calibrations=2, min_contributors=3, min_share=0.75, contributor_period=0, min_votes=7
    )


@pytest.mark.parametrize("name", [name for name in ENVIRONMENT if name[:4] not in ("AWS_", "MIN_")])
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
        ("MIN_CALIBRATIONS", ""),
        ("CONTRIBUTOR_PERIOD", "-1"),
        ("MIN_SHARE", "much"),
        ("MIN_SHARE", "nan"),
        ("MAX_FOCAL_SPREAD", "0"),
        ("SESSION_SECRETS", ","),
    ],
)
def test_nonsense(name: str, value: str) -> None:
    with pytest.raises(SettingsError, match=name):
        Settings.from_environment({**ENVIRONMENT, name: value})


def test_the_thresholds_are_the_same_in_settings_template_and_solver() -> None:
    """Three places, for three rooms that do not know each other."""
    thresholds = asdict(Thresholds())
    document = parse(ROOT / "template.yaml")
    variables = document["Globals"]["Function"]["Environment"]["Variables"]
    for name, value in thresholds.items():
        parameter = document["Parameters"][variables[name.upper()]["Ref"]]
        assert parameter["Default"] == value, name
    rule = asdict(Rule())
    assert rule.keys() <= thresholds.keys()
    # How many contributors there must be, the solver cannot know: on one's own machine there is only one.
    assert {n: thresholds[n] for n in rule if n != "min_contributors"} == {
        n: value for n, value in rule.items() if n != "min_contributors"
    }
