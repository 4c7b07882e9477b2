"""The command that draws what a file holds: ``celltrain plot``."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from rich.console import Console

from celltrain.cli.arguments import Quiet
from celltrain.cli.outputs import check_folder, check_output
from celltrain.cli.progress import Reporter
from celltrain.evolution import Run
from celltrain.evolution.record.recompute import frame_rates
from celltrain.parameters import CaseError
from celltrain.pictures import plot_all
from celltrain.pictures.animation import film_writer
from celltrain.pictures.paraview import export_paraview
from celltrain.pictures.run import animate_run, plot_run
from celltrain.results import load
from celltrain.stability import Stability
from celltrain.steady import Base

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
    """Draw a result or a simulation: growth beside theory, the cells at chosen times, a film."""
    content = read_result(result)
    if not isinstance(content, Run):
        for name, value in (("animation", animation), ("paraview", paraview)):
            if value is not None:
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
    console = Console()
    with Reporter(Console(stderr=True), quiet=quiet) as reporter:
        try:
            for path in _draw(content, folder, animation, paraview, reporter):
                console.print(str(path), highlight=False, markup=False, soft_wrap=True)
        except OSError as error:
            raise CaseError(f"pictures could not be written: {error}") from None
    return 0


def read_result(path: Path) -> Base | Stability | Run:
    """What a file holds.

    Raises:
        CaseError: if there is no such file, or it holds no result.
    """
    if not path.is_file():
        raise CaseError(f"{str(path)!r} cannot be drawn: there is no such file")
    try:
        found = load(path)
    except (OSError, ValueError) as error:
        raise CaseError(f"{str(path)!r} is no result of celltrain: {error}") from None
    try:
        return Run.load(path)
    except ValueError:
        return found
    except OSError as error:
        raise CaseError(f"the simulation in {str(path)!r} cannot be read: {error}") from None


def _draw(
    content: Base | Stability | Run,
    folder: Path,
    animation: Path | None,
    paraview: Path | None,
    reporter: Reporter,
) -> list[Path]:
    if not isinstance(content, Run):
        reporter.log("pictures")
        return plot_all(content, folder)
    reporter.log(
        f"simulation until t = {content.state.time:.6g} of {content.until:g} r0/U,"
        f" {len(content.times)} frames: {content.ending.message}"
    )
    paths = plot_run(content, folder)
    if animation is not None:
        paths.append(
            animate_run(content, animation, progress=lambda *part: reporter.part("film", *part))
        )
    if paraview is not None:
        rates = frame_rates(content, progress=lambda *part: reporter.part("velocities", *part))
        reporter.log("files for ParaView")
        paths.append(export_paraview(content.train, content.times, content.shapes, rates, paraview))
    return paths
