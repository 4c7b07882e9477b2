"""The quantities of a study's dataset that files of single results do not have."""

from celltrain.results import QUANTITIES, Quantity

_OF_CASES = (
    Quantity("taken_degree", "M", "1", "degree of the shapes, given or as the accuracy asks for"),
    Quantity("leading_azimuthal_number", "m", "1", "azimuthal number of the leading mode"),
    Quantity("leading_wave_number", "j", "1", "wave number j of q = 2 pi j/N of the leading mode"),
    Quantity("leading_frequency", r"\omega", "U/r0", "frequency of the leading mode"),
    Quantity(
        "tumbling",
        r"|\omega|",
        "U/r0^2",
        "rate at which the cells' axes turn in the leading mode, for each unit of its amplitude",
    ),
    Quantity(
        "tank_treading",
        r"|\Omega - \omega|",
        "U/r0^2",
        "rate at which membranes turn around their cells in the leading mode, for each unit of its"
        " amplitude",
    ),
    Quantity(
        "axisymmetric_growth_rate",
        r"\alpha_0(0)",
        "U/r0",
        "largest growth rate of what is axisymmetric and alike in all cells; where it is positive,"
        " a march from rest would not have ended in this steady train",
    ),
    Quantity("status", "", "1", "whether a case is finished, failed, or not computed yet"),
    Quantity("reason", "", "1", "why a case failed, empty if it did not"),
    Quantity("origin", "", "1", "how the steady train of a case was reached"),
    Quantity("case_seconds", "", "s", "wall time of a case"),
)

#: Everything that may be in a study's dataset: the quantities of results, and those of cases.
STUDY_QUANTITIES = QUANTITIES | {each.name: each for each in _OF_CASES}


def study_attributes(name: str) -> dict[str, str]:
    """Attributes of a variable of a study's dataset: `long_name`, `units` and `symbol`.

    Raises:
        KeyError: if it is not known.
    """
    known = STUDY_QUANTITIES[name]
    return {"long_name": known.description, "units": known.unit, "symbol": known.symbol}
