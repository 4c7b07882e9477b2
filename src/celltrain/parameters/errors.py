"""The one error that a wrong case raises, and how a validation failure becomes its message."""

from collections.abc import Mapping
from types import NoneType
from typing import Any, get_args

from annotated_types import Ge, Gt, Le, Lt, MultipleOf
from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo


class CaseError(ValueError):
    """A case that cannot be computed; the message names the value and what is allowed."""


def allowed_range(field: FieldInfo) -> str:
    """The values that a field accepts, in words: ``"> 0"``, ``"6 to 48"``, ``"skalak or sphere"``.

    Empty when the field's type is the only condition.
    """
    choices = get_args(field.annotation)
    if choices and all(isinstance(choice, str) for choice in choices):
        return " or ".join(choices)
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


def plain_type(field: FieldInfo) -> Any:
    """The type of a field's values, without what is checked of them and without None."""
    kinds = [kind for kind in get_args(field.annotation) if kind is not NoneType]
    if len(kinds) != len(get_args(field.annotation)):
        [kind] = kinds
        return get_args(kind)[0]
    return field.annotation


def case_error(error: ValidationError, model: type[BaseModel]) -> CaseError:
    """A pydantic failure of ``model`` as a short message, one line for each wrong value."""
    fields: Mapping[str, FieldInfo] = {
        str(field.validation_alias or name): field for name, field in model.model_fields.items()
    }
    return CaseError("\n".join(_line(detail, fields) for detail in error.errors()))


def _line(detail: Any, fields: Mapping[str, FieldInfo]) -> str:
    kind = detail["type"]
    if kind == "value_error":  # raised by a check of ours (or by a section): already readable
        return str(detail["ctx"]["error"])
    name = ".".join(str(part) for part in detail["loc"])
    field = fields.get(name)
    if kind == "missing":
        described = f" ({field.description})" if field and field.description else ""
        return f"{name} is missing{described}; {allowed_values(field)}"
    if kind == "extra_forbidden":
        return f"unknown name {name!r}; allowed are: {', '.join(fields)}"
    return f"{name} = {detail['input']!r} is not allowed; {allowed_values(field)}"


def allowed_values(field: FieldInfo | None) -> str:
    """A sentence's end on what a field accepts: ``"allowed: a whole number >= 1"``."""
    if field is None:
        return "see the documentation of this section"
    limits = allowed_range(field)
    nouns = {float: "a number", int: "a whole number"}
    noun = nouns.get(plain_type(field), "")
    extra = field.json_schema_extra
    reason = f" ({extra['reason']})" if isinstance(extra, dict) and "reason" in extra else ""
    return f"allowed: {' '.join(part for part in (noun, limits) if part)}{reason}"
