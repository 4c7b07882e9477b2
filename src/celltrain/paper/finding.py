"""A statement of the paper beside what we find, and the cases of a study that it needs."""

import math
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import SupportsFloat

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from celltrain.parameters import Train, merge_case, paper_units

#: The paper's packings of sparse and of dense trains.
SPARSE, DENSE = 0.2, 0.7


@dataclass(frozen=True)
class Finding:
    """A statement of the paper, what we find, and whether it holds.

    `holds` is None where cases that it needs are not there.
    """

    name: str
    statement: str
    found: str
    holds: bool | None


def finding(name: str, statement: str, found: str, holds: object, needed: ArrayLike) -> Finding:
    """A finding that is not known unless all of the numbers that it needs are."""
    numbers = np.asarray(needed, dtype=float)
    if numbers.size == 0 or not np.isfinite(numbers).all():
        return Finding(name, statement, "cases are missing", None)
    return Finding(name, statement, found, bool(holds))


def findings_table(findings: Sequence[Finding]) -> str:
    """Findings as a table in Markdown."""
    words = {True: "yes", False: "no", None: "not known"}
    lines = ["| | the paper, in our words | found | holds |", "|---|---|---|---|"]
    lines += [
        f"| {each.name} | {each.statement} | {each.found} | {words[each.holds]} |"
        for each in findings
    ]
    return "\n".join(lines) + "\n"


def first_case(data: xr.Dataset) -> Train:
    """The first case of a study, from which the others differ by the axes' values."""
    return merge_case(tomllib.loads(data.attrs["case"]), {"unusual": True})


def in_paper_units(rates: xr.DataArray) -> xr.DataArray:
    """Rates in U/r0 as the paper prints them."""
    return rates.copy(data=paper_units.rate(rates.values))


def at(values: xr.DataArray, **places: float) -> xr.DataArray:
    """Values at places on some axes, to rounding; NaN where a study has no such place."""
    for name, place in places.items():
        chosen = np.flatnonzero(np.isclose(values[name], place))
        here = values.isel({name: int(chosen[0]) if chosen.size else 0}, drop=True)
        values = here if chosen.size else xr.full_like(here, math.nan)
    return values


def number(value: SupportsFloat, error: SupportsFloat = math.nan) -> str:
    """A number with its error, if that is known: ``0.118 +- 0.017``."""
    value, error = float(value), float(error)
    if not math.isfinite(value):
        return "not known"
    return f"{value:.3g}" + (f" +- {error:.1g}" if math.isfinite(error) else "")


def numbers(values: xr.DataArray, errors: xr.DataArray) -> str:
    """The numbers along one axis, each with its error and its place: ``8: 0.118 +- 0.017``."""
    [axis] = values.dims
    return ", ".join(
        f"{float(place):.3g}: {number(value, error)}"
        for place, value, error in zip(
            values[axis].values, values.values, errors.values, strict=True
        )
    )
