"""Simulate a disturbed train, or go on with a simulation."""

from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from pathlib import Path

import numpy as np

from celltrain.evolution.checks import check_not_negative, check_positive
from celltrain.evolution.disturbances import Disturbance
from celltrain.evolution.dynamics import Dynamics, train_dynamics
from celltrain.evolution.ending import Ending, StepFailed
from celltrain.evolution.films.repulsion import Repulsion
from celltrain.evolution.linear import LinearPrediction, linear_prediction
from celltrain.evolution.march import March, SimulationProgress
from celltrain.evolution.methods import Automatic, Manner, Method, Step, Work
from celltrain.evolution.record.archive import SAVE_SECONDS, Archive
from celltrain.evolution.record.frames import SAME_TIME
from celltrain.evolution.record.quantities import STEP_QUANTITIES
from celltrain.evolution.record.run import Run
from celltrain.evolution.start import at_degree
from celltrain.evolution.wall_resolution import LARGEST, followed
from celltrain.membrane import place_cells
from celltrain.parameters import CaseError, Train
from celltrain.results import only_writer, remove_leftovers
from celltrain.stability import Stability
from celltrain.steady import Base

EVERY = 1.0


def evolve(
    start: Train | Base | Stability,
    disturbance: Disturbance,
    *,
    until: float,
    degree: int | None = None,
    integrator: Method | None = None,
    repulsion: Repulsion | None = None,
    every: float = EVERY,
    path: str | Path | None = None,
    overwrite: bool = False,
    save_seconds: float = SAVE_SECONDS,
    most_steps: int | None = None,
    progress: SimulationProgress | None = None,
) -> Run:
    """Simulate a steady train with a disturbance, in the frame that moves with the steady train.

    **Arguments:**

    - `start`: a case, or what `steady` or `stability` gave. The linear dynamics of the latter, or
      of a case, give predictions beside the result, and are needed for disturbances that are modes.
    - `degree`: of the simulation, 12 unless given here or in a case. A start of another degree is
      computed at this one.
    - `disturbance`: such as `Leading(amplitude=0.1)`. The volumes of the disturbed cells are made
      those of the steady ones, which changes the size of a large disturbance a little.
    - `until`, `every`: last time, and time between frames, in r0/U. Frames lie within steps and do
      not change them.
    - `integrator`: `Automatic()` unless given.
    - `repulsion`: what keeps membranes apart in thin films, `Repulsion()` unless given;
      `Repulsion(range=0)` for none.
    - `path`: netCDF-4 file that holds the simulation at every moment; see `resume`.
    - `overwrite`: whether a file of that name may be replaced.
    - `save_seconds`: wall time between saves, lengthened where a save takes more than 5 % of it; 0
      saves after every step.
    - `most_steps`: end after so many steps.
    - `progress`: called after every step.

    **Returns:** a `Run` with all that there is, whatever ended it (`Run.ending`): the time reached,
    an interruption (Ctrl-C), an overlap, a file that can no longer be written, ...

    **Raises:** `CaseError` for a setting that is not allowed, a steady train with gaps within the
    range of the repulsion, cells that overlap from the beginning, or a file that exists
    or that another process is writing;
    `NotConverged` if there is no steady train; `StepFailed` if the disturbed train has no velocity
    or is too close to the wall.
    """
    check_positive("until", until)
    check_positive("every", every)
    check_not_negative("save_seconds", save_seconds)
    place = Path(path) if path is not None else None
    with _alone(place):
        if place is not None and place.exists() and not overwrite:
            raise CaseError(
                f"output = {str(place)!r} is not allowed: it exists; go on with it (resume), or"
                " allow it to be overwritten"
            )
        start = at_degree(start, degree)
        base = start.base if isinstance(start, Stability) else start
        change = disturbance.shapes(start)
        film = Repulsion() if repulsion is None else repulsion
        dynamics = train_dynamics(base, film, wall_gap=LARGEST)
        train = base.train
        _check_steady(dynamics, film)
        method = Automatic() if integrator is None else integrator
        shapes = place_cells(base.coefficients, train, train.cells) + change
        settled = dynamics.settle(shapes)
        met = dynamics.overlaps(settled.shapes)
        if met:
            raise CaseError(
                f"disturbance ({disturbance}) is not allowed: {met[0]}; a smaller amplitude may be"
            )
        wall_gap = followed(LARGEST, dynamics.wall_distance(settled.shapes))
        if wall_gap != dynamics.wall_gap:
            dynamics = train_dynamics(base, film, wall_gap=wall_gap, known=dynamics)
        state = dynamics.state(0.0, shapes)
        if not np.isfinite(state.rates).all():
            raise StepFailed("not_finite", "the first shapes have no finite velocity")
        memory = method.begin(state)
        first = dynamics.continuous(state.shapes, state.laps) - np.asarray(dynamics.base)
        run = Run(
            start=start,
            disturbance=str(disturbance),
            growth_rate=disturbance.growth_rate(start),
            integrator=method,
            repulsion=film,
            every=float(every),
            until=float(until),
            history={name: np.zeros(0) for name in STEP_QUANTITIES},
            times=np.zeros(0),
            shapes=np.zeros((0, *shapes.shape)),
            frames={},
            state=state,
            memory=memory,
            ending=Ending("running", "not ended yet"),
        )
        march = March(
            run,
            dynamics,
            _prediction(start, first),
            archive=_archive(place),
            save_seconds=save_seconds,
            progress=progress,
        )
        beginning = Manner(size=0.0, stages=0, error=0.0, radius=float("nan"))
        march.begin(Step(state, memory, beginning, Work(evaluations=1)))
        return march.go(most_steps)


def resume(
    path: str | Path,
    *,
    until: float | None = None,
    save_seconds: float = SAVE_SECONDS,
    most_steps: int | None = None,
    progress: SimulationProgress | None = None,
) -> Run:
    """Go on with the simulation in a file, to the result that it would have had without a stop.

    On the same machine and version that holds to the last bit. Of `evolve`'s arguments only `until`
    may change; a simulation that has reached it is returned as it is.

    **Raises:** `CaseError` for a file that holds no simulation or that another process is writing,
    or a time that lies before its end.
    """
    check_not_negative("save_seconds", save_seconds)
    if until is not None:
        check_positive("until", until)
    path = Path(path)
    with _alone(path):
        try:
            run = Run.load(path)
        except (OSError, ValueError) as error:
            raise CaseError(f"{str(path)!r} cannot be gone on from: {error}") from None
        if until is not None:
            if until < run.times[-1] * (1.0 - SAME_TIME):
                raise CaseError(
                    f"until = {until:g} is not allowed: {str(path)!r} has already reached"
                    f" t = {run.times[-1]:g}; allowed: >= {run.times[-1]:g}"
                )
            run = replace(run, until=float(until))
        march = March(
            run,
            train_dynamics(run.base, run.repulsion, wall_gap=run.state.wall_gap),
            _prediction(run.start, run.disturbances[0]),
            archive=_archive(path),
            save_seconds=save_seconds,
            progress=progress,
        )
        return march.go(most_steps)


def _check_steady(dynamics: Dynamics, repulsion: Repulsion) -> None:
    """Check that the repulsion leaves the steady train as it is."""
    gap = dynamics.film_forces(np.asarray(dynamics.base)).gap
    if gap < np.inf:
        raise CaseError(
            f"repulsion_range = {repulsion.range:g} is not allowed: the steady train, which knows"
            f" no repulsion, has a gap of {gap:.4g} r0; allowed: less than that, 0 for none"
        )


def _alone(path: Path | None) -> AbstractContextManager[None]:
    return nullcontext() if path is None else only_writer(path)


def _archive(path: Path | None) -> Archive | None:
    if path is None:
        return None
    remove_leftovers(path)
    return Archive(path)


def _prediction(start: Base | Stability, disturbance: np.ndarray) -> LinearPrediction:
    if isinstance(start, Stability):
        return linear_prediction(start, disturbance)
    return LinearPrediction(())
