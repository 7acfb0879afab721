"""The server of the page: on the loopback address alone, and only for whoever has the token."""

from __future__ import annotations

import hmac
import logging
import secrets
from collections.abc import Callable
from typing import Any

import panel as pn
from bokeh.server.auth_provider import AuthProvider
from tornado.web import RequestHandler
from tornado.websocket import WebSocketHandler

from pymdr.explore.model import Choice
from pymdr.explore.page import Page

ADDRESS = "127.0.0.1"
_COOKIE = "pymdr_explore"
_LARGEST = 24 * 2**20
"""Bytes of a message of the browser."""
_ABANDONED = 15_000
"""Milliseconds after which a closed page is forgotten."""


class _Refusal(RequestHandler):
    """What whoever has no token is told."""

    def get(self) -> None:
        """Answer with the status 403."""
        self.set_status(403)
        self.finish("403: open the page by the address that pymdr explore printed; it holds a token.")


class _Token(AuthProvider):
    """
    Only requests with the token, in the address or as the cookie that the first of them sets, are answered.

    Parameters
    ----------
    cookie : str
        Its name, of this server alone.
    """

    def __init__(self, token: str, cookie: str) -> None:
        self._token, self._name = token, cookie
        super().__init__()

    @property
    def get_user(self) -> Callable[[Any], str | None]:
        """Who a request comes from: "owner", or nobody."""

        def user(handler: Any) -> str | None:
            given = handler.get_query_argument("token", None)
            if given is not None and hmac.compare_digest(given.encode(), self._token.encode()):
                # a socket has sent its headers by then
                if not isinstance(handler, WebSocketHandler):
                    handler.set_cookie(self._name, self._token, httponly=True, samesite="Strict")
                return "owner"
            kept = handler.get_cookie(self._name, "")
            return "owner" if hmac.compare_digest(kept.encode(), self._token.encode()) else None

        return user

    @property
    def get_user_async(self) -> None:
        """Not used."""
        return None

    @property
    def login_url(self) -> str:
        """Where everybody else is sent."""
        return "/refused"

    @property
    def get_login_url(self) -> None:
        """Not used."""
        return None

    @property
    def login_handler(self) -> type[RequestHandler]:
        """What is there."""
        return _Refusal

    @property
    def logout_url(self) -> None:
        """Nobody logs out."""
        return None

    @property
    def logout_handler(self) -> None:
        """Nobody logs out."""
        return None


def _page(choices: dict[str, Choice]) -> Any:
    theme = (pn.state.session_args or {}).get("theme", [b""])[0]
    pn.config.theme = "dark" if theme == b"dark" else "default"
    return Page(choices).view()


def new_server(choices: dict[str, Choice], port: int = 0) -> tuple[Any, str]:
    """
    A server that waits to be started, and the address of its page.

    Parameters
    ----------
    choices : dict of str to Choice
        Cases to choose from by name, the first of which is shown.
    port : int
        0 takes any that is free.

    Returns
    -------
    server : bokeh.server.server.Server
    address : str
        With the token.
    """
    from bokeh.server.util import bind_sockets

    sockets, port = bind_sockets(ADDRESS, port)
    for socket in sockets:
        socket.close()
    token = secrets.token_urlsafe(24)
    logging.getLogger("tornado.access").setLevel(logging.ERROR)
    pn.extension("filedropper", notifications=False)
    server = pn.io.server.get_server(
        lambda: _page(choices),
        port=port,
        address=ADDRESS,
        title="pymdr explore",
        websocket_origin=[f"{ADDRESS}:{port}", f"localhost:{port}"],
        auth_provider=_Token(token, f"{_COOKIE}_{port}"),
        websocket_max_message_size=_LARGEST,
        unused_session_lifetime_milliseconds=_ABANDONED,
        check_unused_sessions_milliseconds=_ABANDONED // 3,
        show=False,
        start=False,
    )
    return server, f"http://{ADDRESS}:{port}/?token={token}"


def serve(
    choices: dict[str, Choice], announce: Callable[[str], None], port: int = 0, *, show: bool = True
) -> None:
    """Serve the page until interrupted."""
    server, address = new_server(choices, port)
    announce(f"{address}\n(Ctrl+C ends it)")
    server.start()
    if show:
        import webbrowser

        server.io_loop.add_callback(webbrowser.open, address)
    try:
        server.io_loop.start()
    except KeyboardInterrupt:
        server.stop()
