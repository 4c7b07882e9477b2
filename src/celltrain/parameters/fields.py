"""What a field of a section says of itself: description, unit, symbol, and what it allows."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import NoneType
from typing import Any, TypeVar, get_args

from annotated_types import Ge, Gt, Le, Lt, MultipleOf
from pydantic import GetCoreSchemaHandler
from pydantic.fields import FieldInfo
from pydantic_core import CoreSchema, PydanticCustomError
from pydantic_core.core_schema import no_info_after_validator_function

from celltrain.parameters.dimension import NUMBER, Dimension, Symbol

Kind = TypeVar("Kind")


@dataclass(frozen=True)
class Choice:
    """That a word is one of the names in a registry, which may still grow."""

    registry: Mapping[str, object]

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        """How pydantic checks a value."""
        return no_info_after_validator_function(self._check, handler(source))

    def _check(self, name: str) -> str:
        if name not in self.registry:
            raise PydanticCustomError("choice", "unknown name")
        return name


def allowed_range(field: FieldInfo) -> str:
    """The values that a field accepts, in words: ``"> 0"``, ``"6 to 48"``, ``"skalak or sphere"``.

    Empty when the field's type is the only condition.
    """
    choices = get_args(field.annotation)
    if choices and all(isinstance(choice, str) for choice in choices):
        return " or ".join(choices)
    choice = _among(field, Choice)
    if choice is not None:
        return " or ".join(choice.registry)
    bounds: dict[str, Any] = {}
    ending = ""
    for item in field.metadata:
        if isinstance(item, MultipleOf):
            ending = f", multiple of {item.multiple_of}"
        for kind, name in ((Gt, "gt"), (Ge, "ge"), (Lt, "lt"), (Le, "le")):
            if isinstance(item, kind):
                bounds[name] = getattr(item, name)
    if "ge" in bounds and "le" in bounds:
        return f"{bounds['ge']:g} to {bounds['le']:g}{ending}"
    signs = {"gt": ">", "ge": ">=", "lt": "<", "le": "<="}
    return " and ".join(f"{signs[name]} {bound:g}" for name, bound in bounds.items()) + ending


def allowed_values(field: FieldInfo | None) -> str:
    """A sentence's end on what a field accepts: ``"allowed: a whole number >= 1"``."""
    if field is None:
        return "see the documentation of this section"
    limits = allowed_range(field)
    nouns = {float: "a number", int: "a whole number"}
    noun = next((each for kind, each in nouns.items() if plain_type(field) is kind), "")
    extra = field.json_schema_extra
    reason = f" ({extra['reason']})" if isinstance(extra, dict) and "reason" in extra else ""
    return f"allowed: {' '.join(part for part in (noun, limits) if part)}{reason}"


def plain_type(field: FieldInfo) -> object:
    """The type of a field's values, without what is checked of them and without None."""
    kinds = [kind for kind in get_args(field.annotation) if kind is not NoneType]
    if len(kinds) != len(get_args(field.annotation)):
        [kind] = kinds
        return get_args(kind)[0]
    return field.annotation


def dimension(field: FieldInfo) -> Dimension:
    """What a field is measured in; only numbers with a fractional part have any.

    Raises:
        TypeError: for such a field that does not say it.
    """
    found = _among(field, Dimension)
    if found is None and plain_type(field) is float:
        raise TypeError(f"the field with the description {field.description!r} lacks its Dimension")
    return found or NUMBER


def symbol(field: FieldInfo) -> str | None:
    """How formulas call a field, if it says so."""
    found = _among(field, Symbol)
    return None if found is None else found.text


def described(field: FieldInfo) -> str:
    """A field's description with its unit: ``"diameter of the tube, r0"``."""
    measured = _among(field, Dimension)
    unit = "" if measured is None or measured.unit == "1" else f", {measured.unit}"
    return f"{field.description or ''}{unit}"


def _among(field: FieldInfo, kind: type[Kind]) -> Kind | None:
    return next((item for item in field.metadata if isinstance(item, kind)), None)
