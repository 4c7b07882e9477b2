"""The quantities of a simulation's file: name, symbol, unit, meaning, dimensions."""

from dataclasses import dataclass, fields
from typing import get_type_hints

from celltrain.diagnostics import FRAME_QUANTITIES
from celltrain.evolution.state import Measures

#: Column of the history, in its order: symbol, unit, meaning. In files they begin with "step_".
STEP_QUANTITIES: dict[str, tuple[str, str, str]] = {
    "time": ("t", "r0/U", "time at the end of each step"),
    "eps": (r"\epsilon", "r0", "size of the disturbance (Eq. 8)"),
    "eps_x": (
        r"\epsilon_x",
        "r0",
        "root of the sum over cells of the mean square displacement of the membrane",
    ),
    "eps_linear": (r"|e^{A t} v|", "r0", "size that the linear dynamics predicts"),
    "eps_exponential": (
        r"\epsilon_0 e^{\alpha t}",
        "r0",
        "size if the disturbance grew at the rate of its mode from the beginning",
    ),
    "energy": ("W", "mu U r0^2", "elastic energy of all membranes"),
    "area": ("A", "r0^2", "area of all membranes"),
    "volume_correction": (
        "",
        "r0",
        "largest displacement by the correction of the cells' volumes after each step",
    ),
    "gap": (
        "d",
        "r0",
        "thinnest film within the range of the repulsion, infinite if there is none",
    ),
    "film_energy": ("W_r", "mu U r0^2", "energy of the repulsion in all films"),
    "film_force": (
        "",
        "mu U r0",
        "largest force of films on a cell, the sum of its parts without regard to directions",
    ),
    "size": ("h", "r0/U", "size of each step"),
    "stages": ("s", "1", "evaluations of the velocity in each step"),
    "error": ("", "r0", "estimated error of each step, the largest displacement of a membrane"),
    "radius": (r"\rho", "U/r0", "spectral radius for which each step is stable"),
    "rejected": ("", "1", "steps rejected since the beginning"),
    "evaluations": ("", "1", "evaluations of the velocity since the beginning"),
    "wall_seconds": ("", "s", "wall time since the beginning"),
}


@dataclass(frozen=True)
class Attributes:
    """What a file says of a variable."""

    dims: tuple[str, ...]
    unit: str
    symbol: str
    description: str


def _quantities() -> dict[str, Attributes]:
    shape = ("cell", "axis", "coefficient")
    found = {
        f"step_{name}": Attributes(("step",), unit, symbol, text)
        for name, (symbol, unit, text) in STEP_QUANTITIES.items()
    }
    found |= {
        "time": Attributes(("frame",), "r0/U", "t", "time of each frame"),
        "shapes": Attributes(
            ("frame", *shape),
            "r0",
            "s",
            "shapes of all cells in the frame that moves with the steady train; order of the"
            " coefficients as in the steady train's",
        ),
        "frame_laps": Attributes(
            ("frame", "cell"), "1", "", "lengths of the train that each cell has gained on it"
        ),
        "frame_eps": Attributes(("frame",), "r0", r"\epsilon", STEP_QUANTITIES["eps"][2]),
        "frame_eps_x": Attributes(("frame",), "r0", r"\epsilon_x", STEP_QUANTITIES["eps_x"][2]),
        "frame_eps_linear": Attributes(
            ("frame",), "r0", r"|e^{A t} v|", STEP_QUANTITIES["eps_linear"][2]
        ),
    }
    found |= {
        f"frame_{name}": Attributes(("frame", *each.dims), each.unit, each.symbol, each.description)
        for name, each in FRAME_QUANTITIES.items()
    }
    state = {
        "shapes": (shape, "r0", "shapes, mean points within the train's length"),
        "laps": (("cell",), "1", "lengths of the train that each cell is put back by"),
        "rates": (shape, "U", "rates of change in the frame of the steady train"),
        "time": ((), "r0/U", "time"),
        "wall_gap": ((), "r0", "smallest distance of cells for which the wall is resolved"),
    }
    for each in fields(Measures):
        _, unit, text = STEP_QUANTITIES[each.name]
        state[each.name] = ((), unit, text)
    found |= {
        f"state_{name}": Attributes(dims, unit, "", f"state to go on from: {text}")
        for name, (dims, unit, text) in state.items()
    }
    return found


#: Every variable that a simulation adds to the file of the result that it started from.
RUN_QUANTITIES: dict[str, Attributes] = _quantities()


def memory_quantities(memory: type) -> dict[str, Attributes]:
    """Variables for the memory of a method, which is a dataclass of this class."""
    hints = get_type_hints(memory, include_extras=True)
    about = {each.name: hints[each.name].__metadata__[0] for each in fields(memory)}
    return {
        f"memory_{name}": Attributes(
            each.dims, each.unit, "", f"memory of the method: {each.meaning}"
        )
        for name, each in about.items()
    }
