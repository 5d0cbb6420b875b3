"""Settings: their defaults, and errors that name the variable; how long a process keeps a service."""

import math
from dataclasses import asdict, fields
from pathlib import Path

import pytest

from calibdb.access.tokens import ApiToken
from calibdb.service import Service
from calibdb.settings import Settings, SettingsError, Thresholds
from calibdb.store import Store
from calibsolver.consensus import Rule
from infra.deploy.template import parse
from tests.helpers.clock import Clock

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


def test_settings_are_read_from_the_environment() -> None:
    settings = Settings.from_environment(ENVIRONMENT)
    assert settings.session_secrets == ("new", "old")
    assert settings.thresholds == Thresholds()
    assert settings.refit_function is None
    assert settings.region == "eu-central-1"


def test_every_threshold_has_its_variable() -> None:
    environment = {"MIN_CALIBRATIONS": "2", "MIN_SHARE": "0.75", "CONTRIBUTOR_PERIOD": "0", "MIN_VOTES": "7"}
    thresholds = Settings.from_environment({**ENVIRONMENT, **environment}).thresholds
    assert thresholds == Thresholds(
        min_calibrations=2, min_contributors=3, min_share=0.75, contributor_period=0, min_votes=7
    )


def test_variables_override_the_thresholds_parameter() -> None:
    environment = {"THRESHOLDS": "MIN_SHARE=0.75,MIN_CONTRIBUTORS=1", "MIN_CONTRIBUTORS": "2"}
    assert Thresholds.from_environment(environment) == Thresholds(min_share=0.75, min_contributors=2)
    assert Thresholds.from_environment({"THRESHOLDS": ""}) == Thresholds()


def test_template_passes_thresholds_without_defaults() -> None:
    document = parse(ROOT / "template.yaml")
    variables = document["Globals"]["Function"]["Environment"]["Variables"]
    assert variables["THRESHOLDS"] == {"Ref": "Thresholds"}
    assert document["Parameters"]["Thresholds"]["Default"] == ""
    assert {field.name.upper() for field in fields(Thresholds)} & variables.keys() == set()


@pytest.mark.parametrize("name", [name for name in ENVIRONMENT if name[:4] not in ("AWS_", "MIN_")])
@pytest.mark.parametrize("value", ["", None])
def test_missing_settings_are_named(name: str, value: str | None) -> None:
    environment = {k: v for k, v in ENVIRONMENT.items() if k != name} | ({name: value} if value else {})
    with pytest.raises(SettingsError, match=name):
        Settings.from_environment(environment)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("MIN_CALIBRATIONS", "0"),
        ("MIN_CALIBRATIONS", "x"),
        ("MIN_CALIBRATIONS", ""),
        ("CONTRIBUTOR_PERIOD", "-1"),
        ("MIN_SHARE", "much"),
        ("MIN_SHARE", "nan"),
        ("MAX_UNEXPLAINED", "0"),
        ("SESSION_SECRETS", ","),
        ("THRESHOLDS", "MIN_SHARE"),
        ("THRESHOLDS", "TABLE_NAME=other"),
        *(("PLAN_FACTORS", value) for value in ("page", "page=0", "page=x", "=2")),
    ],
)
def test_malformed_settings_are_refused(name: str, value: str) -> None:
    with pytest.raises(SettingsError, match=name):
        Settings.from_environment({**ENVIRONMENT, name: value})


def test_the_thresholds_are_the_same_in_settings_and_solver() -> None:
    rule = {
        **asdict(Rule()),
        "min_contributors": Thresholds().min_contributors,
    }  # which the solver cannot know
    assert rule.items() <= asdict(Thresholds()).items()


SETTINGS = Settings.from_environment(ENVIRONMENT)


def test_sessions_sort_by_their_start() -> None:
    clock = Clock(1_700_000_000.9)
    service = Service.build(SETTINGS, Store.of(SETTINGS), clock)
    token = ApiToken("dev", "")
    first = service.ticket(token, None).sid
    clock.now += 1
    assert (first[:8], len(first)) == ("6553f100", 24)
    assert service.ticket(token, None).sid > first


@pytest.mark.usefixtures("function_environment")
def test_environment_is_read_once(monkeypatch: pytest.MonkeyPatch) -> None:
    service = Service.of_process()
    monkeypatch.setenv("TABLE_NAME", "other")
    assert Service.of_process() is service
    Service.forget()
    assert Service.of_process().settings.table_name == "other"


@pytest.mark.usefixtures("function_environment")
def test_equal_secrets_read_again_are_one_service(monkeypatch: pytest.MonkeyPatch) -> None:
    current = {"SESSION_SECRETS": "a,b"}
    monkeypatch.setattr(
        "calibdb.service.with_secrets", lambda environment: ({**environment, **current}, -math.inf)
    )
    service = Service.of_process()
    assert Service.of_process() is service
    current["SESSION_SECRETS"] = "c,a"
    assert Service.of_process() is not service
    assert Service.of_process().settings.session_secrets == ("c", "a")
