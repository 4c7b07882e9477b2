"""The contract of everything that is computed: checked, computed, kept, shown, drawn, loaded.

An analysis is one object (`Analysis`), its settings are its fields, and its result is a dataclass
whose fields say what they are. Commands, files, JSON, reports, pictures, studies and documentation
are made from it: a new one is one file in `celltrain.analyses`.

Its parts are imported when they are asked for: the command line only needs the names at first.
"""

from typing import TYPE_CHECKING

from celltrain.later import imported_later

if TYPE_CHECKING:
    from celltrain.contract.analysis import (
        Analysis,
        Draw,
        OfStability,
        Presentation,
        Setting,
        WrittenMeanwhile,
    )
    from celltrain.contract.catalogue import (
        analysis_named,
        commands,
        first_lines,
        kinds,
        presentation,
    )
    from celltrain.contract.files import draw_all, load, show
    from celltrain.contract.progress import Progress, Silent

__all__ = [
    "Analysis",
    "Draw",
    "OfStability",
    "Presentation",
    "Progress",
    "Setting",
    "Silent",
    "WrittenMeanwhile",
    "analysis_named",
    "commands",
    "draw_all",
    "first_lines",
    "kinds",
    "load",
    "presentation",
    "show",
]

__getattr__ = imported_later(
    __name__,
    {
        "analysis": (
            "Analysis",
            "Draw",
            "OfStability",
            "Presentation",
            "Setting",
            "WrittenMeanwhile",
        ),
        "catalogue": ("analysis_named", "commands", "first_lines", "kinds", "presentation"),
        "files": ("draw_all", "load", "show"),
        "progress": ("Progress", "Silent"),
    },
)
