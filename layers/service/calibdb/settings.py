"""What the deployment decides, read from the environment that the template sets."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


class SettingsError(ValueError):
    """The environment lacks a variable or holds nonsense; the message names the variable."""


@dataclass(frozen=True)
class Settings:
    """Settings of one function; equal environments give equal settings."""

    table_name: str
    bucket_name: str
    session_secrets: tuple[str, ...]  # newest first: the first signs, all verify
    contributor_secret: str
    guidance_url: str  # ends with "/"
    min_calibrations: int
    min_contributors: int
    refit_function: str | None  # set where `refit` is asked: submit and lookup
    region: str

    @classmethod
    def from_environment(cls, environment: Mapping[str, str]) -> Settings:
        """Read `environment`; raises SettingsError naming the variable that is missing or wrong."""
        secrets = tuple(s for s in _text(environment, "SESSION_SECRETS").split(",") if s)
        if not secrets:
            raise SettingsError("SESSION_SECRETS holds no secret")
        return cls(
            table_name=_text(environment, "TABLE_NAME"),
            bucket_name=_text(environment, "BUCKET_NAME"),
            session_secrets=secrets,
            contributor_secret=_text(environment, "CONTRIBUTOR_SECRET"),
            guidance_url=_text(environment, "GUIDANCE_URL"),
            min_calibrations=_count(environment, "MIN_CALIBRATIONS"),
            min_contributors=_count(environment, "MIN_CONTRIBUTORS"),
            refit_function=environment.get("REFIT_FUNCTION") or None,
            region=environment.get("AWS_REGION") or environment.get("AWS_DEFAULT_REGION") or "us-east-1",
        )


def _text(environment: Mapping[str, str], name: str) -> str:
    value = environment.get(name, "")
    if not value:
        raise SettingsError(f"{name} is not set")
    return value


def _count(environment: Mapping[str, str], name: str) -> int:
    text = _text(environment, name)
    if not text.isdecimal() or int(text) < 1:
        raise SettingsError(f"{name} is not a positive whole number")
    return int(text)
