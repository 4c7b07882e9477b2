"""exp(x^2) erfc(x) for x >= 0 as a polynomial, so that one exponential serves erfc and Gaussian."""

from numpy.polynomial import chebyshev
from scipy.special import erfcx


def _polynomial(degree: int, middle: float) -> list[float]:
    """Coefficients, highest first, of exp(x^2) erfc(x) as a polynomial in (x - c)/(x + c)."""
    nodes = chebyshev.chebpts1(400)
    values = erfcx(middle * (1.0 + nodes) / (1.0 - nodes))
    fitted = chebyshev.cheb2poly(chebyshev.chebfit(nodes, values, degree))
    return [float(each) for each in fitted[::-1]]


#: c, and the coefficients, highest first; relative error 1e-13.
SCALED_ERFC_MIDDLE = 3.0
SCALED_ERFC = _polynomial(18, SCALED_ERFC_MIDDLE)
