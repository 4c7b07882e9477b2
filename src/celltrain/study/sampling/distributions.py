"""How a parameter differs from train to train: normal, lognormal or uniform, cut where need be.

Mean and standard deviation of a normal and of a lognormal distribution are those of the parameter
itself, before anything is cut off; for a lognormal one, with the relative deviation c = s/m,

    ln x ~ N(ln m - S^2/2, S^2),   S^2 = ln(1 + c^2).

What lies beyond the values that are allowed is cut off and the rest scaled up: x = F^-1(F(a) +
u [F(b) - F(a)]) for u even in (0, 1), F the distribution function and a, b the ends.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import numpy as np
import scipy  # loads its parts when they are used
from annotated_types import Ge, Gt, Le, Lt
from jaxtyping import Float
from pydantic import Field, model_validator
from pydantic.fields import FieldInfo

from celltrain.parameters import CaseError, Scales
from celltrain.parameters.dimension import NUMBER
from celltrain.parameters.fields import plain_type
from celltrain.parameters.routing import DIMENSIONS, SECTIONS, TAKEN
from celltrain.parameters.section import Real, Section

#: Largest part of a distribution that is cut off because the parameter does not allow it.
MOST_CUT = 0.05
# What is cut off is told from this part on.
_TOLD = 1e-6


class Spread(Section):
    """A normal or lognormal distribution, by its mean and one of two deviations."""

    mean: Real | None = Field(
        default=None, description="mean; the value in [case], or the default, unless given"
    )
    standard_deviation: Real | None = Field(default=None, gt=0, description="standard deviation")
    relative_deviation: Real | None = Field(
        default=None, gt=0, description="standard deviation over the mean"
    )
    least: Real | None = Field(default=None, description="below this it is cut off")
    most: Real | None = Field(default=None, description="above this it is cut off")

    @model_validator(mode="after")
    def _one_deviation(self) -> Self:
        given = [self.standard_deviation, self.relative_deviation]
        if given.count(None) != 1:
            how = "neither is" if given.count(None) == 2 else "both are"
            raise CaseError(
                f"{how} given of standard_deviation and relative_deviation; allowed: one of them"
            )
        if self.least is not None and self.most is not None and not self.least < self.most:
            raise CaseError(
                f"least = {self.least:g} and most = {self.most:g} are not allowed; allowed:"
                " least < most"
            )
        return self


class Even(Section):
    """A uniform distribution between two ends."""

    first: Real = Field(validation_alias="from", description="least value")
    last: Real = Field(validation_alias="to", description="largest value")

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        if not self.first < self.last:
            raise CaseError(
                f"from = {self.first:g} and to = {self.last:g} are not allowed; allowed: from < to"
            )
        return self


#: The forms of distributions, by their names in study files.
FORMS: dict[str, type[Section]] = {"normal": Spread, "lognormal": Spread, "uniform": Even}


@dataclass(frozen=True)
class Distribution:
    """The distribution of one parameter, complete; in the units of the study file.

    `least` and `most` are where it is cut, infinite where it is not.
    """

    name: str
    form: str
    mean: float
    standard_deviation: float
    least: float
    most: float

    @cached_property
    def _whole(self) -> Any:
        """What SciPy has of it, before it is cut."""
        if self.form == "uniform":
            return scipy.stats.uniform(self.least, self.most - self.least)
        if self.form == "normal":
            return scipy.stats.norm(self.mean, self.standard_deviation)
        width = math.sqrt(math.log1p((self.standard_deviation / self.mean) ** 2))
        return scipy.stats.lognorm(width, scale=self.mean * math.exp(-0.5 * width**2))

    @property
    def cuts(self) -> tuple[float, float]:
        """The parts of the distribution that are cut off below and above."""
        return float(self._whole.cdf(self.least)), float(self._whole.sf(self.most))

    @cached_property
    def central_score(self) -> float:
        """The place of the mean in the distribution, in deviations of a normal one."""
        return float(self.scores(np.array([self.mean]))[0])

    def values(self, even: Float[np.ndarray, " point"]) -> Float[np.ndarray, " point"]:
        """The parameter's values at points that are evenly distributed in (0, 1)."""
        below, above = (float(self._whole.cdf(end)) for end in (self.least, self.most))
        found = self._whole.ppf(below + np.asarray(even) * (above - below))
        return np.clip(found, self.least, self.most)

    def scores(self, values: Float[np.ndarray, " point"]) -> Float[np.ndarray, " point"]:
        """The places of values in the distribution, in deviations of a normal one."""
        below, above = (float(self._whole.cdf(end)) for end in (self.least, self.most))
        even = (self._whole.cdf(values) - below) / (above - below)
        return np.asarray(scipy.stats.norm.ppf(even))

    def __str__(self) -> str:
        if self.form == "uniform":
            return f"uniform from {self.least:g} to {self.most:g}"
        words = (
            f"{self.form}, mean {self.mean:.4g}, standard deviation {self.standard_deviation:.3g}"
        )
        ends = [
            f"{name} {end:g}"
            for name, end, part in zip(
                ("below", "above"), (self.least, self.most), self.cuts, strict=True
            )
            if part >= _TOLD
        ]
        part = sum(self.cuts)
        return f"{words}; {part:.2g} of it cut off {' and '.join(ends)}" if ends else words


def check_name(name: str, units: str) -> FieldInfo:
    """The field of a parameter that may differ from train to train.

    Raises:
        CaseError: for others.
    """
    fields = dict(TAKEN)
    if units == "SI":
        fields |= Scales.model_fields
    allowed = [
        each
        for each, field in fields.items()
        if plain_type(field) is float and each not in SECTIONS["resolution"].model_fields
    ]
    if name not in allowed:
        raise CaseError(f"distribution {name} is not allowed; allowed: {', '.join(allowed)}")
    return fields[name]


def read_form(name: str, given: object) -> tuple[str, Section]:
    """The form of a distribution and its numbers as a study file gives them.

    Raises:
        CaseError: for what is not allowed, with the parameter's name.
    """
    if not isinstance(given, Mapping) or len(given) != 1 or next(iter(given)) not in FORMS:
        raise CaseError(
            f"distribution {name} = {given!r} is not allowed; allowed: one of"
            " {normal = {mean = ..., standard_deviation = ...}},"
            " {lognormal = {mean = ..., relative_deviation = ...}},"
            " {uniform = {from = ..., to = ...}}"
        )
    [(form, numbers)] = given.items()
    if not isinstance(numbers, Mapping):
        raise CaseError(f"distribution {name}: {form} = {numbers!r} is not allowed: it is a table")
    try:
        return form, FORMS[form](**numbers)
    except CaseError as error:
        lines = (f"distribution {name}: {line}" for line in str(error).split("\n"))
        raise CaseError("\n".join(lines)) from None


def complete(name: str, form: str, numbers: Section, mean: float, units: str) -> Distribution:
    """A distribution with everything that follows.

    **Arguments:** `mean`: that of a normal or lognormal one, from wherever it comes.

    **Raises:** `CaseError` if too much of it lies beyond what the parameter allows.
    """
    field = check_name(name, units)
    low, high = _bounds(name, field, units)
    if isinstance(numbers, Even):
        for end in (numbers.first, numbers.last):
            if not low <= end <= high:
                raise CaseError(
                    f"distribution {name}: {end:g} is not allowed; allowed: {_between(low, high)}"
                )
        width = numbers.last - numbers.first
        middle = 0.5 * (numbers.first + numbers.last)
        return Distribution(
            name, form, middle, width / math.sqrt(12.0), numbers.first, numbers.last
        )
    assert isinstance(numbers, Spread)
    deviation = numbers.standard_deviation
    if deviation is None:
        assert numbers.relative_deviation is not None
        deviation = numbers.relative_deviation * abs(mean)
    if mean == 0.0 and numbers.relative_deviation is not None:
        raise CaseError(
            f"distribution {name}: relative_deviation is not allowed with a mean of 0; allowed:"
            " standard_deviation"
        )
    if form == "lognormal" and mean <= 0.0:
        raise CaseError(f"distribution {name}: mean = {mean:g} is not allowed; allowed: > 0")
    given = [end for end in (numbers.least, numbers.most) if end is not None]
    found = Distribution(
        name,
        form,
        mean,
        deviation,
        max(low, -math.inf if numbers.least is None else numbers.least),
        min(high, math.inf if numbers.most is None else numbers.most),
    )
    if not found.least < mean < found.most:
        raise CaseError(
            f"distribution {name}: mean = {mean:g} is not allowed; allowed:"
            f" {_between(found.least, found.most)}"
        )
    if sum(found.cuts) > MOST_CUT and not given:
        raise CaseError(
            f"distribution {name}: {sum(found.cuts):.0%} of it lie beyond what is allowed,"
            f" {_between(low, high)}; allowed: at most {MOST_CUT:.0%}, which are cut off, or more"
            " where least or most say so"
        )
    return found


def _bounds(name: str, field: FieldInfo, units: str) -> tuple[float, float]:
    """The least and the largest value that a parameter allows, in the units of the file.

    In SI other bounds than 0 depend on scales, which may differ, too: there cases are checked one
    by one.
    """
    low, high = -math.inf, math.inf
    for item in field.metadata:
        if isinstance(item, Gt | Ge):
            low = float(item.gt if isinstance(item, Gt) else item.ge)  # type: ignore[arg-type]
        if isinstance(item, Lt | Le):
            high = float(item.lt if isinstance(item, Lt) else item.le)  # type: ignore[arg-type]
    if units == "SI" and DIMENSIONS.get(name, NUMBER) != NUMBER:
        low, high = (end if end == 0.0 else math.copysign(math.inf, end) for end in (low, high))
    return low, high


def _between(low: float, high: float) -> str:
    if math.isinf(high):
        return f"above {low:g}"
    return f"below {high:g}" if math.isinf(low) else f"{low:g} to {high:g}"
