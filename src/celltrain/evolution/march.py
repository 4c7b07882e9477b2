"""The loop of a simulation: steps, frames, saves, and the many ways to end."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import jax
import numpy as np

from celltrain.evolution.dynamics import Dynamics, train_dynamics
from celltrain.evolution.ending import Ending, StepFailed
from celltrain.evolution.linear import LinearPrediction
from celltrain.evolution.methods import Integrator, Memory, Step, Work
from celltrain.evolution.record.archive import Archive
from celltrain.evolution.record.frames import SAME_TIME, due_times, frame_row, shapes_within
from celltrain.evolution.record.history import Row, columns, rows, step_row
from celltrain.evolution.record.run import Run
from celltrain.evolution.state import State
from celltrain.evolution.wall_resolution import followed
from celltrain.interruption import kept_by, take

# Overlaps are looked for after at least this time (r0/U): cells pass each other at about U.
OVERLAP_INTERVAL = 0.1
# A save may take this part of the time since the one before.
SAVING_SHARE = 0.05


INTERRUPTED = Ending("interrupted", "interrupted by the user")


@dataclass(frozen=True)
class Status:
    """How far a simulation is: time (r0/U), eps (r0), steps, and seconds since it (re)started."""

    begin: float
    time: float
    until: float
    eps: float
    steps: int
    seconds: float


SimulationProgress = Callable[[Status], None]


@dataclass(frozen=True)
class _Committed:
    """All that is certain: where to go on from, and how many steps and frames there are."""

    state: State
    memory: Memory
    work: Work
    steps: int
    frames: int


def _not_saved(error: OSError) -> Ending:
    return Ending("not_saved", f"the file could not be written: {error.strerror or error}")


class March:
    """One simulation under way.

    Steps, frames, state and memory are committed together by one assignment, so that an
    interruption at any moment leaves a consistent whole.
    """

    def __init__(
        self,
        run: Run,
        dynamics: Dynamics,
        prediction: LinearPrediction,
        *,
        archive: Archive | None,
        save_seconds: float,
        progress: SimulationProgress | None,
    ) -> None:
        self._run, self._dynamics, self._prediction = run, dynamics, prediction
        self._archive, self._save_seconds, self._progress = archive, save_seconds, progress
        self._steps = rows(run.history)
        self._frames = rows({"time": run.times, "shapes": run.shapes, **run.frames})
        self._committed = _Committed(
            run.state, run.memory, run.work, len(self._steps), len(self._frames)
        )
        self._clock = time.monotonic()
        self._seconds_before = float(self._steps[-1]["wall_seconds"]) if self._steps else 0.0
        self._saved_at, self._saving = self._clock, 0.0
        self._checked = -np.inf

    def begin(self, first: Step[Memory]) -> None:
        """Enter the beginning of a new simulation, a step that led from nowhere."""
        self._commit(first, Work(), [self._frame(first.state)])

    def go(self, most_steps: int | None) -> Run:
        """March until the end, whatever it is; the run as it is then, saved."""
        with kept_by(self._keep):
            try:
                return self._saved(self._ending(most_steps))
            except KeyboardInterrupt:
                take()
                return self._saved(INTERRUPTED)

    def _ending(self, most_steps: int | None) -> Ending:
        try:
            self._save()
            return self._go(most_steps)
        except StepFailed as failure:
            return Ending(failure.kind, str(failure))
        except OSError as error:
            return _not_saved(error)
        except (jax.errors.JaxRuntimeError, RuntimeError) as error:
            return Ending("failed", f"the velocity could not be computed: {error}")

    def _saved(self, ending: Ending) -> Run:
        run = self._as_run(ending)
        if self._archive is not None:
            try:
                self._archive.save(run)
            except OSError as error:
                run = replace(run, ending=_not_saved(error))
        return run

    def _keep(self) -> str:
        """Save what is committed, in another thread than that which marches; where, in words."""
        if self._archive is None:
            return ""
        run = self._as_run(INTERRUPTED)
        self._archive.save(run)
        return self._archive.where(run)

    def _go(self, most_steps: int | None) -> Ending:
        until, taken = self._run.until, 0
        method: Integrator[Any] = self._run.integrator
        state, memory, wasted = self._committed.state, self._committed.memory, Work()
        met = self._overlap(state)
        while met is None:
            if self._last_time() >= until * (1.0 - SAME_TIME):
                return Ending("complete", f"t = {until:g} r0/U reached")
            if most_steps is not None and taken >= most_steps:
                return Ending("steps", f"{taken} steps taken")
            self._resolve(state)
            step = method.advance(self._dynamics, state, memory)
            met = self._overlap(step.state)
            shorter = None if met is None else method.shortened(memory, step.manner.size)
            if shorter is not None:
                # Fluid keeps cells apart: where they meet the step was too long for it.
                wasted += step.work + Work(rejected=1)
                memory, met = shorter, None
                continue
            frames = self._due_frames(state, step)
            if step.state.time > until * (1.0 + SAME_TIME):
                # Beyond the end only the frames count: going on later repeats this step as it is.
                self._commit(None, wasted, frames)
                continue
            self._commit(step, wasted, frames)
            state, memory, wasted, taken = step.state, step.memory, Work(), taken + 1
            if self._progress is not None:
                self._progress(self._status(state))
            self._save_if_due()
        return Ending("overlap", f"at t = {state.time:.6g} r0/U {met}")

    def _resolve(self, state: State) -> None:
        """Make the dynamics anew if the cells' distance from the wall asks for it.

        It depends on the state alone, so that going on from it later gives the same.
        """
        distance = self._dynamics.wall_distance(state.shapes)
        wall_gap = followed(state.wall_gap, distance)
        if wall_gap != self._dynamics.wall_gap:
            self._dynamics = train_dynamics(
                self._run.base,
                self._run.repulsion,
                wall_gap=wall_gap,
                known=self._dynamics,
            )

    def _last_time(self) -> float:
        return float(self._frames[self._committed.frames - 1]["time"])

    def _due_frames(self, state: State, step: Step[Memory]) -> list[Row]:
        """The frames at multiples of `every`, and at the end, that lie within a step."""
        every, until, dynamics = self._run.every, self._run.until, self._dynamics
        times = due_times(self._last_time(), step.state.time, every=every, until=until)
        return [
            self._frame(dynamics.state(at, shapes_within(dynamics, state, step, at)))
            for at in times
        ]

    def _frame(self, state: State) -> Row:
        return frame_row(self._run.train, self._dynamics, self._prediction, state)

    def _overlap(self, state: State) -> str | None:
        # Steps that could be shorter are all checked; those of one size are many, and are not.
        retries = self._run.integrator.retries
        if not retries and state.time - self._checked < OVERLAP_INTERVAL:
            return None
        self._checked = state.time
        met = self._dynamics.overlaps(state.shapes)
        return str(met[0]) if met else None

    def _commit(self, step: Step[Memory] | None, wasted: Work, frames: list[Row]) -> None:
        """Enter frames, and a step unless it is None, with the work of its failed attempts."""
        known = self._committed
        self._frames[known.frames :] = frames
        if step is not None:
            work = known.work + wasted + step.work
            self._steps[known.steps :] = [self._row(step, work)]
            known = _Committed(step.state, step.memory, work, known.steps + 1, known.frames)
        self._committed = replace(known, frames=known.frames + len(frames))

    def _row(self, step: Step[Memory], work: Work) -> Row:
        state = step.state
        first = self._steps[0]["eps"] if self._steps else state.measures.eps
        return step_row(
            step,
            work,
            eps_linear=self._prediction.eps(state.time),
            eps_exponential=float(first * np.exp(self._run.growth_rate * state.time)),
            wall_seconds=self._seconds_before + time.monotonic() - self._clock,
        )

    def _as_run(self, ending: Ending) -> Run:
        known = self._committed
        frames = self._frames[: known.frames]
        kept = columns(list(frames[0]), frames)
        return replace(
            self._run,
            history=columns(list(self._run.history), self._steps[: known.steps]),
            times=kept.pop("time"),
            shapes=kept.pop("shapes"),
            frames=kept,
            state=known.state,
            memory=known.memory,
            ending=ending,
        )

    def _status(self, state: State) -> Status:
        seconds = time.monotonic() - self._clock
        return Status(
            begin=float(self._run.state.time),
            time=state.time,
            until=self._run.until,
            eps=state.measures.eps,
            steps=self._committed.steps - 1,
            seconds=seconds,
        )

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
