"""A cell in a tight tube by lubrication theory: exact limits."""

import numpy as np
import pytest

from celltrain.diagnostics.lubrication import outline, rigid_bullet, rigid_cell
from celltrain.harmonics import coefficients_of
from celltrain.membrane import meridian_membrane


@pytest.mark.parametrize("ratio", [0.3, 0.9, 0.99])
def test_a_long_cylinder_goes_with_the_parabola(ratio: float) -> None:
    """Between a free cylinder and the wall the flow is the plain fluid's at a higher gradient."""
    radius, length, period = 0.7, 3.0, 5.0
    z = np.linspace(0.0, length, 101)
    velocity, viscosity = rigid_cell(z, np.full_like(z, ratio * radius), radius, period)
    expected, gradient = rigid_bullet(ratio)
    assert velocity == pytest.approx(expected, rel=1e-12)
    # The film's conductance is a difference of the order (1 - ratio)^3.
    assert viscosity == pytest.approx(1.0 + length / period * (gradient - 1.0), rel=1e-10)
    # The flux of the cell and of the parabola around it is that of the tube.
    parabola = 2.0 * gradient * (1.0 - ratio**2)
    assert parabola == pytest.approx(velocity, rel=1e-12)
    around = gradient * (1.0 - ratio**2) ** 2
    assert ratio**2 * velocity + around == pytest.approx(1.0, rel=1e-12)


def test_thin_films_cost_as_one_over_their_thickness() -> None:
    z = np.linspace(0.0, 2.0, 101)
    for film, error in ((1e-2, 2e-2), (1e-3, 2e-3)):
        velocity, viscosity = rigid_cell(z, np.full_like(z, 1.0 - film), 1.0, 4.0)
        assert velocity == pytest.approx(1.0 + film, abs=2 * film**2)
        # 2 mu U l/(R h) over the drop 8 mu U L/R^2 of the plain fluid.
        assert viscosity - 1.0 == pytest.approx(2.0 * 2.0 / film / (8.0 * 4.0), rel=5 * error)


def test_a_short_cell_of_varying_width_is_between_its_cylinders() -> None:
    z = np.linspace(0.0, 3.0, 2001)
    widths = 0.9 + 0.04 * np.sin(2.0 * np.pi * z / 3.0)
    velocity, viscosity = rigid_cell(z, widths, 1.0, 4.0)
    narrow, wide = rigid_bullet(0.86), rigid_bullet(0.94)
    assert wide[0] < velocity < narrow[0]
    assert narrow[1] - 1.0 < (viscosity - 1.0) * 4.0 / 3.0 < wide[1] - 1.0


def test_the_outline_hides_hollows(make_base) -> None:
    made = make_base(diameter=4, packing=0.2)
    rest = meridian_membrane(made.train).rest_profile
    z, radius = outline(type(made)(**{**vars(made), "coefficients": coefficients_of(rest)}))
    # The biconcave disc: its largest radius in the middle, its rims at the ends.
    assert radius.max() == pytest.approx(1.3858, rel=1e-3)
    assert radius[len(z) // 2] == radius.max()
    assert radius[2] > 0.5
    assert np.ptp(z) < 1.0
