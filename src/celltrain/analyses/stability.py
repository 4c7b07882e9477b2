"""The linear stability of a train of N cells."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated

from rich.console import Console
from rich.table import Table

from celltrain.analyses.base import SteadyTrain, print_base
from celltrain.contract import Draw, Progress, Setting
from celltrain.contract.analysis import OfDynamics
from celltrain.contract.tables import case_line, rate, seconds_line, titled, verdict_line
from celltrain.parameters import Train, paper_units
from celltrain.results import Plain, plain
from celltrain.stability import (
    NEAR_DOUBLE,
    Mode,
    Stability,
    check_count,
    leading_condition,
    neutral_defects,
    stability,
    with_error_bars,
)
from celltrain.stability.verdict import leading_error, verdict, wave_words
from celltrain.steady import Base

# Modes listed in the report, and in JSON.
ROWS, LEADING_MODES = 12, 24


@dataclass(frozen=True, kw_only=True)
class LinearStability(OfDynamics[Stability]):
    """Compute the steady train and its linear stability: growth rates, modes, transient growth."""

    result = Stability

    error_bars: Annotated[
        int | None,
        Setting(
            "Give this many leading growth rates an error bar, from two higher degrees and from"
            " finer rules.",
            "whole numbers >= 1",
        ),
    ] = None

    def check(self, train: Train) -> None:
        """Look at case and settings before anything is computed.

        Raises:
            CaseError: for what is not allowed.
        """
        super().check(train)
        if self.error_bars is not None:
            check_count(self.error_bars)

    def compute(self, train: Train, start: Base | None, progress: Progress) -> Stability:
        """Compute the linear dynamics, and error bars if they were asked for.

        Raises:
            NotConverged: if there is no steady train.
        """
        result = stability(
            train,
            start=start,
            accuracy=self.accuracy,
            azimuthal_numbers=self.azimuthal_numbers,
            estimate_error=self.error_bars is None,
            progress=progress.share,
            iteration=progress.iteration,
            tell=progress.log,
        )
        if self.error_bars is None:
            return result
        progress.log("error bars: higher degrees, then finer rules")
        return with_error_bars(result, count=self.error_bars)

    @classmethod
    def summary(cls, result: Stability) -> dict[str, Plain]:
        """Also the leading modes, and what neutral modes are before deflation."""
        return {
            **super().summary(result),
            "condition_number": leading_condition(result),
            "leading_modes": plain(result.modes[:LEADING_MODES]),
            "neutral_defects": plain(neutral_defects(result)),
        }

    @classmethod
    def report(cls, result: Stability, console: Console) -> None:
        """Print case, steady train, whether it is stable, and the leading modes."""
        console.print(case_line(result.base))
        print_base(result.base, console)
        console.print()
        console.print(verdict_line(verdict(result)))
        console.print(_rates(result))
        console.print(_degrees(result), style="dim", highlight=False)
        console.print(_modes_table(result))
        console.print(seconds_line(result.seconds))

    @classmethod
    def pictures(cls, result: Stability) -> Mapping[str, Draw]:
        """Those of the steady train, the spectrum, and the cells as disturbances move them."""
        from celltrain.pictures import (
            draw_error_bars,
            draw_leading_mode,
            draw_spectrum,
            draw_transient_mode,
        )

        found: dict[str, Draw] = {
            **SteadyTrain.pictures(result.base),
            "spectrum": lambda: draw_spectrum(result),
            "leading_mode": lambda: draw_leading_mode(result),
            "transient_mode": lambda: draw_transient_mode(result),
        }
        if result.error_bars:
            found["error_bars"] = lambda: draw_error_bars(result)
        return found


def _rates(result: Stability) -> Table:
    table = Table(box=None, pad_edge=False)
    table.add_column("")
    table.add_column("U/r0", justify="right")
    table.add_column("in the paper's unit", justify="right")
    for name, value in (
        ("spectral abscissa (alpha)", result.spectral_abscissa),
        ("  its error, estimated", leading_error(result)),
        ("numerical abscissa (eta)", result.numerical_abscissa),
    ):
        table.add_row(name, rate(value), rate(paper_units.rate(value)))
    return table


def _degrees(result: Stability) -> str:
    """How the growth rate changes with the degree, and whether it is close to a double one."""
    convergence = result.convergence
    lines = []
    if convergence.degrees:
        rates = ", ".join(
            f"{rate(value)} ({degree})"
            for degree, value in zip(convergence.degrees, convergence.values, strict=True)
        )
        lines.append(f"degree {result.base.train.degree}; alpha at each degree: {rates}")
    condition = leading_condition(result)
    if condition > NEAR_DOUBLE:
        lines.append(
            f"close to a double eigenvalue (condition number {condition:.0f}): errors grow as the"
            " root of those of the dynamics"
        )
    return "\n".join(lines)


def _modes_table(result: Stability) -> Table:
    """The leading modes one by one, then the neutral ones of each kind together."""
    cells = result.base.train.cells
    bars = {bar.mode: rate(bar.total) for bar in result.error_bars}
    error = ("error",) if bars else ()
    table = titled(
        "Leading modes (rates in U/r0, q = 2 pi j/N)",
        *("m", "j", "growth rate", *error, "frequency", "multiplicity"),
        left=0,
    )
    table.add_column("pattern")
    leading = [mode for mode in result.modes if not mode.neutral]
    for mode in leading[:ROWS]:
        table.add_row(
            str(mode.azimuthal_number),
            str(mode.wave_number),
            rate(mode.growth_rate),
            *([bars.get(mode, "")] if bars else []),
            rate(mode.frequency),
            str(mode.multiplicity),
            wave_words(mode.wave_number, cells),
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
            _largest(same, "growth_rate"),
            *([""] if bars else []),
            _largest(same, "frequency"),
            str(sum(mode.multiplicity for mode in same)),
            f"neutral: {kind} (before deflation {raw:.0e})",
            style="dim",
        )
    table.caption = (
        f"{min(ROWS, len(leading))} of {len(leading)} distinct modes, and the neutral ones"
    )
    return table


def _largest(modes: Sequence[Mode], name: str) -> str:
    return rate(max((float(getattr(mode, name)) for mode in modes), key=abs))


def _numbers(values: Iterable[int]) -> str:
    """The values that occur, as a range where there are several."""
    present = sorted(set(values))
    return str(present[0]) if len(present) == 1 else f"{present[0]}-{present[-1]}"
