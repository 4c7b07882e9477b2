"""What a simulation costs: our methods beside the paper's forward Euler.

The case is that of the breakup: diameter 10, packing 0.7, eight cells, degree 12. Its fastest mode
is followed until the first transients are over, or a simulation's last state is taken. From that
one state each method is marched through a short window, one after another in this process: the
exponential method and Runge-Kutta-Chebyshev at three tolerances, Euler at the paper's step. The
error of each is that of ln(eps) per time, the error of a rate of growth, so windows of different
lengths can be compared; the reference is Runge-Kutta-Chebyshev at a smaller tolerance, at which its
error is about five times smaller than at the smallest of these. Each line of simulation.csv is one
method.

    python benchmarks/simulation.py [--run RUN.nc] [--window TIME] [--euler-window TIME]

Run time. Five to ten minutes on two cores, with nothing else to do.
"""

import argparse
import csv
import os
import time
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from measuring import describe_version, peak_mib, processor, reset_peak
from rich.console import Console
from rich.table import Table

from celltrain import Run, Train, evolve, stability, steady
from celltrain.evolution import (
    ExponentialAdams,
    ForwardEuler,
    Integrator,
    Leading,
    RungeKuttaChebyshev,
)
from celltrain.evolution.dynamics import Dynamics, train_dynamics
from celltrain.evolution.methods import ChebyshevMemory, EulerMemory, ExponentialMemory, Memory
from celltrain.evolution.record.frames import shapes_within
from celltrain.evolution.state import State

RESULTS = Path(__file__).resolve().parent / "simulation.csv"
TRAIN = Train(diameter=10, packing=0.7, cells=8, degree=12)
AMPLITUDE = 0.1
# Times in r0/U: of the first transients, and of the windows.
SPIN_UP = 20.0
WINDOW = 10.0
EULER_WINDOW = 2.0
TOLERANCES = (1e-3, 1e-4, 1e-5)
REFERENCE = 1e-6
EULER_STEP = 0.014


@dataclass(frozen=True)
class March:
    """A march through a window: times from its beginning, eps, and what it cost."""

    times: np.ndarray
    eps: np.ndarray
    seconds: float
    evaluations: int
    peak_mib: float

    @property
    def length(self) -> float:
        """Time that it covers, r0/U."""
        return float(self.times[-1])


def past_the_transients() -> Run:
    """A simulation of the fastest mode until the first transients are over."""
    start = stability(steady(TRAIN), azimuthal_numbers=(1,), estimate_error=False)
    method = RungeKuttaChebyshev(TOLERANCES[0])
    return evolve(start, Leading(AMPLITUDE), until=SPIN_UP, every=SPIN_UP, integrator=method)


def march(
    dynamics: Dynamics,
    method: Integrator,
    begin: State,
    memory: Memory,
    window: float,
    dense: int = 1,
) -> March:
    """March through a window; eps also at `dense` - 1 times within each step."""
    shapes = dynamics.continuous(begin.shapes, begin.laps)
    times, eps, state, evaluations = [0.0], [size(dynamics, shapes)], begin, 0
    reset_peak()
    started = time.perf_counter()
    while state.time - begin.time < window:
        step = method.advance(dynamics, state, memory)
        after, memory = step.state, step.memory
        evaluations += step.work.evaluations
        for at in np.linspace(state.time, after.time, dense + 1)[1:]:
            times.append(float(at - begin.time))
            eps.append(size(dynamics, shapes_within(dynamics, state, step, float(at))))
        state = after
    seconds = time.perf_counter() - started
    return March(np.array(times), np.array(eps), seconds, evaluations, peak_mib())


def size(dynamics: Dynamics, shapes: np.ndarray) -> float:
    """eps of continuous shapes, r0."""
    change = shapes - np.asarray(dynamics.base)
    return float(np.sqrt(np.sum(np.asarray(dynamics.weights) * change**2)))


def with_step(memory: ChebyshevMemory, tolerance: float) -> ChebyshevMemory:
    """The memory with a step for another tolerance: errors of a step fall as its third power."""
    factor = (tolerance / TOLERANCES[0]) ** (1.0 / 3.0)
    return replace(memory, step=factor * memory.step, last_step=0.0, last_error=0.0)


def exponential_memory(
    memory: ChebyshevMemory, state: State, tolerance: float
) -> ExponentialMemory:
    """The memory of the exponential method with the same first step."""
    step = with_step(memory, tolerance).step
    return replace(ExponentialAdams(tolerance).begin(state), step=step)


def error(found: March, reference: March) -> float:
    """Error of ln(eps) over the time covered, U/r0: that of a rate of growth."""
    end = min(found.length, reference.length)
    sizes = [np.interp(end, each.times, np.log(each.eps)) for each in (found, reference)]
    return float(abs(sizes[0] - sizes[1]) / end)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--run", type=Path, help="simulation of this train to start from, its last")
    parser.add_argument("--window", type=float, default=WINDOW, help="r0/U")
    parser.add_argument("--euler-window", type=float, default=EULER_WINDOW, help="r0/U")
    options = parser.parse_args()
    errors = Console(stderr=True)
    with errors.status("steady train, its linear dynamics, the first transients"):
        run = Run.load(options.run) if options.run else past_the_transients()
    if run.train != TRAIN or run.integrator != RungeKuttaChebyshev(TOLERANCES[0]):
        parser.error(f"{options.run} is no simulation of this train by Runge-Kutta-Chebyshev")
    state = run.state
    dynamics = train_dynamics(run.base, run.repulsion, wall_gap=state.wall_gap)
    # What is compiled is not measured.
    dynamics.settle(dynamics.rates(state.shapes) + state.shapes)
    errors.print(f"from t = {state.time:.0f} r0/U")
    assert isinstance(run.memory, ChebyshevMemory)
    methods: dict[str, tuple[Integrator, State, Memory, float]] = {
        f"exponential, tolerance {tolerance:g}": (
            ExponentialAdams(tolerance),
            state,
            exponential_memory(run.memory, state, tolerance),
            options.window,
        )
        for tolerance in TOLERANCES
    }
    methods |= {
        f"Runge-Kutta-Chebyshev, tolerance {tolerance:g}": (
            RungeKuttaChebyshev(tolerance),
            state,
            with_step(run.memory, tolerance),
            options.window,
        )
        for tolerance in TOLERANCES
    }
    # Euler's time is the number of its steps times their size.
    still = replace(state, time=0.0)
    methods[f"forward Euler, step {EULER_STEP:g}"] = (
        ForwardEuler(EULER_STEP),
        still,
        EulerMemory(0),
        options.euler_window,
    )
    marches = {}
    for name, (method, first, memory, window) in methods.items():
        with errors.status(name):
            marches[name] = march(dynamics, method, first, memory, window)
        errors.print(f"{name}: {marches[name].seconds:.0f} s")
    longest = max(each.length for each in marches.values())
    with errors.status("reference"):
        reference = march(
            dynamics,
            RungeKuttaChebyshev(REFERENCE),
            state,
            with_step(run.memory, REFERENCE),
            longest,
            dense=8,
        )
    results = {name: (each, error(each, reference)) for name, each in marches.items()}
    record(results)
    output = Console() if Console().is_terminal else Console(width=110)
    output.print(report(results))


def report(results: dict[str, tuple[March, float]]) -> Table:
    """All methods beside Euler, the last."""
    euler = list(results.values())[-1][0]
    table = Table(title="D = 10 r0, packing 0.7, N = 8, M = 12", title_justify="left")
    table.caption = "error: of ln(eps) per time; times Euler: by the time, and by the evaluations"
    table.add_column("method", no_wrap=True)
    for column in ("r0/U an hour", "times Euler", "evaluations a r0/U", "error, U/r0", "MiB"):
        table.add_column(column, justify="right")
    for name, (each, off) in results.items():
        faster = speed(each) / speed(euler)
        fewer = (euler.evaluations / euler.length) / (each.evaluations / each.length)
        table.add_row(
            name,
            f"{speed(each):.0f}",
            f"{faster:.1f}, {fewer:.1f}",
            f"{each.evaluations / each.length:.2f}",
            f"{off:.1e}",
            f"{each.peak_mib:.0f}",
        )
    return table


def speed(each: March) -> float:
    """Simulated r0/U per hour."""
    return 3600.0 * each.length / each.seconds


def record(results: dict[str, tuple[March, float]]) -> None:
    """Append a line for each method to the table of results."""
    new = not RESULTS.exists()
    with RESULTS.open("a", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        if new:
            writer.writerow(
                (
                    "date",
                    "version",
                    "processor",
                    "cores",
                    "method",
                    "window",
                    "seconds",
                    "evaluations",
                    "per_hour",
                    "growth_rate_error",
                    "peak_mib",
                )
            )
        for name, (each, off) in results.items():
            writer.writerow(
                (
                    datetime.now(UTC).strftime("%Y-%m-%d"),
                    describe_version(),
                    processor(),
                    len(os.sched_getaffinity(0)),
                    name,
                    f"{each.length:.4g}",
                    f"{each.seconds:.4g}",
                    each.evaluations,
                    f"{speed(each):.4g}",
                    f"{off:.2e}",
                    f"{each.peak_mib:.0f}",
                )
            )


if __name__ == "__main__":
    main()
