"""The form of a cell in words."""

import numpy as np
import pytest

from celltrain.harmonics import Profile
from celltrain.membrane import meridian_membrane
from celltrain.parameters import Train
from celltrain.steady.form import form_of

DEGREE = 6


def cell(length: float, width: float, *, bent: float = 0.0) -> Profile:
    """A spheroid, bent by z - b cos^2(theta): at the poles by b more than at the equator."""
    profile = np.zeros((2, DEGREE))
    profile[0, 1] = 0.5 * length * np.sqrt(4 * np.pi / 3)
    profile[1, 1] = 0.5 * width * np.sqrt(8 * np.pi / 3)
    profile[0, 2] = bent / (1.5 * np.sqrt(5 / (4 * np.pi)))
    return profile


@pytest.mark.parametrize(
    ("length", "width", "bent", "form"),
    [
        (3.0, 1.4, 0.0, "bullet"),
        (1.0, 2.4, 0.0, "lens"),
        (1.5, 2.4, 0.8, "cup"),
        (2.0, 1.4, 1.2, "bullet with a dimple"),
        (1.0, 1.4, 2.0, "parachute"),
        (1.0, 1.4, -2.0, "parachute, pointing backwards"),
    ],
)
def test_forms(length: float, width: float, bent: float, form: str) -> None:
    assert form_of(cell(length, width, bent=bent)) == form


def test_the_cell_at_rest_is_a_biconcave_disc() -> None:
    train = Train(diameter=6, packing=0.2, degree=12)
    assert form_of(meridian_membrane(train).rest_profile) == "biconcave disc"
