"""What the explorer was opened with: nothing, a case, a result, a simulation, a study's folder."""

from dataclasses import dataclass
from pathlib import Path

from celltrain.contract import load, presentation
from celltrain.evolution import Run
from celltrain.explore.address import USUAL, View
from celltrain.explore.overview import Overview, overview_of
from celltrain.parameters import CaseError, merge_case, read_case
from celltrain.quantities import Record
from celltrain.steady import Base
from celltrain.study import SampleResult, StudyResult

#: The file in a study's folder that holds its numbers.
STUDY_FILE = "study.nc"


@dataclass(frozen=True, eq=False)
class Opened:
    """Where a page begins, and what else it shows: a steady train, a simulation or a study."""

    view: View
    name: str = ""
    start: Base | None = None
    run: Run | None = None
    study: Overview | None = None


def opened(path: Path | None) -> Opened:
    """What a file or folder holds.

    Raises:
        CaseError: if it cannot be read, or holds nothing that can be explored.
    """
    if path is None:
        return Opened(View(USUAL))
    if path.is_dir():
        return _of_folder(path)
    if path.suffix.lower() == ".nc":
        return _of_result(read_result(path), path)
    content = read_case(path)
    if {"axes", "distributions"} & set(content):
        raise CaseError(
            f"{str(path)!r} is a study, not a case; allowed: the folder that `celltrain sweep"
            f" {path}` makes"
        )
    units = "SI" if content.get("units") == "SI" else "dimensionless"
    return Opened(View(merge_case(content, {}), units), path.name)  # type: ignore[arg-type]


def read_result(path: Path) -> Record:
    """The result in a file.

    Raises:
        CaseError: if there is none.
    """
    if not path.is_file():
        raise CaseError(f"{str(path)!r} cannot be read: there is no such file")
    try:
        return load(path)
    except (OSError, ValueError) as error:
        raise CaseError(f"{str(path)!r} is not a result of celltrain: {error}") from None


def _of_folder(path: Path) -> Opened:
    file = path / STUDY_FILE
    if not file.is_file():
        raise CaseError(
            f"{str(path)!r} cannot be explored: there is no {STUDY_FILE} in it; allowed: the folder"
            " of a study that `celltrain sweep` has finished"
        )
    return _of_result(read_result(file), path)


def _of_result(result: Record, path: Path) -> Opened:
    if isinstance(result, StudyResult | SampleResult):
        try:
            study = overview_of(result)
        except CaseError as error:
            raise CaseError(f"{str(path)!r}: {error}") from None
        return Opened(View(study.first, study.units), path.name, study=study)
    base = presentation(result.kind).steady_train(result)
    run = result if isinstance(result, Run) else None
    return Opened(View(base.train), path.name, base, run)
