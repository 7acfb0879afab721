"""Output folders of commands, and writing of figures and tables."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from pymdr.errors import CaseError, FileError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pymdr.result import Result
    from pymdr.solving.study import Answer
    from pymdr.solving.sweep import Sweep


def folders_of(cases: Sequence[Path], output: Path | None) -> dict[Path, Path]:
    """A distinct output folder for every case."""
    absolute = {case: case.resolve() for case in cases}
    if output is None:
        folders = {case: named_after(case) for case in cases}
    elif len(cases) == 1:
        folders = {cases[0]: output}
    else:
        folders = {case: output / case.stem for case in cases}
        if len(set(folders.values())) < len(folders):
            shared = os.path.commonpath([file.parent for file in absolute.values()])
            folders = {c: output / absolute[c].parent.relative_to(shared) / c.stem for c in cases}
    taken: dict[Path, Path] = {}
    for case, folder in folders.items():
        other = taken.setdefault(folder.resolve(), case)
        if other != case or list(cases).count(case) > 1:
            raise CaseError(f"{other} and {case} would both be written into {folder}; give each case once")
    return folders


def named_after(case: Path) -> Path:
    """The default folder of a case, next to its file."""
    if not case.name:
        raise FileError(
            f"cannot read {case}: a case file is a regular file, not a folder; give the name of a .toml file"
        )
    return case.with_suffix("")


@contextmanager
def ready_folder(folder: Path) -> Iterator[Path]:
    """Create a folder and check that it is writable; a failure removes it again."""
    from pymdr.presentation.files import named_file

    named_file(folder, "write")
    made = [place for place in (folder, *folder.parents) if not place.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe = folder / ".pymdr-probe"
        probe.touch()
        probe.unlink()
    except OSError as error:
        why = "it is a file" if folder.is_file() else error.strerror or error
        raise FileError(f"cannot write into {folder}: {why}; choose another folder with -o DIR") from error
    try:
        yield folder
    except BaseException:
        for place in made:
            if any(place.iterdir()):
                break
            place.rmdir()
        raise


def ready_output(output: Path | None) -> AbstractContextManager[Path | None]:
    """A writable folder, if one is given: before a command computes."""
    return nullcontext() if output is None else ready_folder(output)


def write_figure(figure: Figure, file: Path) -> Path:
    """Write a figure atomically. Its layout is computed once: matplotlib computes it anew, and draws twice, while it has an engine."""
    from pymdr.presentation.files import write_atomically

    engine = figure.get_layout_engine()
    if engine is not None:
        engine.execute(figure)
        figure.set_layout_engine(None)
    write_atomically(file, lambda temporary: figure.savefig(temporary, dpi=figure.dpi))
    return file


def write_figures(
    figures: Mapping[str, Figure], folder: Path, progress: Callable[[int, int], None] | None
) -> list[Path]:
    """Write figures under their names."""
    files = []
    for name, figure in figures.items():
        files.append(write_figure(figure, folder / f"{name}.png"))
        if progress is not None:
            progress(len(files), len(figures))
    return files


def write_study(
    study: Answer, output: Path | None, name: str, figures: bool = True, animate: bool = False
) -> list[Path]:
    """Write the table and the figure of a study, if a folder is given and figures are wanted."""
    from pymdr.solving.machines import Motion
    from pymdr.solving.press import PressedSurface

    if output is None:
        return []
    with ready_folder(output) as folder:
        study.to_csv(folder / f"{name}.csv")
        written = [folder / f"{name}.csv"]
        if figures:
            written.append(write_figure(study.plot(), folder / f"{name}.png"))
        if animate and isinstance(study, Motion):
            study.animate(folder / f"{name}.gif")
            written.append(folder / f"{name}.gif")
        if isinstance(study, PressedSurface):
            study.save(folder / f"{name}.nc")
            written.append(folder / f"{name}.nc")
        return written


def write_stress(result: Result, wanted: Mapping[str, Any], folder: Path, figures: bool) -> list[Path]:
    """
    Write the stress inside the bodies of a result as the table ``[stress]`` of its case wants it: figure, animation and table.

    Parameters
    ----------
    wanted : mapping
        The table ``[stress]``.
    """
    keys = dict(wanted)
    name, animate = keys.pop("measure", "von_mises"), keys.pop("animate", False)
    axes = {axis: keys.pop(axis) for axis in ("r", "x", "z") if axis in keys}
    written = []
    if figures:
        written.append(write_figure(result.plot_stress(name=name, **keys), folder / "stress.png"))
        if animate:
            result.animate_stress(folder / "stress.gif", name=name, **keys)
            written.append(folder / "stress.gif")
    if axes:
        result.stress_to_csv(folder / "stress.csv", **axes, **keys)
        written.append(folder / "stress.csv")
    return written


def write_report(study: Answer, file: Path | None, title: str, settings: Mapping[str, object]) -> list[Path]:
    """Write the report of a study, if a file is given; settings that are not given are left out."""
    if file is None:
        return []
    given = {
        name.replace("_", " "): ", ".join(map(str, value)) if isinstance(value, list | tuple) else str(value)
        for name, value in settings.items()
        if value not in (None, False, [], ())
    }
    study.to_html(file, title=title, settings=given)
    return [file]


class Tables(NamedTuple):
    """Which tables are written."""

    csv: bool
    xlsx: bool

    def check(self) -> None:
        """Check before solving that the tables can be written."""
        if self.xlsx:
            from pymdr.presentation.tables import new_book

            new_book()

    def write(self, result: Result | Sweep, folder: Path, name: str) -> list[Path]:
        """Write the tables into a folder."""
        written = []
        if self.csv:
            result.to_csv(folder / f"{name}.csv")
            written.append(folder / f"{name}.csv")
        if self.xlsx:
            result.to_xlsx(folder / f"{name}.xlsx")
            written.append(folder / f"{name}.xlsx")
        return written
