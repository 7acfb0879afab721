"""The Python blocks of the documentation pages run, and their assertions hold."""

import re
from pathlib import Path

import pytest

import pymdr

DOCS = Path(__file__).parent.parent / "docs"
OUTPUT = re.compile(r"^( *)```python\n(.*?)^\1```\n(?:\n\1```text\n(.*?)^\1```)?", re.MULTILINE | re.DOTALL)
BLOCK = re.compile(r"^( *)```python\n(.*?)^\1```", re.MULTILINE | re.DOTALL)


def blocks(page):
    for indent, body in BLOCK.findall(page.read_text()):
        yield re.sub(f"^{indent}", "", body, flags=re.MULTILINE)


@pytest.mark.parametrize(
    "page",
    [
        "first_steps.md",
        "book.md",
        "adhesion.md",
        "friction.md",
        "claims.md",
        "exactness.md",
        "profiles.md",
        "contributing.md",
    ],
)
def test_blocks_run(page):
    found = list(blocks(DOCS / page))
    assert any("assert " in block for block in found)
    space = {"__name__": page.replace(".", "_")}
    for block in found:
        exec(compile(block, page, "exec"), space)


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


def test_the_readme_leads_to_every_page():
    links = set(re.findall(r"\]\(docs/(\w+\.md)\)", (DOCS.parent / "README.md").read_text()))
    assert links == {page.name for page in DOCS.glob("*.md")} - {"index.md"}
    contents = (DOCS / "index.md").read_text().split()
    assert all(page.removesuffix(".md") in contents for page in links)


def test_no_source_is_cited_that_readers_do_not_have():
    root = DOCS.parent
    texts = [*root.glob("*.md"), *DOCS.glob("*.md"), *(root / "docs/demonstrations").glob("*.py")]
    for file in [*texts, *(root / "examples").glob("*.py"), *(root / "src").rglob("*.py")]:
        assert not re.search(r"mdr_math|DESIGN\.md|founding", file.read_text(encoding="utf-8")), file


def test_the_readme_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    space = {}
    for block in blocks(DOCS.parent / "README.md"):
        exec(compile(block, "README.md", "exec"), space)
    assert (tmp_path / "ball.png").stat().st_size > 10_000


def test_the_reference_names_everything_public():
    named = set(re.findall(r"^   (\w+)$", (DOCS / "reference.md").read_text(), re.MULTILINE))
    errors = {name for name in pymdr.__all__ if name.endswith("Error")}  # in the page of pymdr.errors
    assert set(pymdr.__all__) - named - errors == {"__version__"}


@pytest.mark.parametrize("page", sorted(DOCS.glob("*.md")), ids=lambda p: p.stem)
def test_named_modules_exist(page):
    package = Path(pymdr.__file__).parent
    for name in re.findall(r"`((?:\w+/)+(?:\w+\.py)?)`", page.read_text()):
        assert (package / name).exists(), name
