"""Flow inside a tube from its velocity on the wall, and the wall's velocity from rings of force.

For a wave exp(i (m phi + k z)), in amplitudes R, Phi and Z' with Z = i sign(k) Z', in which all is
real. With x = |k| r, X = |k| a for the tube's radius a, I = I(x), regular flows are (Happel &
Brenner 1983), m > 0:

    (R, Phi, Z') = (I_{m-1}, -I_{m-1}, I_m),  (I_{m+1}, I_{m+1}, I_m),
                   (x I_{m+2} + m I_{m+1}, -(m + 2) I_{m+1}, x I_{m+1}),

the last with the pressure 2 |k| I_m, and for m = 0: (I_1, 0, I_0), (0, I_1, 0), (x I_2, 0, x I_1).
N(r) is the flow of unit velocities on the wall: the three in columns, times the inverse at X.

W is the velocity on the wall of waves of force f on the wall, in free space,

    W f = (1/4 pi) int G f exp(i (m phi + k z)) dphi dz      at phi = z = 0,

a symmetric matrix. With f_+- = R +- Phi, (f_1, f_2, f_3) = (f_+, f_-, f_Z'), and I and K of X,

    A = (X I_m - m I_{m+1}, X I_m + m I_{m-1}, X I_m'),   B = (I_{m+1}, I_{m-1}, I_m),
    w = (1/2, 1/2, 1),
    u_+  = sum_j w_j f_j (-A_j K_{m+1} + B_j (X K_m + m K_{m+1})) + 2 K_{m+1} I_{m+1} f_+,
    u_-  = sum_j w_j f_j (-A_j K_{m-1} + B_j (X K_m - m K_{m-1})) + 2 K_{m-1} I_{m-1} f_-,
    u_Z' = sum_j w_j f_j (A_j K_m + B_j X K_m') + 2 K_m I_m f_Z'.

For k = 0 flows are powers of x = r/a, and there is no net force: any constant serves for log r.
"""

from typing import no_type_check

import numpy as np
from jaxtyping import Float
from numba import njit

from celltrain.parts import part

Response = Float[np.ndarray, "wave wall 3 point"]


def response(
    m: int,
    wave: Float[np.ndarray, " wave"],
    radius: float,
    places: Float[np.ndarray, " point"],
    inside: Float[np.ndarray, "order wave point"],
    on_wall: Float[np.ndarray, "order wave"],
) -> tuple[Response, Response, Float[np.ndarray, "wave wall point"]]:
    """N(r), dN/dr and the pressure of its columns, for waves |k| > 0.

    **Arguments:** `wave` = |k|; `inside`, `on_wall`: exp(-x) I_n(x) at the places and the wall.
    """
    shape = (wave.size, 3, 3, places.size)
    value, slope = np.empty(shape), np.empty(shape)
    pressure = np.empty((wave.size, 3, places.size))
    _fill_response(m, wave, radius, places, inside, on_wall, value, slope, pressure)
    return value, slope, pressure


def uniform_response(
    m: int, radius: float, places: Float[np.ndarray, " point"]
) -> tuple[Response, Response, Float[np.ndarray, "wave wall point"]]:
    """The same for k = 0."""
    x = places / radius
    value, slope = np.zeros((3, 3, x.size)), np.zeros((3, 3, x.size))
    pressure = np.zeros((3, x.size))
    value[2, 2], slope[2, 2] = x**m, m * x ** max(m - 1, 0) / radius
    if m == 0:
        # Radial velocities that are uniform along the wall leave no flow inside.
        value[1, 1], slope[1, 1] = x, 1.0 / radius
        return value[None], slope[None], pressure[None]
    ratio = (m + 2) / m
    low, high = x ** (m - 1), x ** (m + 1)
    low_slope = (m - 1) * x ** max(m - 2, 0) / radius
    high_slope = (m + 1) * x**m / radius
    # (1, -1) r^{m-1}, and (1, -ratio) r^{m+1} with the pressure 4 (m + 1)/m r^m.
    inverse = np.linalg.inv(np.array([[1.0, 1.0], [-1.0, -ratio]]))
    for wall in range(2):
        first, second = inverse[:, wall]
        value[wall, 0] = first * low + second * high
        value[wall, 1] = -first * low - ratio * second * high
        slope[wall, 0] = first * low_slope + second * high_slope
        slope[wall, 1] = -first * low_slope - ratio * second * high_slope
        pressure[wall] = 4.0 * (m + 1) / m * x**m / radius * second
    return value[None], slope[None], pressure[None]


def ring_velocity(
    m: int,
    wave: Float[np.ndarray, " wave"],
    radius: float,
    regular: Float[np.ndarray, "order wave"],
    decaying: Float[np.ndarray, "order wave"],
) -> Float[np.ndarray, "wave 3 3"]:
    """W for waves |k| > 0.

    **Arguments:** `regular`, `decaying`: exp(-X) I_n(X) and exp(X) K_n(X).
    """
    x = wave * radius
    low = abs(m - 1)
    i_low, i_m, i_high = regular[low], regular[m], regular[m + 1]
    k_low, k_m, k_high = decaying[low], decaying[m], decaying[m + 1]
    a = (x * i_m - m * i_high, x * i_m + m * i_low, x * i_high + m * i_m)
    b = (i_high, i_low, i_m)
    size = (0.5, 0.5, 1.0)
    slope = -x * k_high + m * k_m  # X K_m'
    plus, minus, axial = np.empty((3, 3, wave.size))
    for j in range(3):
        plus[j] = size[j] * (-a[j] * k_high + b[j] * (x * k_m + m * k_high))
        minus[j] = size[j] * (-a[j] * k_low + b[j] * (x * k_m - m * k_low))
        axial[j] = size[j] * (a[j] * k_m + b[j] * slope)
    plus[0] += 2.0 * k_high * i_high
    minus[1] += 2.0 * k_low * i_low
    axial[2] += 2.0 * k_m * i_m
    found = np.empty((wave.size, 3, 3))
    for row, each in enumerate((0.5 * (plus + minus), 0.5 * (plus - minus), axial)):
        found[:, row, 0], found[:, row, 1] = each[0] + each[1], each[0] - each[1]
        found[:, row, 2] = each[2]
    return found


def uniform_ring_velocity(m: int) -> Float[np.ndarray, "1 3 3"]:
    """W for k = 0, of forces without a resultant.

    The transverse part is the two-dimensional Stokeslet 2 (-log d + d d/d^2)/2 on the unit circle,
    by its Fourier coefficients.
    """
    found = np.zeros((3, 3))
    if m > 0:
        found[2, 2] = 1.0 / m

    def log(n: int) -> float:
        """Fourier coefficient of -log d, but for the constant."""
        return 0.0 if n == 0 else 0.5 / abs(n)

    even, odd = 0.5 * (log(m - 1) + log(m + 1)), 0.5 * (log(m - 1) - log(m + 1))
    first, still = (0.5 if m == 1 else 0.0), (1.0 if m == 0 else 0.0)
    if m > 0:
        found[0, 0], found[0, 1] = even + 0.5 * (first - still), -odd - 0.5 * first
        found[1, 0] = -odd - 0.5 * first
    found[1, 1] = even + 0.5 * (still + first)
    return found[None]


@part(fastmath=True)
@no_type_check
def _flows(m, x, low, mid, high, top, flow):
    """The three regular flows in columns, from I_{m-1}, I_m, I_{m+1} and I_{m+2}."""
    if m == 0:
        flow[0, 0], flow[0, 1], flow[0, 2] = high, 0.0, x * top
        flow[1, 0], flow[1, 1], flow[1, 2] = 0.0, high, 0.0
        flow[2, 0], flow[2, 1], flow[2, 2] = mid, 0.0, x * high
    else:
        flow[0, 0], flow[0, 1], flow[0, 2] = low, high, x * top + m * high
        flow[1, 0], flow[1, 1], flow[1, 2] = -low, high, -(m + 2) * high
        flow[2, 0], flow[2, 1], flow[2, 2] = mid, mid, x * high


@part(fastmath=True)
@no_type_check
def _flow_slopes(m, x, low, mid, high, top, flow):
    """Their derivatives in x."""
    low_slope = mid + (m - 1) * low / x
    mid_slope = high + m * mid / x
    high_slope = mid - (m + 1) * high / x
    # (x I_{m+2})' = x I_{m+1} - (m + 1) I_{m+2},  (x I_{m+1})' = x I_m - m I_{m+1}.
    twist, along = x * high - (m + 1) * top, x * mid - m * high
    if m == 0:
        flow[0, 0], flow[0, 1], flow[0, 2] = high_slope, 0.0, twist
        flow[1, 0], flow[1, 1], flow[1, 2] = 0.0, high_slope, 0.0
        flow[2, 0], flow[2, 1], flow[2, 2] = mid_slope, 0.0, along
    else:
        flow[0, 0], flow[0, 1], flow[0, 2] = low_slope, high_slope, twist + m * high_slope
        flow[1, 0], flow[1, 1], flow[1, 2] = -low_slope, high_slope, -(m + 2) * high_slope
        flow[2, 0], flow[2, 1], flow[2, 2] = mid_slope, mid_slope, along


@part(fastmath=True)
@no_type_check
def _inverse(matrix, found):
    """The inverse of a 3 x 3 matrix, its columns scaled first."""
    scale = np.empty(3)
    for j in range(3):
        scale[j] = max(abs(matrix[0, j]), abs(matrix[1, j]), abs(matrix[2, j]))
        for i in range(3):
            matrix[i, j] /= scale[j]
    for i in range(3):
        a, b = (i + 1) % 3, (i + 2) % 3
        for j in range(3):
            c, d = (j + 1) % 3, (j + 2) % 3
            found[j, i] = matrix[a, c] * matrix[b, d] - matrix[a, d] * matrix[b, c]
    determinant = 0.0
    for j in range(3):
        determinant += matrix[0, j] * found[j, 0]
    for i in range(3):
        for j in range(3):
            found[i, j] /= determinant * scale[i]


@njit(fastmath=True, cache=True, error_model="numpy")
@no_type_check
def _fill_response(m, wave, radius, places, inside, on_wall, value, slope, pressure):
    low = abs(m - 1)
    at_wall, inverse = np.empty((3, 3)), np.empty((3, 3))
    flow, change = np.empty((3, 3)), np.empty((3, 3))
    for w in range(wave.size):
        edge = wave[w] * radius
        _flows(
            m, edge, on_wall[low, w], on_wall[m, w], on_wall[m + 1, w], on_wall[m + 2, w], at_wall
        )
        _inverse(at_wall, inverse)
        for p in range(places.size):
            x = wave[w] * places[p]
            fall = np.exp(x - edge)
            lower, mid = inside[low, w, p] * fall, inside[m, w, p] * fall
            high, top = inside[m + 1, w, p] * fall, inside[m + 2, w, p] * fall
            _flows(m, x, lower, mid, high, top, flow)
            _flow_slopes(m, x, lower, mid, high, top, change)
            for wall in range(3):
                for i in range(3):
                    total, rising = 0.0, 0.0
                    for j in range(3):
                        total += flow[i, j] * inverse[j, wall]
                        rising += change[i, j] * inverse[j, wall]
                    value[w, wall, i, p] = total
                    slope[w, wall, i, p] = rising * wave[w]
                pressure[w, wall, p] = 2.0 * wave[w] * mid * inverse[2, wall]
