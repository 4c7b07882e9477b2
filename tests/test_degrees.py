"""Degrees that rise until a number is known, and what sequences of them leave open."""

import math

import pytest

from celltrain.steady.degree import DEGREES, Convergence, higher, raised, remaining


def test_one_value_tells_nothing() -> None:
    assert math.isnan(remaining([1.0]))
    assert math.isnan(remaining([]))
    assert math.isnan(Convergence(12, (12,), (1.0,)).error)


@pytest.mark.parametrize("rate", [0.45, 0.6, 0.7])
def test_geometric_sequences_are_judged_exactly(rate: float) -> None:
    values = [3.0 + rate**i for i in range(6)]
    assert remaining(values) == pytest.approx(values[-1] - 3.0, rel=1e-12)


def test_rates_are_bounded() -> None:
    # From 1 to 0.9 to 0.89: the change falls to a tenth, which may be chance.
    assert remaining([1.0, 0.9, 0.89]) == pytest.approx(0.4 / 0.6 * max(0.01, 0.1 * 0.4))
    # Changes that do not fall are carried on at the worst rate.
    assert remaining([0.0, 1.0, 2.0]) == pytest.approx(3.0)
    assert remaining([0.0, 1.0]) == pytest.approx(3.0)


def test_changes_that_are_small_by_chance() -> None:
    values = [1.0, 0.5, 0.3, 0.3]
    assert remaining(values) >= 0.4 / 0.6 * 0.4 * 0.2 * (1 - 1e-12)
    assert remaining([2.0, 2.0, 2.0]) == 0.0


def test_error_at_a_lower_degree() -> None:
    found = Convergence(16, (12, 16, 20), (1.0, 0.9, 0.86))
    left = remaining(found.values)
    assert found.left == left
    assert found.error == pytest.approx(0.04 + left)


def test_degrees_rise_until_it_is_enough() -> None:
    asked: list[int] = []

    def evaluate(degree: int) -> float:
        asked.append(degree)
        return 1.0 + 2.0 ** -(degree / 4)

    found = raised(evaluate, lambda each: each.left < 0.02)
    assert found.degrees == tuple(asked) == DEGREES[: len(asked)]
    assert found.degree == asked[-1]
    assert found.left < 0.02
    assert remaining(found.values[:-1]) >= 0.02
    # One value is never enough, and the ladder ends.
    assert raised(evaluate, lambda _: True).degrees == DEGREES[:2]
    assert raised(evaluate, lambda _: False, first=30).degrees == (30, 32, 40, 48)
    assert raised(evaluate, lambda _: True, first=50).degrees == (50,)
    assert higher(20) == (24, 32, 40, 48)
    assert higher(48) == ()
