"""Configuration of the documentation."""

import contextlib
import io
import os
import re
import sys
from pathlib import Path

import latex2mathml.converter
import matplotlib.style
import sphinx_gallery.backreferences
from docutils import nodes
from matplotlib.transforms import Bbox
from PIL import Image

import pymdr

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))
os.environ.setdefault("MPLBACKEND", "agg")
matplotlib.style.use("pymdr.figures")

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
    "generated/examples/index.rst",  # examples.md has them by subject
    "sg_execution_times.rst",
    "**/GALLERY_HEADER.rst",
    "**/sg_execution_times.rst",
]
myst_enable_extensions = ["colon_fence", "dollarmath", "deflist"]
myst_heading_anchors = 3
html_theme = "furo"
html_title = "pymdr"
html_static_path = ["_static"]
html_css_files = ["pymdr.css"]
html_favicon = "_static/favicon.svg"
html_math_renderer = "mathml"
html_show_sphinx = False
copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True
copybutton_line_continuation_character = "\\"
copybutton_selector = "div:not(.highlight-text) > div.highlight > pre"  # no outputs
autosummary_generate = True
autosummary_imported_members = False
autodoc_typehints = "none"
autodoc_member_order = "bysource"
napoleon_google_docstring = False
napoleon_custom_sections = [("Attributes", "params_style")]  # not objects: members have entries of their own
suppress_warnings = [
    "config.cache",
    "autosectionlabel.*",
    "ref.python",
]  # words of types are names of attributes


PICTURES = HERE / "pictures"
"""Pictures of pages, kept in the repository so that the pages show them there too; each build draws them again."""
PICTURED = {"damped_vibration", "claimed_and_actual"}
"""Programs of the galleries whose figure a page shows."""


def save_picture(figure, name):
    """Save a picture of a page with a palette, which is a third of the size."""
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=110)
    with Image.open(file) as image:
        image.convert("RGB").quantize(128).save(PICTURES / f"{name}.png", optimize=True)


def save_first_panel(figure, file):
    """Save the first panel of a figure alone, with its second scales and its colour bars."""
    place = figure.axes[0].get_subplotspec()
    panel = [axes for axes in figure.axes if axes.get_subplotspec() == place]
    bars = [axes for axes in figure.axes if getattr(axes, "_colorbar", None)]
    panel += [axes for axes in bars if axes._colorbar.mappable.axes in panel]
    figure.set_layout_engine("none")
    for axes in figure.axes:
        axes.set_visible(axes in panel)
        for text in axes.texts:
            text.set_visible(text.get_text() != "(a)")
    for artist in (*figure.texts, *figure.legends):
        artist.set_visible(False)
    if figure._suptitle is not None:
        figure._suptitle.set_visible(False)
    boxes = [axes.get_tightbbox() for axes in panel]
    box = Bbox.union([one for one in boxes if one is not None]).transformed(figure.dpi_scale_trans.inverted())
    figure.savefig(file, dpi=110, bbox_inches=box.padded(0.05))


def scrape_figure(block, block_vars, gallery_conf):
    """Save the matplotlib figure named ``figure`` of an example; pyplot does not know it. Its text is the title."""
    from sphinx_gallery.scrapers import figure_rst

    figure = block_vars["example_globals"].pop("figure", None)
    if figure is None:
        return ""
    panel = next(block_vars["image_path_iterator"])  # the first image becomes the thumbnail
    file = next(block_vars["image_path_iterator"])
    figure.savefig(file, dpi=110)
    name = Path(block_vars["src_file"]).stem
    if name in PICTURED:
        save_picture(figure, name)
    save_first_panel(figure, panel)
    title = Path(block_vars["src_file"]).read_text(encoding="utf-8").split("\n")[1]
    return figure_rst([file], gallery_conf["src_dir"], f"Figure of the example: {title}")


sphinx_gallery.backreferences.THUMBNAIL_TEMPLATE = sphinx_gallery.backreferences.THUMBNAIL_TEMPLATE.replace(
    ":alt:", ":alt: {title}"
)
sphinx_gallery_conf = {
    "backreferences_dir": "generated/backreferences",
    "examples_dirs": ["../examples", "demonstrations"],
    "gallery_dirs": ["generated/examples", "generated/demonstrations"],
    "filename_pattern": r".*\.py$",
    "ignore_pattern": r"make_\w+\.py",
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


FUNCTION = r"\\(?:arc)?(?:sin|cos|tan|cot|ln|log|exp|max|min)(?![a-z])"


def render_math(self, node):
    """Mathematics as MathML, which browsers show without a network."""
    display = "block" if isinstance(node, nodes.math_block) else "inline"
    # as in TeX: thin spaces around the name of a function, none around a bar or a slash, and an upright d
    tex = re.sub(rf"(?<=[\w)\]}}])\s*(?={FUNCTION})", r"\\, ", node.astext())
    tex = re.sub(rf"({FUNCTION})\s*(?=[A-Za-z0-9]|\\(?!left|!|,))", r"\1\\, ", tex)
    mathml = latex2mathml.converter.convert(tex, display=display)
    mathml = re.sub("<mo(?=[^>]*>&#x000(?:7C|2F);)", '<mo lspace="0" rspace="0"', mathml)
    self.body.append(mathml.replace("<mi>&#x00064;</mi>", '<mi mathvariant="normal">d</mi>'))
    raise nodes.SkipNode


def keep_bars_and_stars(app, what, name, obj, options, lines):
    """|x| in a docstring is an absolute value, not a substitution, and *args are arguments, not emphasis."""
    for i, line in enumerate(lines):
        if "``" not in line and not line.lstrip().startswith((">>>", "...")):
            lines[i] = re.sub(r"(?<!\\)(\||\*(?=args))", r"\\\1", line)


def keep_colons(app, what, name, obj, options, lines):
    """Napoleon reads the words before a colon in the first line about an attribute as its type; they are not."""
    if what in ("attribute", "data", "property") and lines:
        lines[:0] = ["..", ""]


def link_programs(app, docname, source):
    """Pages link to programs in the repository; as HTML the links lead to the pages of the galleries."""
    source[0] = re.sub(
        r"\]\((?:\.\./)?(examples|demonstrations)/(\w+)\.py\)", r"](generated/\1/\2)", source[0]
    )


def draw_figures(app):
    """Save as each picture of a page the last ``figure`` that the Python blocks before it draw, or the next one after it."""
    for page in (
        "adhesion",
        "soft_adhesion",
        "yielding_bodies",
        "friction",
        "impact",
        "rolling",
        "sliding_friction",
        "rough",
        "conductance",
        "wear",
    ):
        text = (HERE / f"{page}.md").read_text(encoding="utf-8")
        space = {"__name__": page}
        blocks = list(re.finditer(r"^```python\n(.*?)^```", text, re.MULTILINE | re.DOTALL))
        for picture in re.finditer(r"\]\(pictures/(\w+)\.png\)", text):
            with contextlib.redirect_stdout(io.StringIO()):
                while blocks and ("figure" not in space or blocks[0].start() < picture.start()):
                    exec(compile(blocks.pop(0)[1], f"{page}.md", "exec"), space)
            save_picture(space.pop("figure"), picture[1])


def setup(app):
    app.add_html_math_renderer(
        "mathml", inline_renderers=(render_math, None), block_renderers=(render_math, None)
    )
    app.connect("autodoc-process-docstring", keep_bars_and_stars)
    app.connect("autodoc-process-docstring", keep_colons, priority=400)  # before napoleon
    app.connect("source-read", link_programs)
    app.connect("builder-inited", draw_figures)
