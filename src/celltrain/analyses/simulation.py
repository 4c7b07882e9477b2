"""A disturbed train in time: its simulation, how it is shown, and what is drawn of it."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
from rich.console import Console

from celltrain.contract import Draw, Progress, Setting
from celltrain.contract.analysis import WrittenMeanwhile
from celltrain.contract.status import ComputationFailed, ExitStatus
from celltrain.contract.tables import case_line, quantities_table
from celltrain.evolution import (
    Automatic,
    Disturbance,
    FastestAtFirst,
    ForwardEuler,
    FromFile,
    Leading,
    NumberedMode,
    RandomDisplacement,
    Repulsion,
    Run,
    StepFailed,
)
from celltrain.evolution.checks import check_not_negative, check_positive
from celltrain.evolution.films.repulsion import RANGE, STRENGTH
from celltrain.evolution.record.archive import SAVE_SECONDS, Archive
from celltrain.evolution.record.repulsion import repulsion_record
from celltrain.evolution.start import DEGREE
from celltrain.extras import check_installed
from celltrain.parameters import CaseError, Train
from celltrain.parameters.errors import called
from celltrain.results import Plain, plain
from celltrain.stability import Stability, check_linearisable, stability
from celltrain.steady import Base, steady
from celltrain.version import __version__

DEFAULT_AMPLITUDE = 0.1
# Nothing else can be told until the first step is done.
_BEGINS = "simulation: getting ready; the first one on a machine compiles, for half a minute"
POSITIVE, NOT_NEGATIVE = "numbers > 0", "numbers >= 0"
_STATUS = {
    **dict.fromkeys(("complete", "steps", "running"), ExitStatus.DONE),
    "interrupted": ExitStatus.INTERRUPTED,
    "not_saved": ExitStatus.NOT_KEPT,
}


@dataclass(frozen=True, kw_only=True)
class Simulation(WrittenMeanwhile[Run]):
    """Simulate a disturbed train; its file can be read meanwhile, a killed simulation resumed.

    The file holds a `history` with an entry for each step, and the frames: `times`, `shapes`, and
    what was measured of them, in r0, U and mu, in the frame of the steady train; velocities are
    relative to the tube.
    """

    result = Run
    command = "evolve"

    disturbance: Annotated[
        str,
        Setting(
            "leading, mode:NUMBER (from 1, by falling growth rate), transient, random or"
            " random:SEED (rigid displacements), or a file: of a simulation, whose last shapes are"
            " taken, or .npy with the change of the coefficients."
        ),
    ] = "leading"
    amplitude: Annotated[
        float | None,
        Setting("Size of the disturbance (Eq. 8), r0; default: 0.1, of a file as it is.", POSITIVE),
    ] = None
    until: Annotated[
        float | None,
        Setting("Last time, r0/U; with --resume, if not given, that of the file.", POSITIVE),
    ] = None
    every: Annotated[float, Setting("Time between frames, r0/U.", POSITIVE)] = 1.0
    step_tolerance: Annotated[
        float,
        Setting(
            "Error of a step relative to the distance from the steady train (1 r0 at most).",
            POSITIVE,
        ),
    ] = Automatic().tolerance
    euler_step: Annotated[
        float | None,
        Setting(
            "Take forward Euler steps of this size, r0/U, in place of adaptive ones.", POSITIVE
        ),
    ] = None
    repulsion_range: Annotated[
        float,
        Setting(
            "Thickness of films within which membranes repel each other, r0; 0: never.",
            NOT_NEGATIVE,
        ),
    ] = RANGE
    repulsion_strength: Annotated[
        float,
        Setting("Energy scale of the repulsion for each area of a film, mu U.", NOT_NEGATIVE),
    ] = STRENGTH
    save_seconds: Annotated[
        float, Setting("Wall time between saves, s; 0 saves after every step.", NOT_NEGATIVE)
    ] = SAVE_SECONDS

    def __post_init__(self) -> None:
        if self.until is not None:
            check_positive("until", self.until)
        check_positive("every", self.every)
        check_not_negative("save_seconds", self.save_seconds)

    def check(self, train: Train) -> None:
        """Look at case and settings before anything is computed.

        Raises:
            CaseError: for what is not allowed.
        """
        check_installed("simulations")
        if self.until is None:
            raise CaseError("until is missing (last time, r0/U); allowed: a number > 0")
        if _is_linear(self._disturbance()):
            check_linearisable(_at_own_degree(train), None)
        self._method()
        self._repulsion()

    def compute_into(
        self, train: Train, start: Base | Stability | None, progress: Progress, path: Path | None
    ) -> Run:
        """Simulate, from what is known of the train or computed first.

        Raises:
            CaseError: for what turns out not to be allowed.
            ComputationFailed: if the disturbed train has no velocity.
            NotConverged: if there is no steady train.
        """
        from celltrain.compiled.ahead import compile_ahead  # JAX

        assert self.until is not None
        disturbance = self._disturbance()
        train = _at_own_degree(train)
        compile_ahead(train.flow.viscosity_ratio)
        dynamic = _is_linear(disturbance) or _is_known(start, train)
        known = (_linear_dynamics if dynamic else _steady)(train, start, progress)
        progress.log(_BEGINS)
        # Only now: it takes a second to load, and loops were compiled meanwhile.
        from celltrain.evolution import evolve

        try:
            return evolve(
                known,
                disturbance,
                until=self.until,
                degree=train.degree,
                every=self.every,
                integrator=self._method(),
                repulsion=self._repulsion(),
                path=path,
                overwrite=self.overwrite,
                save_seconds=self.save_seconds,
                progress=progress.step,
            )
        except StepFailed as failure:
            raise ComputationFailed(str(failure)) from None

    def go_on(self, path: Path, progress: Progress) -> Run:
        """Go on with the simulation in a file.

        Raises:
            CaseError: for what is not allowed.
        """
        from celltrain.evolution import resume  # JAX

        progress.log(_BEGINS)
        return resume(
            path, until=self.until, save_seconds=self.save_seconds, progress=progress.step
        )

    def _disturbance(self) -> Disturbance:
        return parse_disturbance(self.disturbance, self.amplitude)

    def _method(self) -> Automatic | ForwardEuler:
        with called(tolerance="step_tolerance", step="euler_step"):
            if self.euler_step is None:
                return Automatic(self.step_tolerance)
            return ForwardEuler(self.euler_step)

    def _repulsion(self) -> Repulsion:
        return Repulsion(self.repulsion_range, self.repulsion_strength)

    @classmethod
    def summary(cls, result: Run) -> dict[str, Plain]:
        """How it went, in r0, U and mu."""
        history = {name: column[[0, -1]].astype(float) for name, column in result.history.items()}
        method = plain(result.integrator)
        assert isinstance(method, dict)
        content = {
            "version": __version__,
            "kind": result.kind,
            "case": result.train,
            "disturbance": result.disturbance,
            "integrator": {"name": type(result.integrator).__name__, **method},
            "repulsion": {**vars(result.repulsion), **repulsion_record(result)},
            "ending": result.ending,
            "time": result.reached,
            "until": result.until,
            "frames": len(result.times),
            "steps": result.steps,
            "rejected": result.work.rejected,
            "evaluations": result.work.evaluations,
            "wall_seconds": history["wall_seconds"][-1],
            "growth_rate": result.growth_rate,
            "eps": [history["eps"][0], result.frames["eps"][-1]],
            "eps_x": [history["eps_x"][0], result.frames["eps_x"][-1]],
            "largest_volume_correction": _correction(result),
        }
        found = plain(content)
        assert isinstance(found, dict)
        return found

    @classmethod
    def report(cls, result: Run, console: Console) -> None:
        """Print how the simulation went."""
        frames, wall = result.frames, float(result.history["wall_seconds"][-1])
        speed = 3600.0 * result.reached / wall if wall > 0.0 else math.nan
        console.print(case_line(result.base))
        table = quantities_table("Simulation", result, {})
        for name, value, unit in (
            ("time reached", f"{result.reached:.6g} of {result.until:.6g}", "r0/U"),
            ("steps (rejected)", f"{result.steps} ({result.work.rejected})", ""),
            ("evaluations of the velocity", f"{result.work.evaluations}", ""),
            ("eps, first and last", _pair(frames["eps"]), "r0"),
            ("eps by the linear dynamics", _pair(frames["eps_linear"]), "r0"),
            ("eps_x, first and last", _pair(frames["eps_x"]), "r0"),
            ("least distance between cells", f"{frames['cell_distance'].min():.4f}", "r0"),
            ("least distance from the wall", f"{frames['wall_distance'].min():.4f}", "r0"),
            ("largest correction of the volume", f"{_correction(result):.1e}", "r0"),
            *_repulsion_rows(result),
            ("speed", f"{speed:.3g}", "r0/U per hour"),
        ):
            table.add_row(name, value, unit)
        table.caption = f"disturbance: {result.disturbance}; {result.ending.message}"
        console.print(table)

    @classmethod
    def pictures(cls, result: Run) -> Mapping[str, Draw]:
        """Those for which the simulation is long enough."""
        from celltrain.pictures.run import run_pictures

        return run_pictures(result)

    @classmethod
    def status(cls, result: Run) -> int:
        """0 where the time asked for is reached, 3 where it could not go on."""
        return _STATUS.get(result.ending.kind, ExitStatus.NOT_CONVERGED)

    @classmethod
    def remark(cls, result: Run, path: Path | None) -> str:
        """Why it has ended before its time, and where it is."""
        kind = result.ending.kind
        where = "" if path is None else Archive(path).where(result)
        if kind in ("complete", "interrupted"):
            return where if kind == "interrupted" else ""
        words = f"celltrain: {result.ending.message}"
        return words if kind == "not_saved" else f"{words}\n{where}".rstrip()


def parse_disturbance(text: str, amplitude: float | None) -> Disturbance:
    """The disturbance that an option names.

    Raises:
        CaseError: if there is none of that name.
    """
    name, _, number = text.partition(":")
    size = DEFAULT_AMPLITUDE if amplitude is None else amplitude
    if text in ("leading", "transient"):
        return Leading(size) if text == "leading" else FastestAtFirst(size)
    if name == "mode" and number.isdecimal():
        return NumberedMode(int(number), size)
    if name == "random" and number.isdecimal():
        return RandomDisplacement(size, int(number))
    if text == "random":
        return RandomDisplacement(size)
    if Path(text).suffix.lower() in (".nc", ".npy"):
        return FromFile(Path(text), amplitude)
    raise CaseError(
        f"disturbance = {text!r} is not allowed; allowed: leading, mode:NUMBER, transient, random,"
        " random:SEED, or a file (.nc, .npy)"
    )


def _is_linear(disturbance: Disturbance) -> bool:
    """Whether a disturbance is made from the linear dynamics."""
    return isinstance(disturbance, Leading | NumberedMode | FastestAtFirst)


def _at_own_degree(train: Train) -> Train:
    """The case at the degree of simulations, unless it gives one."""
    given = train.resolution.degree
    return train.changed(degree=DEGREE if given is None else given)


def _is_known(start: Base | Stability | None, train: Train) -> bool:
    """Whether a file holds the linear dynamics of a case, at whatever degree."""
    if not isinstance(start, Stability):
        return False
    return start.base.train.changed(degree=train.degree) == train


def _linear_dynamics(train: Train, start: Base | Stability | None, progress: Progress) -> Stability:
    if isinstance(start, Stability) and _is_known(start, train):
        return start
    base = _steady(train, start, progress)
    return stability(base, estimate_error=False, progress=progress.share)


def _steady(train: Train, start: Base | Stability | None, progress: Progress) -> Base:
    base = start.base if isinstance(start, Stability) else start
    if base is not None and base.train == train:
        return base
    return steady(train, start=base, progress=progress.iteration)


def _correction(run: Run) -> float:
    return float(run.history["volume_correction"][1:].max(initial=0.0))


def _repulsion_rows(run: Run) -> list[tuple[str, str, str]]:
    if run.repulsion.range == 0.0:
        return [("repulsion of membranes", "none", "")]
    record = repulsion_record(run)
    if math.isnan(record["since"]):
        return [("repulsion of membranes", f"never within {run.repulsion.range:g}", "r0")]
    return [
        ("repulsion of membranes, acting for", f"{record['duration']:.4g}", "r0/U"),
        ("thinnest film", f"{record['smallest_gap']:.4f}", "r0"),
        ("largest force of films on a cell", f"{record['largest_force']:.3g}", "mu U r0"),
    ]


def _pair(values: np.ndarray) -> str:
    first, last = float(values[0]), float(values[-1])
    return "not known" if math.isnan(last) else f"{first:.4g}  {last:.4g}"
