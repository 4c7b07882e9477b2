"""The command that draws what a file holds: ``celltrain plot``."""

from functools import partial
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from celltrain.cli.arguments import Quiet, ResultFile
from celltrain.cli.compute import read_result
from celltrain.cli.keeping import Keeper
from celltrain.cli.outputs import check_folder, check_output
from celltrain.cli.progress import Reporter
from celltrain.contract.files import pictures
from celltrain.evolution import Run
from celltrain.parameters import CaseError
from celltrain.pictures.animation import film_writer
from celltrain.results import replace_file

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
    if not pictures(content):
        raise CaseError(
            f"file = {str(result)!r} is not allowed: nothing of it is drawn; allowed: of studies,"
            " those with one or two axes of numbers"
        )
    folder = result.with_name(f"{result.stem}-pictures") if output is None else output
    check_folder(folder, "output")
    with Reporter(quiet=quiet) as reporter:
        reporter.log(
            f"pictures of a result of the kind {content.kind}"
            if simulation is None
            else f"simulation until t = {simulation.reached:.6g} of {simulation.until:g} r0/U,"
            f" {len(simulation.times)} frames: {simulation.ending.message}"
        )
        keeper = Keeper(quiet=quiet, listed=True)
        keeper.result(content, None, folder)
        if simulation is not None:
            _film(simulation, animation, paraview, reporter, keeper)
    return keeper.status


def _film(
    run: Run, animation: Path | None, paraview: Path | None, reporter: Reporter, keeper: Keeper
) -> None:
    """What is made of a simulation only when it is asked for."""
    if animation is not None:
        from celltrain.pictures.run import animate_run

        film = partial(animate_run, run, progress=partial(reporter.part, "film"))
        keeper.picture(animation, lambda path: replace_file(path, film))
    if paraview is not None:
        from celltrain.evolution.record.recompute import frame_rates
        from celltrain.pictures.paraview import export_paraview

        rates = frame_rates(run, progress=partial(reporter.part, "velocities"))
        reporter.log("files for ParaView")
        keeper.file(
            paraview / "frames.pvd",
            lambda path: export_paraview(run.train, run.times, run.shapes, rates, path.parent),
        )
