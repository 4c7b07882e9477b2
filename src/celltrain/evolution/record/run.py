"""What a simulation is, finished or not, and how much of it there is."""

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Annotated, ClassVar

import numpy as np
from jaxtyping import Float

from celltrain.evolution.ending import Ending
from celltrain.evolution.films.repulsion import Repulsion
from celltrain.evolution.methods import Memory, Method, Work
from celltrain.evolution.record.quantities import KEPT_OF_FRAMES, STEP_QUANTITIES
from celltrain.evolution.state import State
from celltrain.membrane import place_cells
from celltrain.parameters import Train
from celltrain.quantities import Quantity, Record
from celltrain.results import read
from celltrain.stability import Stability
from celltrain.steady import Base


@dataclass(frozen=True, eq=False)
class Run(Record):
    """A simulation of a disturbed train, in r0, U and mu, in the frame of the steady train.

    `history` holds a column for each of `STEP_QUANTITIES`, one entry for each step, the first for
    the beginning; `frames` what is kept of the frames besides their `times` and `shapes`, by name:
    "laps", "eps", "eps_x", "eps_linear", and what `celltrain.diagnostics.frame` measures.
    Velocities are relative to the tube. It goes on from `state`, and what the method remembers
    there.
    """

    kind: ClassVar[str] = "simulation"
    title: ClassVar[str] = "simulation of a disturbed train of cells in a tube"

    start: Base | Stability
    disturbance: Annotated[str, Quantity("", "1", "what was done to the steady train, in words")]
    growth_rate: Annotated[
        float,
        Quantity(
            r"\alpha",
            "U/r0",
            "growth rate of the disturbance by the linear theory, NaN if it is not known",
        ),
    ]
    integrator: Method
    repulsion: Repulsion
    every: Annotated[float, Quantity("", "r0/U", "time between frames")]
    until: Annotated[float, Quantity("", "r0/U", "last time asked for")]
    history: Annotated[
        dict[str, np.ndarray],
        Quantity("", "1", "a number for each step", parts=STEP_QUANTITIES, bulky=True),
    ]
    times: Annotated[
        Float[np.ndarray, " frame"],
        Quantity("t", "r0/U", "times of the frames: the multiples of `every`, and `until`"),
    ]
    shapes: Annotated[
        Float[np.ndarray, "frame cell 3 coefficient"],
        Quantity(
            "s",
            "r0",
            "shapes of all cells in the frames, where they have really gone; coefficients as those"
            " of the steady train",
            ("frame", "cell", "axis", "coefficient"),
            bulky=True,
        ),
    ]
    frames: Annotated[
        dict[str, np.ndarray],
        Quantity("", "1", "what is kept of each frame", parts=KEPT_OF_FRAMES, bulky=True),
    ]
    state: Annotated[State, Quantity("", "1", "where it goes on from", bulky=True)]
    memory: Annotated[Memory, Quantity("", "1", "what the method remembers there", bulky=True)]
    ending: Ending

    @classmethod
    def load(cls, path: str | Path) -> "Run":
        """Read a simulation's file, whether the simulation has ended or not.

        **Raises:** `OSError` if it cannot be read or lacks what this version needs, `ValueError` if
        it holds no simulation.
        """
        return read(path, cls)

    @property
    def reached(self) -> float:
        """The time that is reached, r0/U: of the last step, or of a frame within the next."""
        return max(self.state.time, float(self.times[-1]))

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
