"""What near neighbours do to growth, and streamlines around the cells."""

from pathlib import Path

import numpy as np
import pytest
from drawn import saved
from numpy.testing import assert_allclose

from celltrain import Base, CaseError, Stability
from celltrain.analyses.streamlines import FlowInCellFrame
from celltrain.contract import load
from celltrain.diagnostics import (
    MeridionalFlow,
    deformation_spectrum,
    mechanisms,
    meridional_flow,
    mode_motion,
    perturbation_energy,
    recirculation,
)
from celltrain.meridian.geometry import meridian_points
from celltrain.pictures import (
    draw_deformation_spectra,
    draw_growth_without_neighbours,
    draw_mode_motions,
    draw_strain_energies,
    draw_streamlines,
)
from celltrain.results import save
from celltrain.stability import (
    blocks_without_neighbours,
    growth_without_neighbours,
)


def test_nothing_removed_is_the_train_itself(coarse_stability: Stability) -> None:
    for m, blocks in blocks_without_neighbours(coarse_stability, 0).items():
        assert_allclose(blocks, coarse_stability.blocks[m], rtol=0, atol=1e-12)
    found = growth_without_neighbours(coarse_stability, 0)
    assert_allclose(found.spectral_abscissa, coarse_stability.spectral_abscissa, atol=1e-12)
    leading = coarse_stability.leading
    assert (found.azimuthal_number, found.wave_number) == (
        leading.azimuthal_number,
        leading.wave_number,
    )


def test_without_all_others_nothing_depends_on_the_wave(coarse_stability: Stability) -> None:
    for blocks in blocks_without_neighbours(coarse_stability, 1).values():
        assert_allclose(blocks[1], blocks[0], rtol=0, atol=1e-12 * np.abs(blocks).max())
        assert_allclose(blocks.imag, 0.0, atol=1e-12 * np.abs(blocks).max())
    found = growth_without_neighbours(coarse_stability, 1)
    assert found.spectral_abscissa != pytest.approx(coarse_stability.spectral_abscissa, rel=1e-3)


@pytest.mark.parametrize("removed", [-1, 2])
def test_neighbours_that_are_not_there(coarse_stability: Stability, removed: int) -> None:
    with pytest.raises(CaseError, match=r"allowed: 0 to 1"):
        growth_without_neighbours(coarse_stability, removed)


def test_picture_of_growth_without_neighbours(coarse_stability: Stability, tmp_path: Path) -> None:
    found = [growth_without_neighbours(coarse_stability, removed) for removed in (0, 1)]
    path = saved(draw_growth_without_neighbours({"train": found}), tmp_path / "growth.png")
    assert path.stat().st_size > 5000


@pytest.fixture(scope="module")
def flow(coarse_base: Base) -> MeridionalFlow:
    return meridional_flow(coarse_base, radial=21, axial=25)


def test_a_velocity_that_is_not_known_is_refused(
    coarse_base: Base, monkeypatch: pytest.MonkeyPatch
) -> None:
    def unknown(base: Base, points: np.ndarray) -> np.ndarray:
        velocity = np.zeros_like(points)
        velocity[4] = np.nan
        return velocity

    monkeypatch.setattr("celltrain.train.fluid_velocity", unknown)
    with pytest.raises(CaseError, match=r"not known at 1 of 6 points .* wider tubes"):
        meridional_flow(coarse_base, radial=3, axial=2)


def test_as_much_fluid_passes_everywhere(coarse_base: Base, flow: MeridionalFlow) -> None:
    """A mean velocity of 1 in the tube, seen from the cells."""
    expected = 0.5 * coarse_base.train.radius**2 * (1.0 - coarse_base.cell_velocity)
    assert_allclose(flow.stream_function[:, -1], expected, rtol=2e-3)
    assert_allclose(flow.velocity[0], flow.velocity[-1], atol=1e-3)
    # On the axis inside: the middle of the cell, not the fluid between two cells.
    radius, axial = meridian_points(coarse_base.profile)
    ends = axial[np.isclose(radius, 0.0, atol=1e-9)]
    middle = np.abs(flow.axial - ends.mean()).argmin()
    assert flow.inside[middle, 0]
    assert not flow.inside[0].any()
    assert not flow.inside[:, -1].any()


def test_turning_fluid_in_a_sparse_train(
    coarse_base: Base, flow: MeridionalFlow, tmp_path: Path
) -> None:
    found = recirculation(coarse_base, flow)
    # Cells far apart: between them the fluid on the axis is the faster one (2 U at most), from one
    # cell to the next; so it turns back farther out.
    assert 0.0 < found.axis_velocity < 2.0 - coarse_base.cell_velocity
    assert found.stagnation_points == ()
    assert found.strength > 0.0
    assert 0.0 < found.centre[0] < 0.5 * coarse_base.train.radius
    path = saved(draw_streamlines(coarse_base, flow), tmp_path / "streamlines.png")
    assert path.stat().st_size > 20000


def synthetic(base: Base, ahead: float) -> MeridionalFlow:
    """psi = r^2 (ahead cos(2 pi s/P) - r^2), s from the middle between two cells; no cells."""
    radius, axial = np.linspace(0, 3, 121), np.linspace(-5, 5, 201)
    across, z = np.meshgrid(radius, axial)
    wave = ahead * np.cos(2 * np.pi * (z - 5) / 10)
    stream = across**2 * (wave - across**2)
    axial_velocity = 2 * wave - 4 * across**2
    velocity = np.stack([np.zeros_like(z), axial_velocity], axis=-1)
    return MeridionalFlow(radius, axial, velocity, stream, np.zeros(z.shape, dtype=bool))


def test_turning_fluid_of_a_known_flow(coarse_base: Base, tmp_path: Path) -> None:
    found = recirculation(coarse_base, synthetic(coarse_base, 0.5))
    assert_allclose(found.stagnation_points, (-2.5, 2.5), atol=1e-3)
    assert_allclose(abs(found.axis_velocity), 1.0)
    # r^2 (a - r^2) is largest, a^2/4, at r^2 = a/2.
    assert_allclose(found.strength, 0.25**2 / (9 * 9.5), rtol=1e-3)
    assert_allclose(found.centre, (0.5, 0.0), atol=0.03)
    whole = FlowInCellFrame(coarse_base, synthetic(coarse_base, 0.5), found)
    assert load(save(whole, tmp_path / "flow.nc")) == whole


def test_no_turning_fluid(coarse_base: Base) -> None:
    found = recirculation(coarse_base, synthetic(coarse_base, 0.0))
    assert found.stagnation_points == ()
    assert found.axis_velocity == 0.0
    assert found.strength == 0.0
    assert np.isnan(found.centre).all()


def test_pictures_of_mechanisms(coarse_stability: Stability, tmp_path: Path) -> None:
    found = mechanisms(coarse_stability)
    assert load(save(found, tmp_path / "found.nc")) == found
    leading, transient = found.strains
    shape = coarse_stability.transient_shape()
    assert_allclose(
        list(transient.energies.values()), perturbation_energy(coarse_stability.base, shape)
    )
    assert_allclose(transient.spectrum, deformation_spectrum(shape))
    assert found.leading_energy == leading.energy == sum(leading.energies.values())
    motion = mode_motion(coarse_stability, coarse_stability.leading)
    assert (found.modes[0].tumbling, found.modes[0].tank_treading) == (
        motion.tumbling,
        motion.tank_treading,
    )
    for draw in (draw_strain_energies, draw_deformation_spectra, draw_mode_motions):
        assert saved(draw(found), tmp_path / "picture.png").stat().st_size > 10_000
