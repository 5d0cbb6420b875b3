"""Smoke test of a deployment, for its pages and pages of other origins.

It leaves nothing but one capture, which `infra.deploy.smoke_capture` removes.
"""

import json
import socket
import ssl
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from http import HTTPStatus
from urllib.parse import urlsplit

import httpx

_SMOKE_TIMEOUT_S = 29.0  # s: the first request of all starts a function
_PROPAGATION_TIMEOUT_S = 45.0  # s in which functions learn of a token that was changed
_ELSEWHERE = "https://elsewhere.example"
_PREFLIGHT = {
    "Origin": _ELSEWHERE,
    "Access-Control-Request-Method": "POST",
    "Access-Control-Request-Headers": "authorization,content-type",
}


@dataclass(frozen=True)
class Site:
    """Addresses of a deployment: the site, without slash, and the domain name of its distribution."""

    url: str
    distribution: str | None = None


Ask = Callable[..., httpx.Response]
"""Method, path, and optionally headers and body, to response."""


def make_requester(url: str, via: str | None = None) -> Ask:
    """Make a function that sends requests to `url`, which ends without slash; `via` as in `target`."""
    context = ssl.create_default_context()

    def ask(
        method: str, path: str, headers: Mapping[str, str] | None = None, body: bytes | None = None
    ) -> httpx.Response:
        address, host, extensions = target(url, via)
        sent = {**host, **(headers or {})}
        with httpx.Client(verify=context, timeout=_SMOKE_TIMEOUT_S, trust_env=False) as client:
            return client.request(
                method, f"{address}{path}", content=body, headers=sent, extensions=extensions
            )

    return ask


def target(url: str, via: str | None) -> tuple[str, dict[str, str], dict[str, str]]:
    """Return the address to connect to for a site, and headers and extensions of httpx's requests.

    It is the name `via` if the site's own does not resolve yet; certificate and Host are the site's own.
    """
    parts = urlsplit(url)
    host = parts.hostname or ""
    if parts.scheme != "https" or via is None or parts.netloc == via or _resolves(host):
        return url, {}, {}
    return f"https://{via}", {"Host": parts.netloc}, {"sni_hostname": host}


def _resolves(host: str) -> bool:
    try:
        socket.getaddrinfo(host, 443)
    except socket.gaierror:
        return False
    return True


def problems(ask: Ask, site: Site, patience_s: float = _PROPAGATION_TIMEOUT_S) -> Iterator[str]:
    """Find the problems of the deployment."""
    try:
        yield from _paths(ask)
        yield from _other_origins(ask)
        location = ask("GET", "//elsewhere.example/page").headers.get("location", "/")
        if urlsplit(location).hostname == "elsewhere.example":
            yield f"GET //elsewhere.example/page: sent to {location}"
        yield from _page(ask, site, patience_s)
    except (OSError, httpx.HTTPError) as error:
        yield f"{site.url} does not answer ({error or type(error).__name__})"
    host = urlsplit(site.url).hostname or ""
    if site.distribution is not None and host != site.distribution and not _resolves(host):
        yield (
            f"{host} does not resolve: point it to {site.distribution} (CNAME, or alias records A and AAAA), "
            "and run `make deploy` again"
        )


def unreleased(releases: Mapping[str, str], release: str) -> Iterator[str]:
    """Find the functions of a stack that do not run the release, by the release of each."""
    for function, running in sorted(releases.items()):
        if running != release:
            yield f"{function} runs the release {running or 'that has no name'}, not {release}"


def _paths(ask: Ask) -> Iterator[str]:
    for method, path, status in (
        *(("GET", path, 200) for path in ("/healthz", "/", "/calibrate/")),
        *(("GET", f"/{name}.json", 200) for name in ("openapi", "config", "shell")),
        ("GET", "/v1/lookup", 401),
        ("POST", "/v1/auth", 401),
        ("GET", "/v1/auth", 405),
    ):
        heard = ask(method, path)
        if heard.status_code != status:
            yield f"{method} {path}: {heard.status_code}, not {status}"
    page = ask("GET", "/calibrate/")
    for header in ("content-security-policy", "x-content-type-options"):
        if header not in page.headers:
            yield f"GET /calibrate/: no {header}"


def _other_origins(ask: Ask) -> Iterator[str]:
    """Ask as a browser does for a page of another origin."""
    for path in ("/v1/lookup", "/v1/session/views", "/v1/nowhere"):
        yield from preflight_problems(ask, path)
    heard = ask("GET", "/sdk/calibdb.js", {"Origin": _ELSEWHERE})
    if heard.status_code != HTTPStatus.OK or heard.headers.get("access-control-allow-origin") != "*":
        yield f"GET /sdk/calibdb.js: {heard.status_code}, and pages of other origins may not load it"


def preflight_problems(ask: Ask, path: str) -> Iterator[str]:
    """Find why a browser would refuse a page of another origin this path of the API."""
    heard = ask("OPTIONS", path, _PREFLIGHT)
    if not heard.is_success:
        yield f"OPTIONS {path}: {heard.status_code}, so that browsers refuse pages of other origins"
    for header, value in (
        ("access-control-allow-origin", "*"),
        ("access-control-allow-methods", "POST"),
        ("access-control-allow-headers", "authorization"),
    ):
        if value not in heard.headers.get(header, "").replace(" ", "").split(","):
            yield f"OPTIONS {path}: no {value} in {header}"


def _page(ask: Ask, site: Site, patience_s: float) -> Iterator[str]:
    """Send a request like the site's own pages."""
    config = ask("GET", "/config.json")
    settings = config.json() if config.status_code == HTTPStatus.OK else {}
    token = str(settings.get("token", ""))
    if not token.startswith("cdb_"):
        yield "GET /config.json: no token"
        return
    headers = {"Authorization": f"Bearer {token}", "Content-Type": "application/json", "Origin": site.url}
    end = time.monotonic() + patience_s
    opened = ask("POST", "/v1/auth", headers, b"")
    while opened.status_code == HTTPStatus.FORBIDDEN and time.monotonic() < end:
        time.sleep(5)
        opened = ask("POST", "/v1/auth", headers, b"")
    if opened.status_code != HTTPStatus.CREATED:
        yield f"POST /v1/auth with the pages' token from {site.url}: {opened.status_code}, not 201"
    camera = {"camera": "calibDB smoke test", "platform": "X11; Linux x86_64", "img_size": [1280, 720]}
    missed = ask("POST", "/v1/lookup", headers, json.dumps({**camera, "redirect": False}).encode())
    guidance = (
        str(missed.json().get("guidance_url", "")) if missed.status_code == HTTPStatus.NOT_FOUND else ""
    )
    if not guidance.startswith(f"{site.url}/"):
        yield f"POST /v1/lookup: {missed.status_code}, and the guidance is {guidance}, not on {site.url}"
