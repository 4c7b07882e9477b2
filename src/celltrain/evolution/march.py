"""The loop of a simulation: steps, frames, saves, and the many ways to end."""

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace

import jax
import numpy as np
from jaxtyping import Float

from celltrain.diagnostics import frame
from celltrain.evolution.archive import Archive
from celltrain.evolution.dynamics import Dynamics, train_dynamics
from celltrain.evolution.ending import Ending
from celltrain.evolution.integrator import StepFailed
from celltrain.evolution.interpolation import interpolated
from celltrain.evolution.linear import LinearPrediction
from celltrain.evolution.run import Run
from celltrain.evolution.state import Record, State
from celltrain.evolution.wall_resolution import followed
from celltrain.proximity.overlaps import overlaps

# Overlaps are looked for after at least this time (r0/U): cells pass each other at about U.
OVERLAP_INTERVAL = 0.1
# A save may take this part of the time since the one before.
SAVING_SHARE = 0.05
# Times closer than this part of the time between frames are the same.
SAME_TIME = 1e-9


@dataclass(frozen=True)
class Status:
    """How far a simulation is: time (r0/U), eps (r0), steps, and seconds since it (re)started."""

    begin: float
    time: float
    until: float
    eps: float
    steps: int
    seconds: float


Progress = Callable[[Status], None]


class March:
    """One simulation under way.

    Steps, frames and state are committed together by one assignment, so that an interruption at any
    moment leaves a consistent whole.
    """

    def __init__(
        self,
        run: Run,
        dynamics: Dynamics,
        prediction: LinearPrediction,
        *,
        archive: Archive | None,
        save_seconds: float,
        progress: Progress | None,
    ) -> None:
        self._run, self._dynamics, self._prediction = run, dynamics, prediction
        self._archive, self._save_seconds, self._progress = archive, save_seconds, progress
        rows = zip(*run.history.values(), strict=True)
        self._steps = [dict(zip(run.history, row, strict=True)) for row in rows]
        self._frames = [
            {"time": at, "shapes": shapes, **{name: each[i] for name, each in run.frames.items()}}
            for i, (at, shapes) in enumerate(zip(run.times, run.shapes, strict=True))
        ]
        self._committed = (run.state, len(self._steps), len(self._frames))
        self._clock = time.monotonic()
        self._seconds_before = float(self._steps[-1]["wall_seconds"]) if self._steps else 0.0
        self._saved_at, self._saving = self._clock, 0.0
        self._checked = -np.inf

    def begin(self, record: Record) -> None:
        """Enter the first state of a new simulation."""
        state = self._committed[0]
        shapes = self._dynamics.continuous(state.shapes, state.laps)
        self._commit(state, record, [self._frame(0.0, shapes)])

    def go(self, most_steps: int | None) -> Run:
        """March until the end, whatever it is; the run as it is then, saved."""
        try:
            self._save()
            ending = self._go(most_steps)
        except KeyboardInterrupt:
            ending = Ending("interrupted", "interrupted by the user")
        except StepFailed as failure:
            ending = Ending(failure.kind, str(failure))
        except OSError as error:
            ending = Ending("not_saved", f"the file could not be written: {error}")
        except (jax.errors.JaxRuntimeError, RuntimeError) as error:
            ending = Ending("failed", f"the velocity could not be computed: {error}")
        run = self._as_run(ending)
        if self._archive is not None:
            try:
                self._archive.save(run)
            except OSError as error:
                message = f"the file could not be written: {error}"
                run = replace(run, ending=Ending("not_saved", message))
        return run

    def _go(self, most_steps: int | None) -> Ending:
        until, taken = self._run.until, 0
        state = self._committed[0]
        met = self._overlap(state)
        while met is None:
            if self._last_time() >= until * (1.0 - SAME_TIME):
                return Ending("complete", f"t = {until:g} r0/U reached")
            if most_steps is not None and taken >= most_steps:
                return Ending("steps", f"{taken} steps taken")
            state = self._resolved(state)
            after, record = self._run.integrator.advance(self._dynamics, state)
            met = self._overlap(after)
            shorter = None if met is None else self._run.integrator.shortened(state, after)
            if shorter is not None:
                # Fluid keeps cells apart: where they meet the step was too long for it.
                state, met = shorter, None
                continue
            frames = self._due_frames(state, after)
            if after.time > until * (1.0 + SAME_TIME):
                # Beyond the end only the frames count: going on later repeats this step as it is.
                self._commit(state, None, frames)
                continue
            self._commit(after, record, frames)
            state, taken = after, taken + 1
            if self._progress is not None:
                self._progress(self._status(state, record))
            self._save_if_due()
        return Ending("overlap", f"at t = {state.time:.6g} r0/U {met}")

    def _resolved(self, state: State) -> State:
        """The state, with the dynamics remade if the cells' distance from the wall asks for it.

        It depends on the state alone, so that going on from it later gives the same.
        """
        distance = self._dynamics.wall_distance(state.shapes)
        wall_gap = followed(state.wall_gap, distance)
        if wall_gap != self._dynamics.wall_gap:
            self._dynamics = train_dynamics(self._run.base, self._run.repulsion, wall_gap=wall_gap)
        return replace(state, wall_gap=wall_gap)

    def _last_time(self) -> float:
        return float(self._frames[self._committed[2] - 1]["time"])

    def _due_frames(self, state: State, after: State) -> list[dict[str, object]]:
        """The frames at multiples of `every`, and at the end, that lie within a step."""
        every, until = self._run.every, self._run.until
        same = SAME_TIME * every
        last, end = self._last_time(), min(after.time, until)
        number = int(np.floor(last / every + SAME_TIME)) + 1
        times = []
        while number * every <= end + same:
            times.append(number * every)
            number += 1
        if after.time >= until - same and (times[-1] if times else last) < until - same:
            times.append(until)
        before = self._dynamics.continuous(state.shapes, state.laps)
        behind = self._dynamics.continuous(after.shapes, after.laps)
        ends = (state.time, before, state.rates), (after.time, behind, after.rates)
        return [self._frame(at, interpolated(at, *ends)) for at in times]

    def _frame(
        self, at: float, shapes: Float[np.ndarray, "cell 3 coefficient"]
    ) -> dict[str, object]:
        """What is kept of shapes (continuous ones) at a time."""
        dynamics = self._dynamics
        settled = dynamics.settle(shapes)
        rates = dynamics.tube_rates(dynamics.rates(settled.shapes))
        whole = dynamics.continuous(settled.shapes, settled.laps)
        return {
            "time": at,
            "shapes": whole,
            "laps": settled.laps,
            "eps": settled.eps,
            "eps_x": settled.eps_x,
            "eps_linear": self._prediction.eps(at),
            **frame(self._run.train, whole, rates),
        }

    def _overlap(self, state: State) -> str | None:
        # Steps that could be shorter are all checked; those of one size are many, and are not.
        retries = self._run.integrator.retries
        if not retries and state.time - self._checked < OVERLAP_INTERVAL:
            return None
        self._checked = state.time
        train = self._run.train
        met = overlaps(state.shapes, period=train.length, radius=train.radius)
        return str(met[0]) if met else None

    def _commit(self, state: State, record: Record | None, frames: list[dict[str, object]]) -> None:
        _, steps, count = self._committed
        if record is not None:
            self._steps[steps:] = [self._row(record)]
            steps += 1
        self._frames[count:] = frames
        self._committed = (state, steps, count + len(frames))

    def _row(self, record: Record) -> dict[str, float]:
        first = self._steps[0]["eps"] if self._steps else record.eps
        grown = first * np.exp(self._run.growth_rate * record.time)
        return {
            **asdict(record),
            "eps_linear": self._prediction.eps(record.time),
            "eps_exponential": float(grown),
            "wall_seconds": self._seconds_before + time.monotonic() - self._clock,
        }

    def _as_run(self, ending: Ending) -> Run:
        state, count, shown = self._committed
        steps, frames = self._steps[:count], self._frames[:shown]
        columns = {name: np.array([each[name] for each in frames]) for name in frames[0]}
        return replace(
            self._run,
            history={name: np.array([row[name] for row in steps]) for name in self._run.history},
            times=columns.pop("time"),
            shapes=columns.pop("shapes"),
            frames=columns,
            state=state,
            ending=ending,
        )

    def _status(self, state: State, record: Record) -> Status:
        begin = float(self._run.state.time)
        seconds = time.monotonic() - self._clock
        return Status(begin, state.time, self._run.until, record.eps, state.steps, seconds)

    def _save_if_due(self) -> None:
        since = time.monotonic() - self._saved_at
        wait = max(self._save_seconds, self._saving / SAVING_SHARE) if self._save_seconds else 0.0
        if since >= wait:
            self._save()

    def _save(self) -> None:
        if self._archive is not None:
            begin = time.monotonic()
            self._archive.save(self._as_run(Ending("running", "not ended yet")))
            self._saved_at = time.monotonic()
            self._saving = self._saved_at - begin
