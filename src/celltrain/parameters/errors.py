"""The one error that a wrong case raises, and how a validation failure becomes its message."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from celltrain.parameters.fields import allowed_values, described


class CaseError(ValueError):
    """A case that cannot be computed; the message names the value and what is allowed."""


@contextmanager
def called(**options: str) -> Iterator[None]:
    """Within this a value that is refused is called by its option, `called(step="euler_step")`.

    Raises:
        CaseError: as what is done within this, with that name in its message.
    """
    try:
        yield
    except CaseError as error:
        name, equals, rest = str(error).partition(" = ")
        raise CaseError(f"{options.get(name, name)}{equals}{rest}") from None


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
        meaning = f" ({described(field)})" if field and field.description else ""
        return f"{name} is missing{meaning}; {allowed_values(field)}"
    if kind == "extra_forbidden":
        return f"unknown name {name!r}; allowed are: {', '.join(fields)}"
    return f"{name} = {detail['input']!r} is not allowed; {allowed_values(field)}"
