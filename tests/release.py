"""Build the archives of a release as a user would get them, and try the package on other versions of Python and of its dependencies.

``python -m tests.release archives`` clones the last commit twice, builds an sdist from each and a wheel from the sdist, compares their bytes,
checks their metadata, installs the wheel into a new environment, and runs the README there. ``python -m tests.release matrix`` installs the
package with the newest dependencies on every Python of ``VERSIONS`` that the machine has, and with the oldest that pyproject.toml allows
on the first, and runs the README and ``QUICK`` in each. ``python -m tests.release paper`` writes paper/paper.md with its citations and figures
as one HTML file into build. None changes the files of the clone.
"""

import argparse
import hashlib
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
VERSIONS = ("3.11", "3.12", "3.13")
QUICK = ("test_units.py", "test_solving.py", "test_tables.py", "test_moduli.py")
TOOLS = ("pytest>=8.3", "hypothesis>=6.100", "mpmath>=1.3")
REPORTED = ("numpy", "scipy", "numba", "pandas", "xarray", "matplotlib", "typer")
DEPRECATED = ("-W", "ignore::DeprecationWarning", "-W", "ignore::PendingDeprecationWarning")
"""An old package next to new ones that it does not pin warns of its own calls."""


def run(*command: str | Path, cwd: Path, **environment: str) -> str:
    """Output of a command that knows nothing of this clone; ends the program with its output if it fails."""
    kept = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "VIRTUAL_ENV")}
    done = subprocess.run(
        [str(part) for part in command],
        cwd=cwd,
        env={**kept, "MPLBACKEND": "agg", **environment},
        capture_output=True,
        text=True,
    )
    if done.returncode:
        raise SystemExit(f"{' '.join(map(str, command))}\n{done.stdout[-4000:]}{done.stderr[-4000:]}")
    return done.stdout


def uv(*arguments: str | Path, cwd: Path) -> str:
    return run(sys.executable, "-m", "uv", *arguments, "--quiet", cwd=cwd)


def program(environment: Path, name: str) -> Path:
    return environment / ("Scripts" if os.name == "nt" else "bin") / name


def clone(folder: Path) -> Path:
    run("git", "clone", "--quiet", ROOT, folder, cwd=ROOT)
    return folder


def built(source: Path) -> dict[str, bytes]:
    """The archives of a clone, dated by its last commit."""
    date = run("git", "log", "-1", "--format=%ct", cwd=source).strip()
    run(sys.executable, "-m", "build", "--installer", "uv", ".", cwd=source, SOURCE_DATE_EPOCH=date)
    return {file.name: file.read_bytes() for file in sorted((source / "dist").iterdir())}


def read_me(environment: Path, folder: Path) -> None:
    """Run the README's Python, and its first commands, in an empty folder."""
    folder.mkdir()
    blocks = re.findall(
        r"^```python\n(.*?)^```", (ROOT / "README.md").read_text(encoding="utf-8"), re.S | re.M
    )
    (folder / "readme.py").write_text("\n".join(blocks), encoding="utf-8")
    run(program(environment, "python"), "readme.py", cwd=folder)
    if not (folder / "ball.png").stat().st_size > 10_000:
        raise SystemExit("the README drew no figure")
    run(program(environment, "pymdr"), "new", "ball", "-o", "case.toml", cwd=folder)
    run(program(environment, "pymdr"), "run", "case.toml", "-o", "out", cwd=folder)
    if not (folder / "out" / "result.nc").exists():
        raise SystemExit("pymdr run wrote no result")


def archives(folder: Path) -> None:
    """Build twice, compare, check, install, run."""
    first, second = (built(clone(folder / name)) for name in ("one", "two"))
    for name, content in first.items():
        same = second.get(name) == content
        print(
            f"{name}: {len(content) / 1e6:.2f} MB, sha256 {hashlib.sha256(content).hexdigest()}, ",
            end="",
        )
        print("the same bytes twice" if same else "DIFFERENT BYTES")
        if not same:
            raise SystemExit("two builds of one commit differ")
    files = [folder / "one" / "dist" / name for name in first]
    run(sys.executable, "-m", "twine", "check", "--strict", *files, cwd=folder)
    print("twine check --strict: passed")
    (wheel,) = (file for file in files if file.suffix == ".whl")
    uv("venv", folder / "env", "--python", sys.executable, cwd=folder)
    uv("pip", "install", "--python", program(folder / "env", "python"), wheel, cwd=folder)
    version = run(program(folder / "env", "pymdr"), "--version", cwd=folder).strip()
    if version.split()[1] != wheel.name.split("-")[1]:
        raise SystemExit(f"{version} is installed from {wheel.name}")
    read_me(folder / "env", folder / "work")
    print(f"{version}: installed in a new environment; the README runs there")
    shutil.copytree(folder / "one" / "dist", ROOT / "dist", dirs_exist_ok=True)
    print(f"Written: {', '.join(f'dist/{name}' for name in first)}")


def interpreter(version: str, folder: Path) -> str | None:
    """A Python of one version, on the path or installed by pyenv; None if there is none."""
    try:
        return uv("python", "find", "--no-project", version, cwd=folder).strip() or version
    except SystemExit:
        kept = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions"
        return next((str(one) for one in sorted(kept.glob(f"{version}.*/bin/python"), reverse=True)), None)


def try_on(python: str, resolution: str, source: Path, folder: Path) -> str:
    """Install the package with dependencies of one kind, run the README and the quick tests; the versions."""
    number = len(list(folder.iterdir()))
    env = folder / f"env-{number}"
    uv("venv", env, "--python", python, cwd=folder)
    own = program(env, "python")
    # only what the package needs is resolved to its lowest; the tools of the tests are not its dependencies
    uv("pip", "install", "--python", own, "--resolution", resolution, source, cwd=folder)
    uv("pip", "install", "--python", own, *TOOLS, cwd=folder)
    read_me(env, folder / f"work-{number}")
    tests = [f"tests/{name}" for name in QUICK]
    options = ("-q", "-p", "no:cacheprovider", "-o", "testpaths=tests", *DEPRECATED)
    summary = run(own, "-m", "pytest", *options, *tests, cwd=source).splitlines()[-1]
    code = f"from importlib.metadata import version as v\nprint(*(f'{{n}} {{v(n)}}' for n in {REPORTED}), sep=', ')"
    return f"{summary.strip('= ')}; {run(own, '-c', code, cwd=folder).strip()}"


def matrix(folder: Path, versions: tuple[str, ...]) -> None:
    """Every version of Python with the newest dependencies, the first with the oldest."""
    source = clone(folder / "source")
    for python, resolution in [(versions[0], "lowest-direct"), *((v, "highest") for v in versions)]:
        result = interpreter(python, folder)
        if result is None:
            print(f"Python {python}: not on this machine, not tried", flush=True)
        else:
            print(f"Python {python}, {resolution}: {try_on(result, resolution, source, folder)}", flush=True)


def paper(file: Path) -> None:
    """Write the paper as one file; what pandoc warns of, such as a citation without its source, is an error."""
    import pypandoc

    file.parent.mkdir(exist_ok=True)
    # figures are named relative to the folder of the paper
    run(
        pypandoc.get_pandoc_path(),
        "paper.md",
        *("--standalone", "--citeproc", "--embed-resources", "--mathml", "--fail-if-warnings"),
        *("--output", file),
        cwd=ROOT / "paper",
    )
    print(f"Written: {file}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", choices=["archives", "matrix", "paper"])
    parser.add_argument("--python", nargs="+", default=VERSIONS, metavar="VERSION")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        if given.what == "paper":
            paper(ROOT / "build" / "paper.html")
        elif given.what == "archives":
            archives(Path(folder))
        else:
            matrix(Path(folder), tuple(given.python))


if __name__ == "__main__":
    main()
