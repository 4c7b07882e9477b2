"""The flow inside cells whose viscosity differs from the plasma's.

On the membranes, with lam the viscosity ratio and b the velocity that the forces and the driven
flow would give at lam = 1,

    (1 + lam)/2 u - (1 - lam) K u = b,   K u = (1/8 pi) PV int T_ijk(y - x) u_j n_k dS

(Pozrikidis 1992, chapter 5; Eq. 3 of Bryngelson & Freund 2018). Two things are known exactly, and
the discrete K is made to obey them, so that no viscosity ratio makes the equation singular:

* a rigid motion v of one cell gives K v = -v/2 on it and nothing elsewhere. Hence u = b for rigid
  motions: what becomes singular as lam grows, and why a steady train does not depend on lam.
* K u moves no fluid through a closed surface. Hence u, like b, keeps each cell's volume: what
  becomes singular as lam falls.

The equation is solved by GMRES, preconditioned with each cell's own equation in free space, which
shares both properties, and near a known steady train with what its cells give each other
(`coupling`); the derivative follows implicitly from the same equation.
"""

from collections.abc import Callable

import equinox as eqx
import jax
import jax.numpy as jnp
import jax.scipy.linalg
from jaxtyping import Array, Bool, Float

from celltrain.compiled.kernels import UNFOLD
from celltrain.harmonics.jax_shapes import JaxShapes
from celltrain.train.coupling import Coupling
from celltrain.train.gmres import Iterations, gmres

Motions = JaxShapes
# From motions without a rigid part to the flow that they give through everything but the near
# kernel of their own cell.
Outer = Callable[[Motions], Motions]


class InteriorFlow(eqx.Module):
    """K at fixed shapes: each cell's own part as a matrix, and the motions known exactly.

    `near` and `free` act on a cell's flattened coefficients, with the near kernel and, nearly, in
    free space; `rigid` are orthonormal rigid motions, `normal` the direction of the volume's
    gradient.
    """

    near: Float[Array, "cell size size"]
    free: Float[Array, "cell size size"]
    rigid: Float[Array, "cell 6 3 coefficient"]
    normal: JaxShapes

    def without_inflation(self, motions: Array) -> Array:
        """Motions less their part that changes the volumes."""
        along = jnp.einsum("cik,cik->c", self.normal, motions)
        return motions - along[:, None, None] * self.normal

    def rigid_part(self, motions: Array) -> Array:
        """Projection to the rigid motions of each cell."""
        return jnp.einsum("crik,crjl,cjl->cik", self.rigid, self.rigid, motions)

    def apply(self, outer: Outer, motions: Array) -> Array:
        """K u."""
        rigid = self.rigid_part(motions)
        rest = self.without_inflation(motions - rigid)
        flow = _by_cell(self.near, rest) + outer(rest)
        return self.without_inflation(flow) - 0.5 * rigid

    def own_equation(self, ratio: Float[Array, ""]) -> Float[Array, "cell size size"]:
        """Matrix of each cell's equation in free space, nearly."""
        cells, size, _ = self.free.shape
        rigid = self.rigid.reshape(cells, 6, size)
        normal = self.normal.reshape(cells, size)
        # Without what is known of rigid motions and of inflation, on the right and on the left.
        known = jnp.concatenate([rigid, normal[:, None]], axis=1)
        kernel = self.free - jnp.einsum("cij,crj,crk->cik", self.free, known, known)
        kernel -= jnp.einsum("ci,cj,cjk->cik", normal, normal, kernel)
        kernel -= 0.5 * jnp.einsum("cri,crj->cij", rigid, rigid)
        return 0.5 * (1.0 + ratio) * jnp.eye(size) - (1.0 - ratio) * kernel

    def solve(
        self,
        outer: Outer,
        ratio: Float[Array, ""],
        free_rates: Motions,
        *,
        coupling: tuple[Coupling, Bool[Array, ""]] | None = None,
        tolerance: Float[Array, ""],
        iterations: int,
    ) -> tuple[Motions, Iterations]:
        """The motion u for the given b.

        **Arguments:** `coupling`: one that is known, and whether it serves; `tolerance`: of the
        residual of the preconditioned equation, which is about the error of u, relative to u;
        `iterations`: at most.
        """
        factors = jax.vmap(jax.scipy.linalg.lu_factor)(self.own_equation(ratio))

        def alone(flow: Motions) -> Motions:
            flat = flow.reshape(flow.shape[0], -1)
            return jax.vmap(jax.scipy.linalg.lu_solve)(factors, flat).reshape(flow.shape)

        def preconditioned(flow: Motions) -> Motions:
            motions = alone(flow)
            if coupling is None:
                return motions
            known, serves = coupling

            # The first two terms of the inverse of both, in powers of the coupling.
            def with_others(motions: Motions) -> Motions:
                # A rigid motion gives other cells nothing, but the coupling knows that only of
                # the steady train's shapes.
                rest = self.without_inflation(motions - self.rigid_part(motions))
                return alone(flow + (1.0 - ratio) * known(rest))

            found: Motions = jax.lax.cond(serves, with_others, lambda motions: motions, motions)
            return found

        def equation(motions: Motions) -> Motions:
            flow = 0.5 * (1.0 + ratio) * motions - (1.0 - ratio) * self.apply(outer, motions)
            return preconditioned(flow)

        right = preconditioned(free_rates)
        return gmres(equation, right, tolerance=tolerance, iterations=iterations)


def _by_cell(matrices: Array, motions: Array) -> Array:
    flat = motions.reshape(motions.shape[0], -1)
    return jnp.einsum("cij,cj->ci", matrices, flat).reshape(motions.shape)


def rigid_motions(
    shapes: JaxShapes,
) -> Float[Array, "cell 6 3 coefficient"]:
    """Orthonormal translations and rotations of each cell."""
    x, y, z = (shapes[:, i].at[:, 0].set(0.0) for i in range(3))
    none = jnp.zeros_like(x)
    rotations = jnp.stack(
        [jnp.stack(each, axis=1) for each in ((none, -z, y), (z, none, -x), (-y, x, none))], axis=1
    )
    # About the mean point, so that translations (degree 0) are orthogonal to them already.
    gram = jnp.einsum("crik,csik->crs", rotations, rotations)
    lower = jnp.linalg.cholesky(gram)
    turned = jax.scipy.linalg.solve_triangular(
        lower, rotations.reshape(*rotations.shape[:2], -1), lower=True
    )
    moved = jnp.zeros_like(rotations)
    moved = moved.at[:, [0, 1, 2], [0, 1, 2], 0].set(1.0)
    return jnp.concatenate([moved, turned.reshape(rotations.shape)], axis=1)


def interior_flow(
    kernels: tuple[Array, Array],
    projection: Float[Array, "coefficient point"],
    shapes: JaxShapes,
    volume_gradients: JaxShapes,
) -> InteriorFlow:
    """K from the matrices of `OwnSurfaceRule.double_layer`, projected from the target grid."""
    cells, count = shapes.shape[0], shapes.shape[-1]

    def projected(kernel: Array) -> Array:
        flat = projection @ kernel.reshape(cells, projection.shape[1], -1)
        return flat.reshape(cells, count, 6, -1)[:, :, UNFOLD]

    near, smooth = (projected(each) for each in kernels)
    free = near.at[..., : smooth.shape[-1]].add(smooth)

    def matrix(kernel: Float[Array, "cell coefficient 3 3 coefficient"]) -> Array:
        return jnp.moveaxis(kernel, 1, 2).reshape(cells, 3 * count, 3 * count)

    size = jnp.linalg.norm(volume_gradients, axis=(1, 2), keepdims=True)
    return InteriorFlow(
        near=matrix(near),
        free=matrix(free),
        rigid=rigid_motions(shapes),
        normal=volume_gradients / size,
    )
