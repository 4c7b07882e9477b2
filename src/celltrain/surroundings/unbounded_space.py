"""Unbounded space with a linear background flow."""

from dataclasses import dataclass

import numpy as np

from celltrain.flow import UnboundedFlow, unbounded_flow
from celltrain.parameters import CaseError
from celltrain.proximity.walls import NoWall
from celltrain.surroundings.surroundings import FlowRules, Surroundings

Row = tuple[float, float, float]

# A trace below this part of the largest component is rounding.
TRACE = 1e-12
STILL: tuple[Row, Row, Row] = ((0.0, 0.0, 0.0),) * 3


@dataclass(frozen=True)
class UnboundedSpace(Surroundings):
    """Fluid without boundaries, that flows as u_i = A_ij x_j without cells.

    `gradient` is A by rows, in U/r0; at rest unless given. There is no length that recurs, and no
    flow rate: U is any velocity, by which moduli and times are measured.

    **Raises:** `CaseError` for a gradient that is not finite, or that has a trace: the fluid is
    incompressible.
    """

    gradient: tuple[Row, Row, Row] = STILL

    def __post_init__(self) -> None:
        gradient = np.asarray(self.gradient, dtype=float)
        if gradient.shape != (3, 3) or not np.isfinite(gradient).all():
            raise CaseError(
                f"gradient = {self.gradient!r} is not allowed; allowed: three rows of three numbers"
            )
        trace = float(np.trace(gradient))
        if abs(trace) > TRACE * np.abs(gradient).max():
            raise CaseError(
                f"gradient = {self.gradient!r} is not allowed: its trace is {trace:g}; allowed: 0,"
                " as the fluid is incompressible"
            )

    @property
    def wall(self) -> NoWall:
        """See `Surroundings`."""
        return NoWall()

    @property
    def period(self) -> float:
        """See `Surroundings`."""
        return float("inf")

    def flow(self, rules: FlowRules) -> UnboundedFlow:
        """See `Surroundings`."""
        return unbounded_flow(
            np.asarray(self.gradient, dtype=float),
            close=rules.close,
            coarse_beyond=rules.coarse_beyond,
        )


def simple_shear(rate: float) -> UnboundedSpace:
    """Unbounded space with the flow u = k y e_x, the rate k in U/r0."""
    return UnboundedSpace(((0.0, rate, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)))
