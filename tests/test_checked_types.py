"""The checks of annotations that tests make: they refuse what does not fit, each time."""

from collections.abc import Callable

import numpy as np
import pytest
from checked_types import checked
from jaxtyping import Float, TypeCheckError, jaxtyped


@jaxtyped(typechecker=checked)
def cut(values: Float[np.ndarray, " n"], length: int) -> Float[np.ndarray, " n"]:
    return values[:length]


def test_arguments_and_results_are_checked() -> None:
    values = np.zeros(3)
    assert len(cut(values, 3)) == 3
    with pytest.raises(TypeCheckError, match="parameters"):
        cut(np.zeros((3, 1)), 3)
    with pytest.raises(TypeCheckError, match="parameters"):
        cut(values, "3")  # type: ignore[arg-type]
    # By the size that the argument has.
    with pytest.raises(TypeCheckError, match="return value"):
        cut(values, 2)


def test_functions_within_others_have_the_checks_of_their_definition() -> None:
    def defined(annotation: object) -> Callable[[object], object]:
        def same(value: annotation) -> annotation:  # type: ignore[valid-type]
            return value

        same.__annotations__ = {"value": annotation, "return": annotation}
        made: Callable[[object], object] = jaxtyped(same, typechecker=checked)
        return made

    for _ in range(2):
        vector, number = defined(Float[np.ndarray, " n"]), defined(int)
        assert number(2) == 2
        assert vector(np.zeros(2)) is not None
        with pytest.raises(TypeCheckError):
            vector(2)
        with pytest.raises(TypeCheckError):
            number(np.zeros(2))
