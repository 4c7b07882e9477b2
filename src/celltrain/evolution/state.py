"""The physical state of a simulation, and what is measured of it."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from jaxtyping import Float, Int

from celltrain.quantities import Quantity

_SHAPE = ("cell", "axis", "coefficient")


@dataclass(frozen=True)
class Measures:
    """What is measured of shapes as soon as they are fit to go on from."""

    eps: Annotated[float, Quantity(r"\epsilon", "r0", "size of the disturbance", source="Eq. (8)")]
    eps_x: Annotated[
        float,
        Quantity(
            r"\epsilon_x",
            "r0",
            "root of the sum over cells of the mean square displacement of the membrane",
        ),
    ]
    energy: Annotated[
        float, Quantity("W", "mu U r0^2", "elastic energy of all membranes, nan if they have none")
    ]
    area: Annotated[float, Quantity("A", "r0^2", "area of all membranes")]
    volume_correction: Annotated[
        float,
        Quantity("", "r0", "largest displacement by the correction of the cells' volumes"),
    ]
    gap: Annotated[
        float,
        Quantity(
            "d", "r0", "thinnest film within the range of the repulsion, infinite if there is none"
        ),
    ]
    film_energy: Annotated[
        float, Quantity("W_r", "mu U r0^2", "energy of the repulsion in all films")
    ]
    film_force: Annotated[
        float,
        Quantity(
            "",
            "mu U r0",
            "largest force of films on a cell, the sum of its parts without regard to directions",
        ),
    ]


@dataclass(frozen=True)
class Settled:
    """Shapes made fit to go on from, and what is measured of them.

    They have the volumes of the steady train, in whose frame they are.
    """

    shapes: Annotated[
        Float[np.ndarray, "cell 3 coefficient"],
        Quantity("s", "r0", "shapes, mean points within the train's length", _SHAPE),
    ]
    laps: Annotated[
        Int[np.ndarray, " cell"],
        Quantity("", "1", "lengths of the train that each cell is put back by", ("cell",)),
    ]
    measures: Measures


@dataclass(frozen=True)
class State(Settled):
    """Where a train is at one time, and how it moves; whatever marches it can go on from there."""

    time: Annotated[float, Quantity("t", "r0/U", "time")]
    rates: Annotated[
        Float[np.ndarray, "cell 3 coefficient"],
        Quantity("", "U", "rates of change of the shapes in the frame of the steady train", _SHAPE),
    ]
    wall_gap: Annotated[
        float,
        Quantity("", "r0", "smallest distance of cells from the wall for which it is resolved"),
    ]
