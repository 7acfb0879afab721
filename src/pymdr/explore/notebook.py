"""The page inside a notebook, served by the notebook's own process."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any

from pymdr.explore.model import choices_of
from pymdr.explore.serve import new_server


@dataclass(frozen=True)
class Shown:
    """
    A page that a notebook shows.

    Parameters
    ----------
    address : str
        Address of the page on this computer, with its token.
    height : int
        Height in pixels.
    server : bokeh.server.server.Server
    """

    address: str
    height: int
    server: Any

    def close(self) -> None:
        """End the server; the page then answers no more."""
        self.server.stop()

    def _repr_html_(self) -> str:
        """The page in a frame, with its address where frames are blocked."""
        address = escape(self.address, quote=True)
        return (
            f'<iframe src="{address}" title="pymdr explore" width="100%" height="{self.height}" '
            f'style="border: 0"></iframe><p><a href="{address}" target="_blank">open in a window</a></p>'
        )


def page(cases: str | Path | None = None, *, height: int = 1000) -> Shown:
    """
    Sliders for a contact inside a notebook: the page of ``pymdr explore``.

    The process of the notebook serves it on the loopback address with a token, so the browser must run on the same computer.

    Parameters
    ----------
    cases : path, optional
        A case file to begin with, or a folder of cases.
    height : int
        Height of the page in pixels.

    Returns
    -------
    Shown
        What the notebook shows; :meth:`Shown.close` ends it.
    """
    choices = choices_of(None if cases is None else Path(cases))
    server, address = new_server(choices)
    server.start()
    return Shown(address, height, server)
