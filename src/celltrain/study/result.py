"""A study's result: a dataset over its axes."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import xarray as xr

from celltrain.results.labelled import Labelled
from celltrain.study.columns import COLUMNS

#: Columns of the table that people read: heading, name, format.
TABLE = (
    ("alpha, U/r0", "spectral_abscissa", ".2e"),
    ("its error", "error_estimate", ".0e"),
    ("M", "taken_degree", ".0f"),
    ("m", "leading_azimuthal_number", ".0f"),
    ("j", "leading_wave_number", ".0f"),
    ("eta, U/r0", "numerical_abscissa", ".3f"),
    ("U_c, U", "cell_velocity", ".5f"),
    ("gap, r0", "gap", ".4f"),
    ("viscosity, mu", "effective_viscosity", ".5f"),
    ("residual, U", "residual", ".0e"),
)
_OWN = {*COLUMNS, "status", "reason", "origin"}


@dataclass(frozen=True, eq=False)
class StudyResult(Labelled):
    """The numbers of all cases of a study over its axes, in r0, U and mu.

    Axes are in the units of the study file. A number that is not there is NaN; `status` and
    `reason` say why, `origin` how each steady train was reached.
    """

    kind: ClassVar[str] = "study"
    title: ClassVar[str] = "study of trains of cells in a tube"

    @property
    def failed(self) -> int:
        """How many cases failed."""
        return int((self.data["status"] == "failed").sum())

    def table(self) -> str:
        """The study as a table in Markdown, a line for each case, and why cases failed."""
        axes = list(self.data["status"].dims)
        more = [(name, str(name), ".4g") for name in self.data.data_vars if str(name) not in _OWN]
        columns = (*TABLE, *more)
        headings = [
            *(self._heading(str(axis)) for axis in axes),
            *(str(heading) for heading, *_ in columns),
        ]
        lines = [f"| {' | '.join(headings)} |", "|" + "---|" * len(headings)]
        failures = []
        for case in self._cases():
            places = [case[axis].item() for axis in axes]
            cells = [each if isinstance(each, str) else f"{each:g}" for each in places]
            words = ", ".join(f"{axis} = {cell}" for axis, cell in zip(axes, cells, strict=True))
            for _, name, form in columns:
                value = float(case[name])
                cells.append("" if value != value else format(value, form))
            lines.append(f"| {' | '.join(cells)} |")
            if case["status"].item() == "failed":
                failures.append(f"- {words}: {' '.join(str(case['reason'].item()).split())}")
        if failures:
            lines += ["", "Failed:", "", *failures]
        return "\n".join(lines) + "\n"

    def _heading(self, axis: str) -> str:
        unit = self.data[axis].attrs.get("units", "1")
        return axis if unit == "1" else f"{axis}, {unit}"

    def _cases(self) -> list[xr.Dataset]:
        shape = self.data["status"].shape
        names = [str(name) for name in self.data["status"].dims]
        return [
            self.data.isel(dict(zip(names, index, strict=True))) for index in np.ndindex(*shape)
        ]
