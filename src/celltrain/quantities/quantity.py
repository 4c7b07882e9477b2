"""One quantity: its symbol, unit and meaning."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeVar

Function = TypeVar("Function", bound=Callable[..., Any])
_MARK = "__quantity__"


@dataclass(frozen=True)
class Quantity:
    """What a number, or an array of numbers, is; its name is that of the field it annotates.

    Attributes:
        symbol: in the paper's notation, LaTeX without dollars; empty if it has none.
        unit: in r0, U, mu; "1" for pure numbers, "s" for the computer's time.
        description: a sentence without its full stop.
        dims: names of an array's dimensions in files; those of its annotation if not given.
        equation: that which defines it, LaTeX without dollars.
        source: where the equation comes from, such as "Eq. (14)" of the paper.
        bulky: whether only files keep it, and neither JSON nor the report.
        parts: of what is kept by name, the quantity of each name.
        words: what reports call it, where its name in words is not good.
    """

    symbol: str
    unit: str
    description: str
    dims: tuple[str, ...] = ()
    equation: str = ""
    source: str = ""
    bulky: bool = False
    parts: Mapping[str, "Quantity"] = field(default_factory=dict)
    words: str = ""

    @property
    def attributes(self) -> dict[str, str]:
        """Those of a variable in a file; equation and source where there are any."""
        found = {"long_name": self.description, "units": self.unit, "symbol": self.symbol}
        found |= {"equation": self.equation} if self.equation else {}
        return found | ({"source": self.source} if self.source else {})


def quantity(meaning: Quantity) -> Callable[[Function], Function]:
    """Say what a function or a property returns; stands below `@property`."""

    def mark(function: Function) -> Function:
        setattr(function, _MARK, meaning)
        return function

    return mark


def marked(function: object) -> Quantity | None:
    """What a function or property was said to return."""
    inner = function.fget if isinstance(function, property) else function
    found = getattr(inner, _MARK, None)
    return found if isinstance(found, Quantity) else None
