"""The base of every group of parameters: frozen, closed, strict, with readable errors."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, Self

import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict, ValidationError

from celltrain.parameters.errors import case_error


def _plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value


#: A finite float; an int or a NumPy scalar is taken, a string or a bool is refused.
Real = Annotated[float, BeforeValidator(_plain)]

#: An int; a NumPy integer is taken, a float, a string or a bool is refused.
Whole = Annotated[int, BeforeValidator(_plain)]


class Section(BaseModel):
    """A group of parameters; making one raises :class:`CaseError` for what is not allowed."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)

    @classmethod
    def of(cls, leaves: Mapping[str, object]) -> Self:
        """A section of those of its fields that are among leaves, as they were given."""
        given: dict[str, Any] = {name: leaves[name] for name in cls.model_fields if name in leaves}
        return cls(**given)

    @classmethod
    def read(cls, values: Mapping[str, object]) -> Self:
        """A section of values as a file has them."""
        given: dict[str, Any] = dict(values)
        return cls(**given)

    # Hidden from type checkers, which should see the fields as the arguments.
    if not TYPE_CHECKING:

        def __init__(self, **values: Any) -> None:
            try:
                super().__init__(**values)
            except ValidationError as error:
                raise case_error(error, type(self)) from None
