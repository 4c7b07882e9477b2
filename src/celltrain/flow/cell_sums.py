"""What the surfaces of cells give by the near kernels: ordinary sums, and graded rules close by."""

import math

import equinox as eqx
from jaxtyping import Array, Float, Int

from celltrain.flow.close_targets import CloseEvaluation, CloseTargets
from celltrain.flow.near import near_sum
from celltrain.flow.sources import Sources
from celltrain.harmonics.jax_shapes import JaxShapes

# Close pairs listed for each target on a cell, on average.
CELL_SHARE = 2.0


class CellSums(eqx.Module):
    """Sums of the near kernels over cells and their images, but for the targets' own cells.

    `parameter` is xi of the near kernels (0: those in free space), beyond the `cutoff` they are
    left out. Images go from -`images` to `images`, `period` apart along z. Cells farther from
    targets than `coarse_beyond` contribute with their coarse samples. Without `close` no target may
    come close to another cell.
    """

    period: Float[Array, ""]
    close: CloseEvaluation | None
    parameter: float = eqx.field(static=True)
    cutoff: float = eqx.field(static=True)
    images: int = eqx.field(static=True)
    coarse_beyond: float = eqx.field(static=True)

    def velocity(
        self,
        targets: Float[Array, "group target 3"],
        owners: Int[Array, " group"],
        sources: Sources,
        close_targets: CloseTargets | None,
    ) -> Float[Array, "group target 3"]:
        """Velocity by all cells and images but that on which a group of targets lies, in U.

        **Arguments:** `owners`: that cell, -1 for points off the cells.
        """
        total = near_sum(
            targets,
            owners,
            sources,
            parameter=self.parameter,
            cutoff=self.cutoff,
            period=self.period,
            images=self.images,
            coarse_beyond=self.coarse_beyond,
            left_out=None if close_targets is None else close_targets.pairs.left_out,
        ) / (8.0 * math.pi)
        if close_targets is not None and self.close is not None:
            total += self.close.velocity(close_targets, targets, sources, self.period)
        return total

    def close_targets(
        self,
        targets: Float[Array, "group target 3"],
        owners: Int[Array, " group"],
        points: Float[Array, "cell source_ring source_azimuth 3"],
        share: float,
        *,
        shapes: JaxShapes | None = None,
    ) -> CloseTargets | None:
        """Which targets are close to which cells' grid points.

        **Arguments:** `share`: pairs listed for each target, on average; `shapes`: prepares double
        layers on these cells, for many densities.
        """
        close = self.close
        if close is None:
            return None
        cells = points.reshape(points.shape[0], -1, 3)
        found = close.find(
            targets, owners, cells, period=self.period, images=self.images, share=share
        )
        return found if shapes is None else close.prepared(found, targets, shapes, self.period)
