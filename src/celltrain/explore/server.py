"""The server of the explorer: on this machine alone, unless told otherwise with a token."""

import hmac
import ipaddress
import secrets
import socket
import webbrowser
from dataclasses import dataclass
from urllib.parse import urlencode

from dash import Dash
from flask import Response, abort, request
from werkzeug.serving import BaseWSGIServer, WSGIRequestHandler, make_server

from celltrain.parameters import CaseError

#: Where the page is unless told otherwise; the next free port if that is taken.
HOST, PORT = "127.0.0.1", 8157
_COOKIE = "celltrain-token"


@dataclass(frozen=True)
class Served:
    """A server that listens, and the address to open."""

    server: BaseWSGIServer
    address: str

    def run(self, *, browser: bool) -> None:
        """Serve until interrupted, with the page opened in the user's browser if wanted."""
        if browser:
            webbrowser.open(self.address)
        try:
            self.server.serve_forever()
        finally:
            self.server.server_close()


class _Quiet(WSGIRequestHandler):
    """Says nothing of single requests."""

    def log_request(self, code: int | str = "-", size: int | str = "-") -> None: ...


def is_loopback(host: str) -> bool:
    """Whether a name or address means this machine alone."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return False


def guarded(app: Dash, host: str, token: str | None) -> str | None:
    """Let only those in who may: returns the token that the address must carry, if there is one.

    On the loopback address requests must name this machine, so that no other site's page can ask
    through the browser; on others they must carry a token, first in the address and then in a
    cookie.
    """
    if token is None and not is_loopback(host):
        token = secrets.token_urlsafe(16)

    @app.server.before_request
    def look() -> None:
        if token is None:
            if not is_loopback(request.host.rsplit(":", 1)[0]):
                abort(403, "this page is served to this machine alone")
            return
        given = request.args.get("token") or request.cookies.get(_COOKIE) or ""
        if not hmac.compare_digest(given.encode(), token.encode()):
            abort(403, "the address must carry the token that `celltrain explore` has printed")

    @app.server.after_request
    def remember(response: Response) -> Response:
        if token is not None and request.args.get("token") == token:
            response.set_cookie(_COOKIE, token, httponly=True, samesite="Strict")
        return response

    return token


def serve(
    app: Dash, *, host: str = HOST, port: int | None = None, token: str | None = None, query: str
) -> Served:
    """Listen; the page is there once `run` is called.

    **Arguments:** `port`: 0 for any that is free; `PORT`, or else any, if not given; `token`: that
    the address must carry, made up if `host` is not the loopback address; `query`: of the page that
    is opened.

    **Raises:** `CaseError` if the address cannot be listened on.
    """
    token = guarded(app, host, token)
    server = _listening(app, host, port)
    if token is not None:
        query = "&".join(part for part in (urlencode({"token": token}), query) if part)
    name = f"[{host}]" if ":" in host else socket.gethostname() if host in _ANY else host
    return Served(server, f"http://{name}:{server.server_port}/{'?' if query else ''}{query}")


_ANY = ("0.0.0.0", "::")


def _listening(app: Dash, host: str, port: int | None) -> BaseWSGIServer:
    for tried in (PORT, 0) if port is None else (port,):
        # Looked at first: werkzeug ends the process where it cannot listen.
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        try:
            with socket.socket(family, socket.SOCK_STREAM) as probe:
                probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                probe.bind((host, tried))
        except OSError as error:
            if port is None and tried:
                continue
            raise CaseError(
                f"port = {tried} is not allowed on host {host!r}: {error.strerror or error};"
                " allowed: one that is free, or 0 for any"
            ) from None
        return make_server(host, tried, app.server, threaded=True, request_handler=_Quiet)
    raise CaseError(f"no port is free on host {host!r}")
