"""Integrals of the near kernels over a surface in polar coordinates about a point of it.

With d = x - y, w the density of the double layer, N = x_alpha cross x_beta = n dS/(dalpha dbeta),
and the kernels G and T of `compiled.kernels`, the integrands are G F sin(alpha) and -T_ijk w_j N_k.

The derivative is given in closed form: the kernels' matrices at the nodes are summed against the
harmonics first, to one row of coefficients for each component of velocity and of each density,
which is then brought back to the given frame. However many directions there are, each costs no more
than the product with these rows.
"""

from dataclasses import replace

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from celltrain.compiled.kernels import (
    UNFOLD,
    Vector,
    cross,
    dot,
    squared,
    stokeslet,
    stokeslet_gradient,
    stokeslet_matrix,
    stokeslet_slopes,
    stresslet,
    stresslet_gradients,
    stresslet_matrix,
    stresslet_slopes,
)
from celltrain.flow.ewald import near_scalars, near_stress_scalars
from celltrain.harmonics.polar import PolarTables
from celltrain.harmonics.rotation import PoleRotation

Channels = Float[Array, "pair 3 coefficient"]
Rows = Float[Array, "pair 3 3 coefficient"]


class PolarRule(eqx.Module):
    """Nodes about a pole, which a rotation brings to any place.

    For each radial node, `weights` are those of sin(alpha) dalpha dbeta over 8 pi, `areas` those of
    dalpha dbeta over 8 pi.
    """

    parameter: float = eqx.field(static=True)
    rotation: PoleRotation
    tables: PolarTables
    weights: Float[Array, " radial"]
    areas: Float[Array, " radial"]

    def with_tangents(self, coefficients: Array) -> tuple[Array, Array, Array]:
        """Values, d/dalpha and d/dbeta at the nodes."""
        # Without 1/sin(alpha), which the areas make up for: two thirds of the cost of the nodes.
        plain = replace(self.tables, inverse_sine=jnp.ones_like(self.weights))
        return plain.with_tangents(coefficients)


class _Nodes(eqx.Module):
    """What the integrands are made of, at the nodes of each pair."""

    places: Float[Array, "3 pair radial azimuthal"]
    d: list[Array]
    force: list[Array] | None
    density: list[Array] | None
    down: list[Array]
    around: list[Array]

    @property
    def normal(self) -> Vector:
        return cross(self.down, self.around)


@jax.custom_jvp
def polar_velocity(
    rule: PolarRule,
    poles: Float[Array, "pair 2"],
    points: Float[Array, "pair 3"],
    shapes: Channels,
    forces: Channels | None,
    densities: Channels | None,
) -> Float[Array, "pair 3"]:
    """Velocity at each point by a surface's force and double layer, either of which may be absent.

    Derivatives hold the rule and its poles fixed.

    **Arguments:** `poles`: (theta, phi) of each pair's; `shapes`, `forces` (per solid angle),
    `densities` (w): coefficients.
    """
    nodes = _at_nodes(rule, poles, points, (shapes, forces, densities))
    velocity = jnp.zeros_like(points)
    if nodes.force is not None:
        velocity = force_sums(
            rule.parameter,
            points,
            jnp.concatenate([nodes.places, jnp.stack(nodes.force)]),
            jnp.broadcast_to(rule.weights[:, None], nodes.places.shape[2:]),
        )
    if nodes.density is not None:
        d, density = nodes.d, [each * rule.areas[:, None] for each in nodes.density]
        scalars = near_stress_scalars(squared(d), rule.parameter)
        parts = stresslet(scalars, d, density, nodes.normal)
        velocity += jnp.stack([jnp.sum(part, axis=(-2, -1)) for part in parts], axis=-1)
    return velocity


@polar_velocity.defjvp
def _polar_velocity_jvp(primals, tangents):  # type: ignore[no-untyped-def]
    rule, poles, points, *channels = primals
    _, _, d_points, *d_channels = tangents
    by_point, by_channel = _derivative_rows(rule, poles, points, tuple(channels))
    value = jnp.zeros_like(points)
    change = jnp.einsum("pij,pj->pi", by_point, d_points)
    for number, rows in enumerate(by_channel):
        if rows is None:
            continue
        change += jnp.einsum("pijk,pjk->pi", rows, d_channels[number])
        if number:
            # The velocity is linear in all but the shapes.
            value += jnp.einsum("pijk,pjk->pi", rows, channels[number])
    return value, change


def force_sums(
    parameter: float,
    targets: Float[Array, "*target 3"],
    nodes: Float[Array, "6 *target radial azimuthal"],
    weights: Float[Array, "radial azimuthal"],
) -> Float[Array, "*target 3"]:
    """sum_s w_s G_near(x - y_s) f_s, of places y and forces f per solid angle at the nodes."""
    d = [targets[..., i, None, None] - nodes[i] for i in range(3)]
    force = nodes[3:] * weights
    parts = stokeslet(near_scalars(squared(d), parameter), d, force)
    return jnp.stack([jnp.sum(part, axis=(-2, -1)) for part in parts], axis=-1)


def density_rows(
    rule: PolarRule,
    poles: Float[Array, "pair 2"],
    points: Float[Array, "pair 3"],
    shapes: Channels,
) -> Rows:
    """Matrices from the coefficients of w to the velocity of its double layer."""
    nodes = _at_nodes(rule, poles, points, (shapes, None, None), tangents=True)
    kernel = _moments(rule.tables, _density_kernel(rule, nodes.d, nodes.normal))
    return _brought_back(rule, poles, kernel)[:, UNFOLD]


def _at_nodes(
    rule: PolarRule,
    poles: Float[Array, "pair 2"],
    points: Float[Array, "pair 3"],
    channels: tuple[Channels, Channels | None, Channels | None],
    tangents: bool = False,
) -> _Nodes:
    """Values at the nodes; the tangents only if they are asked for or there is a double layer."""
    _, forces, densities = channels
    given = jnp.concatenate([each for each in channels if each is not None], axis=1)
    turned = jnp.moveaxis(rule.rotation.to_pole(given, poles[:, 0], poles[:, 1]), 0, 1)
    down: list[Array] = []
    around: list[Array] = []
    if tangents or densities is not None:
        y, *slopes = rule.with_tangents(turned[:3])
        down, around = (list(slope) for slope in slopes)
        rest = list(rule.tables.values(turned[3:])) if turned.shape[0] > 3 else []
    else:
        values = list(rule.tables.values(turned))
        y, rest = jnp.stack(values[:3]), values[3:]
    return _Nodes(
        places=y,
        d=[points[:, i, None, None] - y[i] for i in range(3)],
        force=None if forces is None else rest[:3],
        density=None if densities is None else rest[-3:],
        down=down,
        around=around,
    )


def _derivative_rows(
    rule: PolarRule,
    poles: Float[Array, "pair 2"],
    points: Float[Array, "pair 3"],
    channels: tuple[Channels, Channels | None, Channels | None],
) -> tuple[Float[Array, "pair 3 3"], tuple[Rows, Rows | None, Rows | None]]:
    """Derivatives of the velocity by the point, and by the coefficients of each channel given."""
    nodes = _at_nodes(rule, poles, points, channels)
    tables, pairs = rule.tables, points.shape[0]
    slopes: list[Array] = [jnp.zeros(())] * 9
    by_normal, by_force, by_density = jnp.zeros(()), None, None
    if nodes.force is not None:
        slopes = _force_slopes(rule, nodes.d, nodes.force)
        kernel = _moments(tables, _force_kernel(rule, nodes.d))
        by_force = _brought_back(rule, poles, kernel)[:, UNFOLD]
    if nodes.density is not None:
        kernel = _moments(tables, _density_kernel(rule, nodes.d, nodes.normal))
        by_density = _brought_back(rule, poles, kernel)[:, UNFOLD]
        more, turns = _density_slopes(rule, nodes.d, nodes.density, nodes.normal)
        slopes = [a + b for a, b in zip(slopes, more, strict=True)]
        by_normal = _normal_moments(tables, nodes, turns)
    by_point = jnp.stack([jnp.sum(each, axis=(-2, -1)) for each in slopes], axis=-1)
    by_shape = _brought_back(rule, poles, by_normal - _moments(tables, slopes))
    square = (pairs, 3, 3)
    return by_point.reshape(square), (by_shape.reshape(*square, -1), by_force, by_density)


def _brought_back(
    rule: PolarRule,
    poles: Float[Array, "pair 2"],
    moments: Float[Array, "component pair coefficient"],
) -> Float[Array, "pair component coefficient"]:
    """Functionals of coefficients seen from the pole as functionals of those given."""
    return rule.rotation.from_pole(jnp.moveaxis(moments, 0, 1), poles[:, 0], poles[:, 1])


def _force_kernel(rule: PolarRule, d: Vector) -> list[Array]:
    """Components of G, times the weights."""
    scalars = near_scalars(squared(d), rule.parameter)
    return stokeslet_matrix(_weighted(rule.weights, scalars), d)


def _density_kernel(rule: PolarRule, d: Vector, normal: Vector) -> list[Array]:
    """Components of -T_ijk N_k, times the weights."""
    scalars = near_stress_scalars(squared(d), rule.parameter)
    linear, cubic = _weighted(rule.areas, scalars)
    through = dot(d, normal)
    return list(stresslet_matrix(linear, cubic * through, through, d, normal))


def _force_slopes(rule: PolarRule, d: Vector, force: Vector) -> list[Array]:
    """Derivatives of the force's integrand, by component and then by d, times the weights."""
    square = squared(d)
    scalars = _weighted(rule.weights, near_scalars(square, rule.parameter))
    stress = _weighted(rule.weights, near_stress_scalars(square, rule.parameter))
    return stokeslet_gradient(scalars, stokeslet_slopes(scalars, stress), d, force)


def _density_slopes(
    rule: PolarRule, d: Vector, density: Vector, normal: Vector
) -> tuple[list[Array], list[Array]]:
    """Derivatives of the density's integrand by d, as above, and by N, times the weights."""
    square = squared(d)
    scalars = _weighted(rule.areas, near_stress_scalars(square, rule.parameter))
    slopes = stresslet_slopes(scalars, square, rule.parameter)
    return stresslet_gradients(scalars, slopes, d, density, normal)


def _weighted(
    weights: Float[Array, " radial"], scalars: tuple[Array, Array]
) -> tuple[Array, Array]:
    return scalars[0] * weights[:, None], scalars[1] * weights[:, None]


def _moments(tables: PolarTables, kernel: list[Array]) -> Array:
    """Sums over the nodes times each harmonic, [component, pair, coefficient]."""
    # One by one: stacking them first would cost more than the sums.
    return jnp.stack([tables.moments(each) for each in kernel])


def _normal_moments(tables: PolarTables, nodes: _Nodes, by_normal: list[Array]) -> Array:
    """What acts on N = x_alpha cross x_beta, as acting on x: [9, pair, coefficient]."""
    by_alpha = replace(tables, latitude=tables.latitude_slope)
    by_beta = replace(tables, longitude=tables.longitude_slope)
    rows = [by_normal[3 * i : 3 * i + 3] for i in range(3)]
    down = [each for row in rows for each in cross(nodes.around, row)]
    around = [each for row in rows for each in cross(row, nodes.down)]
    return _moments(by_alpha, down) + _moments(by_beta, around)
