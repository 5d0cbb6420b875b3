"""Plans: multiples of what all users of a token share."""

import pytest

from calibdb.access.plans import KINDS, PLANS, multiplied
from calibdb.service import Service
from calibdb.settings import Settings, SettingsError
from tests.unit.service.access.test_token_cache import ENVIRONMENT


def test_factor_multiplies_what_users_share_and_not_what_each_has() -> None:
    plans = multiplied([("page", 50)])
    assert plans["page"].each == PLANS["page"].each
    for kind in KINDS:
        assert getattr(plans["page"].together, kind) == 50 * getattr(PLANS["page"].together, kind)
    assert plans | {"page": PLANS["page"]} == PLANS


def test_plan_of_one_user_grows_with_its_token_s() -> None:
    partner = multiplied([("partner", 2)])["partner"]
    assert partner.each == partner.together
    assert partner.together.sessions == 10_000
    assert multiplied([("development", 3)])["development"] == PLANS["development"]


def test_environment_names_factors() -> None:
    settings = Settings.from_environment({**ENVIRONMENT, "PLAN_FACTORS": "page=50,free=2"})
    assert settings.plan_factors == (("page", 50), ("free", 2))
    assert Service.make(settings)._plans["page"].together.sessions == 50_000


@pytest.mark.parametrize("text", ["page", "page=0", "page=x", "=2"])
def test_wrong_factor_is_refused(text: str) -> None:
    with pytest.raises(SettingsError, match="PLAN_FACTORS has"):
        Settings.from_environment({**ENVIRONMENT, "PLAN_FACTORS": text})


def test_factor_of_no_plan_is_refused() -> None:
    with pytest.raises(ValueError, match="there is no plan pages"):
        multiplied([("pages", 2)])
