"""A page of docs/validation: text, tables and one figure, with what made it."""

import os
import textwrap
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path

import xarray as xr
from matplotlib.figure import Figure
from rich.console import Console

from celltrain import __version__
from celltrain.results import write_dataset

FOLDER = Path(__file__).resolve().parents[1] / "docs" / "validation"
DOTS_PER_INCH = 110


@dataclass
class Page:
    """Collects the parts of a page and writes it when it is complete."""

    name: str
    title: str
    folder: Path = FOLDER
    parts: list[str] = field(default_factory=list)
    begin: float = field(default_factory=time.perf_counter)
    console: Console = field(default_factory=lambda: Console(stderr=True))

    def text(self, text: str) -> None:
        """A paragraph, filled anew."""
        self.parts.append(textwrap.fill(" ".join(text.split()), 100, break_on_hyphens=False))

    def heading(self, text: str) -> None:
        """A heading below the title."""
        self.parts.append(f"## {text}")

    def table(self, columns: Sequence[str], rows: Sequence[Sequence[object]]) -> None:
        """A table; cells are written as they are."""
        lines = ["| " + " | ".join(columns) + " |", "|" + "---|" * len(columns)]
        lines += ["| " + " | ".join(str(cell) for cell in row) + " |" for row in rows]
        self.parts.append("\n".join(lines))

    def figure(self, figure: Figure, caption: str) -> None:
        """Save the figure beside the page and show it there."""
        self.folder.mkdir(parents=True, exist_ok=True)
        figure.savefig(self.folder / f"{self.name}.png", dpi=DOTS_PER_INCH)
        self.parts.append(f"![{caption}]({self.name}.png)\n\n*{caption}*")

    def log(self, message: str) -> None:
        """A line of progress on standard error, with the seconds so far."""
        seconds = time.perf_counter() - self.begin
        self.console.print(f"{self.name} {seconds:6.0f} s: {message}", highlight=False)

    def kept(self, path: Path, compute: Callable[["Page"], xr.Dataset]) -> xr.Dataset:
        """The data in a file; computed and written there if it is not."""
        if path.is_file():
            return xr.load_dataset(path)
        data = compute(self)
        write_dataset(data, path)
        return data

    def write(self) -> Path:
        """Write the page; returns its path."""
        minutes = (time.perf_counter() - self.begin) / 60.0
        took = f"in {minutes:.1f} minutes" if minutes >= 0.1 else "from data that were kept,"
        footer = (
            f"Made by `python validation/run.py {self.name}` on"
            f" {datetime.now(UTC).strftime('%Y-%m-%d')} with celltrain {__version__},"
            f" {took} on {len(os.sched_getaffinity(0))} cores."
        )
        self.folder.mkdir(parents=True, exist_ok=True)
        path = self.folder / f"{self.name}.md"
        path.write_text("\n\n".join([f"# {self.title}", *self.parts, footer]) + "\n")
        self.log(f"wrote {path}")
        return path


def plain_figure(width: float = 6.4, height: float = 4.0) -> Figure:
    """A figure without global state."""
    return Figure(figsize=(width, height), layout="constrained")
