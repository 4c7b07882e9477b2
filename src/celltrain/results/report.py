"""The report that people read in the terminal."""

import math
from collections.abc import Iterable

from rich.console import Console
from rich.table import Table
from rich.text import Text

from celltrain.parameters import Train, paper_units
from celltrain.parameters.resolution import LARGEST_DEGREE
from celltrain.results.version import version
from celltrain.stability import (
    NEAR_DOUBLE,
    Mode,
    Stability,
    leading_condition,
    neutral_defects,
)
from celltrain.steady import Base

#: A growth rate up to this (U/r0), or up to the resolution's own error, counts as none.
MARGINAL_GROWTH = 1e-4
# Modes listed.
ROWS = 12
# Rates (U/r0) below this are rounding errors of the eigenvalue solver.
ROUNDING = 1e-10


def print_report(result: Base | Stability, console: Console | None = None) -> None:
    """Print case, steady train and, if there, its stability, in r0, U and mu."""
    console = console or Console()
    base = result.base if isinstance(result, Stability) else result
    console.print(_case(base.train))
    console.print(_base_table(base))
    if isinstance(result, Stability):
        console.print()
        console.print(_verdict_line(result))
        console.print(_rates(result))
        console.print(_degrees(result), style="dim", highlight=False)
        console.print(_modes_table(result))
    console.print(_seconds(result.seconds), style="dim")


def is_marginal(result: Stability) -> bool:
    """Whether no mode but the neutral ones grows faster than 1e-4 U/r0."""
    return result.spectral_abscissa <= MARGINAL_GROWTH


def verdict(result: Stability) -> str:
    """Whether the train is stable, in a sentence; distances are those that the train travels."""
    alpha = result.spectral_abscissa
    error = leading_error(result)
    if is_marginal(result):
        known = "not estimated" if math.isnan(error) else f"{error:.1e} U/r0"
        return (
            f"marginally stable: nothing grows but the neutral modes (largest growth rate"
            f" {alpha:.1e} U/r0, the resolution's own error {known}){_sign(result)}"
        )
    if error >= alpha:
        return (
            f"not resolved: the largest growth rate {alpha:.1e} U/r0 is below its own error"
            f" {error:.1e} U/r0; {_remedy(result)}"
        )
    mode = result.leading
    distance = result.base.cell_velocity / alpha
    return (
        f"unstable: the fastest disturbance grows e-fold over {distance:.3g} r0 of travel;"
        f" it {_motion(mode, result.base.train.cells)} (m = {mode.azimuthal_number},"
        f" {_wave_number(mode, result.base.train.cells)})"
    )


def _remedy(result: Stability) -> str:
    if result.base.train.degree == LARGEST_DEGREE:
        return "no higher degree is offered"
    return "a higher degree, or none, so that it rises by itself, is needed"


def leading_error(result: Stability) -> float:
    """The error of the leading growth rate: its bar if there is one, the estimate otherwise."""
    bars = {bar.mode: bar.total for bar in result.error_bars}
    return bars.get(result.leading, result.error_estimate)


def _sign(result: Stability) -> str:
    """What error bars say about the sign of a growth rate close to zero."""
    if result.growth_sign is None:
        return ""
    known = {1: "it is positive", -1: "it is negative", 0: "error bars leave its sign open"}
    return f"; {known[result.growth_sign]}"


def _motion(mode: Mode, cells: int) -> str:
    """What a mode does, told from its azimuthal and wave numbers."""
    deeds = {0: "deforms {} axisymmetrically", 1: "tilts {}"}
    deed = deeds.get(mode.azimuthal_number, f"deforms {{}} {mode.azimuthal_number}-fold around")
    if cells == 1:
        return deed.format("the cell")
    if mode.wave_number == 0:
        return deed.format("all cells alike")
    if 2 * mode.wave_number == cells:
        return deed.format("neighbours oppositely")
    return deed.format(f"cells in a wave of {cells / mode.wave_number:.3g}")


def _wave_number(mode: Mode, cells: int) -> str:
    if mode.wave_number == 0:
        return "q = 0"
    if 2 * mode.wave_number == cells:
        return "q = pi"
    return f"q = 2 pi {mode.wave_number}/{cells}"


def _case(train: Train) -> Text:
    text = Text("celltrain ", style="bold")
    text.append(version(), style="dim")
    text.append(
        f"  D = {train.tube.diameter:g} r0, packing {train.packing:g}, N = {train.cells},"
        f" M = {train.degree}, viscosity ratio {train.flow.viscosity_ratio:g}"
    )
    return text


def _base_table(base: Base) -> Table:
    table = Table(title="Steady train", title_justify="left", title_style="bold", show_header=False)
    table.add_column("quantity")
    table.add_column("value", justify="right")
    table.add_column("unit", style="dim")
    table.add_row("cell velocity", f"{base.cell_velocity:.5f}", "U")
    table.add_row("gap between cells", f"{base.gap:.4f}", "r0")
    table.add_row("largest radius", f"{base.largest_radius:.4f}", "r0")
    table.add_row("effective viscosity", f"{base.effective_viscosity:.5f}", "mu")
    table.add_row("residual", f"{base.residual:.1e}", "U")
    table.add_row("left out by the degree", f"{base.truncation_error:.1e}", "U")
    table.add_row("error of the velocity", f"{base.velocity_error:.1e}", "relative")
    table.caption = base.origin
    table.caption_justify = "left"
    return table


def _verdict_line(result: Stability) -> Text:
    words = verdict(result)
    head, rest = words.split(":", 1)
    color = "green" if is_marginal(result) else "red"
    return Text.assemble((head[0].upper() + head[1:], f"bold {color}"), ":" + rest)


def _rates(result: Stability) -> Table:
    table = Table(box=None, pad_edge=False)
    table.add_column("")
    table.add_column("U/r0", justify="right")
    table.add_column("in the paper's unit", justify="right")
    for name, rate in (
        ("spectral abscissa (alpha)", result.spectral_abscissa),
        ("  its error, estimated", leading_error(result)),
        ("numerical abscissa (eta)", result.numerical_abscissa),
    ):
        table.add_row(name, _rate(rate), _rate(paper_units.rate(rate)))
    return table


def _degrees(result: Stability) -> str:
    """How the growth rate changes with the degree, and whether it is close to a double one."""
    convergence = result.convergence
    lines = []
    if convergence.degrees:
        rates = ", ".join(
            f"{_rate(rate)} ({degree})"
            for degree, rate in zip(convergence.degrees, convergence.values, strict=True)
        )
        lines.append(f"degree {result.base.train.degree}; alpha at each degree: {rates}")
    condition = leading_condition(result)
    if condition > NEAR_DOUBLE:
        lines.append(
            f"close to a double eigenvalue (condition number {condition:.0f}): errors grow as the"
            " root of those of the dynamics"
        )
    return "\n".join(lines)


def _rate(rate: float) -> str:
    if math.isnan(rate):
        return "not known"
    if abs(rate) < ROUNDING:
        return "0"
    return f"{rate:.5f}" if abs(rate) >= 1e-3 else f"{rate:.1e}"


def _modes_table(result: Stability) -> Table:
    """The leading modes one by one, then the neutral ones of each kind together."""
    cells = result.base.train.cells
    table = Table(
        title="Leading modes (rates in U/r0, q = 2 pi j/N)",
        title_justify="left",
        title_style="bold",
    )
    bars = {bar.mode: _rate(bar.total) for bar in result.error_bars}
    error = ("error",) if bars else ()
    for column in ("m", "j", "growth rate", *error, "frequency", "multiplicity"):
        table.add_column(column, justify="right")
    table.add_column("pattern")
    leading = [mode for mode in result.modes if not mode.neutral]
    for mode in leading[:ROWS]:
        if mode.wave_number == 0:
            pattern = "all cells alike"
        elif 2 * mode.wave_number == cells:
            pattern = "neighbours oppositely"
        else:
            pattern = f"{cells / mode.wave_number:.3g} cells a wave"
        table.add_row(
            str(mode.azimuthal_number),
            str(mode.wave_number),
            _rate(mode.growth_rate),
            *([bars.get(mode, "")] if bars else []),
            _rate(mode.frequency),
            str(mode.multiplicity),
            pattern,
        )
    table.add_section()
    neutral = [mode for mode in result.modes if mode.neutral]
    defects = neutral_defects(result)
    for kind in dict.fromkeys(mode.neutral_kind for mode in neutral):
        same = [mode for mode in neutral if mode.neutral_kind == kind]
        raw = max(abs(defect.raw) for defect in defects if defect.kind == kind)
        table.add_row(
            _numbers(mode.azimuthal_number for mode in same),
            _numbers(mode.wave_number for mode in same),
            _rate(max((mode.growth_rate for mode in same), key=abs)),
            *([""] if bars else []),
            _rate(max((mode.frequency for mode in same), key=abs)),
            str(sum(mode.multiplicity for mode in same)),
            f"neutral: {kind} (before deflation {raw:.0e})",
            style="dim",
        )
    table.caption = (
        f"{min(ROWS, len(leading))} of {len(leading)} distinct modes, and the neutral ones"
    )
    table.caption_justify = "left"
    return table


def _numbers(values: Iterable[int]) -> str:
    """The values that occur, as a range where there are several."""
    present = sorted(set(values))
    return str(present[0]) if len(present) == 1 else f"{present[0]}-{present[-1]}"


def _seconds(seconds: dict[str, float]) -> str:
    return "seconds: " + ", ".join(f"{stage} {value:.1f}" for stage, value in seconds.items())
