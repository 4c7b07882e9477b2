"""Command-line options of a case, generated from its parameters: one for each leaf."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import field as dataclass_field
from dataclasses import fields, make_dataclass
from typing import Annotated, Any, Literal, cast

from cyclopts import Group, Parameter, Token
from pydantic.fields import FieldInfo

from celltrain.parameters import Scales
from celltrain.parameters.dimension import NUMBER
from celltrain.parameters.fields import (
    allowed_range,
    allowed_values,
    described,
    plain_type,
)
from celltrain.parameters.routing import DIMENSIONS, LEAVES, TAKEN


def _options() -> Iterator[tuple[str, str, FieldInfo]]:
    """Every leaf as group, name and field."""
    for section, names in LEAVES.items():
        for name in names:
            yield section.capitalize(), name, TAKEN[name]
    for name, field in Scales.model_fields.items():
        yield 'Scales (with units "SI")', name, field


def _help(name: str, field: FieldInfo) -> str:
    limits = allowed_range(field)
    notes = [f"allowed: {limits}"] if limits else []
    dimension = DIMENSIONS.get(name, NUMBER)
    if dimension != NUMBER:
        notes.insert(0, f"in SI {dimension.si}")
    extra = field.json_schema_extra
    if isinstance(extra, dict) and "default" in extra:
        notes.append(f"default: {extra['default']}")
    elif not field.is_required() and field.default is not None:
        default = field.default
        notes.append(f"default: {f'{default:.5g}' if isinstance(default, float) else default}")
    return f"{described(field)} ({'; '.join(notes)})" if notes else described(field)


def reader(kind: type, otherwise: str) -> Callable[[object, Sequence[Token]], object]:
    """How an option with numbers is read: strictly, as an int is otherwise rounded."""

    def read(hint: Any, tokens: Sequence[Token]) -> Any:
        try:
            values = [kind(token.value) for token in tokens]
        except ValueError:
            # Of several values the option is not named otherwise.
            option = "" if hint in (int, float) else f"{tokens[0].keyword} "
            given = option + " ".join(token.value for token in tokens)
            raise ValueError(f"{given} is not allowed; {otherwise}") from None
        return values[0] if hint in (int, float) else values

    return read


def _option_class() -> type:
    columns: list[tuple[str, Any, Any]] = []
    orders: dict[str, Group] = {}
    for title, name, info in _options():
        group = orders.setdefault(title, Group(title, sort_key=len(orders) + 10))
        # Values are checked by the parameters alone, which say what is allowed.
        kind = plain_type(info)
        plain: Any = kind if kind in (int, float) else str
        converter = None if plain is str else reader(plain, allowed_values(info))
        parameter = Parameter(help=_help(name, info), group=group, converter=converter)
        columns.append((name, Annotated[plain | None, parameter], dataclass_field(default=None)))
    units = Parameter(
        help='units of the case file and of these options: "dimensionless" (r0, U, mu) or "SI"',
        group=Group("Units", sort_key=9),
    )
    kind = Literal["dimensionless", "SI"] | None
    columns.append(("units", Annotated[kind, units], dataclass_field(default=None)))
    unusual = Parameter(
        help="Allow profiles of more than 3 times a healthy cell's volume or less than a third, and"
        " scales in SI more than tenfold from a red blood cell's in a capillary.",
        group=units.group,
        negative=(),
    )
    columns.append(("unusual", Annotated[bool | None, unusual], dataclass_field(default=None)))
    options = make_dataclass("CaseOptions", columns, frozen=True, kw_only=True)
    options.__module__ = __name__  # cyclopts only looks into classes of modules like this one
    return options


#: A frozen dataclass with one optional field for each leaf, for cyclopts to read options into.
OPTIONS: Any = _option_class()
#: The same as an argument; None when no option was given.
CaseOptions: Any = Annotated[OPTIONS | None, Parameter(name="*")]


def given_leaves(options: object) -> dict[str, object]:
    """The leaves (and ``units``, ``unusual``) that were given on the command line."""
    if options is None:
        return {}
    names = (item.name for item in fields(cast(Any, options)))
    values = {name: getattr(options, name) for name in names}
    return {name: value for name, value in values.items() if value is not None}
