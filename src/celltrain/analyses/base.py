"""The steady train alone."""

from collections.abc import Mapping
from dataclasses import dataclass

from rich.console import Console

from celltrain.contract import Analysis, Draw, Progress
from celltrain.contract.tables import case_line, quantities_table, seconds_line
from celltrain.parameters import Train
from celltrain.steady import Base, steady

#: What reports say of a steady train, and how.
FORMATS = {
    "cell_velocity": ".5f",
    "gap": ".4f",
    "largest_radius": ".4f",
    "effective_viscosity": ".5f",
    "residual": ".1e",
    "truncation_error": ".1e",
    "velocity_error": ".1e",
    "form": "",
}


@dataclass(frozen=True, kw_only=True)
class SteadyTrain(Analysis[Base]):
    """Compute the steady train alone.

    Without --degree, the degree rises until the cells' velocity is known to 1e-4 U.
    """

    result = Base

    def compute(self, train: Train, start: Base | None, progress: Progress) -> Base:
        """Compute the steady train.

        Raises:
            NotConverged: if there is none.
        """
        return steady(train, start=start, progress=progress.iteration)

    @classmethod
    def steady_train(cls, result: Base) -> Base:
        """The result itself."""
        return result

    @classmethod
    def report(cls, result: Base, console: Console) -> None:
        """Print the case and the steady train."""
        console.print(case_line(result))
        print_base(result, console)
        console.print(seconds_line(result.seconds))

    @classmethod
    def pictures(cls, result: Base) -> Mapping[str, Draw]:
        """The train in its tube, and one cell's meridian."""
        from celltrain.pictures import draw_base_train, draw_profile

        return {
            "base_train": lambda: draw_base_train(result),
            "profile": lambda: draw_profile(result),
        }


def print_base(base: Base, console: Console) -> None:
    """Print what is known of a steady train as a table."""
    table = quantities_table("Steady train", base, FORMATS)
    table.caption = base.origin
    console.print(table)
