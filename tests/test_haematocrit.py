"""Haematocrits of a train, and the law of the viscosity of blood in tubes."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from celltrain import CaseError
from celltrain.diagnostics import (
    discharge_haematocrit,
    in_vitro_fahraeus,
    in_vitro_viscosity,
    tube_haematocrit,
)
from celltrain.steady import Base
from celltrain.train import train_membrane


def test_the_law_is_that_of_the_measurements() -> None:
    # No cells, no change; at 45 % the fit of the diameter alone; wide tubes 3.2, the least at 7 um.
    for diameter in (4.0, 8.0, 20.0, 1000.0):
        assert in_vitro_viscosity(diameter, 0.0) == 1.0
    assert in_vitro_viscosity(1000.0, 0.45) == pytest.approx(3.2, abs=0.02)
    diameters = np.linspace(4.0, 12.0, 81)
    usual = [float(in_vitro_viscosity(each, 0.45)) for each in diameters]
    assert diameters[np.argmin(usual)] == pytest.approx(6.9, abs=0.3)
    assert min(usual) == pytest.approx(1.25, abs=0.02)
    # Narrow tubes: proportional to the haematocrit; wide ones steeper.
    shares = np.array([0.1, 0.2, 0.4])
    narrow = in_vitro_viscosity(5.0, shares) - 1.0
    assert_allclose(narrow / narrow[0], shares / shares[0], rtol=0.03)
    wide = in_vitro_viscosity(1000.0, shares) - 1.0
    assert wide[2] / wide[0] > 5.0
    for wrong in ((1.0, 0.3), (8.0, 1.0), (8.0, -0.1)):
        with pytest.raises(CaseError):
            in_vitro_viscosity(*wrong)


def test_haematocrits_of_a_train(make_base: Callable[..., Base]) -> None:
    made = make_base(diameter=5, packing=0.3)
    train = made.train
    base = replace(made, coefficients=np.asarray(train_membrane(train).reference_shape))
    # A cell of volume 4 pi/3 in each period.
    expected = 4 / 3 / (train.radius**2 * train.period)
    assert tube_haematocrit(base) == pytest.approx(expected, rel=1e-4)
    # Cells are faster than the mean, so more of them leave than are there.
    ratio = discharge_haematocrit(base) / tube_haematocrit(base)
    assert ratio == pytest.approx(base.cell_velocity, rel=1e-12)


def test_fahraeus_effect_of_blood() -> None:
    assert in_vitro_fahraeus(5.0, 1.0 - 1e-12) == pytest.approx(1.0)
    for diameter in (4.0, 10.0, 100.0):
        shares = np.linspace(0.0, 0.9, 10)
        ratio = in_vitro_fahraeus(diameter, shares)
        assert (np.diff(ratio) > 0.0).all()
        assert ((ratio > 0.45) & (ratio < 1.0)).all()
    # Wide tubes do not separate cells from plasma.
    assert in_vitro_fahraeus(1900.0, 0.3) == pytest.approx(1.0, abs=1e-6)
    # At 0: 1 + 1.7 e^-2.075 - 0.6 e^-0.055.
    assert in_vitro_fahraeus(5.0, 0.0) == pytest.approx(0.64555, abs=2e-5)
    with pytest.raises(CaseError, match=r"3.3"):
        in_vitro_fahraeus(3.0, 0.4)
