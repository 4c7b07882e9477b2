"""The six numbers of `density` from the derivatives of the position, and the chain rule back.

Components of the position's derivatives are counted as x_t, x_p, x_tt, x_tp, x_pp, three each, 15
in all. The six numbers are quadratic (a_ij) and trilinear (c_ij) in them, so that derivatives of a
density in the 15 components follow exactly, and cheaply, from those in the six.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from celltrain.laws.arithmetic import Number
from celltrain.membrane.density import Forms
from celltrain.membrane.jets import Jet

Components = Float[np.ndarray, "5 3 point"]
# Places of the derivatives among the five.
_T, _P, _SECOND = 0, 1, (2, 3, 4)


@dataclass(frozen=True)
class PointwiseEnergy:
    """First and second derivatives of an energy density in the 15 components, at points.

    Of forces without an energy, the work that they do and its first derivatives: then the Hessian,
    whose rows belong to the work, is not symmetric.
    """

    gradient: Float[np.ndarray, "point 15"]
    hessian: Float[np.ndarray, "point 15 15"]


def fundamental_forms(derivatives: Number) -> Forms:
    """The six numbers, from x_t, x_p, x_tt, x_tp, x_pp: an array [5, 3, point] of NumPy or JAX."""
    t, p, tt, tp, pp = derivatives
    normal = (t[1] * p[2] - t[2] * p[1], t[2] * p[0] - t[0] * p[2], t[0] * p[1] - t[1] * p[0])

    def dot(u: Number, v: Number) -> Number:
        return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]

    return Forms(dot(t, t), dot(t, p), dot(p, p), dot(tt, normal), dot(tp, normal), dot(pp, normal))


def in_components(density: Jet, components: Components) -> PointwiseEnergy:
    """Derivatives in the 15 components of a density whose derivatives in the six are known."""
    points = components.shape[-1]
    places = components.transpose(2, 0, 1)
    t, p, second = places[:, _T], places[:, _P], places[:, 2:]
    flat = form_slopes(components)
    hessian = flat.transpose(0, 2, 1) @ (density.hessian @ flat)
    blocks = hessian.reshape(points, 5, 3, 5, 3)
    metric, form = density.gradient[:, :3, None, None], density.gradient[:, 3:]
    # d(a_ij): the identity; d(c_ij): c_ij = eps_klm (x_ij)_k t_l p_m.
    identity = np.eye(3)
    blocks[:, _T, :, _T] += 2.0 * metric[:, 0] * identity
    blocks[:, _P, :, _P] += 2.0 * metric[:, 2] * identity
    crossing = metric[:, 1] * identity + _turned(np.einsum("pf,pfi->pi", form, second))
    _add_pair(blocks, _T, _P, crossing)
    by_t, by_p = _turned(p), -_turned(t)
    for each, place in enumerate(_SECOND):
        weight = form[:, each, None, None]
        _add_pair(blocks, place, _T, weight * by_t)
        _add_pair(blocks, place, _P, weight * by_p)
    return PointwiseEnergy(np.einsum("pf,pfc->pc", density.gradient, flat), hessian)


def with_turning(
    pointwise: PointwiseEnergy, turning: Jet, components: Components
) -> PointwiseEnergy:
    """With the work h (x_t . dx_p - x_p . dx_t) of a jet h that is zero where it is taken."""
    turn = np.zeros((components.shape[-1], 5, 3))
    turn[:, _P], turn[:, _T] = components[_T].T, -components[_P].T
    slope = np.einsum("pf,pfc->pc", turning.gradient, form_slopes(components))
    added = turn.reshape(-1, 15, 1) * slope[:, None, :]
    return PointwiseEnergy(pointwise.gradient, pointwise.hessian + added)


def form_slopes(components: Components) -> Float[np.ndarray, "point 6 15"]:
    """First derivatives of the six numbers in the 15 components."""
    points = components.shape[-1]
    places = components.transpose(2, 0, 1)
    t, p, second = places[:, _T], places[:, _P], places[:, 2:]
    slopes = np.zeros((points, 6, 5, 3))
    slopes[:, 0, _T] = 2.0 * t
    slopes[:, 1, _T], slopes[:, 1, _P] = p, t
    slopes[:, 2, _P] = 2.0 * p
    slopes[:, [3, 4, 5], _SECOND] = np.cross(t, p)[:, None]
    slopes[:, 3:, _T] = np.cross(p[:, None], second)
    slopes[:, 3:, _P] = np.cross(second, t[:, None])
    return slopes.reshape(points, 6, 15)


def _add_pair(blocks: np.ndarray, first: int, second: int, matrix: np.ndarray) -> None:
    blocks[:, first, :, second] += matrix
    blocks[:, second, :, first] += matrix.transpose(0, 2, 1)


def _turned(vectors: Float[np.ndarray, "point 3"]) -> Float[np.ndarray, "point 3 3"]:
    """The matrices eps_ijk v_k."""
    turned = np.zeros((len(vectors), 3, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        turned[:, i, j], turned[:, j, i] = vectors[:, k], -vectors[:, k]
    return turned
