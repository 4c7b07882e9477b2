"""The ellipsoid that fits a cell best, and how it lies in the tube."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float


class Ellipsoid(eqx.Module):
    """An ellipsoid about a cell's centroid.

    `semi_axes` in r0, the shortest first; `axes` their unit vectors, one in each row, each with a
    positive largest component.
    """

    semi_axes: Float[Array, "3"]
    axes: Float[Array, "3 3"]

    @property
    def inclination(self) -> Float[Array, ""]:
        """Angle between the shortest axis and the tube's axis, 0 to pi/2, in radians.

        A red blood cell at rest in the tube has 0. Where the two shortest axes are nearly equal,
        as in a long bullet, they change places and the angle jumps.
        """
        return jnp.arctan2(jnp.hypot(self.axes[0, 0], self.axes[0, 1]), jnp.abs(self.axes[0, 2]))

    @property
    def taylor_deformation(self) -> Float[Array, ""]:
        """(l - b)/(l + b), with l the longest and b the shortest axis (Taylor 1934)."""
        shortest, longest = self.semi_axes[0], self.semi_axes[2]
        return (longest - shortest) / (longest + shortest)


def best_ellipsoid(solid: Float[Array, "3 3"]) -> Ellipsoid:
    """The ellipsoid with the second moments G = (1/V) int x x dV of a cell.

    A solid ellipsoid has G = diag(a^2, b^2, c^2)/5, so its semi-axes are sqrt(5 g), g the
    eigenvalues. (It has the volume of the cell only if the cell is an ellipsoid.)
    """
    values, vectors = jnp.linalg.eigh(solid)
    axes = vectors.T
    largest = jnp.take_along_axis(axes, jnp.argmax(jnp.abs(axes), axis=1)[:, None], axis=1)
    return Ellipsoid(jnp.sqrt(5.0 * values), axes * jnp.sign(largest))
