"""What a simulation is, finished or not, and how much of it there is."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float

from celltrain.evolution.ending import Ending
from celltrain.evolution.integrator import Integrator
from celltrain.evolution.repulsion import Repulsion
from celltrain.evolution.state import State
from celltrain.parameters import Train
from celltrain.stability import Stability
from celltrain.steady import Base
from celltrain.train import place_cells


@dataclass(frozen=True)
class Run:
    """A simulation of a disturbed train, in r0, U and mu, in the frame of the steady train.

    Attributes:
        start: the steady train, or its stability, from which it started.
        disturbance: what was done to it, in words.
        growth_rate: that of the disturbance by the linear theory, U/r0; nan if not known.
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
    ending: Ending

    @classmethod
    def load(cls, path: str | Path) -> "Run":
        """Read a simulation's file, whether the simulation has ended or not.

        **Raises:** `OSError` if it cannot be read, `ValueError` if it holds no simulation.
        """
        from celltrain.evolution.archive import load_run  # it makes objects of this class

        return load_run(Path(path))

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
