"""Velocity on a surface by the singular near kernels of its own force and of its own motion.

For each target the surface is integrated in polar coordinates about it, where the area element
cancels the kernels' 1/r. Targets are the points of a product grid; those of one ring share one
rotation of the parameter sphere, since shifting the coefficients in longitude brings each of them
to phi = 0.
"""

import math
from functools import partial
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from celltrain.compiled import compiled_or_plain, loop
from celltrain.compiled.kernels import (
    SYMMETRIC,
    cross,
    dot,
    free_stresslet,
    squared,
    stresslet_matrix,
)
from celltrain.compiled.loops import OWN_DOUBLE_LAYER, OWN_FORCES
from celltrain.flow.ewald import near_stress_scalars
from celltrain.flow.polar import force_sums
from celltrain.harmonics import degree_of, polar_nodes
from celltrain.harmonics.jax_shapes import JaxShapes
from celltrain.harmonics.longitude import shift_longitude, unshift_longitude
from celltrain.harmonics.polar import PolarTables, polar_rotation, polar_tables
from celltrain.runtime import constant

# Degrees that see the difference of the near kernel and that in free space: it is smooth.
SMOOTH_DEGREE = 12

# Of the six `SYMMETRIC` components.
Kernel = Float[Array, "cell ring azimuth 6 coefficient"]
SmoothKernel = Float[Array, "cell ring azimuth 6 low_coefficient"]


class OwnSurfaceRule(eqx.Module):
    """Polar quadrature about the rings of a target grid.

    `low_tables` are those of the lowest degrees alone, at the same nodes.
    """

    parameter: float = eqx.field(static=True)
    rotations: Float[Array, "ring coefficient coefficient"]
    tables: PolarTables
    low_tables: PolarTables
    weights: Float[Array, "radial azimuthal"]

    def velocity(
        self,
        targets: Float[Array, "cell ring azimuth 3"],
        longitudes: Float[Array, " azimuth"],
        shapes: JaxShapes,
        forces: JaxShapes,
    ) -> Float[Array, "cell ring azimuth 3"]:
        """(1/8 pi) int G_near F dOmega over each target's own cell.

        **Arguments:** `longitudes`: of the targets on the parameter sphere; `forces`: coefficients
        of the force per solid angle.
        """
        return own_velocity(self, targets, longitudes, shapes, forces) / (8.0 * math.pi)

    def double_layer(
        self,
        targets: Float[Array, "cell ring azimuth 3"],
        longitudes: Float[Array, " azimuth"],
        shapes: JaxShapes,
    ) -> tuple[Kernel, SmoothKernel]:
        """Matrices from the coefficients of w to (1/8 pi) PV int T_ijk(y - x) w_j n_k dS.

        In free space the integral of a constant w is -w/2 exactly: the rule's error for that kernel
        and w = w(x) is taken from the near kernel's, which leaves an integrand without a
        singularity.

        **Returns:** that of the near kernel, and what is to be added to it for the kernel in free
        space, for the lowest degrees of w only, which is good enough for a preconditioner.
        """
        return own_double_layer(self, targets, longitudes, shapes)


@jax.custom_jvp
def own_velocity(
    rule: OwnSurfaceRule,
    targets: Float[Array, "cell ring azimuth 3"],
    longitudes: Float[Array, " azimuth"],
    shapes: JaxShapes,
    forces: JaxShapes,
) -> Float[Array, "cell ring azimuth 3"]:
    """int G_near F dOmega over each target's own cell, by a compiled loop where there is one.

    Derivatives are those of the formula.
    """
    return compiled_or_plain(_own_loop, _own_formula, rule, targets, longitudes, shapes, forces)


@own_velocity.defjvp
def _own_velocity_jvp(primals, tangents):  # type: ignore[no-untyped-def]
    rule, *inputs = primals
    formula = partial(_own_formula, rule)
    _, moved = jax.jvp(formula, tuple(inputs), tuple(tangents[1:]))
    return own_velocity(rule, *inputs), moved


def _own_loop(
    rule: OwnSurfaceRule, targets: Array, longitudes: Array, shapes: JaxShapes, forces: JaxShapes
) -> Array:
    both = jnp.concatenate([shapes, forces], axis=1)
    tables = (rule.rotations, rule.tables.latitude, rule.tables.longitude, rule.weights)
    given = (targets, both, longitudes, *tables, jnp.asarray(rule.parameter))
    return loop(OWN_FORCES, targets.shape, *given)


def _own_formula(
    rule: OwnSurfaceRule, targets: Array, longitudes: Array, shapes: JaxShapes, forces: JaxShapes
) -> Array:
    """What `own_velocity` computes."""
    shifted = shift_longitude(jnp.concatenate([shapes, forces], axis=1), longitudes)

    def of_ring(ring: tuple[Array, Array]) -> Float[Array, "cell azimuth 3"]:
        rotation, points = ring
        turned = jnp.einsum("kl,acil->icak", rotation, shifted)
        return force_sums(rule.parameter, points, rule.tables.values(turned), rule.weights)

    by_ring = jax.lax.map(of_ring, (rule.rotations, jnp.moveaxis(targets, 1, 0)))
    return jnp.moveaxis(by_ring, 0, 1)


@jax.custom_jvp
def own_double_layer(
    rule: OwnSurfaceRule,
    targets: Float[Array, "cell ring azimuth 3"],
    longitudes: Float[Array, " azimuth"],
    shapes: JaxShapes,
) -> tuple[Kernel, SmoothKernel]:
    """See `OwnSurfaceRule.double_layer`; by a compiled loop where there is one.

    Derivatives are those of the formula.
    """
    size, low = shapes.shape[-1], rule.low_tables.latitude.shape[-1]

    def plain(*given: Any) -> Array:
        return jnp.concatenate(_double_layer_formula(*given), axis=-1)

    both = compiled_or_plain(_double_layer_loop, plain, rule, targets, longitudes, shapes)
    return both[..., :size], both[..., size : size + low * low]


@own_double_layer.defjvp
def _own_double_layer_jvp(primals, tangents):  # type: ignore[no-untyped-def]
    rule, *inputs = primals
    formula = partial(_double_layer_formula, rule)
    return jax.jvp(formula, tuple(inputs), tuple(tangents[1:]))


def _double_layer_loop(
    rule: OwnSurfaceRule, targets: Array, longitudes: Array, shapes: JaxShapes
) -> Array:
    tables, low = rule.tables, rule.low_tables.latitude.shape[-1]
    by_order = (tables.latitude, tables.latitude_slope, tables.longitude, tables.longitude_slope)
    sizes = jnp.array([rule.parameter, low])
    given = (targets, shapes, longitudes, rule.rotations, *by_order, rule.weights)
    shape = (*targets.shape[:3], len(SYMMETRIC), shapes.shape[-1] + low * low)
    return loop(OWN_DOUBLE_LAYER, shape, *given, tables.inverse_sine, sizes)


def _double_layer_formula(
    rule: OwnSurfaceRule, targets: Array, longitudes: Array, shapes: JaxShapes
) -> tuple[Kernel, SmoothKernel]:
    """What `own_double_layer` computes."""
    shifted = shift_longitude(shapes, longitudes)

    def of_ring(ring: tuple[Array, Array]) -> tuple[Array, Array]:
        rotation, points = ring
        turned = jnp.einsum("kl,acil->icak", rotation, shifted)
        values, down, round_ = rule.tables.with_tangents(turned)
        d = [points[..., i, None, None] - values[i] for i in range(3)]
        weighted = [each * rule.weights for each in cross(list(down), list(round_))]
        square, through = squared(d), dot(d, weighted)
        linear, cubic = near_stress_scalars(square, rule.parameter)
        # Signs of T(y - x) = -T(x - y).
        free = -free_stresslet(square, jax.lax.rsqrt(square)) * through
        # Or XLA computes them anew for each of the six components.
        linear, along, free, d, weighted, through = jax.lax.optimization_barrier(
            (linear, cubic * through, free, d, weighted, through)
        )
        near = jnp.stack(stresslet_matrix(linear, along, through, d, weighted))
        alone = jnp.stack([free * d[i] * d[j] for i, j in SYMMETRIC])
        scale = 1.0 / (8.0 * math.pi)
        error = -0.5 * jnp.array([float(i == j) for i, j in SYMMETRIC])[:, None, None]
        error = error - scale * jnp.sum(alone, axis=(-2, -1))
        at_target = jnp.einsum("sca,k->scak", error, _at_pole(rule))
        moments = scale * rule.tables.moments(near) + at_target
        smooth = scale * rule.low_tables.moments(alone - near)
        # Degrees do not mix in a rotation.
        low = rotation[: smooth.shape[-1], : smooth.shape[-1]]
        return (
            unshift_longitude(moments @ rotation, longitudes),
            unshift_longitude(smooth @ low, longitudes),
        )

    by_ring = jax.lax.map(of_ring, (rule.rotations, jnp.moveaxis(targets, 1, 0)))
    near, smooth = (jnp.transpose(each, (2, 0, 3, 1, 4)) for each in by_ring)
    return near, smooth


def _at_pole(rule: OwnSurfaceRule) -> Float[Array, " coefficient"]:
    """Harmonics at the pole: those of order 0, where they are sqrt((2 n + 1)/(4 pi))."""
    n = np.arange(degree_of(rule.rotations))
    values = np.zeros(n.size**2)
    values[n * n + n] = np.sqrt((2 * n + 1) / (4.0 * np.pi))
    return jnp.asarray(values)


def own_surface_rule(
    degree: int, theta: Float[np.ndarray, " ring"], *, radial: int, azimuthal: int, parameter: float
) -> OwnSurfaceRule:
    """Rule with `radial` x `azimuthal` nodes about the targets of the given rings."""
    alpha, beta, weights = polar_nodes(radial, azimuthal)
    return OwnSurfaceRule(
        parameter=parameter,
        rotations=constant(np.stack([polar_rotation(degree, float(each)) for each in theta])),
        tables=polar_tables(degree, alpha, beta),
        low_tables=polar_tables(min(degree, SMOOTH_DEGREE), alpha, beta),
        weights=constant(weights),
    )
