"""Trains of red blood cells in narrow tubes: their steady flow and its stability.

    from celltrain import Train, steady, stability

    train = Train(diameter=6, packing=0.2, cells=8)
    result = stability(train)
    result.spectral_abscissa, result.error_estimate, result.base.train.degree

Lengths are in r0 (radius of the sphere of a cell's volume), velocities in U (mean velocity in the
tube), viscosities in mu (plasma); so rates are in U/r0. What uses JAX is imported when it is asked
for; 64-bit floats are then switched on for JAX.
"""

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING

import celltrain.environment  # noqa: F401  (first: what libraries read when loaded)
from celltrain.version import __version__

if TYPE_CHECKING:
    from celltrain.contract import draw_all, load, show
    from celltrain.evolution.record.run import Run
    from celltrain.evolution.simulate import evolve, resume
    from celltrain.parameters import CaseError, Train, load_case, paper_units
    from celltrain.results import save, summary
    from celltrain.stability import Mode, Stability, stability
    from celltrain.steady import Base, NotConverged, steady
    from celltrain.train.fluid_velocity import fluid_velocity

__all__ = [
    "Base",
    "CaseError",
    "Mode",
    "NotConverged",
    "Run",
    "Stability",
    "Train",
    "__version__",
    "draw_all",
    "evolve",
    "fluid_velocity",
    "load",
    "load_case",
    "paper_units",
    "resume",
    "save",
    "show",
    "stability",
    "steady",
    "summary",
]

_LATER = {
    "contract": ("draw_all", "load", "show"),
    "evolution": ("Run", "evolve", "resume"),
    "parameters": ("CaseError", "Train", "load_case", "paper_units"),
    "results": ("save", "summary"),
    "stability": ("Mode", "Stability", "stability"),
    "steady": ("Base", "NotConverged", "steady"),
    "train": ("fluid_velocity",),
}
_OWNERS = {name: owner for owner, names in _LATER.items() for name in names}


def __getattr__(name: str) -> object:
    if name not in _OWNERS:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"{__name__}.{_OWNERS[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


class _Package(ModuleType):
    """In which `steady` and `stability` are the functions, also once their modules are loaded."""

    def __setattr__(self, name: str, value: object) -> None:
        # An import of the module sets it as the package's attribute.
        if isinstance(value, ModuleType) and _OWNERS.get(name) == name:
            value = getattr(value, name)
        super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package
