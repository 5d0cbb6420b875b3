"""Sessions as the solver's values."""

from calibdb.compute.session_course import Session
from calibdb.rules import session_rules
from calibdb.schema.documents import ViewDocument
from calibdb.schema.membership import RigMembership
from calibdb.schema.session import SessionRequest, SetAside
from calibsolver.guidance import PoseSelection


def test_session_has_the_guidance_and_the_exclusions_of_its_document() -> None:
    request = SessionRequest(
        camera="Camera", platform="linux", img_size=(640, 480), guidance="pose-selection"
    )
    reasons = (None, SetAside(reason="outlier", detail="It is."))
    views = tuple(
        ViewDocument(index=n, ids=(0,), points=((1.0, 2.0),), set_aside=reason)
        for n, reason in enumerate(reasons)
    )
    document = session_rules.begin(request, "0" * 32, 1, 0)
    session = Session.of(document.model_copy(update={"views": views}))
    assert isinstance(session.rules.guide, PoseSelection)
    assert not session.rules.recorded
    assert {i: each.reason for i, each in session.excluded.items()} == {1: "outlier"}
    assert len(session.views) == 2
    rig = session_rules.begin(request, "0" * 32, 1, 0, rig=RigMembership(id="1" * 32, position=0))
    assert Session.of(rig).rules.recorded, "a rig ends its captures"
