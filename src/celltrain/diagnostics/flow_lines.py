"""Lines along the flow around the cells of a steady train (Fig. 7)."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import scipy  # loads its parts when they are used
from jaxtyping import Float
from matplotlib.path import Path as Outline

from celltrain.diagnostics.streamlines import AT_REST, MeridionalFlow

#: Where lines begin: the stream function over that at the wall where fluid passes, and over its
#: largest value where it turns back.
PASSING = (0.8, 0.5, 0.25, 0.1, 0.03, 0.01, 0.003)
TURNING = (0.05, 0.3, 0.6, 0.9)
# Of a line: largest length over the period, points that are given, and how near to its
# beginning it is closed, over the radius of the tube.
LONGEST, POINTS, CLOSED = 6.0, 400, 0.01

Line = Float[np.ndarray, "2 point"]


class Streamlines:
    """Lines along the velocity of a flow between the membranes, the axis and the wall.

    The velocity is zero on the membrane, which moves as the frame does, and taken as zero inside;
    lines end where they come to rest or would enter a cell.

    **Arguments:** `flow`: from `meridional_flow`; `outline`: distance from the axis and height of
    the points of the membrane's meridian, r0.
    """

    def __init__(self, flow: MeridionalFlow, outline: Float[np.ndarray, "2 point"]) -> None:
        self._flow = flow
        self.period = float(flow.axial[-1] - flow.axial[0])
        # Linear, since the velocity has a kink at the membrane.
        self._velocity = [
            scipy.interpolate.RectBivariateSpline(
                flow.axial, flow.radius, flow.velocity[..., component], kx=1, ky=1
            )
            for component in (0, 1)
        ]
        half = outline.T
        self._cell = Outline(np.concatenate([half, half[::-1] * [-1.0, 1.0]]))

    def through(self, radius: float, axial: float) -> Line:
        """The line that begins at a place, in the direction of the flow: heights, distances."""
        whole = LONGEST * self.period
        start = np.array([axial, radius])

        def direction(_: float, place: np.ndarray) -> np.ndarray:
            radial, along = self._at(place)
            speed = np.hypot(radial, along)
            return np.array([along, radial]) / max(speed, AT_REST)

        def enters(_: float, place: np.ndarray) -> float:
            return -1.0 if self._inside(place) else 1.0

        def leaves(length: float, place: np.ndarray) -> float:
            return 1.001 * self.period - abs(place[0] - axial) if length > 0.0 else 1.0

        def closes(length: float, place: np.ndarray) -> float:
            away = float(np.hypot(*(place - start)))
            return away - CLOSED * self._flow.radius[-1] if length > 0.2 else 1.0

        events: list[Any] = [enters, leaves, closes]
        for each in events:
            each.terminal = True
        found = scipy.integrate.solve_ivp(
            direction, (0.0, whole), start, events=events, max_step=0.05, rtol=1e-6, atol=1e-8
        )
        every = np.linspace(0, found.y.shape[1] - 1, min(POINTS, found.y.shape[1])).astype(int)
        return np.asarray(found.y[:, every])

    def passing(self) -> Iterator[Line]:
        """Lines of the fluid that passes the cells, from the middle between two of them."""
        flow = self._flow
        stream = flow.stream_function[-1]
        inward = float(np.sign(stream[-1]))
        levels = inward * np.abs(stream[-1]) * np.array(PASSING)
        # Outside all that turns back the stream function is monotonic.
        outer = int(np.argmax(-inward * stream)) if np.any(inward * stream < 0.0) else 0
        end = (
            flow.axial[-1]
            if self._at(np.array([flow.axial[-1], flow.radius[-2]]))[1] < 0
            else (flow.axial[0])
        )
        for level in levels:
            across = np.interp(inward * level, inward * stream[outer:], flow.radius[outer:])
            yield self.through(float(across), float(end))

    def turning(self) -> Iterator[Line]:
        """Lines of the fluid that turns back between two cells, if there is any."""
        flow = self._flow
        stream = np.where(flow.inside, -np.inf, flow.stream_function)
        row, column = np.unravel_index(int(np.argmax(stream)), stream.shape)
        whole = float(np.abs(flow.stream_function[:, -1]).max())
        largest = stream[row, column]
        if not largest > AT_REST * whole:
            return
        outward = flow.stream_function[row, column:]
        end = int(np.argmax(outward <= 0.0)) + 1 if np.any(outward <= 0.0) else len(outward)
        for level in TURNING:
            across = np.interp(-level * largest, -outward[:end], flow.radius[column:][:end])
            line = self.through(float(across), float(flow.axial[row]))
            # What the grid does not resolve does not come round.
            if np.hypot(*(line[:, -1] - line[:, 0])) < 3.0 * CLOSED * flow.radius[-1]:
                yield line

    def _at(self, place: np.ndarray) -> tuple[float, float]:
        """Radial and axial velocity at a height and distance; the flow is periodic."""
        height = self._flow.axial[0] + np.mod(place[0] - self._flow.axial[0], self.period)
        away = min(abs(place[1]), self._flow.radius[-1])
        radial, along = (float(each.ev(height, away)) for each in self._velocity)
        return radial * (1.0 if place[1] >= 0.0 else -1.0), along

    def _inside(self, place: np.ndarray) -> bool:
        height = np.mod(place[0] + 0.5 * self.period, self.period) - 0.5 * self.period
        return bool(self._cell.contains_point((abs(place[1]), height)))
