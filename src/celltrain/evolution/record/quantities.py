"""The quantities of a simulation's history and of its frames."""

from dataclasses import replace

from celltrain.diagnostics import FRAME_QUANTITIES
from celltrain.evolution.methods import Manner, Work
from celltrain.evolution.state import Measures
from celltrain.quantities import Quantity, quantities

_MEASURES = quantities(Measures)
_LINEAR = Quantity(
    r"|e^{A t} v|", "r0", "size of the disturbance that the linear dynamics predicts"
)


def _along(dim: str, each: Quantity) -> Quantity:
    return replace(each, dims=(dim, *each.dims))


#: Column of the history, one entry for each step.
STEP_QUANTITIES: dict[str, Quantity] = {
    name: _along("step", each)
    for name, each in {
        "time": Quantity("t", "r0/U", "time at the end of each step"),
        **_MEASURES,
        **quantities(Manner),
        **quantities(Work),
        "eps_linear": _LINEAR,
        "eps_exponential": Quantity(
            r"\epsilon_0 e^{\alpha t}",
            "r0",
            "size if the disturbance grew at the rate of its mode from the beginning",
        ),
        "wall_seconds": Quantity("", "s", "wall time since the beginning"),
    }.items()
}

#: What is kept of each frame, but for its time and its shapes.
KEPT_OF_FRAMES: dict[str, Quantity] = {
    name: _along("frame", each)
    for name, each in {
        "laps": Quantity("", "1", "lengths of the train that each cell has gained", ("cell",)),
        "eps": _MEASURES["eps"],
        "eps_x": _MEASURES["eps_x"],
        "eps_linear": _LINEAR,
        **FRAME_QUANTITIES,
    }.items()
}
