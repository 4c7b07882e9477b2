"""What is explored, as the query of the page's address, and back: the address is the state.

    ?diameter=6&packing=0.2&cells=8&capillary_number=... &units=SI&mode=1,0,0&amplitude=0.3

Leaves of the case are by their names, in r0, U and mu with all their digits, and the three scales
where they are not the usual ones; what is left out has its default. A case with a profile of its
own takes the points from the file that was opened.
"""

from dataclasses import dataclass, replace
from urllib.parse import parse_qsl, urlencode

from celltrain.explore.controls import parsed
from celltrain.parameters import CaseError, Scales, Train
from celltrain.parameters.routing import KEPT, TAKEN
from celltrain.parameters.scales import REFERENCE
from celltrain.parameters.train import Units

#: The train of a page that was opened without any.
USUAL = Train(diameter=6, packing=0.2, cells=8)
_ALWAYS = ("diameter", "packing", "cells")
#: What the page alone reads: which mode is played how, and the time of a simulation.
OF_THE_PAGE = ("token", "mode", "amplitude", "phase", "time", "show")


@dataclass(frozen=True)
class View:
    """A case, and how it is looked at: in which units, and as a train of N cells or without end."""

    train: Train
    units: Units = "dimensionless"
    infinite: bool = False

    @property
    def address(self) -> str:
        """The query, without a question mark."""
        leaves = self.train.leaves()
        words = {
            name: "infinite" if name == "cells" and self.infinite else _written(value)
            for name, value in leaves.items()
            if name != "profile" and (name in _ALWAYS or value != KEPT[name].default)
        }
        usual = REFERENCE.model_dump()
        words |= {
            name: _written(value)
            for name, value in self.train.scales.model_dump().items()
            if value != usual[name]
        }
        if self.units == "SI":
            words["units"] = "SI"
        return urlencode(words)


def view_of(address: str, opened: Train | None = None) -> View:
    """What an address means; the case that was opened (or the usual one) where it names none.

    Raises:
        CaseError: for a name that is not known, or a value that is not allowed.
    """
    given = dict(parse_qsl(address.removeprefix("?"), keep_blank_values=True))
    for name in OF_THE_PAGE:
        given.pop(name, None)
    units = given.pop("units", "dimensionless")
    if units not in ("dimensionless", "SI"):
        raise CaseError(f"units = {units!r} is not allowed; allowed: dimensionless or SI")
    base = View(opened or USUAL, "SI" if units == "SI" else "dimensionless")
    if not given:
        return base
    unknown = [name for name in given if name not in TAKEN and name not in Scales.model_fields]
    if unknown:
        raise CaseError(
            f"unknown name {unknown[0]!r}; allowed are: {', '.join((*TAKEN, *Scales.model_fields))}"
        )
    infinite = given.get("cells") == "infinite"
    if infinite:
        given["cells"] = str(base.train.cells)
    values: dict[str, object] = {name: parsed(name, text) for name, text in given.items()}
    scales = {name: values.pop(name) for name in Scales.model_fields if name in values}
    if values.get("reference") == "profile" and opened is not None:
        values["profile"] = opened.cell.profile
    train = Train(**values, scales=scales, unusual=True)
    return replace(base, train=train, infinite=infinite)


def _written(value: object) -> str:
    return str(value) if isinstance(value, str | int) else repr(value)
