"""Streamlines of a known flow: along them the stream function stays, and no cell is entered."""

import numpy as np
import pytest
from drawn import words_outside
from matplotlib.figure import Figure
from matplotlib.path import Path as Outline

from celltrain import Base
from celltrain.diagnostics import MeridionalFlow, meridional_flow
from celltrain.diagnostics.flow_lines import Streamlines
from celltrain.meridian.geometry import meridian_points
from celltrain.pictures import draw_streamlines
from celltrain.pictures.streamlines import streamline_panel

PERIOD, RADIUS, AHEAD = 10.0, 3.0, 0.5


def stream_function(radius: np.ndarray, axial: np.ndarray) -> np.ndarray:
    """psi = r^2 (a cos(2 pi s/P) - r^2), s from the middle between two cells."""
    wave = AHEAD * np.cos(2 * np.pi * (axial - 0.5 * PERIOD) / PERIOD)
    return radius**2 * (wave - radius**2)


@pytest.fixture(scope="module")
def known() -> MeridionalFlow:
    radius = np.linspace(0, RADIUS, 121)
    axial = np.linspace(-0.5, 0.5, 241) * PERIOD
    across, z = np.meshgrid(radius, axial)
    number = 2 * np.pi / PERIOD
    angle = number * (z - 0.5 * PERIOD)
    velocity = np.stack(
        [
            across * AHEAD * number * np.sin(angle),
            2 * AHEAD * np.cos(angle) - 4 * across**2,
        ],
        axis=-1,
    )
    inside = np.hypot(across, z) < 1.0
    return MeridionalFlow(radius, axial, velocity, stream_function(across, z), inside)


@pytest.fixture(scope="module")
def ball() -> np.ndarray:
    angle = np.linspace(0, np.pi, 201)
    return np.stack([np.sin(angle), np.cos(angle)])


def test_the_stream_function_stays_along_every_line(
    known: MeridionalFlow, ball: np.ndarray
) -> None:
    lines = Streamlines(known, ball)
    passing, turning = list(lines.passing()), list(lines.turning())
    assert len(passing) == 7
    assert len(turning) == 4
    whole = np.abs(known.stream_function[:, -1]).max()
    for height, distance in (*passing, *turning):
        values = stream_function(distance, height)
        assert np.ptp(values) < 2e-3 * whole
    largest = known.stream_function.max()
    for height, distance in turning:
        # Fluid that turns back comes round to where it began.
        assert np.hypot(height[-1] - height[0], distance[-1] - distance[0]) < 0.05 * RADIUS
        assert 0.0 < stream_function(distance, height).mean() <= largest
        assert np.ptp(height) > 0.5


def test_lines_pass_the_cell_or_end_on_it(known: MeridionalFlow, ball: np.ndarray) -> None:
    ends = []
    for height, distance in Streamlines(known, ball).passing():
        middle = np.mod(height + 0.5 * PERIOD, PERIOD) - 0.5 * PERIOD
        away = np.hypot(distance, middle)
        # The outline is a polygon inside the circle.
        assert (away > 1.0 - 1e-3).all()
        ends.append(away[-1])
    # This flow does not rest on the ball: the inner lines run into it and end there.
    assert min(ends) == pytest.approx(1.0, abs=1e-3)
    assert max(ends) > 2.0


def test_what_turns_back_is_shaded(known: MeridionalFlow, ball: np.ndarray) -> None:
    def shades(flow: MeridionalFlow) -> int:
        axes = Figure().subplots()
        streamline_panel(axes, flow, ball)
        return len(axes.collections)

    still = MeridionalFlow(
        known.radius,
        known.axial,
        known.velocity,
        np.minimum(known.stream_function, 0.0),
        known.inside,
    )
    assert shades(known) > 0
    assert shades(still) == 0


def test_the_picture_of_a_train(coarse_base: Base) -> None:
    flow = meridional_flow(coarse_base, radial=21, axial=25)
    figure = draw_streamlines(coarse_base, flow)
    assert words_outside(figure) == []
    [axes] = figure.axes
    assert f"packing {coarse_base.train.packing:g}" in axes.get_title(loc="left")
    # No line runs inside a cell: the membrane is their boundary.
    across, along = meridian_points(coarse_base.profile)
    half = np.stack([across, along], axis=-1)
    outline = Outline(np.concatenate([half, half[::-1] * [-1.0, 1.0]]))
    period = coarse_base.train.period
    lines = [line for line in axes.lines if line.get_zorder() == 1]
    assert lines
    for line in lines:
        height, distance = np.asarray(line.get_xydata()).T
        middle = np.mod(height + 0.5 * period, period) - 0.5 * period
        points = np.stack([np.abs(distance), middle], axis=-1)
        # The last one may lie on it.
        assert not outline.contains_points(points[:-1]).any()
