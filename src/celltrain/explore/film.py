"""A simulation's frames in few bytes, for the browser to evaluate on any grid.

Coefficients are rounded to whole steps and written as differences from frame to frame, byte by byte
of all of them in turn: most are small, so their upper bytes cost next to nothing once compressed.
The step is the smallest for which the film is small enough; the error that it leaves is told.
"""

import base64
import gzip

import numpy as np
from jaxtyping import Float

from celltrain.evolution import Run
from celltrain.harmonics import mean_points, real_harmonics
from celltrain.parameters import Train

#: Largest size of a film, bytes of its text, and most frames.
MOST_BYTES, MOST_FRAMES = 7_000_000, 500
#: Finest step of the coefficients, r0.
FINEST = 1e-5


def film_drawing(run: Run) -> dict[str, object]:
    """The film of a simulation as numbers for the browser, times in r0/U and lengths in r0."""
    places = np.linspace(0, len(run.times) - 1, min(len(run.times), MOST_FRAMES))
    chosen = np.unique(places.round().astype(int))
    return film_of(run.train, run.times[chosen], run.shapes[chosen], run.ending.message)


def film_of(
    train: Train,
    times: Float[np.ndarray, " frame"],
    shapes: Float[np.ndarray, "frame cell 3 coefficient"],
    ending: str,
    *,
    most_bytes: int = MOST_BYTES,
) -> dict[str, object]:
    """A film of frames, wherever they come from; `ending` says how they ended."""
    step, text = packed(shapes, most_bytes)
    error = rounding_error(shapes, step)
    words = (
        f"Simulation of {shapes.shape[1]} cells, drawn at its degree {train.degree}, {len(times)}"
        f" frames until t = {times[-1]:.4g} r₀/U: {ending.replace('r0', 'r₀')}."
        + (f" Drawn to {error:.0e} r₀." if error > 1e-3 else "")
    )
    return {
        "times": [float(f"{time:.6g}") for time in times],
        "cells": shapes.shape[1],
        "degree": train.degree,
        "period": train.period,
        "radius": train.radius,
        # Where the first cell is at first, along the tube.
        "start": float(mean_points(shapes[0, 0])[2]),
        "step": step,
        "error": error,
        "words": words,
        "data": text,
    }


def packed(
    shapes: Float[np.ndarray, "frame cell 3 coefficient"], most_bytes: int
) -> tuple[float, str]:
    """The step (r0), and the frames as text.

    The step is the smallest of `FINEST` times a power of 2 that takes at most so many bytes.
    """
    step = FINEST
    while True:
        whole = np.rint(shapes / step).astype(np.int64)
        changes = np.diff(whole, axis=0, prepend=0).astype("<i4")
        planes = changes.reshape(-1, 1).view(np.uint8).T.copy()
        text = base64.b64encode(gzip.compress(planes.tobytes(), 7, mtime=0)).decode()
        if len(text) <= most_bytes or step > 0.01:
            return step, text
        step *= 2.0


def unpacked(
    text: str, step: float, shape: tuple[int, ...]
) -> Float[np.ndarray, "frame cell 3 coefficient"]:
    """The frames again, as the browser has them."""
    planes = np.frombuffer(gzip.decompress(base64.b64decode(text)), np.uint8).reshape(4, -1)
    changes = np.ascontiguousarray(planes.T).view("<i4").reshape(shape)
    return np.asarray(step * np.cumsum(changes, axis=0))


def rounding_error(shapes: Float[np.ndarray, "frame cell 3 coefficient"], step: float) -> float:
    """How far points of the membranes are moved by the step at most, r0, as far as is sampled."""
    sampled = shapes[:: max(1, len(shapes) // 20)]
    lost = np.rint(sampled / step) * step - sampled
    degree = int(np.sqrt(shapes.shape[-1]))
    theta = np.repeat(np.linspace(0.05, np.pi - 0.05, 12), 16)
    phi = np.tile(2.0 * np.pi * np.arange(16) / 16, 12)
    moved = lost @ real_harmonics(degree, theta, phi).T
    return float(np.linalg.norm(moved, axis=-2).max())
