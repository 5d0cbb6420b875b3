"""The OpenAPI document promises what the template routes and the functions serve."""

import pytest

from calibdb import schema
from calibsolver import Board, models
from calibsolver.board import DICTIONARIES
from infra.deploy.template import parse
from infra.web_build import openapi
from infra.web_build.site import ROOT

DOCUMENT = openapi.document()


def test_openapi_has_the_routes_of_the_template() -> None:
    described = {(m.upper(), path) for path, methods in DOCUMENT["paths"].items() for m in methods}
    template = parse(ROOT / "template.yaml")["Resources"].values()
    events = [
        event["Properties"] for each in template for event in each["Properties"].get("Events", {}).values()
    ]
    calls = [event for event in events if not event.get("Path", "").endswith(".html")]  # without pages
    routed = {(e["Method"], e["Path"]) for e in calls if e.get("Method", "ANY") != "ANY"}
    assert described == routed


def test_every_call_but_health_a_badge_and_a_new_token_asks_for_a_credential() -> None:
    open_to_all = {"/healthz", "/v1/tokens", "/badge/{key}/{file}", "/known/v1/{digest}/{size}/{zoom}/{file}"}
    schemes = DOCUMENT["components"]["securitySchemes"].keys()
    for path, methods in DOCUMENT["paths"].items():
        for method, operation in methods.items():
            wanted = {name for choice in operation.get("security", []) for name in choice}
            assert wanted <= schemes
            assert bool(wanted) == (path not in open_to_all), (method, path)
            assert bool(wanted) == ({"401", "403"} <= operation["responses"].keys()), (method, path)


def test_accepted_ranges_are_those_of_the_solver() -> None:
    assert set(schema.DISTORTION_MODELS) == set(models.NAMES)
    assert set(schema.DICTIONARIES) == set(DICTIONARIES)
    for dictionary, markers in DICTIONARIES.items():
        for squares in ((4, 4), (9, 6), (10, 7), (11, 7), (20, 20), (50, 41), (50, 50)):
            for board in (schema.Board, Board):
                if squares[0] * squares[1] // 2 <= markers:
                    board(squares=squares, dictionary=dictionary)
                else:
                    with pytest.raises(ValueError, match="markers"):
                        board(squares=squares, dictionary=dictionary)
    for squares in ((50, 20), (3, 4), (4, 3)):
        of_both = [board(squares=squares, dictionary="DICT_4X4_1000") for board in (schema.Board, Board)]
        assert of_both[0].corner_count == of_both[1].corner_count
