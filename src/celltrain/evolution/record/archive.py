"""A simulation's file: one netCDF-4 file that is whole at every moment.

The file is never changed in place: everything that is known, the state to go on from included,
replaces it at once (see `results.replace`). The price is that each save writes all frames again
(27 kB for each frame of eight cells at degree 12), which `evolve` bounds by saving less often as
saving takes longer.

The file is also a result file: `celltrain.load` gives the steady train or its stability.
"""

import json
from pathlib import Path
from typing import Any

import xarray as xr

from celltrain.evolution.record.quantities import (
    RUN_QUANTITIES,
    STEP_QUANTITIES,
    Attributes,
    memory_quantities,
)
from celltrain.evolution.record.run import FRAME_PREFIX, Run
from celltrain.results import replace_file, to_dataset


class Archive:
    """The file of one simulation."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._of_start: tuple[object, xr.Dataset] | None = None

    def save(self, run: Run) -> None:
        """Replace the file by one with all of a simulation.

        **Raises:** `OSError` if it cannot be written; the old file is left as it was.
        """
        data = self._start(run).assign(_variables(run)).assign_attrs(_header(run))
        encoding = {name: {"_FillValue": None} for name in data.variables}

        def write(part: Path) -> None:
            data.to_netcdf(part, engine="h5netcdf", encoding=encoding)

        replace_file(self._path, write)

    def _start(self, run: Run) -> xr.Dataset:
        """The part of the file that stays the same."""
        if self._of_start is None or self._of_start[0] is not run.start:
            self._of_start = (run.start, to_dataset(run.start))
        return self._of_start[1]


def _header(run: Run) -> dict[str, Any]:
    return {
        "title": "simulation of a disturbed train of cells in a tube",
        "disturbance": run.disturbance,
        "integrator": json.dumps(
            {"name": type(run.integrator).__name__, **run.integrator.settings()}
        ),
        "repulsion": json.dumps(run.repulsion.settings()),
        "growth_rate": run.growth_rate,
        "every": run.every,
        "until": run.until,
        "ending": run.ending.kind,
        "ending_message": run.ending.message,
    }


def _variables(run: Run) -> dict[str, xr.Variable]:
    values: dict[str, Any] = {f"step_{name}": run.history[name] for name in STEP_QUANTITIES}
    values |= {"time": run.times, "shapes": run.shapes}
    values |= {f"{FRAME_PREFIX}{name}": each for name, each in run.frames.items()}
    state = vars(run.state) | vars(run.state.measures)
    values |= {f"state_{name}": value for name, value in state.items() if name != "measures"}
    values |= {f"memory_{name}": value for name, value in vars(run.memory).items()}
    known = RUN_QUANTITIES | memory_quantities(type(run.memory))
    return {name: _variable(known[name], value) for name, value in values.items()}


def _variable(known: Attributes, value: Any) -> xr.Variable:
    attributes = {"long_name": known.description, "units": known.unit, "symbol": known.symbol}
    return xr.Variable(known.dims, value, attributes)
