"""Use of tokens that strangers make for themselves."""

import time

from calibdb.access.plans import MAX_MANAGEMENT_CALLS, MAX_PROOF_CALLS
from tests.helpers.clock import Clock
from tests.helpers.service import published
from tests.helpers.service.client import Client
from tests.helpers.service.strangers import SITE, ask, context, make, manage


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
