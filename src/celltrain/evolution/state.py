"""The physical state of a simulation, and what is measured of it."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int


@dataclass(frozen=True)
class Measures:
    """What is measured of shapes as soon as they are fit to go on from.

    Attributes:
        eps: size of the disturbance, Eq. (8), r0.
        eps_x: root of the sum over the cells of the mean square displacement of the membrane over
            solid angle, r0.
        energy: elastic energy of all membranes, mu U r0^2.
        area: area of all membranes, r0^2.
        volume_correction: largest displacement that the correction of the volumes took, r0.
        gap: thinnest film within the range of the repulsion, r0; infinite if there is none.
        film_energy, film_force: energy of the repulsion, mu U r0^2, and the largest force of films
            on a cell, mu U r0.
    """

    eps: float
    eps_x: float
    energy: float
    area: float
    volume_correction: float
    gap: float
    film_energy: float
    film_force: float


@dataclass(frozen=True)
class Settled:
    """Shapes made fit to go on from, and what is measured of them.

    Attributes:
        shapes: with the volumes of the steady train, every cell's mean point in the train's window,
            in the frame of the steady train, r0.
        laps: how many lengths of the train each cell is put back by.
        measures: of these shapes.
    """

    shapes: Float[np.ndarray, "cell 3 coefficient"]
    laps: Int[np.ndarray, " cell"]
    measures: Measures


@dataclass(frozen=True)
class State(Settled):
    """Where a train is at one time, and how it moves; whatever marches it can go on from there.

    Attributes:
        time: r0/U.
        rates: rates of change of the shapes in the frame of the steady train, U.
        wall_gap: smallest distance of a cell from the wall for which the wall was resolved, r0.
    """

    time: float
    rates: Float[np.ndarray, "cell 3 coefficient"]
    wall_gap: float
