"""What the scripts in the browser draw a train from: numbers, few of them.

A train is its profile (see `harmonics.profile`), a mode a vector in `azimuthal_basis(degree, m)`;
`assets/harmonics.js` evaluates both on a grid.
"""

import numpy as np

from celltrain.explore.reading import Reading
from celltrain.stability import InfiniteTrain, Mode, Stability, WaveMode
from celltrain.stability.verdict import wave_words
from celltrain.steady import Base

#: A train, a mode or a film as JSON has it.
Drawn = dict[str, object]
#: Cells that are drawn of a train without end.
ENDLESS = 8
#: The mode that leads, whichever it is.
LEADING = "leading"


def train_drawing(base: Base, *, infinite: bool = False) -> Drawn:
    """The steady train as numbers for the browser, in r0."""
    train = base.train
    return {
        "degree": train.degree,
        "profile": base.profile.tolist(),
        "period": train.period,
        "radius": train.radius,
        "cells": ENDLESS if infinite else train.cells,
    }


def mode_drawing(
    result: Stability | InfiniteTrain, key: str | None, reading: Reading
) -> Drawn | None:
    """A mode as numbers for the browser, or None where there is none of this key.

    **Arguments:** `key`: `LEADING`, or azimuthal number, wave number (of an infinite train the
    number of the phase) and place in the block, such as ``"1,0,0"``.
    """
    if key is None:
        return None
    if isinstance(result, InfiniteTrain):
        wave = _wave(result, key)
        return None if wave is None else _wave_drawing(wave, key, reading)
    mode = _mode(result, key)
    return None if mode is None else drawing_of_mode(result, mode, key, reading)


def mode_key(mode: Mode) -> str:
    """What a mode of a finite train is called in addresses."""
    return f"{mode.azimuthal_number},{mode.wave_number},{mode.index}"


def vector_numbers(vector: np.ndarray) -> dict[str, list[float]]:
    """A complex vector as numbers for JSON, with a common phase that makes it most real."""
    real = vector * np.exp(-0.5j * np.angle(np.sum(vector**2)))
    digits = np.abs(real).max() * 1e-6
    rounded = np.round(real / digits) * digits
    return {
        "real": [float(f"{each:.7g}") for each in rounded.real],
        "imaginary": [float(f"{each:.7g}") for each in rounded.imag],
    }


def _mode(result: Stability, key: str) -> Mode | None:
    if key == LEADING:
        return result.leading
    return next((mode for mode in result.modes if mode_key(mode) == key), None)


def _wave(result: InfiniteTrain, key: str) -> WaveMode | None:
    if key == LEADING:
        return result.most_unstable
    try:
        m, place, _ = (int(part) for part in key.split(","))
        return result.leading[m][place]
    except (ValueError, KeyError, IndexError):
        return None


def drawing_of_mode(result: Stability, mode: Mode, key: str, reading: Reading) -> Drawn:
    """A mode of a finite train as numbers for the browser."""
    m, j, cells = mode.azimuthal_number, mode.wave_number, result.base.train.cells
    vector = result.right_vectors[m][j, :, mode.index]
    words = f"m = {m}, {wave_words(j, cells)}" + (f" ({mode.neutral_kind})" if mode.neutral else "")
    return _drawing(vector, m, 2.0 * np.pi * j / cells, mode, key, words, reading)


def _wave_drawing(wave: WaveMode, key: str, reading: Reading) -> Drawn:
    length = f"{2.0 * np.pi / wave.phase:.3g} cells a wave" if wave.phase else "all cells alike"
    words = f"m = {wave.azimuthal_number}, {length}"
    return _drawing(wave.right, wave.azimuthal_number, wave.phase, wave, key, words, reading)


def _drawing(
    vector: np.ndarray,
    m: int,
    phase: float,
    mode: Mode | WaveMode,
    key: str,
    words: str,
    reading: Reading,
) -> Drawn:
    factor, unit = reading.of("U/r0")
    frequency = mode.frequency * factor
    rates = f"growth rate {mode.growth_rate * factor:.4g} {unit}"
    if abs(frequency) > 1e-9 * factor:
        rates += f", frequency {frequency:.4g} {unit}"
    return {
        "key": key,
        "m": m,
        "q": phase,
        "words": f"{words}: {rates}".replace("-", "−"),
        "place": [mode.growth_rate * factor, frequency],
        **vector_numbers(vector),
    }
