"""Parts of reports: what is a line, a table of quantities, a table of columns."""

import math
from collections.abc import Mapping

from rich.table import Table
from rich.text import Text

from celltrain.parameters import relative_volume
from celltrain.quantities import quantity_of
from celltrain.steady import Base
from celltrain.version import __version__

# Rates (U/r0) below this are rounding errors of the eigenvalue solver.
ROUNDING = 1e-10


def case_line(base: Base, cells: str | None = None) -> Text:
    """The case in a line; `cells` in place of its number of cells."""
    train = base.train
    text = Text("celltrain ", style="bold")
    text.append(__version__, style="dim")
    number = cells or f"N = {train.cells}"
    text.append(
        f"  D = {train.tube.diameter:g} r0, packing {train.packing:g}, {number},"
        f" M = {train.degree}, viscosity ratio {train.flow.viscosity_ratio:g}"
    )
    volume = relative_volume(train.cell)
    if volume is not None:
        text.append(f", cells of {volume:.3g} times a healthy cell's volume")
    return text


def verdict_line(words: str) -> Text:
    """Whether a train is stable: green if it is, red if it is not or not known to be."""
    head, rest = words.split(":", 1)
    color = "green" if "stable" in head.split() else "red"
    return Text.assemble((head[0].upper() + head[1:], f"bold {color}"), ":" + rest)


def rate(value: float) -> str:
    """A growth rate in as many digits as matter."""
    if math.isnan(value):
        return "not known"
    if abs(value) < ROUNDING:
        return "0"
    return f"{value:.5f}" if abs(value) >= 1e-3 else f"{value:.1e}"


def titled(title: str, *columns: str, left: int = 1) -> Table:
    """A table of columns, the first `left` of them to the left."""
    table = Table(title=title, title_justify="left", title_style="bold", caption_justify="left")
    for number, column in enumerate(columns):
        table.add_column(column, justify="left" if number < left else "right")
    return table


def quantities_table(title: str, result: object, formats: Mapping[str, str]) -> Table:
    """Some quantities of a result, each in its format, with their units."""
    table = Table(
        title=title,
        title_justify="left",
        title_style="bold",
        show_header=False,
        caption_justify="left",
    )
    table.add_column("quantity")
    table.add_column("value", justify="right")
    table.add_column("unit", style="dim")
    for name, form in formats.items():
        known = quantity_of(type(result), name)
        unit = "" if known.meaning.unit == "1" else known.meaning.unit
        table.add_row(known.words, format(getattr(result, name), form), unit)
    return table


def seconds_line(seconds: Mapping[str, float]) -> Text:
    """What the stages took."""
    parts = ", ".join(f"{stage} {value:.1f}" for stage, value in seconds.items())
    return Text(f"seconds: {parts}", style="dim")
