"""Checks of a simulation's settings."""

import math

from celltrain.parameters import CaseError


def check_not_negative(name: str, value: float) -> None:
    """Check that a setting is a number that is positive or zero.

    **Raises:** `CaseError` if it is not.
    """
    if not (math.isfinite(value) and value >= 0.0):
        raise CaseError(f"{name} = {value!r} is not allowed; allowed: a number >= 0")


def check_positive(name: str, value: float) -> None:
    """Check that a setting is a positive number.

    **Raises:** `CaseError` if it is not.
    """
    if not (math.isfinite(value) and value > 0.0):
        raise CaseError(f"{name} = {value!r} is not allowed; allowed: a number > 0")
