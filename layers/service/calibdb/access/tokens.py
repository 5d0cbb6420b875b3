"""Credentials: API tokens `cdb_<id>_<secret>`, of which only hashes are stored, and signed session ids."""

import hashlib
import hmac
import ipaddress
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal

from itsdangerous import BadData, TimestampSigner, URLSafeTimedSerializer

from calibdb.errors import ForbiddenError
from calibdb.schema.fields import IPV6_SOURCE
from calibdb.schema.origins import is_loopback, portless

SESSION_LIFETIME_S = 30 * 60  # a capture takes two minutes, a distracted one ten
_TOKEN = re.compile(r"(cdbm?)_([A-Za-z0-9-]{1,64})_([A-Za-z0-9_-]{1,128})")
MAX_FORMER_SECRETS = 10
"""Earlier secrets that may still open: a rotation whose response was lost is repeated."""
_MAX_SKEW_S = 300  # s by which the signer's clock may be ahead of the verifier's
_MAX_SESSION_ID_LENGTH = 1024
_SALT = "calibdb.session"


@dataclass(frozen=True)
class ApiToken:
    """Facts about an API token, never its secret: `tokens/<id>.json`. Times are unix seconds."""

    id: str
    secret_sha256: str
    origins: tuple[str, ...] = ()  # empty: any origin
    plan: str = "free"
    created: int = 0
    former_sha256: str | None = None  # of the previous secret
    former_until: int = 0  # the previous secret opens until then
    earlier: tuple[tuple[str, int], ...] = ()  # secrets before that one, newest first, with the same times
    pending: tuple[str, ...] = ()  # origins that are claimed and not proved
    management_sha256: str | None = None  # None: an operator issued the token
    name: str = ""
    expires: int | None = None  # unless it is used before
    revoked: int | None = None
    version: int = field(default=0, compare=False)  # grows by one with each change
    layout: Literal[1] = 1  # of the stored document

    @property
    def is_restricted(self) -> bool:
        """True if only pages of some origins may use the token."""
        return bool(self.origins or self.pending)

    def admits(self, origin: str | None) -> bool:
        """True if a page of `origin` may use the token.

        Without an Origin header there is no page to protect: programs send any header, and navigations none.
        An origin that ends with `:*`, or of the machine itself without a port, stands for any port.
        """
        if origin is None or not self.is_restricted or origin in self.origins:
            return True
        host = portless(origin)
        return f"{host}:*" in self.origins or (is_loopback(origin) and host in self.origins)

    def is_expired(self, now: float) -> bool:
        """True if the token was not used within its time."""
        return self.expires is not None and now >= self.expires


def parse(text: str, kind: Literal["cdb", "cdbm"] = "cdb") -> tuple[str, str] | None:
    """Split an API token, or (`cdbm`) a management token, into id and secret; None if it is not one."""
    match = _TOKEN.fullmatch(text)
    return (match[2], match[3]) if match and match[1] == kind else None


def secret_hash(secret: str) -> str:
    """SHA-256 of a secret, in hex. It has 128 random bits, so dictionaries do not help."""
    return hashlib.sha256(secret.encode()).hexdigest()


def matches(token: ApiToken, secret: str, now: float = 0.0) -> bool:
    """True if `secret` is the token's at unix time `now`, in constant time."""
    sent = secret_hash(secret)
    digests = [token.secret_sha256, *(previous for previous, until in former_secrets(token) if now < until)]
    return sum(hmac.compare_digest(one, sent) for one in digests) > 0  # compares all of them


def former_secrets(token: ApiToken) -> tuple[tuple[str, int], ...]:
    """Hashes of earlier secrets, newest first, and until when (unix time) they open."""
    if token.former_sha256 is None:
        return ()
    return ((token.former_sha256, token.former_until), *token.earlier)


def with_secret(token: ApiToken, sha256: str, now: int, grace_s: int) -> ApiToken:
    """Token with another secret; every earlier one opens for `grace_s` more at most."""
    if token.secret_sha256 == sha256:  # repeated, since the first response of storage got lost
        return token
    earlier = [(one, min(until, now + grace_s)) for one, until in former_secrets(token)]
    previous = [(token.secret_sha256, now + grace_s), *earlier]
    valid = [(one, until) for one, until in previous if until > now]
    if len(valid) > MAX_FORMER_SECRETS:  # the oldest stays: it may be the one in use
        valid = [*valid[: MAX_FORMER_SECRETS - 1], valid[-1]]
    newest, until = valid[0] if valid else (None, 0)
    return replace(
        token, secret_sha256=sha256, former_sha256=newest, former_until=until, earlier=tuple(valid[1:])
    )


_NO_HASH = secret_hash("")


def manages(token: ApiToken | None, secret: str) -> bool:
    """True if `secret` manages the token, in constant time, whether there is such a token or not."""
    digest = None if token is None else token.management_sha256
    same = hmac.compare_digest(digest or _NO_HASH, secret_hash(secret))
    return same and digest is not None


@dataclass(frozen=True)
class Ticket:
    """Claims of a session id; only the `origin` may use it."""

    sid: str
    token: str
    origin: str | None = None  # None: the token knows no allow-list


class _Signer(TimestampSigner):
    """Signer with an explicit clock, so that only handlers read the time."""

    def __init__(self, *args: Any, clock: Callable[[], float], **options: Any) -> None:
        super().__init__(*args, **options)
        self._clock = clock

    def get_timestamp(self) -> int:
        return int(self._clock())


class SessionIds:
    """Issuer and verifier of session ids; `clock`: unix seconds.

    `secrets`: newest first. The first signs, every one verifies, so that a key can be replaced while sessions
    run.
    """

    def __init__(self, secrets: Sequence[str], clock: Callable[[], float]) -> None:
        self._clock = clock
        self._serializer = URLSafeTimedSerializer(
            list(reversed(secrets)),  # itsdangerous wants the newest key last
            salt=_SALT,
            signer=_Signer,
            signer_kwargs={"clock": clock, "digest_method": hashlib.sha256, "key_derivation": "hmac"},
        )

    def issue(self, ticket: Ticket) -> tuple[str, int]:
        """Session id of `ticket` and the unix time at which it expires."""
        content = {"s": ticket.sid, "t": ticket.token}
        if ticket.origin is not None:
            content["o"] = ticket.origin
        signed = self._serializer.dumps(content)
        expires_at = int(self._clock()) + SESSION_LIFETIME_S
        return (signed if isinstance(signed, str) else signed.decode()), expires_at

    def sid_of(self, session_id: str) -> str | None:
        """Session of a session id, expired or not; None of a forged one."""
        try:
            return str(self._load(session_id)[0]["s"])
        except BadData:
            return None

    def verify(self, session_id: str, origin: str | None) -> Ticket:
        """Claims of a session id; raises ForbiddenError if it is forged, expired or foreign."""
        try:
            content, signed = self._load(session_id)
        except BadData as error:
            raise ForbiddenError("The session id is not valid.") from error
        if not -_MAX_SKEW_S <= int(self._clock()) - signed.timestamp() <= SESSION_LIFETIME_S:
            raise ForbiddenError("The session id has expired; start a new session.", kind="session-expired")
        ticket = Ticket(content["s"], content["t"], content.get("o"))
        if ticket.origin is not None and origin is not None and origin != ticket.origin:
            raise ForbiddenError("The session was opened by a page of another origin.", kind="origin")
        return ticket

    def _load(self, session_id: str) -> Any:
        """Content and time of a session id; raises BadData."""
        return self._serializer.loads(session_id[:_MAX_SESSION_ID_LENGTH], return_timestamp=True)


def contributor(secret: str, address: str, token_id: str) -> str:
    """Keyed hash of a contributor: address and token.

    Only the first 64 bits of an IPv6 address count: a household chooses the rest (RFC 4291, 2.5.4).
    """
    return _keyed_hash(secret, f"{_site(address)}\n{token_id}")


def source(secret: str, address: str) -> str:
    """Keyed hash of where a contributor is, by which they are counted: anyone can create tokens.

    Only the first 48 bits of an IPv6 address count, the most that one site is given (RFC 6177, 2). The hash
    of an IPv6 site begins with `IPV6_SOURCE`: one line often has an address of either family, and must not
    count twice (`calibdb.rules.votes.count_lines`).
    """
    site = _site(address, 48)
    return (IPV6_SOURCE if ":" in site else "") + _keyed_hash(secret, f"source\n{site}")


def network(secret: str, address: str, token_id: str) -> str | None:
    """Keyed hash of an IPv6 line, the first 48 bits, and a token; None of an IPv4 address.

    A home commonly has 56 bits, which are 256 contributors.
    """
    if ":" not in (line := _site(address, 48)):
        return None
    return _keyed_hash(secret, f"network\n{line}\n{token_id}")


def _keyed_hash(secret: str, text: str) -> str:
    return hmac.new(secret.encode(), text.encode(), hashlib.sha256).hexdigest()


def _site(address: str, bits: int = 64) -> str:
    try:
        parsed = ipaddress.ip_address(address)
    except ValueError:
        return address
    if isinstance(parsed, ipaddress.IPv4Address):
        return str(parsed)
    if parsed.ipv4_mapped is not None:
        return str(parsed.ipv4_mapped)
    return str(ipaddress.ip_network((int(parsed), bits), strict=False))


def with_origins(token: ApiToken, origins: tuple[str, ...]) -> ApiToken:
    """Token with these origins; those of the machine itself need no proof."""
    verified = tuple(o for o in origins if is_loopback(o) or o in token.origins)
    pending = tuple(o for o in origins if o not in verified)
    return _with_plan(replace(token, origins=verified, pending=pending))


def with_proved(token: ApiToken, proved: set[str]) -> ApiToken:
    """Token with the pending origins that were proved as verified."""
    now_verified = tuple(origin for origin in token.pending if origin in proved)
    left = tuple(origin for origin in token.pending if origin not in proved)
    return _with_plan(replace(token, origins=(*token.origins, *now_verified), pending=left))


def _with_plan(token: ApiToken) -> ApiToken:
    if token.plan not in ("trial", "free"):  # given by the operator
        return token
    proved = any(not is_loopback(origin) for origin in token.origins)
    return replace(token, plan="free", expires=None) if proved else replace(token, plan="trial")
