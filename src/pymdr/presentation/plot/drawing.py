"""Figures that a notebook shows without pyplot. Loads matplotlib."""

from __future__ import annotations

import io

from matplotlib.figure import Figure


class Drawing(Figure):
    """A figure that shows itself."""

    def _repr_png_(self) -> bytes:
        """The picture, for notebooks."""
        picture = io.BytesIO()
        self.savefig(picture, format="png", dpi=110)
        return picture.getvalue()
