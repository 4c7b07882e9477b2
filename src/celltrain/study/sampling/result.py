"""A sample's result: every train's numbers, their distribution, and what makes them vary."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import xarray as xr

from celltrain.results.labelled import Labelled

#: Failed trains that the report names; files name all.
NAMED = 20
#: What reports call outputs.
WORDS = {
    "spectral_abscissa": "alpha",
    "cell_velocity": "U_c",
    "effective_viscosity": "apparent viscosity",
    "gap": "gap",
    "largest_radius": "largest radius",
}


@dataclass(frozen=True, eq=False)
class SampleResult(Labelled):
    """The trains of a sample by matrix and point, and what is estimated from them.

    In r0, U and mu, or in SI where the study is. A number that is not there is NaN; `status` and
    `reason` say why.
    """

    kind: ClassVar[str] = "sample"
    title: ClassVar[str] = "sample of trains of cells that differ"

    @property
    def failed(self) -> int:
        """How many trains failed."""
        return int((self.data["status"] == "failed").sum())

    def table(self) -> str:
        """Distributions, quantiles and indices as tables in Markdown, and why trains failed."""
        data = self.data
        finished = int((data["status"] == "finished").sum())
        total = data["status"].size
        missing = total - finished - self.failed
        lines = [
            f"{data.attrs['title']}: {data.sizes['point']} points, {total} trains, {finished}"
            f" finished, {self.failed} failed" + (f", {missing} not computed" if missing else ""),
            "",
            *_table(
                ("parameter", "distribution"),
                [(self._unit(str(n.item())), str(d.item())) for n, d in self._distributions()],
            ),
            "",
        ]
        lines += [*self._quantiles(), ""]
        alpha = data.sel(output="spectral_abscissa")
        part = _with_error(100.0 * float(alpha["positive"]), 100.0 * float(alpha["positive_error"]))
        lines.append(f"Unstable (alpha > 0): {part} % of the trains.")
        checked = data["error_estimate"].values
        known = checked[np.isfinite(checked)]
        words = f"; at most {known.max():.1e} in {known.size} others" if known.size else ""
        lines.append(
            f"Error of alpha at degree {data.attrs['degree']}:"
            f" {data.attrs['central_error']:.1e} in the train of the means{words}."
        )
        seconds = data["processor_seconds"].values
        if finished:
            lines.append(f"Processor time of a train: {np.nanmean(seconds):.2g} s.")
        lines += ["", *self._indices(), *self._failures()]
        return "\n".join(lines).rstrip() + "\n"

    def _distributions(self) -> list[tuple[xr.DataArray, xr.DataArray]]:
        return list(zip(self.data["parameter"], self.data["distribution"], strict=True))

    def _unit(self, name: str) -> str:
        unit = self.data[name].attrs.get("units", "1")
        words = WORDS.get(name, name)
        return words if unit == "1" else f"{words}, {unit}"

    def _quantiles(self) -> list[str]:
        data = self.data
        head = ["", "at the means", "mean", "standard deviation"]
        head += [f"{100.0 * part:g} %" for part in data["probability"].values]
        rows = []
        for name in data["output"].values:
            row = data.sel(output=name)
            cells = [self._unit(str(name)), f"{float(row['central']):.5g}"]
            for each in ("mean", "standard_deviation"):
                cells.append(_with_error(float(row[each]), float(row[f"{each}_error"])))
            for value, error in zip(
                row["quantile"].values, row["quantile_error"].values, strict=True
            ):
                cells.append(_with_error(value, error))
            rows.append(cells)
        return _table(head, rows)

    def _indices(self) -> list[str]:
        """Tables of indices, if there are any."""
        data = self.data
        if "first_order" not in data:
            return []
        lines = []
        titles = {
            "first_order": "First-order Sobol indices: the part of an output's variance that goes"
            " when a parameter is known (95 % interval)",
            "total_order": "Total Sobol indices: the part that stays when all others are known"
            " (95 % interval)",
        }
        head = ["", *(WORDS.get(str(name), str(name)) for name in data["output"].values)]
        for order, title in titles.items():
            rows = []
            for parameter in data["parameter"].values:
                cells = [str(parameter)]
                for name in data["output"].values:
                    row = data.sel(output=name, parameter=parameter)
                    value, low, high = (float(row[order + end]) for end in ("", "_low", "_high"))
                    shown = f"{value:.3f} ({low:.3f} to {high:.3f})"
                    cells.append(shown if math.isfinite(value) else "does not vary")
                rows.append(cells)
            sums = data[order].sum("parameter").values
            rows.append(["sum", *(f"{each:.3f}" for each in sums)])
            lines += [f"{title}:", "", *_table(head, rows), ""]
        left = data.sizes["point"] - int(data.attrs["complete_points"])
        if left:
            lines += [f"{left} points with a failed train are left out of the indices.", ""]
        return lines

    def failures(self) -> list[dict[str, object]]:
        """The parameters of each train that failed, and the reason."""
        data = self.data
        names = [str(name) for name in data["parameter"].values]
        found: list[dict[str, object]] = []
        for matrix, point in np.argwhere(data["status"].values == "failed"):
            train = data.isel(matrix=matrix, point=point)
            values: dict[str, object] = {name: float(train[name]) for name in names}
            found.append(values | {"reason": " ".join(str(train["reason"].item()).split())})
        return found

    def _failures(self) -> list[str]:
        failures = self.failures()
        lines = ["Failed:", ""] if failures else []
        for each in failures[:NAMED]:
            words = (f"{name} = {value:g}" for name, value in each.items() if name != "reason")
            lines.append(f"- {', '.join(words)}: {each['reason']}")
        if len(failures) > NAMED:
            lines.append(f"- and {len(failures) - NAMED} more; `reason` in the file names all")
        return lines


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """A table in Markdown whose columns are aligned."""
    widths = [max(map(len, column)) for column in zip(head, *rows, strict=True)]
    rule = ["-" * max(3, width) for width in widths]
    return [
        "| "
        + " | ".join(cell.ljust(max(3, w)) for cell, w in zip(line, widths, strict=True))
        + " |"
        for line in (head, rule, *rows)
    ]


def _with_error(value: float, error: float) -> str:
    """A value with its error, in as many digits as the error has two of."""
    if not math.isfinite(value):
        return ""
    if not math.isfinite(error) or error <= 0.0:
        return f"{value:.5g}"
    digits = 1 - math.floor(math.log10(error))
    if -2 <= digits <= 7:
        places = max(0, digits)
        return f"{value:.{places}f} ± {error:.{places}f}"
    power = math.floor(math.log10(max(abs(value), error)))
    places = max(0, digits + power)
    return f"({value / 10**power:.{places}f} ± {error / 10**power:.{places}f})e{power}"
