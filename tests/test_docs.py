"""The Python blocks of the documentation pages run, and their assertions hold."""

import re
from pathlib import Path

import pytest

import pymdr

DOCS = Path(__file__).parent.parent / "docs"
BLOCK = re.compile(r"^( *)```python\n(.*?)^\1```", re.MULTILINE | re.DOTALL)


def blocks(page):
    for indent, body in BLOCK.findall(page.read_text()):
        yield re.sub(f"^{indent}", "", body, flags=re.MULTILINE)


@pytest.mark.parametrize(
    "page",
    [
        "first_steps.md",
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
