"""What drives the flow: point forces and stresslets on the surfaces of the cells."""

import equinox as eqx
from jaxtyping import Array, Float

from celltrain.harmonics.jax_shapes import JaxShapes


class Surface(eqx.Module):
    """The surfaces and densities themselves, as coefficients; either density may be absent.

    `forces` are those per solid angle, in mu U r0; `densities` are w, in U.
    """

    shapes: JaxShapes
    forces: JaxShapes | None = None
    densities: JaxShapes | None = None


class Sources(eqx.Module):
    """Weighted samples of surface densities on a product grid of each cell; either may be absent.

    `forces` are those on the fluid, in mu U r0. `stresslets` are symmetric dyads w n + n w times
    the area that a point stands for, in U r0^2, of a double layer

        (1/8 pi) int T_ijk(y - x) w_j n_k dS,   T_ijk(r) = -6 r_i r_j r_k/r^5,   n outward.

    With the `surface` that they are samples of, velocities are accurate close to it, too. `coarse`
    holds samples on half as many rings and azimuths, which serve at a distance.
    """

    points: Float[Array, "cell ring azimuth 3"]
    forces: Float[Array, "cell ring azimuth 3"] | None = None
    stresslets: Float[Array, "cell ring azimuth 6"] | None = None
    surface: Surface | None = None
    coarse: "Sources | None" = None

    @property
    def cells(self) -> int:
        """Number of cells."""
        return self.points.shape[0]
