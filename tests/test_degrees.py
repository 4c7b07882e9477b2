"""Degrees that rise until a number is known, and what sequences of them leave open."""

import math
from collections.abc import Callable
from dataclasses import replace

import pytest

from celltrain import Base, Train
from celltrain.parameters.resolution import LARGEST_DEGREE
from celltrain.steady import NotConverged
from celltrain.steady.base import MembraneCrosses
from celltrain.steady.degree import (
    BEST_RATE,
    CHANGES,
    DEGREES,
    FEWEST,
    WORST_RATE,
    Convergence,
    higher,
    raised,
    remaining,
)
from celltrain.steady.ways import first_degree


def test_one_value_tells_nothing() -> None:
    assert math.isnan(remaining([1.0]))
    assert math.isnan(remaining([]))
    assert math.isnan(Convergence(12, (12,), (1.0,)).error)


@pytest.mark.parametrize("rate", [0.3, 0.5, 0.69])
def test_geometric_sequences_are_judged_exactly(rate: float) -> None:
    values = [3.0 + rate**i for i in range(6)]
    assert remaining(values) == pytest.approx(values[-1] - 3.0, rel=1e-12)


def test_rates_are_bounded() -> None:
    best, worst = BEST_RATE / (1 - BEST_RATE), WORST_RATE / (1 - WORST_RATE)
    # The change falls to a hundredth, which may be chance: the one before is carried on.
    assert remaining([1.0, 0.9, 0.899]) == pytest.approx(best * 0.1 * BEST_RATE)
    # Changes that do not fall are carried on at the worst rate.
    assert remaining([0.0, 1.0, 2.0]) == pytest.approx(worst)
    assert remaining([0.0, 1.0]) == pytest.approx(worst)


def test_changes_that_are_small_by_chance() -> None:
    best = BEST_RATE / (1 - BEST_RATE)
    found = remaining([1.0, 0.5, 0.3, 0.3])
    assert found == pytest.approx(best * max(0.2 * BEST_RATE, 0.5 * BEST_RATE**2))
    assert remaining([2.0, 2.0, 2.0]) == 0.0


def test_old_changes_are_forgotten() -> None:
    recent = [1.0 + 0.5**i for i in range(CHANGES + 1)]
    assert remaining([1e6, *recent]) == pytest.approx(remaining(recent))


def test_error_at_a_lower_degree() -> None:
    found = Convergence(16, (12, 16, 20), (1.0, 0.9, 0.86))
    left = remaining(found.values)
    assert found.left == left
    assert found.error == pytest.approx(0.04 + left)
    assert Convergence(20, (12, 16, 20), (1.0, 1.0, 1.0), least=1e-3).error == 1e-3


def test_a_membrane_that_crosses_at_a_higher_degree_is_told(coarse_base: Base) -> None:
    def evaluate(failure: type[NotConverged]) -> Callable[[int], float]:
        def value(degree: int) -> float:
            if degree > DEGREES[1]:
                raise failure("none", coarse_base)
            return 1.0 / degree

        return value

    found = raised(evaluate(NotConverged), lambda found: False)
    assert found.degree == DEGREES[1]
    with pytest.raises(MembraneCrosses):
        raised(evaluate(MembraneCrosses), lambda found: False)


def test_degrees_rise_until_it_is_enough() -> None:
    asked: list[int] = []

    def evaluate(degree: int) -> float:
        asked.append(degree)
        return 1.0 + 2.0 ** -(degree / 4)

    found = raised(evaluate, lambda each: each.left < 0.02)
    assert found.degrees == tuple(asked) == DEGREES[: len(asked)]
    assert found.degree == asked[-1]
    assert found.left < 0.02
    # Few values are never enough, and the ladder ends.
    assert raised(evaluate, lambda _: True).degrees == DEGREES[:FEWEST]
    assert raised(evaluate, lambda _: False, first=30).degrees == (30, 32, 40, 48, 56, 64)
    assert raised(evaluate, lambda _: True, first=60).degrees == (60, 64)
    assert higher(20) == (24, 32, 40, 48, 56, 64)
    assert higher(LARGEST_DEGREE) == ()


def test_degrees_without_a_train_are_passed_over(make_base: Callable[..., Base]) -> None:
    base = replace(make_base(diameter=2, packing=0.2), truncation_error=1e-3)
    nothing = NotConverged("no steady train", base)

    def evaluate(degree: int) -> float:
        if not 20 <= degree < least_failing:
            raise nothing
        return 1.0 + 2.0 ** -(degree / 4)

    least_failing = 100
    assert raised(evaluate, lambda _: True).degrees == (20, 24, 32)
    # One that fails above others ends it with what is known.
    least_failing = 32
    assert raised(evaluate, lambda _: True).degrees == (20, 24)
    least_failing = 20
    with pytest.raises(NotConverged, match="no steady train"):
        raised(evaluate, lambda _: True)


def test_a_search_that_ends_at_a_resolved_shape_is_not_repeated(
    make_base: Callable[..., Base],
) -> None:
    # Cells close to spheres have no room at this packing, by any degree.
    asked: list[int] = []

    def evaluate(degree: int) -> float:
        asked.append(degree)
        left_out = {12: 1e-4, 16: 4e-5, 20: 2e-5}[degree]
        raise NotConverged("no train", replace(make_base(), truncation_error=left_out))

    with pytest.raises(NotConverged, match="no train"):
        raised(evaluate, lambda _: True)
    assert asked == [12, 16, 20]


def test_narrow_tubes_begin_at_higher_degrees() -> None:
    degrees = [first_degree(Train(diameter=d, packing=0.1)) for d in (6, 3, 2.4, 2, 1.6, 1.45)]
    assert degrees[:2] == [DEGREES[0]] * 2
    assert degrees == sorted(degrees)
    assert degrees[-1] == 32
