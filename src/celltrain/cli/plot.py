"""The command that draws what a file holds: ``celltrain plot``."""

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from rich.console import Console

from celltrain.cli.arguments import Quiet
from celltrain.cli.compute import NOT_KEPT, read_result
from celltrain.cli.failure import CommandFailed
from celltrain.cli.outputs import check_folder, check_output
from celltrain.cli.progress import Reporter
from celltrain.contract.files import draw_each
from celltrain.evolution import Run
from celltrain.evolution.record.recompute import frame_rates
from celltrain.parameters import CaseError
from celltrain.pictures.animation import film_writer
from celltrain.pictures.paraview import export_paraview
from celltrain.pictures.run import animate_run

ResultFile = Annotated[
    Path,
    Parameter(
        help="netCDF file of a result or of a simulation, also of one that is under way (.nc)."
    ),
]
Folder = Annotated[
    Path | None,
    Parameter(
        name=("--output", "-o"),
        help="Folder for the pictures, made if it is not there; default: beside the file, named"
        " as it with -pictures. Pictures of the same names are replaced.",
    ),
]
Animation = Annotated[
    Path | None,
    Parameter(
        help="Film of a simulation, replaced if it exists: .gif, or .mp4 if ffmpeg is there."
    ),
]
Paraview = Annotated[
    Path | None,
    Parameter(
        help="Folder for a simulation's frames as files for ParaView, which opens frames.pvd;"
        " files of the same names are replaced."
    ),
]


def plot(
    result: ResultFile,
    /,
    *,
    output: Folder = None,
    animation: Animation = None,
    paraview: Paraview = None,
    quiet: Quiet = False,
) -> int:
    """Draw what a file holds: any result, a simulation, its film."""
    content = read_result(result, "file")
    simulation = content if isinstance(content, Run) else None
    for name, value in (("animation", animation), ("paraview", paraview)):
        if value is not None and simulation is None:
            raise CaseError(
                f"{name} = {str(value)!r} is not allowed: {str(result)!r} holds no simulation;"
                " allowed: a file that `celltrain evolve` wrote"
            )
    if animation is not None:
        film_writer(animation)
        check_output(animation, "animation")
    if paraview is not None:
        check_folder(paraview, "paraview")
    folder = result.with_name(f"{result.stem}-pictures") if output is None else output
    check_folder(folder, "output")
    errors, console = Console(stderr=True), Console()
    with Reporter(errors, quiet=quiet) as reporter:
        reporter.log(
            f"pictures of a result of the kind {content.kind}"
            if simulation is None
            else f"simulation until t = {simulation.state.time:.6g} of {simulation.until:g} r0/U,"
            f" {len(simulation.times)} frames: {simulation.ending.message}"
        )
        kept = True
        for path, failure in draw_each(content, folder):
            kept &= failure is None
            where = console if failure is None else errors
            words = (
                str(path) if failure is None else f"celltrain: {path} could not be drawn: {failure}"
            )
            where.print(words, highlight=False, markup=False, soft_wrap=True)
        if simulation is None:
            return 0 if kept else NOT_KEPT
        try:
            for path in _film(simulation, animation, paraview, reporter):
                console.print(str(path), highlight=False, markup=False, soft_wrap=True)
        except OSError as error:
            raise CommandFailed(f"files could not be written: {error}", NOT_KEPT) from None
    return 0 if kept else NOT_KEPT


def _film(
    run: Run, animation: Path | None, paraview: Path | None, reporter: Reporter
) -> Iterator[Path]:
    """What is made of a simulation only when it is asked for."""
    if animation is not None:
        yield animate_run(run, animation, progress=lambda *part: reporter.part("film", *part))
    if paraview is not None:
        rates = frame_rates(run, progress=lambda *part: reporter.part("velocities", *part))
        reporter.log("files for ParaView")
        yield export_paraview(run.train, run.times, run.shapes, rates, paraview)
