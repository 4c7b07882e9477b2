"""Study files: those of ranges and those of distributions."""

from pathlib import Path

from celltrain.parameters import CaseError, read_case
from celltrain.study.definition import Study, make_study
from celltrain.study.sampling.definition import SampledStudy, make_sampled_study


def read_study(path: str | Path) -> Study | SampledStudy:
    """The study that a TOML file describes: a sample if it has distributions, else a grid.

    Raises:
        CaseError: if the file cannot be read, or the study or one of its cases is not allowed.
    """
    content = {"title": Path(path).stem, **read_case(path)}
    if "distributions" in content:
        return make_sampled_study(content)
    if "sample" in content:
        raise CaseError("[sample] is not allowed without [distributions]")
    return make_study(content)
