"""Bending energies: energy per unit of reference area from the curvature of the surface.

Curvatures are mixed tensors kappa = a^-1 b with b_ij = n . x_ij and n outward, so that a sphere of
radius R has kappa = -1/R and the mean curvature H = -tr(kappa)/2 = 1/R.
"""

import abc

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

#: Components 11, 12, 21, 22 of a mixed tensor at the points of a grid.
Mixed = tuple[
    Float[Array, " point"], Float[Array, " point"], Float[Array, " point"], Float[Array, " point"]
]


class BendingLaw(eqx.Module):
    """Bending energy of a membrane; it is proportional to the field `modulus`."""

    modulus: eqx.AbstractVar[Float[Array, ""]]

    @abc.abstractmethod
    def energy_density(
        self, now: Mixed, rest: Mixed, dilatation: Float[Array, " point"]
    ) -> Float[Array, " point"]:
        """Energy per reference area, in mu U.

        **Arguments:** curvature of the deformed surface and of the resting one, in 1/r0;
        `dilatation`: deformed over reference area.
        """


class ElasticBending(BendingLaw):
    """Linear isotropic bending about the resting shape, Eq. (2) of Bryngelson & Freund (2018).

    Eb/2 tr((kappa - kappa_ref)^2) for each reference area; nothing at rest.
    """

    modulus: Float[Array, ""]

    def energy_density(
        self, now: Mixed, rest: Mixed, dilatation: Float[Array, " point"]
    ) -> Float[Array, " point"]:
        """See `BendingLaw`."""
        del dilatation
        k11, k12, k21, k22 = (a - b for a, b in zip(now, rest, strict=True))
        return 0.5 * self.modulus * (k11**2 + 2.0 * k12 * k21 + k22**2)


class HelfrichBending(BendingLaw):
    """A fluid membrane's bending energy (Helfrich 1973), which knows no resting shape.

    Eb/2 (2H - c0)^2 for each area of the deformed surface: 8 pi Eb for any sphere if the
    spontaneous curvature c0 is zero. With c0 = 0 it is the elastic energy, with the same Eb, of a
    membrane that is flat at rest and keeps its area locally, plus 4 pi Eb, which is Eb int K dA.
    """

    modulus: Float[Array, ""]
    spontaneous_curvature: Float[Array, ""]

    def energy_density(
        self, now: Mixed, rest: Mixed, dilatation: Float[Array, " point"]
    ) -> Float[Array, " point"]:
        """See `BendingLaw`."""
        del rest
        k11, _, _, k22 = now
        mean = -(k11 + k22)
        return 0.5 * self.modulus * (mean - self.spontaneous_curvature) ** 2 * dilatation


def make_bending(
    name: str,
    modulus: float | Float[Array, ""],
    spontaneous_curvature: float | Float[Array, ""] = 0.0,
) -> BendingLaw:
    """The bending energy of the given name; `KeyError` if there is none."""
    eb = jnp.asarray(modulus, dtype=float)
    laws = {
        "elastic": lambda: ElasticBending(eb),
        "helfrich": lambda: HelfrichBending(eb, jnp.asarray(spontaneous_curvature, dtype=float)),
    }
    return laws[name]()
