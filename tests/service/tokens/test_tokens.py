"""Tokens that strangers make for themselves, and their use."""

import time

import pytest

from calibdb.access.plans import MAX_MANAGEMENT_CALLS, MAX_PROOF_CALLS, TRIAL_PERIOD_S
from infra.ops import tokens
from infra.ops.reindex import reindex
from infra.server.server import Server
from tests.helpers.clock import Clock
from tests.helpers.service import published
from tests.helpers.service.client import Client
from tests.helpers.service.strangers import SITE, ask, context, make, manage, rotate, standing_clock, states


def test_loopback_origins_are_verified_at_once(client: Client) -> None:
    made = make(client, "http://localhost", "http://127.0.0.1:8000", "http://[::1]", "https://app.localhost")
    assert {origin["state"] for origin in made["origins"]} == {"verified"}
    assert made["plan"] == "trial"
    assert ask(client, made["token"], "http://localhost:5173").status == 200
    assert ask(client, made["token"], "https://localhost").problem == (403, "origin")


@pytest.mark.parametrize("origin", ["http://example.org", "http://localhost:80", "http://LOCALHOST", "*", ""])
def test_origin_that_cannot_be_proved_is_refused_and_not_counted(client: Client, origin: str) -> None:
    for _ in range(6):
        assert client.call("POST", "/v1/tokens", {"origins": [origin]}).fields == ["origins.0"]
    make(client)


@pytest.mark.parametrize(
    ("kind", "origin", "status"),
    [
        ("application/json", "https://evil.example", 403),
        ("application/json", "null", 403),
        ("application/json", "http://127.0.0.1.evil.example", 403),
        ("application/x-www-form-urlencoded", "http://localhost:8000", 415),
        ("", None, 415),
    ],
)
def test_token_for_a_page_of_another_origin_is_refused_and_not_counted(
    client: Client, kind: str, origin: str | None, status: int
) -> None:
    headers = {"content-type": kind} | ({} if origin is None else {"origin": origin})
    body = b'{"origins": ["http://localhost"]}'
    for _ in range(6):
        assert client.call("POST", "/v1/tokens", body, headers=headers).status == status
    own = {"content-type": "application/json; charset=utf-8", "origin": "http://localhost:5173"}
    for n in range(6):
        made = client.call("POST", "/v1/tokens", body, headers=own if n else None)
        assert made.status == (201 if n < 5 else 429)


def test_origin_is_admitted_once_its_proof_is_found(client: Client, site: dict[str, str]) -> None:
    made = make(client, "http://localhost", SITE)
    (pending,) = [origin for origin in made["origins"] if origin["state"] == "pending"]
    assert pending["proof"] == {
        "url": "https://example.org/.well-known/calibdb.txt",
        "content": f"calibdb-site-verification={made['id']}",
    }
    refused = ask(client, made["token"], SITE)
    assert refused.problem == (403, "origin-unverified")
    looked = manage(client, "POST", made, "/verify")
    assert states(looked) == {"http://localhost": "verified", SITE: "pending"}
    assert looked.json["origins"][1]["failure"] == "status"
    for wrong in ("", made["id"], f"calibdb-site-verification={made['id']}0", "calibdb-site-verification="):
        site["example.org"] = wrong
        assert manage(client, "POST", made, "/verify").json["origins"][1]["failure"] == "content"
    assert manage(client, "GET", made).json["plan"] == "trial"
    site["example.org"] = f"calibdb-site-verification=another\r\n {pending['proof']['content']} \r\n"
    looked = manage(client, "POST", made, "/verify")
    assert states(looked) == {"http://localhost": "verified", SITE: "verified"}
    assert (looked.json["plan"], looked.json["expires"]) == ("free", None)
    assert ask(client, made["token"], SITE).status == 200
    site.clear()  # again is answered by how it is
    assert states(manage(client, "POST", made, "/verify"))[SITE] == "verified"
    assert ask(client, made["token"], "https://www.example.org").status == 403


def test_origins_and_name_can_be_changed_and_proofs_are_kept(client: Client, site: dict[str, str]) -> None:
    made = make(client, SITE, name="One")
    site["example.org"] = f"calibdb-site-verification={made['id']}"
    manage(client, "POST", made, "/verify")
    changed = manage(client, "PATCH", made, body={"origins": [SITE, "https://other.example"], "name": "Two"})
    assert states(changed) == {SITE: "verified", "https://other.example": "pending"}
    assert (changed.json["name"], changed.json["plan"]) == ("Two", "free")
    assert manage(client, "PATCH", made, body={"origins": []}).status == 422
    left = manage(client, "PATCH", made, body={"origins": ["http://localhost"]})
    assert (states(left), left.json["plan"]) == ({"http://localhost": "verified"}, "trial")
    assert left.json["name"] == "Two"
    back = manage(client, "PATCH", made, body={"origins": [SITE]})
    assert states(back) == {SITE: "pending"}  # it has to be proved anew


def test_nobody_learns_whether_an_origin_has_a_token(client: Client, site: dict[str, str]) -> None:
    other = Client(client.stack, address="198.18.7.7")
    first = make(client, SITE)
    site["example.org"] = f"calibdb-site-verification={first['id']}"
    assert states(manage(client, "POST", first, "/verify")) == {SITE: "verified"}
    second, unclaimed = make(other, SITE), make(other, "https://unclaimed.example")
    hidden = {"id", "token", "management_token", "origins", "created", "expires"}
    shown = [{k: v for k, v in token.items() if k not in hidden} for token in (second, unclaimed)]
    assert shown[0] == shown[1]
    looked = manage(other, "POST", second, "/verify")
    assert looked.json["origins"][0]["failure"] == "content"  # the file's, which all can read, not ours
    refused = ask(other, unclaimed["token"], "https://unclaimed.example")
    assert ask(other, second["token"], SITE).json == refused.json


def statuses(client: Client, *tokens: str) -> list[int]:
    return [ask(client, token).status for token in tokens]


def test_secret_is_rotated_and_earlier_ones_keep_their_time(client: Client, clock: Clock) -> None:
    made = make(client)
    # The first answer gets lost: whoever asks again has the old secret and the newest.
    lost = rotate(client, made)["token"]
    newest = rotate(client, made, grace_s=3600)
    assert newest["former_until"] == pytest.approx(clock() + 3600, abs=5)
    assert statuses(client, made["token"], lost, newest["token"]) == [200] * 3
    clock.now += 3700
    assert statuses(client, made["token"], lost, newest["token"]) == [403, 403, 200]
    last = rotate(client, made, grace_s=0)
    assert last["former_until"] is None
    assert statuses(client, newest["token"], last["token"]) == [403, 200]
    assert manage(client, "POST", made, "/rotate", body={"grace_s": 10**9}).status == 422


def test_new_secret_works_in_the_next_request_where_the_token_is_remembered(stack: Server) -> None:
    """Functions remember a token for half a minute; three seconds pass here."""
    with standing_clock() as clock:
        client = Client(stack, address="198.51.100.77")
        made = make(client)
        assert ask(client, made["token"]).status == 200
        secret = made["token"]
        for _ in range(3):
            rotated = rotate(client, made, grace_s=0)["token"]
            assert statuses(client, rotated, secret) == [200, 403]
            secret = rotated
            clock.now += 1  # for which the wrong one keeps the token from being read again


def test_five_rotations_within_their_grace_leave_every_secret_valid(client: Client) -> None:
    made = make(client)
    rotated = [rotate(client, made, grace_s=3600) for _ in range(10)]
    secrets = [made["token"], *(answer["token"] for answer in rotated)]
    assert statuses(client, *secrets) == [200] * 11
    manage(client, "POST", made, "/rotate", body={"grace_s": 3600})
    assert statuses(client, *secrets) == [200, 403] + [200] * 9


def test_revoked_token_opens_nothing_and_says_so_to_its_owner(client: Client) -> None:
    made = make(client)
    assert ask(client, made["token"]).status == 200
    assert [manage(client, "DELETE", made).status for _ in range(2)] == [204, 204]
    assert ask(client, made["token"]).status == 403
    for method, action in (("GET", ""), ("POST", "/rotate"), ("POST", "/verify")):
        answer = manage(client, method, made, action)
        assert answer.problem == (403, "token-revoked")
    reindex(context(client.stack))
    assert ask(client, made["token"]).status == 403


def test_trial_token_that_was_never_used_expires(client: Client, clock: Clock) -> None:
    unused, used = make(client), make(client)
    assert unused["expires"] == pytest.approx(clock() + TRIAL_PERIOD_S, abs=5)
    assert client.call("POST", "/v1/auth", token=unused["token"][:-1] + "x").status == 403, "that is no use"
    assert client.call("POST", "/v1/auth", token=used["token"]).status == 201
    clock.now += TRIAL_PERIOD_S + 60
    answer = ask(client, unused["token"])
    assert answer.problem == (403, "token-expired")
    assert manage(client, "GET", unused).status == 403
    assert ask(client, used["token"]).status == 200
    assert manage(client, "GET", used).json["expires"] is None


def test_management_token_is_not_an_api_token_nor_the_other_way_round(client: Client) -> None:
    made = make(client)
    assert ask(client, made["management_token"]).status == 403
    id_, secret = made["management_token"].split("_")[1:]
    unknown = f"cdbm_{'0' * len(id_)}_{secret}"
    wrong = f"cdbm_{id_}_{'0' * len(secret)}"
    answers = [
        client.call("GET", "/v1/tokens/self", token=sent)
        for sent in (made["token"], unknown, wrong, f"cdbm_{id_}_{made['token'].split('_')[2]}", "cdbm__")
    ]
    assert {(a.status, a.body) for a in answers} == {(403, answers[0].body)}
    assert client.call("GET", "/v1/tokens/self", token="").status == 401
    assert secret not in repr(published.store(client.stack).tokens.read(id_))


def test_use_is_shown_by_hour_and_day(client: Client, clock: Clock) -> None:
    made = make(client)
    for _ in range(3):
        ask(client, made["token"])
    client.call("POST", "/v1/auth", token=made["token"])
    now = time.gmtime(clock())
    use = manage(client, "GET", made).json["use"]
    assert (len(use["hours"]), len(use["days"])) == (48, 30)
    counted = {"sessions": 1, "views": 0, "poses": 0, "lookups": 3}
    assert use["hours"][-1] == {**counted, "hour": time.strftime("%Y-%m-%dT%H", now)}
    assert use["days"][-1] == {**counted, "day": time.strftime("%Y-%m-%d", now)}
    assert tokens.use(context(client.stack), made["id"]).days[-1].lookups == 3
    clock.now += 3 * 86_400
    ask(client, made["token"])
    use = manage(client, "GET", made).json["use"]
    assert [day["lookups"] for day in use["days"]][-4:] == [3, 0, 0, 1]
    assert sum(hour["lookups"] for hour in use["hours"]) == 1


def test_limits_are_told_in_headers_and_by_the_usage_call(client: Client, clock: Clock) -> None:
    made = make(client)
    for left in ("r=599", "r=598", "r=597"):
        headers = ask(client, made["token"]).headers
        assert headers["ratelimit-policy"] == '"lookups-each";q=600;w=3600, "lookups";q=600;w=3600'
        assert headers["ratelimit"].split(";")[1] == left
    opened = client.call("POST", "/v1/auth", token=made["token"])
    assert opened.headers["ratelimit"].startswith('"sessions-each";r=19;t=')
    usage = client.call("GET", "/v1/usage", token=made["token"])
    assert usage.json["plan"] == "trial"
    assert usage.json["limits"] == made["limits"]
    assert usage.json["used"] == {"sessions": 1, "views": 0, "poses": 0, "lookups": 4}
    assert 0 < usage.json["resets_at"] - clock() <= 3600
    assert "ratelimit" not in client.call("GET", "/healthz").headers


def test_five_tokens_a_day_and_source(client: Client, clock: Clock) -> None:
    line = [Client(client.stack, address=f"2001:db8:7:{n:x}::1") for n in range(6)]
    for one in line[:5]:
        make(one)
    refused = line[5].call("POST", "/v1/tokens", {"origins": [SITE]})
    assert refused.status == 429
    assert 1 <= int(refused.headers["retry-after"]) <= 86_400
    assert "5 new tokens a day" in refused.json["detail"]
    make(client)
    clock.now += 86_400
    make(line[5])
    issued = dict(context(client.stack).store.quotas.issued())
    assert issued[time.strftime("%Y-%m-%d", time.gmtime(clock()))] >= 1


def test_management_is_bounded(client: Client, clock: Clock, site: dict[str, str]) -> None:
    made = make(client, SITE)
    assert not site
    statuses = [manage(client, "POST", made, "/verify").status for _ in range(MAX_PROOF_CALLS + 1)]
    assert statuses == [200] * MAX_PROOF_CALLS + [429]
    used = MAX_MANAGEMENT_CALLS - len(statuses) - 2
    published.store(client.stack).quotas.add(made["id"], "management", int(clock()), used)
    others = [manage(client, "PATCH", made, body={"name": "x"}).status for _ in range(4)]
    assert others == [200, 200, 429, 429]
    assert ask(client, made["token"]).status == 200
