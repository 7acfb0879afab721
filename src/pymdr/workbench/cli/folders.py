"""Where a command writes, and how its figures and tables get there."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pymdr.result import Result
    from pymdr.solving.fits import FitResult
    from pymdr.solving.study import Study
    from pymdr.solving.sweep import Sweep


def folders_of(cases: Sequence[Path], output: Path | None) -> dict[Path, Path]:
    """Where every case is written: no two into one folder."""
    from pymdr.errors import CaseError

    whole = {case: case.resolve() for case in cases}
    if output is None:
        folders = {case: named_after(case) for case in cases}
    elif len(cases) == 1:
        folders = {cases[0]: output}
    else:
        folders = {case: output / case.stem for case in cases}
        if len(set(folders.values())) < len(folders):
            shared = os.path.commonpath([file.parent for file in whole.values()])
            folders = {c: output / whole[c].parent.relative_to(shared) / c.stem for c in cases}
    taken: dict[Path, Path] = {}
    for case, folder in folders.items():
        other = taken.setdefault(folder.resolve(), case)
        if other != case or list(cases).count(case) > 1:
            raise CaseError(f"{other} and {case} would both be written into {folder}; name each of them once")
    return folders


def named_after(case: Path) -> Path:
    """The folder of a case beside its file."""
    from pymdr.errors import FileError

    if not case.name:
        raise FileError(f"cannot read {case}: a case file is a regular file, not a folder")
    return case.with_suffix("")


@contextmanager
def ready_folder(folder: Path) -> Iterator[Path]:
    """Make the folder and see that it takes files before any work is done; without result it goes again."""
    from pymdr.errors import FileError

    made = [place for place in (folder, *folder.parents) if not place.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe = folder / ".pymdr-probe"
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise FileError(
            f"cannot write into {folder}: {error.strerror or error}; choose another with -o DIR"
        ) from error
    try:
        yield folder
    except BaseException:
        for place in made:
            if any(place.iterdir()):
                break
            place.rmdir()
        raise


def write_figure(figure: Figure, file: Path) -> Path:
    """Write a figure, whole or not at all."""
    from pymdr.presentation.files import write_atomically

    write_atomically(file, lambda beside: figure.savefig(beside, dpi=150))
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


def write_found(found: Study | FitResult, output: Path | None, name: str) -> list[Path]:
    """The table and the figure of what was found, where a folder is named for them."""
    from pymdr.solving.press import PressedSurface

    if output is None:
        return []
    with ready_folder(output) as folder:
        found.to_csv(folder / f"{name}.csv")
        written = [folder / f"{name}.csv", write_figure(found.plot(), folder / f"{name}.png")]
        if isinstance(found, PressedSurface):
            found.save(folder / f"{name}.nc")
            written.append(folder / f"{name}.nc")
        return written


class Tables(NamedTuple):
    """Which tables are written."""

    csv: bool
    xlsx: bool

    def check(self) -> None:
        """Refuse before any work what cannot be written after it."""
        if self.xlsx:
            from pymdr.presentation.tables import new_book

            new_book()

    def write(self, found: Result | Sweep, folder: Path, name: str) -> list[Path]:
        """Write them into a folder."""
        written = []
        if self.csv:
            found.to_csv(folder / f"{name}.csv")
            written.append(folder / f"{name}.csv")
        if self.xlsx:
            found.to_xlsx(folder / f"{name}.xlsx")
            written.append(folder / f"{name}.xlsx")
        return written
