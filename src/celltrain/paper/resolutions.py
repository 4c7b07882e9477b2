"""One figure's data at both resolutions: what is drawn as lines, and what as symbols."""

import tomllib
from typing import Any, TypeAlias

import xarray as xr

from celltrain.paper.trains import PAPER_DEGREE

#: The resolutions by their names on the command line: the paper's, and converged.
PAPER, CONVERGED = "paper", "converged"
#: Data of one figure by resolution; either may be absent, not both.
Resolutions: TypeAlias = dict[str, xr.Dataset]

#: How a curve is drawn, for matplotlib.
Style: TypeAlias = dict[str, Any]

#: How each is drawn: lines for what is converged, open symbols for the paper's degree.
LABELS = {CONVERGED: "converged", PAPER: f"M = {PAPER_DEGREE}"}


def present(data: Resolutions) -> list[tuple[str, xr.Dataset]]:
    """What is there, the converged one first."""
    return [(name, data[name]) for name in (CONVERGED, PAPER) if name in data]


def label_of(name: str, data: xr.Dataset) -> str:
    """What a legend calls data: converged, or the degree where the study's case gives one."""
    case = tomllib.loads(data.attrs.get("case", ""))
    degree = case.get("resolution", {}).get("degree")
    return LABELS[name] if degree is None else f"M = {degree}"


def best(data: Resolutions) -> xr.Dataset:
    """The converged data, or else the paper's."""
    return present(data)[0][1]
