"""One registry of the quantities that results consist of: name, symbol, unit, meaning, dimensions.

Everything written to a file takes its attributes from here. A quantity may be spread over several
variables: one for each azimuthal number (suffix `_m00`, `_m01`, ...), as blocks differ in size,
and one each for the real and imaginary parts (suffixes `_real`, `_imag`) of complex numbers.
"""

import re
from dataclasses import dataclass

from rich.console import Console
from rich.table import Table
from rich.text import Text

_SUFFIXES = re.compile(r"(?P<name>.+?)(_m(?P<number>\d\d+))?(_(?P<part>real|imag))?")


@dataclass(frozen=True)
class Quantity:
    """One quantity of a result.

    Attributes:
        name: as in Python and in files.
        symbol: in the paper's notation, LaTeX without dollars.
        unit: in r0, U, mu; "1" for pure numbers, "s" for the computer's time.
        description: one sentence.
        dims: names of the dimensions in files.
        per_azimuthal_number: whether there is one variable for each azimuthal number m; the
            dimensions `row`, `column` and `eigenvalue` then get the suffix, too.
        is_complex: whether real and imaginary parts are variables of their own.
    """

    name: str
    symbol: str
    unit: str
    description: str
    dims: tuple[str, ...] = ()
    per_azimuthal_number: bool = False
    is_complex: bool = False


def _table(*quantities: Quantity) -> dict[str, Quantity]:
    return {quantity.name: quantity for quantity in quantities}


def _block(name: str, symbol: str, unit: str, description: str, *dims: str) -> Quantity:
    return Quantity(name, symbol, unit, description, ("wave", *dims), True, True)


QUANTITIES: dict[str, Quantity] = _table(
    # The steady train.
    Quantity(
        "coefficients",
        "s",
        "r0",
        "shape of one cell: coefficients of x, y, z in real orthonormal spherical harmonics; column"
        " n*n + n + m holds degree n and order m, cos(m phi) for m > 0, sin(|m| phi) for m < 0",
        ("axis", "coefficient"),
    ),
    Quantity("cell_velocity", "U_c", "U", "velocity at which the steady train moves"),
    Quantity(
        "gap",
        r"\Delta",
        "r0",
        "least streamwise distance between the membranes of neighbouring cells",
    ),
    Quantity("largest_radius", r"r_\mathrm{max}", "r0", "largest distance of a cell from the axis"),
    Quantity(
        "effective_viscosity",
        r"\mu_\mathrm{eff}",
        "mu",
        "viscosity of the plain fluid with the same pressure drop at the same flow rate",
    ),
    Quantity(
        "residual",
        r"\max|v - U_c e_z|",
        "U",
        "largest velocity of the membrane relative to the moving train",
    ),
    Quantity(
        "truncation_error",
        r"\max|u - v|",
        "U",
        "the same before the velocity is cut at the degree of the shape",
    ),
    Quantity(
        "velocity_error",
        r"\max|\Delta v|/\max|v|",
        "1",
        "estimated relative error of the velocity by the rules and grids",
    ),
    Quantity(
        "history_method", "", "1", "method of each iteration: march or newton", ("iteration",)
    ),
    Quantity("history_residual", "", "U", "residual before each iteration", ("iteration",)),
    Quantity(
        "history_step",
        r"\Delta t",
        "r0/U",
        "pseudo-time step of each iteration, infinite for Newton's method",
        ("iteration",),
    ),
    Quantity(
        "history_cell_velocity",
        "U_c",
        "U",
        "velocity of the train in each iteration",
        ("iteration",),
    ),
    # The linear dynamics.
    Quantity(
        "azimuthal_numbers",
        "m",
        "1",
        "azimuthal numbers for which there are blocks",
        ("azimuthal",),
    ),
    Quantity("wave_numbers", "j", "1", "wave numbers along the train, q = 2 pi j/N", ("wave",)),
    _block("blocks", "A_m(q)", "U/r0", "block of the linearised dynamics", "row", "column"),
    _block("eigenvalues", r"\lambda", "U/r0", "eigenvalues of each block", "eigenvalue"),
    _block(
        "right_vectors",
        "v",
        "1",
        "right eigenvectors of each block, in columns",
        "row",
        "eigenvalue",
    ),
    _block(
        "left_vectors", "w", "1", "left eigenvectors of each block, in columns", "row", "eigenvalue"
    ),
    Quantity(
        "mode_growth_rate", r"\mathrm{Re} \lambda", "U/r0", "growth rate of each mode", ("mode",)
    ),
    Quantity("mode_frequency", r"\mathrm{Im} \lambda", "U/r0", "frequency of each mode", ("mode",)),
    Quantity("mode_azimuthal_number", "m", "1", "azimuthal number of each mode", ("mode",)),
    Quantity("mode_wave_number", "j", "1", "wave number of each mode, q = 2 pi j/N", ("mode",)),
    Quantity(
        "mode_neutral",
        "",
        "1",
        "whether a symmetry makes the growth rate of the mode zero",
        ("mode",),
    ),
    Quantity("mode_neutral_kind", "", "1", "the symmetry, empty if not neutral", ("mode",)),
    Quantity(
        "mode_multiplicity",
        "",
        "1",
        "how many modes of the whole train this one stands for",
        ("mode",),
    ),
    Quantity(
        "mode_index", "", "1", "place of each mode among the eigenvalues of its block", ("mode",)
    ),
    Quantity(
        "spectral_abscissa",
        r"\alpha",
        "U/r0",
        "largest growth rate, neutral modes set aside (Eq. 14)",
    ),
    Quantity(
        "numerical_abscissa",
        r"\eta",
        "U/r0",
        "largest initial growth rate in the paper's norm (Eq. 15)",
    ),
    Quantity(
        "numerical_abscissas",
        r"\eta",
        "U/r0",
        "largest initial growth rate in several norms",
        ("norm",),
    ),
    Quantity("norm", "", "1", "name of the norm", ("norm",)),
    Quantity(
        "error_estimate",
        r"\delta\alpha",
        "U/r0",
        "error of the largest growth rate by what its changes with the degree leave",
    ),
    Quantity(
        "convergence_degrees",
        "M",
        "1",
        "degrees at which the largest growth rate was computed",
        ("degree",),
    ),
    Quantity(
        "convergence_abscissas",
        r"\alpha(M)",
        "U/r0",
        "largest growth rate at these degrees",
        ("degree",),
    ),
    Quantity("convergence_least", "", "U/r0", "the smallest error that is stated"),
    Quantity("bar_mode", "", "1", "number of the mode that each error bar belongs to", ("bar",)),
    Quantity("bar_by_degree", "", "U/r0", "what higher degrees leave of its eigenvalue", ("bar",)),
    Quantity("bar_by_rules", "", "U/r0", "change of its eigenvalue by finer rules", ("bar",)),
    Quantity("bar_overlap", "", "1", "overlap with the mode in these computations", ("bar",)),
    Quantity(
        "transient_growth_rate", r"\eta", "U/r0", "initial growth rate of the transient disturbance"
    ),
    Quantity("transient_azimuthal_number", "m", "1", "azimuthal number of the same"),
    Quantity("transient_wave_number", "j", "1", "wave number of the same"),
    Quantity(
        "transient_vector",
        r"v_\eta",
        "1",
        "the disturbance that grows fastest at first",
        ("transient_row",),
        is_complex=True,
    ),
    # What it took.
    Quantity("base_seconds", "", "s", "wall time of each stage of the base flow", ("base_stage",)),
    Quantity("base_stage", "", "1", "name of the stage of the base flow", ("base_stage",)),
    Quantity("seconds", "", "s", "wall time of each stage of the whole", ("stage",)),
    Quantity("stage", "", "1", "name of the stage", ("stage",)),
    Quantity("axis", "", "1", "x, y and z, the tube's axis and direction of flow", ("axis",)),
)


def quantity(variable: str) -> Quantity:
    """The quantity to which a variable of a file belongs, such as `blocks_m01_real` to `blocks`.

    Raises:
        KeyError: if the registry does not know it, or it does not come in such parts.
    """
    if variable in QUANTITIES:
        return QUANTITIES[variable]
    match = _SUFFIXES.fullmatch(variable)
    found = QUANTITIES.get(match["name"]) if match else None
    if (
        match is None
        or found is None
        or found.per_azimuthal_number != (match["number"] is not None)
        or found.is_complex != (match["part"] is not None)
    ):
        raise KeyError(f"{variable!r} is not in the registry of quantities")
    return found


def attributes(variable: str) -> dict[str, str]:
    """Attributes of a variable of a file: `long_name`, `units` and `symbol`.

    Raises:
        KeyError: if the registry does not know it.
    """
    entry = quantity(variable)
    match = _SUFFIXES.fullmatch(variable)
    description = entry.description
    if variable not in QUANTITIES and match is not None:
        if match["number"]:
            description += f", azimuthal number m = {int(match['number'])}"
        description += {"real": ", real part", "imag": ", imaginary part", None: ""}[match["part"]]
    return {"long_name": description, "units": entry.unit, "symbol": entry.symbol}


def print_registry(console: Console | None = None) -> None:
    """Print the registry as a table."""
    table = Table(title="Quantities in results (r0, U, mu)", title_justify="left")
    for column in ("name", "symbol", "unit", "dimensions"):
        table.add_column(column, no_wrap=True)
    table.add_column("description")
    for entry in QUANTITIES.values():
        name = entry.name + ("_mNN" if entry.per_azimuthal_number else "")
        name += "_real/imag" if entry.is_complex else ""
        # As text, so that nothing in a symbol is taken for markup.
        cells = (name, entry.symbol, entry.unit, ", ".join(entry.dims), entry.description)
        table.add_row(*(Text(cell) for cell in cells))
    (console or Console()).print(table)
