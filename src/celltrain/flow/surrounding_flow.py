"""What the operator of cells of any shape asks of the flow around them, whatever bounds it."""

import abc

import equinox as eqx
from jaxtyping import Array, Float, Int

from celltrain.flow.close_targets import CloseTargets
from celltrain.flow.sources import Sources
from celltrain.harmonics.jax_shapes import JaxShapes

# For each set of points at which a flow is evaluated, the targets first.
CloseTargetSets = tuple[CloseTargets, ...]


class SurroundingFlow(eqx.Module):
    """Stokes flow around cells: what their surfaces drive, and what there is without them.

    A velocity is the sum of three parts: the near kernel's integral over a target's own cell (see
    `OwnSurfaceRule`), everything else that the cells' forces and motions give, and the background,
    the flow without them. The last two are this object's. Velocities have forward derivatives.
    """

    @property
    @abc.abstractmethod
    def near_parameter(self) -> float:
        """xi of the near kernel that is left out on a target's own cell; 0: that in free space."""

    @abc.abstractmethod
    def velocity(
        self,
        targets: Float[Array, "group ring azimuth 3"],
        owners: Int[Array, " group"],
        sources: Sources,
        *,
        close_targets: CloseTargetSets | None = None,
        background: bool = True,
    ) -> Float[Array, "group ring azimuth 3"]:
        """Velocity at points in the fluid or on cells, in U.

        **Arguments:** `owners`: cell on which each group of targets lies, -1 for points off the
        cells. The near kernels of a group's own cell are left out. `close_targets`: of these
        targets and cells, if they are known already. Without the `background` the velocity is
        linear in the sources.
        """

    @abc.abstractmethod
    def close_targets(
        self,
        targets: Float[Array, "group ring azimuth 3"],
        owners: Int[Array, " group"],
        points: Float[Array, "cell source_ring source_azimuth 3"],
        *,
        shapes: JaxShapes | None = None,
    ) -> CloseTargetSets | None:
        """Which targets, and which other points that `velocity` needs, are close to cells.

        That is to their grid points; None where no point may be close.

        **Arguments:** `shapes`: prepares double layers on these cells, for many densities.
        """
