"""The Python blocks of the documentation pages run, and their assertions hold."""

import doctest
import importlib
import inspect
import json
import pkgutil
import re
import runpy
import shlex
import shutil
import sys
import tomllib
from pathlib import Path
from types import SimpleNamespace

import matplotlib
import numpy as np
import pytest

import pymdr as mdr
from pymdr.interpretation import theories
from pymdr.quantities import POSITION, QUANTITIES, RADIUS
from pymdr.workbench import casefile
from pymdr.workbench.templates import template

DOCS = Path(__file__).parent.parent / "docs"
OUTPUT = re.compile(r"^( *)```python\n(.*?)^\1```\n(?:\n\1```text\n(.*?)^\1```)?", re.MULTILINE | re.DOTALL)
BLOCK = re.compile(r"^( *)```python\n(.*?)^\1```", re.MULTILINE | re.DOTALL)


def blocks(page):
    for indent, body in BLOCK.findall(page.read_text()):
        yield re.sub(f"^{indent}", "", body, flags=re.MULTILINE)


@pytest.mark.usefixtures("kinds")
@pytest.mark.parametrize(
    "page",
    [
        "first_steps.md",
        "book.md",
        "adhesion.md",
        "friction.md",
        "rolling.md",
        "bodies.md",
        "layers.md",
        "viscoelasticity.md",
        "sliding_friction.md",
        "rough.md",
        "topography.md",
        "press.md",
        "shapes.md",
        "impact.md",
        "conductance.md",
        "claims.md",
        "exactness.md",
        "profiles.md",
        "closure.md",
        "curves.md",
        "fits.md",
        "nanoindentation.md",
        "law.md",
        "stepping.md",
        "machines.md",
        "contributing.md",
        "for_teaching.md",
        "soft_adhesion.md",
        "stress.md",
        "scale.md",
        "sweeps.md",
        "torsion.md",
        "wear.md",
        "yielding_bodies.md",
    ],
)
def test_blocks_run(page, tmp_path, monkeypatch):
    if page == "scale.md":
        pytest.importorskip("distributed", reason="distributed, of the extra cluster, is not installed")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "examples").symlink_to(DOCS.parent / "examples")
    monkeypatch.setattr(theories, "THEORIES", dict(theories.THEORIES))
    result = list(blocks(DOCS / page))
    assert any("assert " in block for block in result)
    space = {"__name__": page.replace(".", "_")}
    for block in result:
        exec(compile(block, page, "exec"), space)


def test_every_block_of_the_readme_runs_alone(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for block in blocks(DOCS.parent / "README.md"):
        exec(compile(block, "README.md", "exec"), {"__name__": "readme"})
    assert "PULLED_OFF" in capsys.readouterr().out
    assert (tmp_path / "ball.png").stat().st_size > 10_000


@pytest.fixture
def quartic(tmp_path, monkeypatch, kinds):
    """The file that the page on contributing has people write."""
    (text,) = [block for block in blocks(DOCS / "contributing.md") if "class Quartic" in block]
    (tmp_path / "quartic.py").write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "quartic", raising=False)
    yield importlib.import_module("quartic").Quartic
    sys.modules.pop("quartic")


TABLES = re.compile(r"^```toml\n(.*?)^```", re.MULTILINE | re.DOTALL)
COMPLETED = {
    "case_files.md": ("", "joint"),
    "layers.md": ("layers",),
    "machines.md": ("machine",),
    "press.md": ("press",),
    "rough.md": ("rough",),
    "stress.md": ("joint", "ball"),
    "viscoelasticity.md": ("rubber",),
    "yielding_bodies.md": ("",),
}
"""Cases of ``pymdr new`` whose tables the blocks of a page complete or replace; empty for blocks that are whole cases."""
READERS = {
    "machine": casefile.read_machine_case,
    "press": casefile.read_press_case,
    "rough": casefile.read_rough_case,
}


def tables_on(page):
    return [tomllib.loads(text) for text in TABLES.findall((DOCS / page).read_text())]


def test_every_page_with_tables_is_compared_with_a_case():
    assert {page.name for page in DOCS.glob("*.md") if tables_on(page.name)} == {*COMPLETED, "plugins.md"}


@pytest.mark.parametrize("page", COMPLETED)
def test_tables_on_pages_complete_the_cases_that_new_writes(page, tmp_path):
    heights = " ".join(str(i * i % 7) for i in range(64))
    (tmp_path / "ground.sdf").write_text(
        "aISO-1.0\nManufacID = A\nCreateDate = 040120100853\nModDate = 050320101353\nNumPoints = 8\nNumProfiles = 8\n"
        "Xscale = 1e-6\nYscale = 1e-6\nZscale = 1e-9\nZresolution = 1e-12\nCompression = 0\nDataType = 7\n"
        f"CheckType = 0\n*\n{heights}\n*\n"
    )
    (tmp_path / "dma.csv").write_text("time [s],G [MPa]\n0.001,4\n0.01,3\n0.1,2\n1,1.5\n10,1\n")
    file = tmp_path / "case.toml"
    for kind, tables in zip(COMPLETED[page], tables_on(page), strict=True):
        file.write_text(casefile.case_text(tomllib.loads(template(kind) if kind else "") | tables))
        READERS.get(kind, casefile.read_case)(file)


def test_two_commands_give_the_stress_below_a_coat(tmp_path, monkeypatch, shell):
    """Across the interface of the page and the template the tractions and the strain along it are equal, the stress along it is not."""
    monkeypatch.chdir(tmp_path)
    text = (DOCS / "layers.md").read_text()
    first, second = re.search(r"Two commands .*?: `pymdr (new .*?)` .*?; `pymdr (run .*?)` ", text).groups()
    assert shell(*shlex.split(first))[0] == 0
    with Path("coated.toml").open("a") as case:
        case.write(TABLES.search(text)[1])
    assert shell(*shlex.split(second), "--no-figures")[0] == 0
    above, below = np.genfromtxt("out/stress.csv", delimiter=",", names=True, deletechars="")[-2:]
    coat, under = (layer["material"] for layer in tomllib.loads(template("layers"))["body"]["layers"])
    assert tomllib.loads(template("layers"))["body"]["layers"][0]["thickness"] == "2 um"
    (along, radial) = ([row[f"stress_{name}_[Pa]"] for row in (above, below)] for name in ("zz", "rr"))
    assert along[0] == pytest.approx(along[1], rel=1e-9)
    assert radial[0] != pytest.approx(radial[1], rel=0.1)
    strains = [
        ((1.0 - body["poisson"]) * across - body["poisson"] * down) / mdr.Elastic(body["young"], 0.3).young
        for body, across, down in zip((coat, under), radial, along, strict=True)
    ]
    assert strains[0] == pytest.approx(strains[1], rel=1e-6)


LAWS = {
    "none": {},
    "jkr": {"adhesion": mdr.JKR("1 mJ/m^2")},
    "dmt": {"adhesion": mdr.DMT("1 mJ/m^2", range="1 nm")},
    "maugis": {"adhesion": mdr.MaugisDugdale("1 mJ/m^2", range="1 nm")},
    "coulomb": {"friction": mdr.Coulomb(0.3)},
}


@pytest.mark.parametrize("law", LAWS)
def test_a_profile_of_ones_own_is_solved_drawn_and_saved(quartic, tmp_path, law):
    body = mdr.Elastic("1 GPa", 0.3)
    path = mdr.indent("1 um", steps=3)
    if law == "coulomb":
        path >>= mdr.shift("20 nm", steps=3)
    mine, power = (
        mdr.solve(mdr.Contact(profile, body, **LAWS[law]), path)
        for profile in (quartic("1 um", "1 mm"), mdr.PowerLaw(4, "1 um", "1 mm"))
    )
    assert mine.status is power.status
    for name in mine.data:
        assert mine.data[name].values == pytest.approx(power.data[name].values, rel=1e-9, nan_ok=True)
    mine.save(tmp_path / "mine.nc")
    again = mdr.open_result(tmp_path / "mine.nc")
    assert again.contact == mine.contact
    assert type(again.contact.profile) is quartic
    assert again.data.identical(mine.data)
    r = np.linspace(0.0, 1e-3, 9)
    assert np.array_equal(again.field("pressure", r), mine.field("pressure", r), equal_nan=True)
    assert all(figure.axes for figure in again.figures().values())


def test_a_profile_of_ones_own_in_cases_and_batches(quartic, tmp_path, shell):
    file = tmp_path / "case.toml"
    file.write_text(
        "[profile]\nkind = 'sum'\nparts = [{ kind = 'quartic', height = '1 um', radius = '1 mm' }, "
        "{ kind = 'rounded_cone', slope = 0.1, tip_radius = '1 mm' }]\n[body]\nkind = 'elastic'\nyoung = '1 GPa'\n"
        "poisson = 0.3\n[[path]]\nkind = 'indent'\nindentation = '1 um'\n"
    )
    status, _, error = shell("run", file, "-o", tmp_path / "out", "--quiet")
    assert (status, error) == (0, "")
    result = mdr.open_result(tmp_path / "out" / "result.nc")
    assert [type(part) for part in result.contact.profile.parts] == [quartic, mdr.RoundedCone]
    status, out, _ = shell("schema")
    assert status == 0
    assert json.loads(out)["$defs"]["quartic"]["required"] == ["kind", "height", "radius"]
    file.write_text(file.read_text().replace("height = '1 um'", "heigth = '1 um'"))
    status, _, error = shell("check", file)
    assert status == 1
    assert "did you mean 'height'" in error
    contacts = [result.contact, mdr.Contact(quartic("1 um", "1 mm"), result.contact.body)]
    separate = mdr.solve_batch(contacts, mdr.indent("1 um"), workers=2)
    assert [r.data.identical(mdr.solve(r.contact, r.path).data) for r in separate] == [True, True]


def test_first_steps_print_what_is_shown(capsys):
    space = {"__name__": "first_steps"}
    shown = 0
    for indent, body, output in OUTPUT.findall((DOCS / "first_steps.md").read_text()):
        exec(compile(re.sub(f"^{indent}", "", body, flags=re.MULTILINE), "first_steps.md", "exec"), space)
        assert (
            capsys.readouterr().out.rstrip() == re.sub(f"^{indent}", "", output, flags=re.MULTILINE).rstrip()
        )
        shown += bool(output)
    assert shown >= 4


FILE = re.compile(r"^:::\{code-block\} \w+\n:caption: (\S+)\n\n(.*?)^:::", re.MULTILINE | re.DOTALL)
CONSOLE = re.compile(r"^```console\n(.*?)^```", re.MULTILINE | re.DOTALL)


@pytest.mark.usefixtures("kinds")
@pytest.mark.parametrize("page", [*sorted(DOCS.glob("for_*.md")), DOCS / "plugins.md"], ids=lambda p: p.stem)
def test_commands_print_the_numbers_that_are_shown(page, tmp_path, monkeypatch, shell):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    monkeypatch.delitem(sys.modules, "mine", raising=False)
    shutil.copytree(DOCS.parent / "examples" / "data", tmp_path / "examples" / "data")
    for name, body in FILE.findall(page.read_text()):
        (tmp_path / name).write_text(body)
    consoles = CONSOLE.findall(page.read_text())
    assert consoles
    for console in consoles:
        for command in console.replace("\\\n", " ").removeprefix("$ ").split("\n$ "):
            line, _, shown = command.partition("\n")
            status, out, error = shell(*shlex.split(line)[1:])
            assert status == 0, error
            assert set(re.findall(r"[-\d.e]*\d", shown)) <= set(re.findall(r"[-\d.e]*\d", out)), line


JOBS = ("press", "layers", "book", "plugins", *(page.stem for page in DOCS.glob("for_*.md")))
"""Pages of jobs."""
NUMBERS = ("one", "two", "three")


@pytest.mark.parametrize("page", JOBS)
def test_pages_of_jobs_say_how_many_commands_they_take(page):
    """Each number is that of the commands in the console that follows, or in the text of the section where there is none."""
    text = (DOCS / f"{page}.md").read_text()
    phrases = list(re.finditer(rf"\b({'|'.join(NUMBERS)}) commands?\b", text, re.IGNORECASE))
    assert phrases
    for phrase in phrases:
        section = text[phrase.end() :].partition("\n## ")[0]
        if page == "book":  # each row has its own
            section = re.search(r"^\| \d.*`pymdr .*$", section, re.MULTILINE)[0]
        console = re.search(r"^```console\n(.*?)^```", section, re.MULTILINE | re.DOTALL)
        shown = re.findall(
            r"^\$ pymdr " if console else "`pymdr ", console[1] if console else section, re.MULTILINE
        )
        assert len(shown) == NUMBERS.index(phrase[1].lower()) + 1, phrase


def test_the_readme_leads_to_every_page():
    links = set(re.findall(r"\]\(docs/(\w+\.md)\)", (DOCS.parent / "README.md").read_text()))
    assert links == {page.name for page in DOCS.glob("*.md")} - {"index.md"}
    contents = (DOCS / "index.md").read_text().split()
    assert all(page.removesuffix(".md") in contents for page in links)


def test_every_example_has_one_place_in_the_gallery():
    shown = re.findall(r"examples/(\w+)\.py", (DOCS / "examples.md").read_text())
    programs = [file.stem for file in (DOCS.parent / "examples").glob("*.py")]
    assert sorted(shown) == sorted(name for name in programs if not name.startswith("make_"))


MATHEMATICS = {
    r"t x \arctan(x/c)": r'x</mi><mspace width="0.167em" /><mi>arctan',
    r"1 - \cos kr": r'cos</mi><mspace width="0.167em" /><mi>k',
    r"\max_k r": r"<msub><mi>max</mi><mi>k</mi></msub>|max",
    r"r\,\mathrm dr": r'<mspace width="0.167em" /><mi mathvariant="normal">d</mi><mi>r',
    r"\lvert x \rvert": r'<mo lspace="0" rspace="0">&#x0007C;</mo><mi>x',
    r"x/R": r'<mo lspace="0" rspace="0">&#x0002F;</mo>',
}


@pytest.mark.parametrize("tex", MATHEMATICS)
def test_mathematics_keeps_its_spaces(tex):
    for package in ("latex2mathml", "sphinx_gallery"):
        pytest.importorskip(package, reason="the packages of the group docs are not installed")
    nodes = pytest.importorskip("docutils.nodes")
    shown = SimpleNamespace(body=[])
    with matplotlib.rc_context(), pytest.raises(nodes.SkipNode):
        runpy.run_path(str(DOCS / "conf.py"))["render_math"](shown, nodes.math(text=tex))
    assert re.search(MATHEMATICS[tex], shown.body[0]), shown.body[0]


def test_no_source_is_cited_that_readers_do_not_have():
    root = DOCS.parent
    texts = [*root.glob("*.md"), *DOCS.glob("*.md"), *(root / "docs/demonstrations").glob("*.py")]
    programs = [*(root / "examples").glob("*.py"), *(root / "src").rglob("*.py")]
    tests = [file for file in (root / "tests").rglob("*.py") if file != Path(__file__)]
    for file in [*texts, *programs, *tests]:
        assert not re.search(r"mdr_math|DESIGN\.md", file.read_text(encoding="utf-8")), file


@pytest.mark.parametrize("quantity", [*QUANTITIES.values(), RADIUS, POSITION], ids=lambda q: q.name)
def test_the_glossary_lists_every_quantity(quantity):
    q = quantity
    row = f"| `{q.name}` | ${q.symbol}$ | {q.unit or '1'} | {q.long_name} | {', '.join(q.dims)} |"
    assert row in (DOCS / "glossary.md").read_text(), f"docs/glossary.md needs the row {row}"


def test_the_reference_names_everything_public():
    named = set(re.findall(r"^   (\w+)$", (DOCS / "reference.md").read_text(), re.MULTILINE))
    errors = {name for name in mdr.__all__ if name.endswith("Error")}  # in the page of pymdr.errors
    assert set(mdr.__all__) - named - errors == {"__version__"}


def test_the_reference_names_what_is_there():
    for path in re.findall(r"^   ([\w.]+)$", (DOCS / "reference.md").read_text(), re.MULTILINE):
        assert pkgutil.resolve_name(f"pymdr.{path}") is not None


@pytest.mark.parametrize(
    "page", [DOCS.parent / "README.md", *sorted(DOCS.glob("*.md"))], ids=lambda p: p.stem
)
def test_links_lead_to_files_of_the_repository(page):
    for link in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", page.read_text()):
        assert (page.parent / link).exists(), link


@pytest.mark.parametrize("page", sorted(DOCS.glob("*.md")), ids=lambda p: p.stem)
def test_named_modules_exist(page):
    package = Path(mdr.__file__).parent
    for name in re.findall(r"`((?:\w+/)+(?:\w+\.py)?)`", page.read_text()):
        assert (package / name).exists(), name


def test_files_of_a_contribution_exist():
    package, root = Path(mdr.__file__).parent, DOCS.parent
    text = (DOCS / "contributing.md").read_text()
    for name in re.findall(r"`([\w/]+\.(?:py|md|pyi))`", text):
        folders = (package, root, root / "tests", root / "tests" / "reference")
        assert name == "quartic.py" or any((folder / name).exists() for folder in folders), name
    for subject in (
        "profile",
        "claim",
        "leg",
        "history",
        "law of adhesion",
        "body",
        "rheology",
        "field",
        "figure",
    ):
        assert f"## A new {subject}\n" in text


def public_objects():
    """Public names and the members of public classes."""
    for name in sorted(set(mdr.__all__) - {"__version__"}):
        value = getattr(mdr, name)
        yield name, value
        if inspect.isclass(value):
            members = (inspect.isfunction, inspect.isdatadescriptor, inspect.ismethod)
            for member, one in vars(value).items():
                if not member.startswith("_") and (
                    isinstance(one, classmethod | staticmethod) or any(is_kind(one) for is_kind in members)
                ):
                    yield f"{name}.{member}", one


def test_examples_of_public_names_run_where_they_are_pasted():
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE)
    without = []
    for name, value in public_objects():
        text = inspect.getdoc(value) or ""
        examples_of_name = doctest.DocTestParser().get_examples(text)
        if examples_of_name:
            runner.run(doctest.DocTest(examples_of_name, {}, name, None, None, text))
        elif "." not in name:
            without.append(name)
    assert (runner.summarize(verbose=False).failed, without) == (0, [])


SECTION = re.compile(r"^(\w[\w ]*)\n-{3,}\n", re.MULTILINE)
YEAR = re.compile(r"(?<![.\d])(?:18|19|20)\d\d\b(?!\.\d)")


def sections(value):
    """The sections of a docstring by title; the summary has none."""
    parts = SECTION.split(inspect.getdoc(value) or "")
    return {"": parts[0], **dict(zip(parts[1::2], parts[2::2], strict=True))}


WITHOUT_ARGUMENTS = {"Level", "Status", "Result", "ShapePreserving", "SmoothingSpline", "__version__"}


@pytest.mark.parametrize("name", sorted(set(mdr.__all__) - WITHOUT_ARGUMENTS))
def test_docstrings_describe_arguments_returns_and_errors(name):
    value = getattr(mdr, name)
    if inspect.isclass(value) and issubclass(value, Exception):
        return
    result = sections(value)
    assert {"Parameters", "Raises", *([] if inspect.isclass(value) else ["Returns"])} <= set(result)
    for title in ("Parameters", "Returns", "Raises"):
        for entry in re.split(r"\n(?=\S)", result[title].strip()) if title in result else ():
            assert "\n    " in entry, f"{name}: {title} does not describe {entry.splitlines()[0]}"


def test_sources_that_docstrings_name_have_references():
    missing = {}
    for name, value in public_objects():
        parts = sections(value)
        listed = set(YEAR.findall(parts.pop("References", "")))
        parts.pop("Examples", None)
        if "." not in name and (years := set(YEAR.findall(" ".join(parts.values()))) - listed):
            missing[name] = years
    assert missing == {}


def test_references_are_cited_with_their_place():
    for name, value in public_objects():
        for source in re.findall(
            r"^- .*?\.$|^[A-Z].*?\.$", sections(value).get("References", ""), re.M | re.S
        ):
            assert re.match(r"(?:- )?[A-Z][\w ,.-]+ \(\d{4}\), \S", source), (name, source)


def test_names_to_see_also_exist():
    for name, value in public_objects():
        for line in sections(value).get("See Also", "").splitlines():
            if line.strip():
                seen, _, purpose = line.partition(" : ")
                assert purpose, (name, line)
                assert pkgutil.resolve_name(f"pymdr:{seen}") is not value, name
