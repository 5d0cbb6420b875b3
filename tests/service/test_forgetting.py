"""A contributor who wants to be forgotten."""

import json

from calibdb.schema import DISTORTION_MODELS
from calibdb.store.keys import vote_object
from infra.ops import withdrawal
from infra.server.server import Server
from tests.helpers.service import published
from tests.helpers.service.client import BRIEF, Client, Truth, until
from tests.helpers.service.commands import Operator
from tests.helpers.service.published import PLATFORM, calibration, publish, store, views
from tests.helpers.service.strangers import context, standing_clock


def stored(stack: Server) -> tuple[set[str], set[tuple[str, str]]]:
    names = {name for name in stack.storage.objects.names("") if not name.startswith("tokens/")}
    return names, set(stack.storage.table.keys(""))


def test_forgetting_covers_revoked_tokens(operator: Operator) -> None:
    """A calibration, a vote on another's camera, a capture that is under way, and the hour's counters."""
    token = operator("token", "create", "--plan", "free").strip()
    others = calibration("Another's camera Z77", 0)
    with standing_clock(), Server(operator.folder) as stack:  # uses are counted by the hour
        publish(stack, others, models=DISTORTION_MODELS)
        before = stored(stack)
        client = Client(stack, api_token=token)
        Truth().calibrate(client, **BRIEF)
        until(lambda: client.lookup(redirect=False).json["reason"] == "too_few")
        assert client.open(camera="Never finished").status == 201
        assert client.view(client.pose().json["index"], *Truth().see(client.pose().json)).json["accepted"]
        answer = client.check(views(Truth(seed=1)), camera=others.camera)
        assert (answer.json["counted"], answer.json["votes"]["agree"]) == (True, 1)
    operator("token", "revoke", token.split("_")[1])
    with Server(operator.folder) as stack:
        assert sum(sk.startswith("SHARE#") and sk.count("#") == 2 for _, sk in stored(stack)[1]) == 1
    removed = operator("contributor", "forget", "--address", "127.0.0.1")
    assert "removed 1 calibrations, 2 sessions, 1 votes" in removed
    with Server(operator.folder) as stack:
        names, items = stored(stack)
        assert names == before[0]
        # Of the token, which is revoked, it is still known how much all its users used together.
        of_token = f"TOKEN#{token.split('_')[1]}"
        assert before[1] <= items
        assert not store(stack).tokens.get(of_token.removeprefix("TOKEN#"))
        more = {key for key in items - before[1] if not key[0].startswith("REFIT#")}
        assert {(pk, sk.count("#")) for pk, sk in more} == {(of_token, 1)}
        left = published.stored(store(stack), others, "fisheye")
        assert (left.total, left.votes.agree) == (1, 0)


def test_forgotten_vote_under_an_earlier_key_recomputes_the_consensus() -> None:
    document = calibration("Voted on Z77", 0)
    earlier = f"c1-{document.camera_key[3:]}"
    with Server() as stack:
        publish(stack, document)
        voted = Client(stack).check(views(Truth(seed=1)), camera=document.camera, platform=PLATFORM)
        assert voted.json["votes"]["agree"] == 1
        (vote,) = store(stack).votes.all()
        operator = context(stack)
        operator.objects.purge_all_versions([vote_object(vote.camera_key, vote.id)])
        store(stack).votes.cast(vote.model_copy(update={"camera_key": earlier}))
        assert withdrawal.forget(operator, {vote.contributor}).votes == 1
        left = published.stored(store(stack), document)
        assert (left.total, left.votes.agree) == (1, 0)


def test_receipt_of_the_browser_forgets_the_contributor(operator: Operator) -> None:
    with Server(operator.folder) as stack:
        client = Client(stack)
        mine = Truth().calibrate(client, **BRIEF)["calibration_id"]
        receipt = client.session_id
        others = calibration("Another's camera Z77", 0)
        store(stack).calibrations.publish(others)
        assert receipt not in json.dumps(client.calibration(mine).json)
    for wrong in (receipt[:-2] + "xx", mine):
        complaint = operator("contributor", "forget", "--receipt", wrong, status=1)
        assert "no key of SESSION_SECRETS has signed" in complaint
    removed = operator("contributor", "forget", "--receipt", receipt)
    assert "removed 1 calibrations, 1 sessions, 0 votes" in removed
    operator("contributor", "forget", "--receipt", receipt, status=1)
    with Server(operator.folder) as stack:
        assert [one.id for one in store(stack).calibrations.all()] == [others.id]
