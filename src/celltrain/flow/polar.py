"""Integrals of the near kernels over a surface in polar coordinates about a point of it.

With d = x - y, w the density of the double layer, N = x_alpha cross x_beta = n dS/(dalpha dbeta),
and the scalars A, C of `near_scalars` and a, b of `near_stress_scalars`, the integrands are

    force:   [A F + C d (d.F)] sin(alpha)
    density: -[a (w (d.N) + d (w.N) + N (d.w)) + b d (d.w) (d.N)].

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

from celltrain.flow.ewald import near_scalars, near_stress_scalars
from celltrain.flow.force_sums import force_sums
from celltrain.flow.sources import SYMMETRIC, UNFOLD
from celltrain.harmonics.polar import PolarTables
from celltrain.harmonics.rotation import PoleRotation

Vector = list[Array]
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
    d: Vector
    force: Vector | None
    density: Vector | None
    down: Vector
    around: Vector

    @property
    def normal(self) -> Vector:
        return _cross(self.down, self.around)


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
        d, normal = nodes.d, nodes.normal
        density = [each * rule.areas[:, None] for each in nodes.density]
        linear, cubic = near_stress_scalars(_dot(d, d), rule.parameter)
        through, onto = _dot(d, normal), _dot(d, density)
        along = linear * _dot(density, normal) + cubic * onto * through
        parts = [
            -d[i] * along - linear * (density[i] * through + normal[i] * onto) for i in range(3)
        ]
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
    down: Vector = []
    around: Vector = []
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
    slopes: Vector = [jnp.zeros(())] * 9
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


def _force_kernel(rule: PolarRule, d: Vector) -> Vector:
    """Components of A I + C d d, times the weights."""
    isotropic, dyadic = _weighted(rule.weights, near_scalars(_dot(d, d), rule.parameter))
    return [dyadic * d[i] * d[j] + (isotropic if i == j else 0.0) for i, j in SYMMETRIC]


def _density_kernel(rule: PolarRule, d: Vector, normal: Vector) -> Vector:
    """Components of -[a (I (d.N) + d N + N d) + b d d (d.N)], times the weights."""
    linear, cubic = _weighted(rule.areas, near_stress_scalars(_dot(d, d), rule.parameter))
    through = _dot(d, normal)
    cubic = cubic * through
    return [
        -linear * (d[i] * normal[j] + normal[i] * d[j])
        - cubic * d[i] * d[j]
        - (linear * through if i == j else 0.0)
        for i, j in SYMMETRIC
    ]


def _force_slopes(rule: PolarRule, d: Vector, force: Vector) -> Vector:
    """Derivatives of the force's integrand, by component and then by d, times the weights."""
    square = _dot(d, d)
    linear, cubic = _weighted(rule.weights, near_stress_scalars(square, rule.parameter))
    _, dyadic = _weighted(rule.weights, near_scalars(square, rule.parameter))
    # A'/r = a - C and C'/r = b/2.
    isotropic_slope, along = linear - dyadic, _dot(d, force)
    return [
        d[k] * (isotropic_slope * force[i] + 0.5 * cubic * along * d[i])
        + dyadic * (d[i] * force[k] + (along if i == k else 0.0))
        for i in range(3)
        for k in range(3)
    ]


def _density_slopes(
    rule: PolarRule, d: Vector, density: Vector, normal: Vector
) -> tuple[Vector, list[Vector]]:
    """Derivatives of the density's integrand by d, as above, and by N, [component][of N]."""
    square = _dot(d, d)
    linear, cubic = _weighted(rule.areas, near_stress_scalars(square, rule.parameter))
    # (1/r) d/dr of a and of b.
    linear_slope = -2.0 * rule.parameter**2 * linear
    cubic_slope = -(5.0 * cubic + 2.0 * linear_slope) / square
    through, onto, across = _dot(d, normal), _dot(d, density), _dot(density, normal)
    by_d, by_normal = [], []
    for i in range(3):
        dipole = density[i] * through + d[i] * across + normal[i] * onto
        radial = linear_slope * dipole + cubic_slope * d[i] * onto * through
        by_d += [
            -d[k] * radial
            - linear * (density[i] * normal[k] + normal[i] * density[k])
            - cubic * d[i] * (density[k] * through + onto * normal[k])
            - (linear * across + cubic * onto * through if i == k else 0.0)
            for k in range(3)
        ]
        by_normal.append(
            [
                -linear * (density[i] * d[k] + d[i] * density[k])
                - cubic * onto * d[i] * d[k]
                - (linear * onto if i == k else 0.0)
                for k in range(3)
            ]
        )
    return by_d, by_normal


def _weighted(
    weights: Float[Array, " radial"], scalars: tuple[Array, Array]
) -> tuple[Array, Array]:
    return scalars[0] * weights[:, None], scalars[1] * weights[:, None]


def _moments(tables: PolarTables, kernel: Vector) -> Array:
    """Sums over the nodes times each harmonic, [component, pair, coefficient]."""
    # One by one: stacking them first would cost more than the sums.
    return jnp.stack([tables.moments(each) for each in kernel])


def _normal_moments(tables: PolarTables, nodes: _Nodes, by_normal: list[Vector]) -> Array:
    """What acts on N = x_alpha cross x_beta, as acting on x: [9, pair, coefficient]."""
    by_alpha = replace(tables, latitude=tables.latitude_slope)
    by_beta = replace(tables, longitude=tables.longitude_slope)
    down = [each for row in by_normal for each in _cross(nodes.around, row)]
    around = [each for row in by_normal for each in _cross(row, nodes.down)]
    return _moments(by_alpha, down) + _moments(by_beta, around)


def _dot(a: Vector, b: Vector) -> Array:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: Vector, b: Vector) -> Vector:
    return [a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2] for i in range(3)]
