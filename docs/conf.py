"""Configuration of the documentation."""

import contextlib
import io
import os
import re
import sys
from pathlib import Path

import latex2mathml.converter
import matplotlib as mpl
from docutils import nodes

import pymdr
from pymdr.presentation.plot.shared import STYLE
from pymdr.quantities import POSITION, QUANTITIES, RADIUS

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))
os.environ.setdefault("MPLBACKEND", "agg")
mpl.rcParams.update(STYLE)

project = "pymdr"
author = "The pymdr developers"
copyright = "2026, The pymdr developers"
version = release = pymdr.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
    "sphinx_copybutton",
    "sphinx_gallery.gen_gallery",
]
templates_path = ["_templates"]
exclude_patterns = [
    "_build",
    "_templates",
    "generated/quantities.md",
    "sg_execution_times.rst",
    "**/GALLERY_HEADER.rst",
    "**/sg_execution_times.rst",
]
myst_enable_extensions = ["dollarmath", "deflist"]
myst_heading_anchors = 3
html_theme = "furo"
html_title = "pymdr"
html_static_path = ["_static"]
html_css_files = ["pymdr.css"]
html_math_renderer = "mathml"
html_show_sphinx = False
copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True
copybutton_selector = "div:not(.highlight-text) > div.highlight > pre"  # no outputs
autosummary_generate = True
autosummary_imported_members = False
autodoc_typehints = "none"
autodoc_member_order = "bysource"
napoleon_google_docstring = False
napoleon_custom_sections = [("Attributes", "params_style")]  # not objects: members are documented apart
suppress_warnings = ["config.cache", "autosectionlabel.*"]


def scrape_figure(block, block_vars, gallery_conf):
    """Save the matplotlib figure named ``figure`` of an example: it is not known to pyplot."""
    from sphinx_gallery.scrapers import figure_rst

    figure = block_vars["example_globals"].pop("figure", None)
    if figure is None:
        return ""
    file = next(block_vars["image_path_iterator"])
    figure.savefig(file, dpi=110)
    return figure_rst([file], gallery_conf["src_dir"])


sphinx_gallery_conf = {
    "examples_dirs": ["../examples", "demonstrations"],
    "gallery_dirs": ["generated/examples", "generated/demonstrations"],
    "filename_pattern": r".*\.py$",
    "ignore_pattern": r"make_(worn_tip|rough_curve)\.py",
    "image_scrapers": (scrape_figure,),
    "reset_modules": (),
    "abort_on_example_error": True,
    "download_all_examples": False,
    "show_memory": False,
    "min_reported_time": 1e9,
    "plot_gallery": True,
    "show_signature": False,
    "capture_repr": (),
}


def render_math(self, node):
    """Mathematics as MathML, which browsers show without a network."""
    display = "block" if isinstance(node, nodes.math_block) else "inline"
    self.body.append(latex2mathml.converter.convert(node.astext(), display=display))
    raise nodes.SkipNode


def keep_bars(app, what, name, obj, options, lines):
    """|x| in a docstring is an absolute value, not a substitution."""
    for i, line in enumerate(lines):
        if "``" not in line and not line.lstrip().startswith((">>>", "...")):
            lines[i] = re.sub(r"(?<!\\)\|", r"\|", line)


def keep_colons(app, what, name, obj, options, lines):
    """A colon in words about an attribute parts no type from them; napoleon looks for one in the first line."""
    if what in ("attribute", "data", "property") and lines:
        lines[:0] = ["..", ""]


def write_glossary(app):
    """The table of quantities, from the one place that defines them."""
    lines = ["| name | symbol | unit | meaning | over |", "|---|---|---|---|---|"]
    for q in (*QUANTITIES.values(), RADIUS, POSITION):
        lines.append(f"| `{q.name}` | ${q.symbol}$ | {q.unit or '1'} | {q.long_name} | {', '.join(q.dims)} |")
    folder = HERE / "generated"
    folder.mkdir(exist_ok=True)
    (folder / "quantities.md").write_text("\n".join(lines) + "\n")


def draw_figures(app):
    """The ``figure`` that the Python blocks of a page draw, next to the glossary."""
    folder = HERE / "generated"
    folder.mkdir(exist_ok=True)
    for page in ("adhesion", "friction", "impact", "rolling", "sliding_friction", "rough", "conductance"):
        text = (HERE / f"{page}.md").read_text(encoding="utf-8")
        space = {"__name__": page}
        with contextlib.redirect_stdout(io.StringIO()):
            for body in re.findall(r"^```python\n(.*?)^```", text, re.MULTILINE | re.DOTALL):
                exec(compile(body, f"{page}.md", "exec"), space)
        space["figure"].savefig(folder / f"{page}.png", dpi=110)


def setup(app):
    app.add_html_math_renderer(
        "mathml", inline_renderers=(render_math, None), block_renderers=(render_math, None)
    )
    app.connect("autodoc-process-docstring", keep_bars)
    app.connect("autodoc-process-docstring", keep_colons, priority=400)  # before napoleon
    app.connect("builder-inited", write_glossary)
    app.connect("builder-inited", draw_figures)
