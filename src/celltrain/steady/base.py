"""The steady train: what a base flow is, and what is known about how it was reached."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

import numpy as np
from jaxtyping import Float

from celltrain.harmonics import Profile, profile_of
from celltrain.parameters import Train
from celltrain.quantities import Quantity, Record, quantity
from celltrain.steady.form import form_of


@dataclass(frozen=True)
class Iteration:
    """One step towards a steady train.

    `residual` is that of the shape before the step, in U; `step` the pseudo-time step in r0/U,
    infinite for Newton's method.
    """

    method: Annotated[Literal["march", "newton"], Quantity("", "1", "march or newton")]
    residual: Annotated[float, Quantity("", "U", "residual before the iteration")]
    step: Annotated[
        float,
        Quantity(r"\Delta t", "r0/U", "pseudo-time step, infinite for Newton's method"),
    ]
    cell_velocity: Annotated[float, Quantity("U_c", "U", "velocity of the train")]


#: Called after every iteration.
IterationProgress = Callable[[Iteration], None]


@dataclass(frozen=True, eq=False)
class Base(Record):
    """A steady train of equal axisymmetric cells, in r0, U and mu.

    `coefficients` are those of one cell whose mean point is at z = 0; the others are copies, one
    `train.period` apart. `residual` is the largest |v - U_c e_z| on the target grid, v being the
    discrete velocity whose coefficients are the rates of change of the shape; `truncation_error` is
    the same for the velocity before it is cut at the shape's degree: an estimate of what the degree
    leaves out. `velocity_error` estimates what everything else leaves out, relative to the velocity
    (see `rates_error`).
    """

    kind: ClassVar[str] = "base"
    title: ClassVar[str] = "steady train of cells in a tube"

    train: Train
    coefficients: Annotated[
        Float[np.ndarray, "3 coefficient"],
        Quantity(
            "s",
            "r0",
            "shape of one cell: coefficients of x, y, z in real orthonormal spherical harmonics;"
            " column n*n + n + m holds degree n and order m, cos(m phi) for m > 0, sin(|m| phi) for"
            " m < 0",
            ("axis", "coefficient"),
            bulky=True,
        ),
    ]
    cell_velocity: Annotated[
        float, Quantity("U_c", "U", "velocity at which the steady train moves")
    ]
    gap: Annotated[
        float,
        Quantity(
            r"\Delta",
            "r0",
            "least streamwise distance between the membranes of neighbouring cells",
            words="gap between cells",
        ),
    ]
    largest_radius: Annotated[
        float, Quantity(r"r_\mathrm{max}", "r0", "largest distance of a cell from the axis")
    ]
    effective_viscosity: Annotated[
        float,
        Quantity(
            r"\mu_\mathrm{eff}",
            "mu",
            "viscosity of the plain fluid with the same pressure drop at the same flow rate",
        ),
    ]
    residual: Annotated[
        float,
        Quantity(
            r"\max|v - U_c e_z|",
            "U",
            "largest velocity of the membrane relative to the moving train",
        ),
    ]
    truncation_error: Annotated[
        float,
        Quantity(
            r"\max|u - v|",
            "U",
            "the same before the velocity is cut at the degree of the shape",
            words="left out by the degree",
        ),
    ]
    velocity_error: Annotated[
        float,
        Quantity(
            r"\max|\Delta v|/\max|v|",
            "1",
            "estimated relative error of the velocity by the rules and grids",
            words="relative error of the velocity",
        ),
    ]
    history: tuple[Iteration, ...]
    origin: Annotated[str, Quantity("", "1", "how the steady train was reached")]
    seconds: Annotated[dict[str, float], Quantity("", "s", "wall time of each stage")]

    @property
    def profile(self) -> Profile:
        """The cells' meridian (see `harmonics.profile`)."""
        return profile_of(self.coefficients)

    @property
    @quantity(Quantity("", "1", "form of a cell in words", words="form"))
    def form(self) -> str:
        """Whether a cell is a parachute, a bullet, ... (see `steady.form`)."""
        return form_of(self.profile)


class NotConverged(RuntimeError):
    """No steady train was found; `last` is the last state and `history` the way to it."""

    def __init__(self, message: str, last: Base) -> None:
        super().__init__(message)
        self.last = last

    @property
    def history(self) -> tuple[Iteration, ...]:
        """The way to the last state."""
        return self.last.history


class MembraneCrosses(NotConverged):
    """The train that was found is none of cells: their membrane crosses itself."""
