"""The frames of a simulation: when they are due, and what each holds."""

from typing import Any

import numpy as np

from celltrain.diagnostics import frame
from celltrain.evolution.dynamics import Dynamics
from celltrain.evolution.linear import LinearPrediction
from celltrain.evolution.linear_part import level_of
from celltrain.evolution.methods import Step
from celltrain.evolution.record.history import Row
from celltrain.evolution.record.interpolation import interpolated
from celltrain.evolution.state import State
from celltrain.parameters import Train

#: Times closer than this part of the time between frames are the same.
SAME_TIME = 1e-9


def due_times(last: float, end: float, *, every: float, until: float) -> list[float]:
    """Times of the frames after the last one up to a time: multiples of `every`, and `until`."""
    same = SAME_TIME * every
    number = int(np.floor(last / every + SAME_TIME)) + 1
    times = []
    while number * every <= min(end, until) + same:
        times.append(number * every)
        number += 1
    if end >= until - same and (times[-1] if times else last) < until - same:
        times.append(until)
    return times


def shapes_within(dynamics: Dynamics, before: State, step: Step[Any], time: float) -> np.ndarray:
    """Continuous shapes at a time within a step, r0.

    Within exponential steps the linear dynamics may be as fast as it likes, and no polynomial
    follows it.
    """
    after, linear = step.state, dynamics.linear_part
    if step.exponential and linear is not None:
        begin = dynamics.continuous(before.shapes, before.laps)
        change = dynamics.continuous(after.shapes, after.laps) - begin
        part = (time - before.time) / step.manner.size
        level, turns = level_of(step.manner.size), linear.turns(before.shapes)
        return begin + linear.within(level, turns, before.rates, change, part)
    ends = (
        (each.time, dynamics.continuous(each.shapes, each.laps), each.rates)
        for each in (before, after)
    )
    return interpolated(time, *ends)


def frame_row(train: Train, dynamics: Dynamics, prediction: LinearPrediction, state: State) -> Row:
    """What is kept of a train at a time: shapes where the cells have really gone, and measures."""
    whole = dynamics.continuous(state.shapes, state.laps)
    return {
        "time": state.time,
        "shapes": whole,
        "laps": state.laps,
        "eps": state.measures.eps,
        "eps_x": state.measures.eps_x,
        "eps_linear": prediction.eps(state.time),
        **frame(train, whole, dynamics.tube_rates(state.rates)),
    }
