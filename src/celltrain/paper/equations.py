"""The paper's equations, and what of this package is each of them."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Equation:
    """Numbers of equations of the paper, what they say, and the names that are it here."""

    numbers: str
    words: str
    names: tuple[str, ...]


#: All of them, in the paper's order. Names are checked by a test.
EQUATIONS = (
    Equation("1", "in-plane energy of the membrane", ("celltrain.laws.constitutive.Skalak",)),
    Equation(
        "2",
        "bending: an energy by default, the moments as the paper's solver has them, or balanced",
        (
            "celltrain.laws.bending.ElasticBending",
            "celltrain.laws.bending.MomentBending",
            "celltrain.laws.bending.BalancedMomentBending",
        ),
    ),
    Equation(
        "3",
        "velocity on the membranes, on the meridian and in three dimensions",
        (
            "celltrain.meridian.train.TrainFlow.velocity",
            "celltrain.meridian.double_layer.DoubleLayer",
            "celltrain.train.operator.CellsOperator.surface_velocity",
        ),
    ),
    Equation("4", "shapes in harmonics", ("celltrain.harmonics.tables.harmonic_tables",)),
    Equation(
        "5, 6",
        "motion of the shapes",
        (
            "celltrain.meridian.train.TrainFlow.rates",
            "celltrain.train.operator.CellsOperator.rates",
        ),
    ),
    Equation(
        "7, 8",
        "disturbance and its norm; orders are weighted as in the paper",
        (
            "celltrain.diagnostics.spectrum.disturbance_amplitude",
            "celltrain.stability.norms.PaperNorm",
            "celltrain.stability.norms.paper_weights",
        ),
    ),
    Equation(
        "9 to 12",
        "the matrix A, exact here in place of differences, and by the blocks A_m(q)",
        (
            "celltrain.stability.linearise.linear_blocks",
            "celltrain.train.full_matrix.full_matrix",
        ),
    ),
    Equation("13", "linear evolution exp(A t)", ("celltrain.evolution.linear.linear_prediction",)),
    Equation(
        "14",
        "spectral abscissa alpha",
        (
            "celltrain.stability.analysis.stability",
            "celltrain.stability.spectrum.block_spectrum",
        ),
    ),
    Equation(
        "15",
        "numerical abscissa eta",
        (
            "celltrain.stability.spectrum.numerical_abscissa",
            "celltrain.stability.coordinates.normed_blocks",
        ),
    ),
    Equation(
        "16", "spectrum of deformation", ("celltrain.diagnostics.spectrum.deformation_spectrum",)
    ),
    Equation(
        "17, 19",
        "rotation of the cell's axes",
        (
            "celltrain.diagnostics.rotation.axes_rotation",
            "celltrain.diagnostics.modes.mode_motion",
        ),
    ),
    Equation("18", "second moments", ("celltrain.diagnostics.moments.cell_moments",)),
    Equation(
        "20, 21",
        "rotation of the membrane",
        ("celltrain.diagnostics.rotation.membrane_rotation",),
    ),
    Equation(
        "22",
        "growth without near neighbours",
        ("celltrain.stability.neighbours.growth_without_neighbours",),
    ),
    Equation("23", "strain energy by part", ("celltrain.diagnostics.energy.energy_parts",)),
    Equation(
        "24",
        "strain energy of a disturbance",
        ("celltrain.diagnostics.energy.perturbation_energy",),
    ),
)


def equations_table(source: str) -> str:
    """The equations as a table in Markdown; `source` is the way to the package's files."""
    lines = ["| Eq. | what | here |", "|---|---|---|"]
    for each in EQUATIONS:
        names = ", ".join(_link(name, source) for name in each.names)
        lines.append(f"| {each.numbers} | {each.words} | {names} |")
    return "\n".join(lines) + "\n"


def _link(name: str, source: str) -> str:
    """A name with its file; what begins with a capital, and what follows, is inside it."""
    parts = name.split(".")
    count = next((place for place, part in enumerate(parts) if part[0].isupper()), len(parts) - 1)
    path = "/".join(parts[1:count])
    return f"[`{'.'.join(parts[count:])}`]({source}/{path}.py)"
