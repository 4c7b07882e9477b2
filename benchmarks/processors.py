"""One evaluation of the velocity on every kind of processor that JAX finds here, in 64-bit floats.

    python benchmarks/processors.py [--cells 8 64 512] [--runs 5] [--without-loops]

Prints for each number of cells and each platform (processors, and graphics processors if there are
any, with their names) the seconds of one evaluation, those of the first beyond that (compiling),
and how far its rates are from those of the first platform. `--without-loops` adds, on processors,
the formulas that other platforms use: their code, where there is no such platform.
Trains as in `operator_stages.py`: D = 6 r0, packing 0.2, degree 12, every cell disturbed.
"""

import argparse
import os
import sys
from collections.abc import Callable
from dataclasses import dataclass

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from measuring import measure
from rich.console import Console
from rich.table import Table

from celltrain import Train, steady
from celltrain.compiled import dispatch
from celltrain.membrane import place_cells
from celltrain.train import train_operator

LOOPS = dispatch.LOOPS_SERVE
TRAIN = Train(diameter=6, packing=0.2, cells=8, degree=12)
# Size of the disturbance (r0) that makes the shapes of the train different from each other.
DISTURBANCE = 0.01


def disturbed(cells: int) -> np.ndarray:
    """Shapes of that many cells, each disturbed in its lower harmonics."""
    train = TRAIN.changed(cells=cells)
    shapes = np.asarray(place_cells(steady(TRAIN).coefficients, train, cells))
    low = np.arange(shapes.shape[-1]) < 49
    return shapes + DISTURBANCE * np.random.default_rng(0).normal(size=shapes.shape) * low


@dataclass(frozen=True)
class Place:
    """Where an evaluation runs: a device, with what is compiled for processors or without."""

    device: jax.Device
    loops: bool = True

    @property
    def name(self) -> str:
        """Platform and kind of device."""
        if self.device.platform != "cpu":
            return f"{self.device.platform}: {self.device.device_kind}"
        return f"{os.cpu_count()} cores" + ("" if self.loops else ", without loops")

    def evaluation(self, cells: int) -> Callable[[], jax.Array]:
        """One evaluation of a train of so many cells."""
        dispatch.LOOPS_SERVE = LOOPS and self.loops
        with jax.default_device(self.device):
            operator = train_operator(TRAIN.changed(cells=cells), cells=cells)
            arrays, rest = eqx.partition(operator, eqx.is_array)
            placed = eqx.combine(jax.device_put(arrays, self.device), rest)
            shapes = jax.device_put(jnp.asarray(disturbed(cells)), self.device)
        compiled = eqx.filter_jit(lambda operator, shapes: operator.rates(shapes))
        return lambda: jax.block_until_ready(compiled(placed, shapes))


def places(*, without_loops: bool) -> list[Place]:
    """The first device of each platform; processors come first."""
    processors, usual = jax.devices("cpu")[0], jax.devices()[0]
    found = [Place(processors)]
    if without_loops:
        found.append(Place(processors, loops=False))
    return found if usual == processors else [*found, Place(usual)]


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="Seconds of one evaluation on each platform.")
    parser.add_argument("--cells", type=int, nargs="+", default=[8, 64, 512])
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--without-loops", action="store_true")
    options = parser.parse_args()
    table = Table(title="One evaluation of the velocity, degree 12, 64-bit floats")
    for name in ("cells", "on", "seconds", "first, beyond", "peak MiB of the host", "difference"):
        table.add_column(name, justify="left" if name == "on" else "right")
    for cells in options.cells:
        first: np.ndarray | None = None
        for place in places(without_loops=options.without_loops):
            evaluate = place.evaluation(cells)
            row = measure(evaluate, options.runs)
            values = np.asarray(evaluate())
            first = values if first is None else first
            table.add_row(
                str(cells),
                place.name,
                f"{row['seconds']:.4g}",
                f"{row['first_seconds']:.3g}",
                f"{row['peak_mib']:.0f}",
                f"{np.abs(values - first).max() / np.abs(first).max():.1e}",
            )
            print(f"{cells} cells on {place.name}: {row['seconds']:.4g} s", file=sys.stderr)
    Console().print(table)


if __name__ == "__main__":
    main()
