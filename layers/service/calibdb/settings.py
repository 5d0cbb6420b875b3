"""Settings of the deployment, from the environment."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from urllib.parse import urlsplit


class SettingsError(ValueError):
    """A variable is missing or invalid; the message names it."""


@dataclass(frozen=True)
class Thresholds:
    """Conditions of a reliable consensus, by environment variables of these names."""

    min_calibrations: int = 5  # in the largest group that agrees, as `min_contributors`
    min_contributors: int = 3
    min_share: float = 0.6  # of all calibrations, in this group
    max_unexplained: float = 0.004  # as of `calibsolver.consensus.Rule`
    max_calibrations: int = 200  # the newest, which are pooled
    contributor_period: int = 86_400  # s in which contributors count once for a camera; 0: all are one
    min_votes: int = 3  # of checks that confirm a consensus of fewer calibrations, or withdraw any
    min_doubt: float = 0.3333  # share of a consensus's contributors that withdraws it
    max_check_ratio: float = 2.0  # error on fresh views / expected error, up to which a consensus fits

    @classmethod
    def from_environment(cls, environment: Mapping[str, str]) -> Thresholds:
        """Read thresholds from variables, else from `THRESHOLDS`, such as `MIN_SHARE=0.7,MIN_VOTES=5`.

        Raises SettingsError.
        """
        values = {**_overrides(environment.get("THRESHOLDS", "")), **environment}
        read: dict[str, int | float] = {}
        for threshold in fields(cls):
            name = threshold.name.upper()
            if name not in values:
                continue
            if isinstance(threshold.default, int):
                read[threshold.name] = _count(values, name, 0 if name == "CONTRIBUTOR_PERIOD" else 1)
            else:
                read[threshold.name] = _positive(values, name)
        return cls(**read)  # type: ignore[arg-type]  # by the type of the default


def _overrides(text: str) -> dict[str, str]:
    names = {threshold.name.upper() for threshold in fields(Thresholds)}
    result = {}
    for part in filter(None, text.split(",")):
        name, equals, value = part.partition("=")
        if name not in names or not equals:
            raise SettingsError(f"THRESHOLDS holds {part!r}, which is not a threshold such as MIN_SHARE=0.7")
        result[name] = value
    return result


@dataclass(frozen=True)
class Settings:
    """Settings of one function."""

    table_name: str
    bucket_name: str
    session_secrets: tuple[str, ...]  # newest first: the first signs, all verify
    contributor_secret: str
    guidance_url: str  # ends with "/"
    thresholds: Thresholds
    refit_function: str | None  # of submit, lookup, checks
    region: str
    edge_secrets: tuple[str, ...] = ()  # our CloudFront sends one of them
    verify_function: str | None = None  # of `tokens`
    max_new_tokens: int = 5  # per day and source
    processor_factor: float = 1.0  # processor time of a computation here / where its limits were set
    plan_factors: tuple[tuple[str, int], ...] = ()  # multiples of what all users of a token share, by plan
    web_bucket: str | None = None  # of the public dumps

    @property
    def site_origin(self) -> str:
        """Origin of the site's own pages, "https://calibdb.example"."""
        parts = urlsplit(self.guidance_url)
        return f"{parts.scheme}://{parts.netloc}"

    @classmethod
    def from_environment(cls, environment: Mapping[str, str]) -> Settings:
        """Read `environment`; raises SettingsError."""
        secrets = tuple(s for s in _text(environment, "SESSION_SECRETS").split(",") if s)
        if not secrets:
            raise SettingsError("SESSION_SECRETS holds no secret")
        return cls(
            table_name=_text(environment, "TABLE_NAME"),
            bucket_name=_text(environment, "BUCKET_NAME"),
            session_secrets=secrets,
            contributor_secret=_text(environment, "CONTRIBUTOR_SECRET"),
            guidance_url=_text(environment, "GUIDANCE_URL"),
            thresholds=Thresholds.from_environment(environment),
            refit_function=environment.get("REFIT_FUNCTION") or None,
            region=environment.get("AWS_REGION") or environment.get("AWS_DEFAULT_REGION") or "us-east-1",
            edge_secrets=tuple(s for s in environment.get("EDGE_SECRETS", "").split(",") if s),
            verify_function=environment.get("VERIFY_FUNCTION") or None,
            max_new_tokens=_count(environment, "NEW_TOKENS", 0, "5"),
            processor_factor=_positive(environment, "PROCESSOR_FACTOR", "1"),
            plan_factors=parse_plan_factors(environment.get("PLAN_FACTORS", "")),
            web_bucket=environment.get("WEB_BUCKET_NAME") or None,
        )


def parse_plan_factors(text: str) -> tuple[tuple[str, int], ...]:
    """Parse `page=50,free=2`; raises SettingsError."""
    factors = []
    for part in filter(None, text.split(",")):
        name, _, factor = part.partition("=")
        if not name or not factor.isdecimal() or int(factor) < 1:
            raise SettingsError(
                f"PLAN_FACTORS has {part!r}, which is not a multiple of a plan such as page=50"
            )
        factors.append((name, int(factor)))
    return tuple(factors)


def _text(environment: Mapping[str, str], name: str, default: str = "") -> str:
    value = environment.get(name, default)
    if not value:
        raise SettingsError(f"{name} is not set")
    return value


def _count(environment: Mapping[str, str], name: str, least: int, default: str = "") -> int:
    text = _text(environment, name, default)
    if not text.isdecimal() or int(text) < least:
        raise SettingsError(f"{name} is not a whole number from {least} on")
    return int(text)


def _positive(environment: Mapping[str, str], name: str, default: str = "") -> float:
    try:
        number = float(_text(environment, name, default))
    except ValueError as error:
        raise SettingsError(f"{name} is not a number") from error
    if not 0 < number < float("inf"):
        raise SettingsError(f"{name} is not a positive number")
    return number
