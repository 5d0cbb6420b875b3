"""Auth: exchanges an API token for the signed id of one guided capture."""

from starlette.responses import Response

from calibdb.http import application
from calibdb.http.application import Call, json_response, route
from calibdb.schema import SessionOpened


def open_session(call: Call) -> Response:
    """Issue a session id; only a count is stored."""
    token = call.api_token(charge="sessions")
    session_id, expires_at = call.service.session_ids.issue(call.service.ticket(token, call.origin))
    return json_response(SessionOpened(session_id=session_id, expires_at=expires_at), 201)


handler = application.handler(route("/v1/auth", POST=open_session))
