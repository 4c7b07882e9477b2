"""Newton's method with known roots taken out finds the others, and says what it tried."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from celltrain import Base, CaseError
from celltrain.continuation import deflated_newton, deflated_step, further_trains
from celltrain.continuation.deflation import SAME, TOLERANCE, UNIT

# x^3 = x and y^2 = 4: six roots.
ROOTS = {(x, y) for x in (-1.0, 0.0, 1.0) for y in (-2.0, 2.0)}


def residual(point: np.ndarray) -> np.ndarray:
    return np.array([point[0] ** 3 - point[0], point[1] ** 2 - 4.0])


def jacobian(point: np.ndarray) -> np.ndarray:
    return np.diag([3 * point[0] ** 2 - 1.0, 2 * point[1]])


def equations(point: np.ndarray) -> tuple[np.ndarray, float]:
    value = residual(point)
    return -np.linalg.solve(jacobian(point), value), float(np.abs(value).max())


def test_step_is_newtons_of_the_deflated_equations() -> None:
    known = [np.array([1.0, 2.0]), np.array([-1.0, 2.0])]
    point = np.array([0.4, 1.1])

    def deflated(at: np.ndarray) -> np.ndarray:
        factors = [1.0 / np.sum((at - root) ** 2) + 1.0 for root in known]
        return np.prod(factors) * residual(at)

    step = 1e-6
    columns = [
        (deflated(point + step * unit) - deflated(point - step * unit)) / (2 * step)
        for unit in np.eye(2)
    ]
    expected = -np.linalg.solve(np.stack(columns, axis=1), deflated(point))
    found = deflated_step(equations(point)[0], point, known)
    assert_allclose(found, expected, rtol=1e-7)


def test_all_roots_from_one_start() -> None:
    found: list[np.ndarray] = []
    while True:
        point, ending, _ = deflated_newton(
            equations, np.array([0.7, 1.3]), found, tolerance=1e-12, most_iterations=200
        )
        if point is None:
            break
        found.append(point)
        assert ending == "found"
        assert len(found) <= len(ROOTS)
    # Without deflation the same start gives the same root for ever.
    assert {tuple(np.round(point, 9) + 0.0) for point in found} == ROOTS


def test_endings() -> None:
    start = np.array([0.7, 1.3])
    assert deflated_newton(equations, start, [], tolerance=1e-12, most_iterations=1)[1:] == (
        "did not converge",
        1,
    )
    assert deflated_newton(lambda _: None, start, [], tolerance=1e-12)[1] == "left what is allowed"


@pytest.mark.slow
def test_search_for_other_trains(coarse_base: Base) -> None:
    search = further_trains(coarse_base, random_starts=1, most_iterations=10)
    assert len(search.attempts) == 5
    assert all(attempt.iterations <= 10 for attempt in search.attempts)
    assert len(search.found) == sum(attempt.ending == "found" for attempt in search.attempts)
    assert f"{len(search.attempts)} starts" in str(search)
    shapes = [coarse_base.coefficients, *(base.coefficients for base in search.found)]
    for number, base in enumerate(search.found):
        assert base.residual < TOLERANCE
        assert base.train == coarse_base.train
        for other in shapes[: number + 1]:
            assert np.linalg.norm(base.coefficients - other) > SAME * UNIT


def test_what_is_refused(coarse_base: Base) -> None:
    with pytest.raises(CaseError, match="random_starts = -1"):
        further_trains(coarse_base, random_starts=-1)
