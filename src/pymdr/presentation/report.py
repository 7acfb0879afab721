"""Printable reports: one HTML file with tables, figures, claims, assumptions, notes and sources."""

from __future__ import annotations

import base64
import io
import os
from collections.abc import Callable, Iterable, Sequence
from html import escape
from typing import TYPE_CHECKING, NamedTuple

from pymdr.errors import FileError
from pymdr.presentation.files import named_file, write_atomically
from pymdr.presentation.html import assumptions_html, claims_html, numbers_html, table
from pymdr.presentation.text import StudyText

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_SUFFIXES, _DPI = (".html", ".htm"), 130
_STYLE = """
body { font: 10.5pt/1.4 Georgia, "Times New Roman", serif; max-width: 62em; margin: 2em auto; padding: 0 1em; color: #111; }
h1 { font-size: 1.5em; } h2 { font-size: 1.15em; margin-top: 1.6em; border-bottom: 1px solid #999; }
table { border-collapse: collapse; font-size: 0.88em; } th, td { padding: 0.15em 0.8em 0.15em 0; vertical-align: top; overflow-wrap: break-word; }
thead th { border-bottom: 1px solid #555; } thead { display: table-header-group; }
figure { margin: 0.8em 0; } figcaption { font-size: 0.88em; } img { max-width: 100%; max-height: 95mm; } p { margin: 0.3em 0; }
tr, figure { break-inside: avoid; } h2 { break-after: avoid; }
@page { margin: 15mm; } @media print { body { max-width: none; margin: 0; font-size: 9pt; } }
"""


class ReportPart(NamedTuple):
    """A section of a report."""

    heading: str
    lines: Sequence[str] = ()
    header: tuple[Sequence[str], Sequence[str]] = ((), ())
    """Labels and units of the columns of a table."""
    rows: Sequence[Sequence[str]] = ()
    figures: Sequence[tuple[str, Callable[[], Figure]]] = ()
    """Captions, and what draws the figures."""


class Report(NamedTuple):
    """The content of a report."""

    title: str
    settings: Sequence[tuple[str, str]]
    """Names and values."""
    text: StudyText
    figure: Callable[[], Figure]
    sections: Sequence[ReportPart]
    sources: Sequence[str]


def write_report(file: str | os.PathLike[str], report: Report) -> None:
    """Write a report."""
    target = named_file(file, "write")
    if target.suffix.lower() not in _SUFFIXES:
        raise FileError(f"cannot write {str(file)!r}: a report is HTML with a name that ends with '.html'")
    page = report_html(report)
    write_atomically(target, lambda temporary: temporary.write_text(page, encoding="utf-8"))


def report_html(report: Report) -> str:
    """The page of a report."""
    groups, columns, remarks, claims, assumptions, notes = report.text
    title = escape(report.title or "Report")
    parts = [
        f"<h1>{title}</h1>",
        _headed("Settings", table(("", ""), _escaped(report.settings))),
        _headed("Results", numbers_html(groups, columns) + _lines(remarks) + _picture("", report.figure)),
        *(_section(section) for section in report.sections),
        _headed("Assumptions", assumptions_html(assumptions)) if assumptions else "",
        _headed("Claims", claims_html(claims)) if claims else "",
        _headed("Notes", _lines(notes)) if notes else "",
        _headed("Sources", _lines(report.sources)) if report.sources else "",
    ]
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{title}</title><style>{_STYLE}</style></head>\n<body>'
        + "\n".join(parts)
        + "</body></html>\n"
    )


def _headed(heading: str, content: str) -> str:
    return f"<h2>{escape(heading)}</h2>{content}"


def _lines(lines: Iterable[str]) -> str:
    return "".join(f"<p>{escape(line)}</p>" for line in lines)


def _escaped(rows: Iterable[Sequence[str]]) -> list[list[str]]:
    return [[escape(cell) for cell in row] for row in rows]


def _section(section: ReportPart) -> str:
    titles, units = section.header
    labels = [escape(f"{t} ({u})" if u else t) for t, u in zip(titles, units, strict=True)]
    rows = table(labels, _escaped(section.rows)) if labels else ""
    pictures = "".join(_picture(caption, figure) for caption, figure in section.figures)
    return _headed(section.heading, _lines(section.lines) + rows + pictures)


def _picture(caption: str, figure: Callable[[], Figure]) -> str:
    """A figure inside the page."""
    picture = io.BytesIO()
    figure().savefig(picture, format="png", dpi=_DPI)
    code = base64.b64encode(picture.getvalue()).decode()
    below = f"<figcaption>{escape(caption)}</figcaption>" if caption else ""
    return f'<figure><img alt="{escape(caption or "figure")}" src="data:image/png;base64,{code}">{below}</figure>'
