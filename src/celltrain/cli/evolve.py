"""The command that simulates: ``celltrain evolve``.

Exit status 0: the time asked for is reached; 2: bad input, nothing written; 3: the steady train did
not converge, or the simulation could not go on (the file holds all until then); 4: the file could
not be written; 130 or 143: interrupted by Ctrl-C or SIGTERM, and saved: ``--resume`` goes on with
it.
"""

import sys
from collections.abc import Mapping
from contextlib import redirect_stdout
from pathlib import Path
from typing import Annotated, Any, cast

from cyclopts import Parameter
from rich.console import Console

from celltrain.cli.arguments import Json, Quiet
from celltrain.cli.compute import Request, print_result, read_request, read_result
from celltrain.cli.keeping import Keeper
from celltrain.cli.options import CaseOptions, given_leaves
from celltrain.cli.outputs import check_output
from celltrain.cli.progress import Reporter
from celltrain.cli.simulation_progress import SimulationReporter
from celltrain.contract import presentation
from celltrain.contract.status import ExitStatus
from celltrain.evolution import (
    Disturbance,
    FastestAtFirst,
    ForwardEuler,
    FromFile,
    Leading,
    NumberedMode,
    RandomDisplacement,
    Repulsion,
    Run,
    RungeKuttaChebyshev,
    StepFailed,
    resume,
)
from celltrain.evolution import evolve as simulate
from celltrain.evolution.checks import check_not_negative, check_positive
from celltrain.evolution.films.repulsion import RANGE, STRENGTH
from celltrain.evolution.record.archive import Archive
from celltrain.evolution.start import DEGREE
from celltrain.parameters import CaseError
from celltrain.results import only_writer
from celltrain.stability import Stability, check_linearisable, stability
from celltrain.steady import Base, NotConverged, steady

DEFAULT_AMPLITUDE = 0.1

Source = Annotated[
    Path | None,
    Parameter(
        help="TOML file of the case, or netCDF file of a result (.nc) to start from; options"
        " override the case."
    ),
]
DisturbanceName = Annotated[
    str,
    Parameter(
        help="leading, mode:NUMBER (from 1, by falling growth rate), transient, random or"
        " random:SEED (rigid displacements), or a file: of a simulation, whose last shapes are"
        " taken, or .npy with the change of the coefficients."
    ),
]
Amplitude = Annotated[
    float | None,
    Parameter(help="Size of the disturbance (Eq. 8), r0; default: 0.1, of a file as it is."),
]
Until = Annotated[
    float | None, Parameter(help="Last time, r0/U; with --resume, if not given, that of the file.")
]
Every = Annotated[float, Parameter(help="Time between frames, r0/U.")]
StepTolerance = Annotated[
    float,
    Parameter(
        help="Error of a step relative to the distance from the steady train (1 r0 at most)."
    ),
]
EulerStep = Annotated[
    float | None,
    Parameter(help="Take forward Euler steps of this size, r0/U, in place of adaptive ones."),
]
RepulsionRange = Annotated[
    float,
    Parameter(help="Thickness of films within which membranes repel each other, r0; 0: never."),
]
RepulsionStrength = Annotated[
    float, Parameter(help="Energy scale of the repulsion for each area of a film, mu U.")
]
SaveSeconds = Annotated[
    float, Parameter(help="Wall time between saves, s; 0 saves after every step.")
]
Output = Annotated[
    Path | None, Parameter(name=("--output", "-o"), help="netCDF file of the simulation.")
]
Resume = Annotated[
    bool, Parameter(help="Go on with the simulation in the output file.", negative=())
]
Overwrite = Annotated[bool, Parameter(help="Replace the output file.", negative=())]


def evolve(
    source: Source = None,
    /,
    *,
    options: CaseOptions = None,
    disturbance: DisturbanceName = "leading",
    amplitude: Amplitude = None,
    until: Until = None,
    every: Every = 1.0,
    step_tolerance: StepTolerance = 1e-3,
    euler_step: EulerStep = None,
    repulsion_range: RepulsionRange = RANGE,
    repulsion_strength: RepulsionStrength = STRENGTH,
    save_seconds: SaveSeconds = 30.0,
    output: Output = None,
    resume: Resume = False,
    overwrite: Overwrite = False,
    json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Simulate a disturbed train; its file can be read meanwhile, a killed simulation resumed."""
    errors = Console(stderr=True)
    leaves = given_leaves(options)
    place = _named(output)
    check_not_negative("save_seconds", save_seconds)
    check_positive("every", every)
    if until is not None:
        check_positive("until", until)
    # Nobody else may come between looking at the file and writing it.
    with redirect_stdout(sys.stderr), only_writer(place):
        try:
            if resume:
                run = _go_on(source, leaves, place, until, save_seconds, errors, quiet)
            else:
                _check_new(place, until, overwrite)
                integrator = (
                    RungeKuttaChebyshev(step_tolerance)
                    if euler_step is None
                    else ForwardEuler(euler_step)
                )
                repulsion = Repulsion(repulsion_range, repulsion_strength)
                wanted = parse_disturbance(disturbance, amplitude)
                start, degree = _start(source, leaves, wanted, errors, quiet)
                with SimulationReporter(errors, quiet=quiet) as reporter:
                    run = simulate(
                        start,
                        wanted,
                        until=cast(float, until),
                        degree=degree,
                        every=every,
                        integrator=integrator,
                        repulsion=repulsion,
                        path=place,
                        overwrite=overwrite,
                        save_seconds=save_seconds,
                        progress=reporter.step,
                    )
        except NotConverged as failure:
            errors.print(f"not converged: {failure}", markup=False, highlight=False)
            return ExitStatus.NOT_CONVERGED
        except StepFailed as failure:
            errors.print(f"celltrain: {failure}", markup=False, highlight=False)
            return ExitStatus.NOT_CONVERGED
    keeper = Keeper(errors, quiet=quiet)
    print_result(run, keeper, as_json=json)
    shown = presentation(run.kind)
    if run.ending.kind == "interrupted":
        raise KeyboardInterrupt(Archive(place).where(run))
    if run.ending.kind != "complete":
        errors.print(
            f"celltrain: {run.ending.message}", markup=False, highlight=False, soft_wrap=True
        )
        if run.ending.kind != "not_saved":
            where = Archive(place).where(run)
            errors.print(where, markup=False, highlight=False, soft_wrap=True)
    return shown.status(run) or keeper.status


def _named(output: Path | None) -> Path:
    """The file of a simulation, which can be written."""
    if output is None:
        raise CaseError("output is missing: name a file (-o FILE.nc)")
    check_output(output)
    return output


def _check_new(output: Path, until: float | None, overwrite: bool) -> None:
    """Refuse a new simulation that is not possible, before anything is computed."""
    if until is None:
        raise CaseError("until is missing (last time, r0/U); allowed: a number > 0")
    if output.exists() and not overwrite:
        raise CaseError(
            f"output = {str(output)!r} is not allowed: it exists; allowed: another file, or"
            " --resume, or --overwrite"
        )


def parse_disturbance(text: str, amplitude: float | None) -> Disturbance:
    """The disturbance that an option names.

    Raises:
        CaseError: if there is none of that name.
    """
    name, _, number = text.partition(":")
    size = DEFAULT_AMPLITUDE if amplitude is None else amplitude
    if text in ("leading", "transient"):
        return Leading(size) if text == "leading" else FastestAtFirst(size)
    if (name == "mode" and number.isdecimal()) or (name == "random" and number.isdecimal()):
        return (
            NumberedMode(int(number), size)
            if name == "mode"
            else RandomDisplacement(size, int(number))
        )
    if text == "random":
        return RandomDisplacement(size)
    if Path(text).suffix.lower() in (".nc", ".npy"):
        return FromFile(Path(text), amplitude)
    raise CaseError(
        f"disturbance = {text!r} is not allowed; allowed: leading, mode:NUMBER, transient, random,"
        " random:SEED, or a file (.nc, .npy)"
    )


def _go_on(
    source: Path | None,
    leaves: Mapping[str, Any],
    output: Path,
    until: float | None,
    save_seconds: float,
    errors: Console,
    quiet: bool,
) -> Run:
    if source is not None or leaves:
        raise CaseError(
            "a case is not allowed with --resume: the simulation goes on with that of its file"
        )
    if not output.is_file():
        raise CaseError(f"output = {str(output)!r} cannot be resumed: there is no such file")
    with SimulationReporter(errors, quiet=quiet) as reporter:
        return resume(output, until=until, save_seconds=save_seconds, progress=reporter.step)


def _start(
    source: Path | None,
    leaves: Mapping[str, Any],
    disturbance: Disturbance,
    errors: Console,
    quiet: bool,
) -> tuple[Base | Stability, int]:
    """What the simulation starts from, and its degree: read if it is there, computed otherwise."""
    train, base, _ = read_request(Request(case=source), leaves)
    # A file's degree is that of its own computation; simulations have theirs.
    given = train.resolution.degree if base is None else leaves.get("degree")
    degree = DEGREE if given is None else int(given)
    train = train.changed(degree=degree)
    known = None if base is None or source is None else read_result(source, "case")
    if isinstance(known, Stability) and train == known.base.train.changed(degree=degree):
        return known, degree
    linear = isinstance(disturbance, Leading | NumberedMode | FastestAtFirst)
    if linear:
        check_linearisable(train, None)
    with Reporter(errors, quiet=quiet) as reporter:
        if base is None or train != base.train:
            base = steady(train, start=base, progress=reporter.iteration)
        if not linear:
            return base, degree
        return stability(base, estimate_error=False, progress=reporter.share), degree
