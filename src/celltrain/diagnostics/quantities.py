"""The quantities that a frame of a simulation consists of: name, symbol, unit, meaning, dimensions.

Names differ from those of other results, so that all can go into one file.
"""

from dataclasses import dataclass

from celltrain.parameters.fields import symbol
from celltrain.parameters.routing import KEPT
from celltrain.parameters.strength import MODULI

#: The parts of the strain energy, and the modulus of the membrane that each belongs to.
ENERGY_PARTS = {modulus.removesuffix("_modulus"): modulus for modulus in MODULI}


@dataclass(frozen=True)
class FrameQuantity:
    """One quantity of a frame.

    Attributes:
        name: as in Python and in files.
        symbol: in the paper's notation, LaTeX without dollars.
        unit: in r0, U, mu; "1" for pure numbers.
        description: one sentence.
        dims: names of the dimensions of one frame: "cell", "axis" (x, y, z), "principal" (the axes
            of an ellipsoid, the shortest first), "harmonic" (degrees n = 0 ... M - 1).
    """

    name: str
    symbol: str
    unit: str
    description: str
    dims: tuple[str, ...]


def _table(*quantities: FrameQuantity) -> dict[str, FrameQuantity]:
    return {quantity.name: quantity for quantity in quantities}


#: All quantities that `frame` returns, in its order.
FRAME_QUANTITIES: dict[str, FrameQuantity] = _table(
    FrameQuantity("centroid", "x_c", "r0", "centroid of each cell's volume", ("cell", "axis")),
    FrameQuantity(
        "centroid_velocity",
        r"\dot{x}_c",
        "U",
        "velocity of the centroid, in the frame of the rates",
        ("cell", "axis"),
    ),
    FrameQuantity("cell_volume", "V", "r0^3", "volume of each cell", ("cell",)),
    FrameQuantity("cell_area", "A_s", "r0^2", "area of each cell's membrane", ("cell",)),
    FrameQuantity(
        "semi_axes",
        "a_i",
        "r0",
        "semi-axes of the ellipsoid with the second moments of the cell's volume",
        ("cell", "principal"),
    ),
    FrameQuantity(
        "principal_axes",
        "e_i",
        "1",
        "unit vectors of these axes, each with a positive largest component",
        ("cell", "principal", "axis"),
    ),
    FrameQuantity(
        "inclination",
        r"\theta",
        "rad",
        "angle between the shortest axis and the tube's axis, 0 to pi/2",
        ("cell",),
    ),
    FrameQuantity(
        "rotation_rate",
        r"\omega",
        "U/r0",
        "rotation of the cell's axes (Eq. 19)",
        ("cell", "axis"),
    ),
    FrameQuantity(
        "membrane_rotation_rate",
        r"\Omega",
        "U/r0",
        "mean rotation of the membrane's points (Eq. 20)",
        ("cell", "axis"),
    ),
    FrameQuantity("tumbling", r"|\omega|", "U/r0", "rate at which the axes turn", ("cell",)),
    FrameQuantity(
        "tank_treading",
        r"|\Omega - \omega|",
        "U/r0",
        "rate at which the membrane turns around the cell",
        ("cell",),
    ),
    *(
        FrameQuantity(
            f"energy_{part}",
            # W_s of E_s.
            f"W{(symbol(KEPT[modulus]) or part)[1:]}",
            "mu U r0^2",
            f"strain energy of {part} (Eq. 23), the part with the {part} modulus"
            + (", not a number for bending moments" if part == "bending" else ""),
            ("cell",),
        )
        for part, modulus in ENERGY_PARTS.items()
    ),
    FrameQuantity(
        "shape_spectrum",
        "E_n",
        "r0^2",
        "spectrum of the shapes over degrees, averaged over cells, positions left out (Eq. 16)",
        ("harmonic",),
    ),
    FrameQuantity(
        "wall_distance", r"h_w", "r0", "smallest distance of each cell from the wall", ("cell",)
    ),
    FrameQuantity(
        "cell_distance",
        r"h_c",
        "r0",
        "smallest distance of each cell from another membrane",
        ("cell",),
    ),
)
