"""The contract of everything that is computed: checked, computed, kept, shown, drawn, loaded.

An analysis is one object (`Analysis`), its settings are its fields, and its result is a dataclass
whose fields say what they are. Commands, files, JSON, reports, pictures, studies and documentation
are made from it: a new one is one file in `celltrain.analyses`. What computes many cases, such as a
study, is an object of the same form (`InFolder`).

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
    from celltrain.contract.in_folder import Crew, InFolder, Kept
    from celltrain.contract.progress import Progress, Silent

__all__ = [
    "Analysis",
    "Crew",
    "Draw",
    "InFolder",
    "Kept",
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
        "in_folder": ("InFolder", "Kept", "Crew"),
        "progress": ("Progress", "Silent"),
    },
)
