"""Resting shapes of other reduced volumes, Fig. 17 of Bryngelson & Freund (2018).

The healthy biconcave cell of area A_0 is deflated or inflated to the volume V = v V_0, V_0 = 4 pi/3
(A_0/4 pi)^(3/2) being the largest that its area can hold, and relaxes:

    least E(s) + P(s)   subject to   A(s) = A_0,  V(s) = v V_0,

over axisymmetric shapes with a mirror plane, E the energy of the healthy cell's membrane (Skalak
with the default moduli, bending about the biconcave shape; the minimum depends on ratios of moduli
only). The shape that is found is then free of stress: another cell's rest.

Below v of about 0.61 the two faces of the dimple would meet. P keeps them apart while the shape
forms: with h = 2 z/n_z the thickness along the normal, from one face to its mirror image,

    P = K int_(upper face) max(0, 1 - h/range)^3 dA,

finite and of short range. It is zero for all larger v, and the finished shape has no part of it.

The search is by sequential quadratic programming, its end corrected by Newton's method (see
`stationary`), which also gives the derivative of a shape by v.
"""

from functools import cache
from math import copysign, isqrt, pi, sqrt, trunc

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from scipy.optimize import NonlinearConstraint, minimize

from celltrain.harmonics import coefficient_index
from celltrain.harmonics.tables import harmonic_tables
from celltrain.membrane.bending import make_bending
from celltrain.membrane.energy import Membrane
from celltrain.membrane.geometry import surface_geometry
from celltrain.membrane.laws import make_law
from celltrain.membrane.reference import reference_coefficients
from celltrain.membrane.stationary import corrected_minimum, minimum_slope
from celltrain.parameters import CaseError, Cell

#: Thickness, in r0, below which the faces of a cell repel each other while it forms.
REPULSION_RANGE = 0.2
#: Energy of the repulsion for each area where the faces touch, mu U.
REPULSION_STRENGTH = 10.0
#: Change of the reduced volume from one minimum to the next.
VOLUME_STEP = 0.02
#: Order of the rule along the meridian; the densities are no polynomials.
LEAST_ORDER = 48
#: Closer to 1 than this the shape is the sphere, to which it tends like sqrt(1 - v).
NEARLY_ONE = 1e-6
#: Largest part of the forces, in mu U r0, that the constraints do not balance.
LARGEST_IMBALANCE = 1e-9


class Relaxation(eqx.Module):
    """A cell's energy, area and volume as functions of its free coefficients.

    Integrals are taken along one meridian, with weights for the whole circle.
    """

    membrane: Membrane
    basis: Float[Array, "unknown 3 coefficient"]
    upper: Float[Array, " point"]
    repulsion: Float[Array, ""]

    def shape(self, unknowns: Float[Array, " unknown"]) -> Float[Array, "3 coefficient"]:
        """The harmonic coefficients of a shape."""
        return jnp.einsum("u,uik->ik", unknowns, self.basis)

    def unknowns(self, shape: Float[Array, "3 coefficient"]) -> Float[Array, " unknown"]:
        """The free coefficients of a shape that is axisymmetric and has a mirror plane."""
        return jnp.einsum("uik,ik->u", self.basis, shape)

    def thickness(
        self, shape: Float[Array, "3 coefficient"]
    ) -> tuple[Float[Array, " point"], Float[Array, " point"]]:
        """Thickness along the normal, r0, and the area that each point stands for, r0^2."""
        surface = surface_geometry(self.membrane.tables, shape)
        area = surface.area * self.membrane.inverse_sine * self.membrane.weights
        return 2.0 * surface.position[:, 2] / surface.normal[:, 2], area

    def energy(self, unknowns: Float[Array, " unknown"]) -> Float[Array, ""]:
        """Energy of the membrane and of the repulsion, mu U r0^2."""
        shape = self.shape(unknowns)
        thickness, area = self.thickness(shape)
        overlap = jnp.maximum(0.0, 1.0 - thickness / REPULSION_RANGE)
        repulsion = self.repulsion * jnp.sum(self.upper * area * overlap**3)
        return self.membrane.energy(shape) + repulsion

    def held(self, unknowns: Float[Array, " unknown"]) -> Float[Array, "2"]:
        """Area, r0^2, and volume, r0^3."""
        shape = self.shape(unknowns)
        _, area = self.thickness(shape)
        return jnp.stack([jnp.sum(area), self.membrane.volume(shape)])


@cache
def relaxation(degree: int) -> Relaxation:
    """The problem for shapes below `degree`."""
    order = max(LEAST_ORDER, 3 * degree)
    nodes, weights = np.polynomial.legendre.leggauss(order)
    theta = np.arccos(nodes)[::-1].copy()
    tables = harmonic_tables(degree, theta, np.zeros_like(theta))
    healthy = jnp.asarray(reference_coefficients(degree, "biconcave"))
    cell = Cell()
    membrane = Membrane(
        law=make_law(cell.law, cell.shear_modulus, cell.dilatation_modulus),
        bending=make_bending(cell.bending, cell.bending_modulus),
        tables=tables,
        weights=jnp.asarray(2.0 * pi * weights[::-1]),
        inverse_sine=jnp.asarray(1.0 / np.sin(theta)),
        reference=eqx.filter_jit(surface_geometry)(tables, healthy),
        reference_shape=healthy,
    )
    # Odd degrees of z and of the distance from the axis: the mirror plane is z = 0.
    basis = []
    for n in range(1, degree, 2):
        along, across = np.zeros((2, 3, degree**2))
        along[2, coefficient_index(n, 0)] = 1.0
        across[0, coefficient_index(n, 1)] = across[1, coefficient_index(n, -1)] = sqrt(0.5)
        basis += [along, across]
    upper = jnp.asarray(theta < 0.5 * pi, float)
    return Relaxation(
        membrane, jnp.asarray(np.array(basis)), upper, jnp.asarray(REPULSION_STRENGTH)
    )


@cache
def relaxed_shape(degree: int, reduced_volume: float) -> Float[np.ndarray, "3 coefficient"]:
    """Coefficients of the resting cell of a reduced volume v, its axis the tube's, its centre at 0.

    **Raises:** `CaseError` if no minimum was found.
    """
    problem = relaxation(degree)
    area, _, healthy = _healthy(problem)
    if reduced_volume > 1.0 - NEARLY_ONE:
        shape = sqrt(area / (4.0 * pi)) * reference_coefficients(degree, "sphere")
    else:
        start = _rung(degree, trunc((reduced_volume - healthy) / VOLUME_STEP))
        unknowns = _minimum(problem, start, reduced_volume)
        shape = np.array(problem.shape(jnp.asarray(unknowns)))
    shape.setflags(write=False)
    return shape


@cache
def relaxed_slope(degree: int, reduced_volume: float) -> Float[np.ndarray, "3 coefficient"]:
    """Derivative of `relaxed_shape` by the reduced volume, r0.

    **Raises:** `CaseError` next to the sphere, where it becomes infinite, or if there is no shape.
    """
    if reduced_volume > 1.0 - NEARLY_ONE:
        raise CaseError(
            f"reduced_volume = {reduced_volume:g} is not allowed: the shape at rest has no"
            " derivative there; allowed: < 1"
        )
    problem = relaxation(degree)
    _, largest, _ = _healthy(problem)
    unknowns = np.asarray(problem.unknowns(jnp.asarray(relaxed_shape(degree, reduced_volume))))
    slope = minimum_slope(problem, unknowns, np.array([0.0, largest]))
    shape = np.array(problem.shape(jnp.asarray(slope)))
    shape.setflags(write=False)
    return shape


def healthy_reduced_volume(degree: int) -> float:
    """The reduced volume of the biconcave cell itself, 0.6444, by the rule of a degree."""
    return _healthy(relaxation(degree))[2]


@cache
def _rung(degree: int, count: int) -> Float[np.ndarray, " unknown"]:
    """The shape a number of steps (negative: of deflation) away from the healthy one."""
    problem = relaxation(degree)
    if count == 0:
        return np.asarray(problem.unknowns(problem.membrane.reference_shape))
    *_, healthy = _healthy(problem)
    before = _rung(degree, count - int(copysign(1, count)))
    return _minimum(problem, before, healthy + count * VOLUME_STEP)


def contact_volume(degree: int) -> float:
    """The reduced volume below which faces would meet if nothing kept them apart.

    The deflation is followed without repulsion until the thickness at some point is zero.
    """
    problem = eqx.tree_at(lambda each: each.repulsion, relaxation(degree), jnp.zeros(()))
    unknowns = problem.unknowns(problem.membrane.reference_shape)
    *_, v = _healthy(problem)
    thinnest = float(least_thickness(problem, unknowns))
    while True:
        following = v - 0.5 * VOLUME_STEP
        unknowns = jnp.asarray(_minimum(problem, np.asarray(unknowns), following))
        before, thinnest = thinnest, float(least_thickness(problem, unknowns))
        if thinnest <= 0.0:
            return following + (v - following) * -thinnest / (before - thinnest)
        v = following


def _healthy(problem: Relaxation) -> tuple[float, float, float]:
    """Area of the healthy cell, the largest volume that it can hold, and the reduced volume."""
    rest = problem.unknowns(problem.membrane.reference_shape)
    area, volume = (float(each) for each in held_by(problem, rest)[0])
    largest = area**1.5 / (6.0 * sqrt(pi))
    return area, largest, volume / largest


def _minimum(
    problem: Relaxation, start: Float[np.ndarray, " unknown"], reduced_volume: float
) -> Float[np.ndarray, " unknown"]:
    """Least energy at the healthy cell's area and a reduced volume, from a shape nearby."""
    area, largest, _ = _healthy(problem)
    target = np.array([area, reduced_volume * largest])

    def energy(unknowns: np.ndarray) -> tuple[float, np.ndarray]:
        value, gradient = _energy(problem, jnp.asarray(unknowns))
        return float(value), np.asarray(gradient)

    def missed(unknowns: np.ndarray) -> np.ndarray:
        return np.asarray(held_by(problem, jnp.asarray(unknowns))[0]) - target

    def normals(unknowns: np.ndarray) -> np.ndarray:
        return np.asarray(held_by(problem, jnp.asarray(unknowns))[1])

    found = minimize(
        energy,
        start,
        jac=True,
        method="SLSQP",
        constraints=NonlinearConstraint(missed, 0.0, 0.0, jac=normals),
        options={"maxiter": 500, "ftol": 1e-13},
    )
    # The method may also end because rounding allows no further step: what counts is where.
    unknowns = corrected_minimum(problem, found.x, target)
    left = float(np.abs(imbalance(problem, unknowns)).max())
    if not (left < LARGEST_IMBALANCE and np.abs(missed(unknowns)).max() < 1e-9):
        degree = isqrt(problem.basis.shape[-1])
        raise CaseError(
            f"reduced_volume = {reduced_volume:g} is not allowed at degree {degree}: no resting"
            f" shape was found (forces of {left:.1e} mu U r0 are not balanced); take another degree"
        )
    return unknowns


def imbalance(
    problem: Relaxation, unknowns: Float[np.ndarray, " unknown"]
) -> Float[np.ndarray, " unknown"]:
    """The energy's gradient less what a tension and a pressure balance; nothing at a minimum."""
    gradient = np.asarray(_energy(problem, jnp.asarray(unknowns))[1])
    normals = np.asarray(held_by(problem, jnp.asarray(unknowns))[1])
    return gradient - normals.T @ np.linalg.lstsq(normals.T, gradient)[0]


@eqx.filter_jit
def _energy(problem: Relaxation, unknowns: Array) -> tuple[Array, Array]:
    return jax.value_and_grad(problem.energy)(unknowns)


@eqx.filter_jit
def held_by(
    problem: Relaxation, unknowns: Float[Array, " unknown"]
) -> tuple[Float[Array, "2"], Float[Array, "2 unknown"]]:
    """Area and volume of a shape, and their derivatives."""
    return problem.held(unknowns), jax.jacfwd(problem.held)(unknowns)


@eqx.filter_jit
def least_thickness(problem: Relaxation, unknowns: Float[Array, " unknown"]) -> Float[Array, ""]:
    """The least thickness of a shape along its normals, r0; negative if its faces cross."""
    thickness, _ = problem.thickness(problem.shape(unknowns))
    return jnp.where(problem.upper > 0.0, thickness, jnp.inf).min()
