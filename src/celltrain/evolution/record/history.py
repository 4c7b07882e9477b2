"""The history of a simulation: a row for each step, and rows as columns and back."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from celltrain.evolution.methods import Memory, Step, Work

Row = dict[str, Any]


def step_row(
    step: Step[Memory],
    work: Work,
    *,
    eps_linear: float,
    eps_exponential: float,
    wall_seconds: float,
) -> Row:
    """What is kept of a step: a number for each of `STEP_QUANTITIES`.

    **Arguments:** `work`: since the beginning, this step's included; `eps_linear`,
    `eps_exponential`: what the linear theory and a growth from the beginning predict, r0.
    """
    return {
        "time": step.state.time,
        **asdict(step.state.measures),
        **asdict(step.manner),
        **asdict(work),
        "eps_linear": eps_linear,
        "eps_exponential": eps_exponential,
        "wall_seconds": wall_seconds,
    }


def rows(columns: Mapping[str, np.ndarray]) -> list[Row]:
    """Columns of one length as rows."""
    each = zip(*columns.values(), strict=True)
    return [dict(zip(columns, row, strict=True)) for row in each]


def columns(names: Sequence[str], rows: Sequence[Row]) -> dict[str, np.ndarray]:
    """Rows as columns with these names, in their order."""
    return {name: np.array([row[name] for row in rows]) for name in names}
