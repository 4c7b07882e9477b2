"""The complete state of an integration, and the record of a step."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int


@dataclass(frozen=True)
class State:
    """All that an integrator needs to go on, to the last bit.

    Attributes:
        time: r0/U.
        shapes: every cell's mean point in the train's window, frame of the steady train, r0.
        laps: lengths of the train that each cell is put back by.
        rates: rates of change of these shapes in the same frame, U.
        step: size of the next step, r0/U.
        last_step, last_error: those of the step before (error relative to the tolerance), 0 if
            there was none.
        radius: estimated spectral radius, U/r0, 0 if not known.
        radius_age: steps since it was estimated.
        direction: last direction of the power iteration.
        steps, rejected, evaluations: counts since the beginning.
        gap: thinnest film within the range of the repulsion, r0; infinite if there is none.
        wall_gap: smallest distance of a cell from the wall for which the wall was resolved, r0.
    """

    time: float
    shapes: Float[np.ndarray, "cell 3 coefficient"]
    laps: Int[np.ndarray, " cell"]
    rates: Float[np.ndarray, "cell 3 coefficient"]
    step: float
    last_step: float
    last_error: float
    radius: float
    radius_age: int
    direction: Float[np.ndarray, "cell 3 coefficient"]
    steps: int
    rejected: int
    evaluations: int
    gap: float
    wall_gap: float


@dataclass(frozen=True)
class Record:
    """What is kept of a step: the state at its end, and how it was taken.

    Attributes:
        time: at the end of the step, r0/U.
        eps, eps_x, energy, area, volume_correction, gap, film_energy, film_force: as in `Settled`,
            there.
        size: of the step, r0/U; 0 for the beginning.
        stages: evaluations that the step itself took.
        error: estimated error of the step, the largest displacement of a membrane, r0.
        radius: spectral radius assumed, U/r0.
        rejected, evaluations: counts since the beginning.
    """

    time: float
    eps: float
    eps_x: float
    energy: float
    area: float
    volume_correction: float
    gap: float
    film_energy: float
    film_force: float
    size: float
    stages: int
    error: float
    radius: float
    rejected: int
    evaluations: int
