"""Studies: trains over ranges or distributions of parameters."""

from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import Annotated

from celltrain.contract import Crew, InFolder, Kept, Setting, presentation
from celltrain.contract.files import pictures
from celltrain.contract.status import ComputationFailed
from celltrain.study import (
    NoCentralTrain,
    SampledStudy,
    SampleResult,
    Study,
    StudyResult,
    collect_sample,
    compute_study,
    read_study,
    run_sample,
)


@dataclass(frozen=True, kw_only=True)
class Sweep(InFolder):
    """Run or resume a study: trains over ranges or distributions of parameters.

    Exit status 3 if cases failed; the table says why.
    """

    argument = "study"

    study: Annotated[Path, Setting("TOML file of the study.")]

    @cached_property
    def _wanted(self) -> Study | SampledStudy:
        return read_study(self.study)

    def check(self) -> None:
        """Read the study.

        Raises:
            CaseError: if the file cannot be read, or the study or a case of it is not allowed.
        """
        _ = self._wanted

    @property
    def folder(self) -> Path:
        """Named after the study's file, in the folder at work."""
        return Path(self.study.stem)

    def compute(self, folder: Path, crew: Crew) -> Kept:
        """Compute the cases that the folder has no result of.

        Raises:
            CaseError, ComputationFailed, KeyboardInterrupt: as `Crew`.
        """
        wanted = self._wanted
        result: StudyResult | SampleResult
        if isinstance(wanted, SampledStudy):
            run = partial(run_sample, wanted, folder.absolute())
            try:
                found = crew(run, wanted.title, wanted.total, many=True)
            except NoCentralTrain as error:
                raise ComputationFailed(str(error)) from None
            result = collect_sample(wanted, found)
        else:
            result = compute_study(wanted, folder, crew)
        shown, table = presentation(result.kind), result.table()
        return Kept(
            table,
            shown.summary(result),
            {"table.md": table},
            {"study.nc": result},
            partial(pictures, result),
            shown.status(result),
        )
