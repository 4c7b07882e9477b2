"""What a simulation is, finished or not, and how much of it there is."""

import json
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, get_type_hints

import numpy as np
import xarray as xr
from jaxtyping import Float

from celltrain.evolution.ending import Ending
from celltrain.evolution.films.repulsion import Repulsion
from celltrain.evolution.methods import METHODS, Integrator, Memory, Work
from celltrain.evolution.record.quantities import RUN_QUANTITIES, STEP_QUANTITIES
from celltrain.evolution.state import Measures, State
from celltrain.parameters import Train
from celltrain.results import from_dataset, read_dataset
from celltrain.results.netcdf import reading
from celltrain.stability import Stability
from celltrain.steady import Base
from celltrain.train import place_cells

#: What the names of quantities of frames begin with in files.
FRAME_PREFIX = "frame_"


@dataclass(frozen=True)
class Run:
    """A simulation of a disturbed train, in r0, U and mu, in the frame of the steady train.

    Attributes:
        start: the steady train, or its stability, from which it started.
        disturbance: what was done to it, in words.
        growth_rate: that of the disturbance by the linear theory, U/r0; NaN if not known.
        integrator: how it is marched.
        repulsion: what keeps membranes apart in thin films.
        every, until: time between frames, and last time asked for, r0/U.
        history: a column for each of `STEP_QUANTITIES`, one entry for each step, the first for the
            beginning.
        times: of the frames: the multiples of `every`, and `until`.
        shapes: of the frames, every cell where it has really gone.
        frames: other quantities of the frames by name: "laps", "eps", "eps_x", "eps_linear", and
            those of `celltrain.diagnostics.frame`; velocities are relative to the tube.
        state: where it goes on from.
        memory: what the method remembers there.
        ending: why it ended.
    """

    start: Base | Stability
    disturbance: str
    growth_rate: float
    integrator: Integrator
    repulsion: Repulsion
    every: float
    until: float
    history: dict[str, np.ndarray]
    times: Float[np.ndarray, " frame"]
    shapes: Float[np.ndarray, "frame cell 3 coefficient"]
    frames: dict[str, np.ndarray]
    state: State
    memory: Memory
    ending: Ending

    @classmethod
    def load(cls, path: str | Path) -> "Run":
        """Read a simulation's file, whether the simulation has ended or not.

        **Raises:** `OSError` if it cannot be read or lacks what this version needs, `ValueError` if
        it holds no simulation.
        """
        data = read_dataset(Path(path))
        analysed = data.attrs["kind"] == Stability.kind
        start = from_dataset(Stability, data) if analysed else from_dataset(Base, data)
        if "ending" not in data.attrs:
            raise ValueError(f"{str(path)!r} is a result of celltrain, but holds no simulation")
        with reading(data):
            return _run(start, data)

    @property
    def steps(self) -> int:
        """Steps so far."""
        return len(self.history["time"]) - 1

    @property
    def work(self) -> Work:
        """Steps rejected, and evaluations of the velocity, since the beginning."""
        if not len(self.history["time"]):
            return Work()
        return Work(*(int(self.history[each.name][-1]) for each in fields(Work)))

    @property
    def base(self) -> Base:
        """The steady train."""
        return self.start.base if isinstance(self.start, Stability) else self.start

    @property
    def train(self) -> Train:
        """The case."""
        return self.base.train

    @property
    def disturbances(self) -> Float[np.ndarray, "frame cell 3 coefficient"]:
        """Shapes of the frames less those of the steady train, r0."""
        train = self.train
        return self.shapes - place_cells(self.base.coefficients, train, train.cells)


def _run(start: Base | Stability, data: xr.Dataset) -> Run:
    """The simulation in a file's data; `KeyError` if something is missing."""
    settings = json.loads(data.attrs["integrator"])
    method = METHODS[settings.pop("name")]
    state = _values(data, "state_", State) | {
        "measures": Measures(**_values(data, "state_", Measures))
    }
    return Run(
        start=start,
        disturbance=data.attrs["disturbance"],
        growth_rate=float(data.attrs["growth_rate"]),
        integrator=method(**settings),
        repulsion=Repulsion(**json.loads(data.attrs["repulsion"])),
        every=float(data.attrs["every"]),
        until=float(data.attrs["until"]),
        history={name: data[f"step_{name}"].values for name in STEP_QUANTITIES},
        times=data["time"].values,
        shapes=data["shapes"].values,
        frames={
            name.removeprefix(FRAME_PREFIX): data[name].values
            for name in RUN_QUANTITIES
            if name.startswith(FRAME_PREFIX)
        },
        state=State(**state),
        memory=method.remembers(**_values(data, "memory_", method.remembers)),
        ending=Ending(data.attrs["ending"], data.attrs["ending_message"]),
    )


def _values(data: xr.Dataset, prefix: str, kind: type) -> dict[str, Any]:
    """The fields of a dataclass, but for those that are dataclasses themselves."""
    found = {}
    for name, hint in get_type_hints(kind).items():
        if hint is Measures or name not in {each.name for each in fields(kind)}:
            continue
        value = data[f"{prefix}{name}"].values
        found[name] = hint(value) if value.ndim == 0 else value
    return found
