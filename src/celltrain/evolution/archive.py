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

from celltrain.evolution.ending import Ending
from celltrain.evolution.euler import ForwardEuler
from celltrain.evolution.integrator import Integrator
from celltrain.evolution.quantities import RUN_QUANTITIES, STEP_QUANTITIES
from celltrain.evolution.repulsion import Repulsion
from celltrain.evolution.run import Run
from celltrain.evolution.runge_kutta_chebyshev import RungeKuttaChebyshev
from celltrain.evolution.state import State
from celltrain.results import from_dataset, read_dataset, replace_file, to_dataset
from celltrain.results.netcdf import reading
from celltrain.stability import Stability
from celltrain.steady import Base

INTEGRATORS: dict[str, type[Integrator]] = {
    method.__name__: method for method in (RungeKuttaChebyshev, ForwardEuler)
}
_FRAME_PREFIX = "frame_"
_COUNTS: dict[str, type] = {"radius_age": int, "steps": int, "rejected": int, "evaluations": int}


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
    values |= {f"{_FRAME_PREFIX}{name}": each for name, each in run.frames.items()}
    values |= {f"state_{name}": value for name, value in vars(run.state).items()}
    return {name: _variable(name, value) for name, value in values.items()}


def _variable(name: str, value: Any) -> xr.Variable:
    known = RUN_QUANTITIES[name]
    attributes = {"long_name": known.description, "units": known.unit, "symbol": known.symbol}
    return xr.Variable(known.dims, value, attributes)


def load_run(path: Path) -> Run:
    """Read a simulation's file.

    **Raises:** `OSError` if it cannot be read or lacks what this version needs, `ValueError` if it
    holds no simulation.
    """
    data = read_dataset(path)
    start = from_dataset(Stability if data.attrs["kind"] == "stability" else Base, data)
    if "ending" not in data.attrs:
        raise ValueError(f"{str(path)!r} is a result of celltrain, but holds no simulation")
    with reading(data):
        return _run(start, data)


def _run(start: Base | Stability, data: xr.Dataset) -> Run:
    """The simulation in a file's data; `KeyError` if something is missing."""
    settings = json.loads(data.attrs["integrator"])
    state: dict[str, Any] = {
        name.removeprefix("state_"): data[name].values
        for name in RUN_QUANTITIES
        if name.startswith("state_")
    }
    state |= {
        name: _COUNTS.get(name, float)(value) for name, value in state.items() if value.ndim == 0
    }
    return Run(
        start=start,
        disturbance=data.attrs["disturbance"],
        growth_rate=float(data.attrs["growth_rate"]),
        integrator=INTEGRATORS[settings.pop("name")](**settings),
        repulsion=Repulsion(**json.loads(data.attrs["repulsion"])),
        every=float(data.attrs["every"]),
        until=float(data.attrs["until"]),
        history={name: data[f"step_{name}"].values for name in STEP_QUANTITIES},
        times=data["time"].values,
        shapes=data["shapes"].values,
        frames={
            name.removeprefix(_FRAME_PREFIX): data[name].values
            for name in RUN_QUANTITIES
            if name.startswith(_FRAME_PREFIX)
        },
        state=State(**state),
        ending=Ending(data.attrs["ending"], data.attrs["ending_message"]),
    )
