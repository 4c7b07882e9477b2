"""The quantities of a simulation's file: name, symbol, unit, meaning, dimensions."""

from dataclasses import dataclass

from celltrain.diagnostics import FRAME_QUANTITIES

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
        "direction": (shape, "1", "last direction of the power iteration"),
        "time": ((), "r0/U", "time"),
        "step": ((), "r0/U", "next step"),
        "last_step": ((), "r0/U", "last step"),
        "last_error": ((), "1", "estimated error of the last step over what was allowed"),
        "radius": ((), "U/r0", "spectral radius"),
        "radius_age": ((), "1", "steps since it was estimated"),
        "steps": ((), "1", "steps so far"),
        "rejected": ((), "1", "steps rejected so far"),
        "evaluations": ((), "1", "evaluations of the velocity so far"),
        "gap": ((), "r0", "thinnest film within the range of the repulsion"),
        "wall_gap": ((), "r0", "smallest distance of cells for which the wall is resolved"),
    }
    found |= {
        f"state_{name}": Attributes(dims, unit, "", f"state to go on from: {text}")
        for name, (dims, unit, text) in state.items()
    }
    return found


#: Every variable that a simulation adds to the file of the result that it started from.
RUN_QUANTITIES: dict[str, Attributes] = _quantities()
