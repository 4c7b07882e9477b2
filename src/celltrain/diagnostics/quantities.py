"""The quantities that a frame of a simulation consists of: symbol, unit, meaning, dimensions."""

from celltrain.parameters.fields import symbol
from celltrain.parameters.routing import KEPT
from celltrain.parameters.strength import MODULI
from celltrain.quantities import Quantity

#: The parts of the strain energy, and the modulus of the membrane that each belongs to.
ENERGY_PARTS = {modulus.removesuffix("_modulus"): modulus for modulus in MODULI}


#: All quantities that `frame` returns, in its order.
FRAME_QUANTITIES: dict[str, Quantity] = {
    "centroid": Quantity("x_c", "r0", "centroid of each cell's volume", ("cell", "axis")),
    "centroid_velocity": Quantity(
        r"\dot{x}_c",
        "U",
        "velocity of the centroid, in the frame of the rates",
        ("cell", "axis"),
    ),
    "cell_volume": Quantity("V", "r0^3", "volume of each cell", ("cell",)),
    "cell_area": Quantity("A_s", "r0^2", "area of each cell's membrane", ("cell",)),
    "semi_axes": Quantity(
        "a_i",
        "r0",
        "semi-axes of the ellipsoid with the second moments of the cell's volume",
        ("cell", "principal"),
    ),
    "principal_axes": Quantity(
        "e_i",
        "1",
        "unit vectors of these axes, each with a positive largest component",
        ("cell", "principal", "axis"),
    ),
    "inclination": Quantity(
        r"\theta",
        "rad",
        "angle between the shortest axis and the tube's axis, 0 to pi/2",
        ("cell",),
    ),
    "rotation_rate": Quantity(
        r"\omega",
        "U/r0",
        "rotation of the cell's axes (Eq. 19)",
        ("cell", "axis"),
    ),
    "membrane_rotation_rate": Quantity(
        r"\Omega",
        "U/r0",
        "mean rotation of the membrane's points (Eq. 20)",
        ("cell", "axis"),
    ),
    "tumbling": Quantity(r"|\omega|", "U/r0", "rate at which the axes turn", ("cell",)),
    "tank_treading": Quantity(
        r"|\Omega - \omega|",
        "U/r0",
        "rate at which the membrane turns around the cell",
        ("cell",),
    ),
    **{
        f"energy_{part}": Quantity(  # W_s of E_s.
            f"W{(symbol(KEPT[modulus]) or part)[1:]}",
            "mu U r0^2",
            f"strain energy of {part} (Eq. 23), the part with the {part} modulus"
            + (", NaN for bending moments" if part == "bending" else ""),
            ("cell",),
        )
        for part, modulus in ENERGY_PARTS.items()
    },
    "shape_spectrum": Quantity(
        "E_n",
        "r0^2",
        "spectrum of the shapes over degrees, averaged over cells, positions left out (Eq. 16)",
        ("harmonic",),
    ),
    "wall_distance": Quantity(
        r"h_w", "r0", "smallest distance of each cell from the wall", ("cell",)
    ),
    "cell_distance": Quantity(
        r"h_c",
        "r0",
        "smallest distance of each cell from another membrane",
        ("cell",),
    ),
}
