"""Bending: energy per unit of reference area, or moments, from the curvature of the surface.

Curvatures are mixed tensors kappa = a^-1 b with b_ij = n . x_ij and n outward, so that a sphere of
radius R has kappa = -1/R and the mean curvature H = -tr(kappa)/2 = 1/R.
"""

from dataclasses import dataclass
from typing import ClassVar, Protocol, TypeAlias, runtime_checkable

from celltrain.laws.arithmetic import Number

#: Components 11, 12, 21, 22 of a mixed tensor.
Mixed: TypeAlias = tuple[Number, Number, Number, Number]


@runtime_checkable
class BendingEnergy(Protocol):
    """Bending energy of a membrane: a dataclass with the names of `parameters.Cell`.

    The energy is proportional to `bending_modulus`, Eb in mu U r0^2.
    """

    @property
    def bending_modulus(self) -> Number:
        """The modulus Eb."""
        ...

    def energy_density(self, now: Mixed, rest: Mixed, dilatation: Number) -> Number:
        """Energy per reference area, in mu U.

        **Arguments:** curvature of the deformed surface and of the resting one, in 1/r0;
        `dilatation`: deformed over reference area.
        """
        ...


@dataclass(frozen=True)
class ElasticBending:
    """Linear isotropic bending about the resting shape, Eq. (2) of Bryngelson & Freund (2018).

    Eb/2 tr((kappa - kappa_ref)^2) for each reference area; nothing at rest.
    """

    bending_modulus: Number

    def energy_density(self, now: Mixed, rest: Mixed, dilatation: Number) -> Number:
        """See `BendingEnergy`."""
        del dilatation
        k11, k12, k21, k22 = (a - b for a, b in zip(now, rest, strict=True))
        return 0.5 * self.bending_modulus * (k11**2 + 2.0 * (k12 * k21) + k22**2)


@dataclass(frozen=True)
class HelfrichBending:
    """A fluid membrane's bending energy (Helfrich 1973), which knows no resting shape.

    Eb/2 (2H - c0)^2 for each area of the deformed surface: 8 pi Eb for any sphere if the
    spontaneous curvature c0 is zero. With c0 = 0 it is the elastic energy, with the same Eb, of a
    membrane that is flat at rest and keeps its area locally, plus 4 pi Eb, which is Eb int K dA.
    """

    bending_modulus: Number
    spontaneous_curvature: Number

    def energy_density(self, now: Mixed, rest: Mixed, dilatation: Number) -> Number:
        """See `BendingEnergy`."""
        del rest
        k11, _, _, k22 = now
        mean = -(k11 + k22)
        return 0.5 * self.bending_modulus * (mean - self.spontaneous_curvature) ** 2 * dilatation


@dataclass(frozen=True)
class MomentBending:
    """Bending moments for each current length, of which the transverse shear acts; no energy.

    M^ab = -Eb (kappa - kappa_ref)^a_c a^cb, Eq. (2) of Bryngelson & Freund (2018) as its published
    solver has it (RBC3D). The shear Q^b = D_a M^ab balances the moments, and its force D_b (Q^b n),
    for each current area, does the work

        f . dx dA = M^ab (db_ab - b_a^c x_,c . dx_,b) dA,

    with db_ab the change of the curvature form. The in-plane stress that would balance the moments
    about the normal is left out: on surfaces of revolution there is none, but elsewhere, also to
    first order beside them, the membrane then exerts a torque on the fluid.
    """

    bending_modulus: Number
    #: Whether the moments about the normal are balanced.
    BALANCED: ClassVar[bool] = False

    def moments(self, now: Mixed, rest: Mixed) -> Mixed:
        """Eb (kappa - kappa_ref), in mu U r0: -M as a mixed tensor."""
        k11, k12, k21, k22 = (
            self.bending_modulus * (a - b) for a, b in zip(now, rest, strict=True)
        )
        return k11, k12, k21, k22


@dataclass(frozen=True)
class BalancedMomentBending(MomentBending):
    """The same moments with the antisymmetric in-plane stress that balances them: no torque.

    x_,c . dx_,b becomes da_cb/2. That is the work of `ElasticBending` for current areas, with half
    of what the curvature a^-1 b changes by the metric; so this has no energy either.
    """

    BALANCED: ClassVar[bool] = True


#: What bends a membrane: an energy, or moments without one.
BendingLaw: TypeAlias = BendingEnergy | MomentBending

#: The ways to bend by their names in a case.
BENDINGS = {
    "elastic": ElasticBending,
    "helfrich": HelfrichBending,
    "moments": MomentBending,
    "balanced_moments": BalancedMomentBending,
}
