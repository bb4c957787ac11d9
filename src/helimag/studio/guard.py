"""Who may speak to the server: the right host, the right origin, the right token, and nothing too large.

A web page elsewhere can make a browser send requests to this machine (another origin's websocket), or reach it under a
name of its own (DNS rebinding). So requests must name this server as their host, and what changes anything must come
from a page of this server. Where the server listens to other machines, whoever comes must have been given the token.
"""

import hmac
from collections.abc import Awaitable, Callable, Iterable, MutableMapping
from dataclasses import dataclass
from http.cookies import CookieError, SimpleCookie
from typing import Any
from urllib.parse import parse_qs, quote, urlsplit

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

COOKIE = "helimag-studio"
MOST_BYTES = 24 * 2**20  # of a request; a stored half-hour run is under one megabyte
LONGEST_ADDRESS = 32 * 2**10
LOOPBACK = ("localhost", "127.0.0.1", "[::1]")
SAFE = ("GET", "HEAD", "OPTIONS")

# all that the page needs comes from here; and no other page may frame it
HEADERS = (
    (
        b"content-security-policy",
        b"default-src 'self'; script-src 'self' 'unsafe-inline' 'unsafe-eval'; style-src 'self' 'unsafe-inline'; "
        b"img-src 'self' data: blob:; media-src 'self' blob:; font-src 'self' data:; "
        b"connect-src 'self' blob:; "
        b"frame-ancestors 'none'; form-action 'self'; base-uri 'none'; object-src 'none'",
    ),
    (b"x-content-type-options", b"nosniff"),
    (b"referrer-policy", b"no-referrer"),
    (b"cross-origin-resource-policy", b"same-origin"),
)


@dataclass(frozen=True)
class Rules:
    """What is asked of a request.

    Attributes
    ----------
    hosts
        Names, with port, by which this server may be called; None allows any, where a token guards it.
    token
        That whoever comes must show, once in the address and then as a cookie; None asks for none.
    """

    hosts: tuple[str, ...] | None
    token: str | None = None


def rules_for(host: str, port: int, token: str | None) -> Rules:
    """Of a server at an address: loopback names where it is one, any name with a token elsewhere."""
    if is_loopback(host):
        return Rules(tuple(f"{name}:{port}" for name in LOOPBACK), None)
    return Rules(None, token)


def is_loopback(host: str) -> bool:
    """Whether only this machine can reach a server that listens there."""
    return host in {"localhost", "::1"} or host.startswith("127.")


class Refusal(Exception):
    """A request that is not answered: status and why."""

    def __init__(self, status: int, why: str) -> None:
        super().__init__(why)
        self.status, self.why = status, why


class Guard:
    """The outermost layer of the server: lets through what the rules allow."""

    def __init__(self, app: App, rules: Rules) -> None:
        self._app, self._rules = app, rules

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer, refuse, or pass on."""
        if scope["type"] not in {"http", "websocket"}:
            await self._app(scope, receive, send)
            return
        try:
            welcome = self._check(scope)
        except Refusal as refusal:
            await _refuse(scope, receive, send, refusal)
            return
        if welcome:
            await _redirect(send, scope["path"], str(self._rules.token))
            return
        await self._app(scope, _limited(receive), _marked(send))

    def _check(self, scope: Scope) -> bool:
        """Raise Refusal where a request is not allowed; tell whether it brings the token in its address."""
        headers = _headers(scope)
        if any([name for name, _ in scope["headers"]].count(name) > 1 for name in (b"host", b"origin")):
            raise Refusal(400, "a request has one host and one origin")
        host = headers.get("host", "")
        if self._rules.hosts is not None and host not in self._rules.hosts:
            raise Refusal(421, "this server does not go by that name")
        raw = len(scope.get("query_string", b"")) + len(scope.get("raw_path") or scope["path"].encode())
        if raw > LONGEST_ADDRESS:
            raise Refusal(414, "the address is too long")
        if int(_digits(headers.get("content-length", "0"))) > MOST_BYTES:
            raise Refusal(413, f"a request may have {MOST_BYTES // 2**20} MB at most")
        origin = headers.get("origin")
        changes = scope["type"] == "websocket" or scope.get("method") not in SAFE
        if (origin is not None and urlsplit(origin).netloc != host) or (origin is None and changes):
            raise Refusal(403, "requests from other pages are not answered")
        return self._token(scope, headers)

    def _token(self, scope: Scope, headers: dict[str, str]) -> bool:
        token = self._rules.token
        if token is None:
            return False
        try:
            jar = SimpleCookie(headers.get("cookie", ""))
        except CookieError:
            jar = SimpleCookie()
        if COOKIE in jar and hmac.compare_digest(jar[COOKIE].value.encode(), token.encode()):
            return False
        given = parse_qs(scope.get("query_string", b"").decode("latin-1")).get("token", [""])[0]
        if scope["type"] == "http" and hmac.compare_digest(given.encode(), token.encode()):
            return True
        raise Refusal(401, "this server wants its token: open the address that 'helimag studio' printed")


def _digits(text: str) -> str:
    if not text.isdecimal() or len(text) > 18:
        raise Refusal(400, "the content-length is no number")
    return text


def _headers(scope: Scope) -> dict[str, str]:
    pairs: Iterable[tuple[bytes, bytes]] = scope["headers"]
    return {name.decode("latin-1").lower(): value.decode("latin-1") for name, value in pairs}


async def _refuse(scope: Scope, receive: Receive, send: Send, refusal: Refusal) -> None:
    if scope["type"] == "websocket":
        await receive()
        await send({"type": "websocket.close", "code": 1008, "reason": refusal.why})
        return
    body = f"helimag studio: {refusal.why}\n".encode()
    headers = [(b"content-type", b"text/plain; charset=utf-8"), (b"connection", b"close"), *HEADERS]
    await send({"type": "http.response.start", "status": refusal.status, "headers": headers})
    await send({"type": "http.response.body", "body": body})


async def _redirect(send: Send, path: str, token: str) -> None:
    """Keep the token in a cookie that scripts cannot read, and take it out of the address."""
    cookie = f"{COOKIE}={token}; Path=/; HttpOnly; SameSite=Strict".encode()
    place = "/" + quote(path.lstrip("/"))  # no line's end, nor a way to another host, gets into the header
    headers = [(b"location", place.encode()), (b"set-cookie", cookie), *HEADERS]
    await send({"type": "http.response.start", "status": 303, "headers": headers})
    await send({"type": "http.response.body", "body": b""})


def _limited(receive: Receive) -> Receive:
    """Bodies end where they pass the limit, whatever their headers said."""
    taken = 0

    async def limited() -> MutableMapping[str, Any]:
        nonlocal taken
        message = await receive()
        if message["type"] == "http.request":
            taken += len(message.get("body", b""))
            if taken > MOST_BYTES:
                return {"type": "http.disconnect"}
        return message

    return limited


def _marked(send: Send) -> Send:
    async def marked(message: MutableMapping[str, Any]) -> None:
        if message["type"] == "http.response.start":
            message["headers"] = [*message.get("headers", []), *HEADERS]
        await send(message)

    return marked
