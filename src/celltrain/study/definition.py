"""What a study is: a case, the parameters that vary, and what is computed of each case.

A study file is TOML; a study over a grid of 7 x 11 cases is

    [case]                       # as a case file; every parameter that does not vary
    cells = 8

    [axes]                       # a range or a list for each parameter that does
    diameter = {from = 6, to = 12, points = 7}
    packing = [0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5, 0.55, 0.6, 0.65, 0.7]

    [compute]                    # may be left out
    estimate_error = false
    analyses = ["mechanisms"]   # numbers of further analyses become columns
"""

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BeforeValidator, Field

from celltrain.parameters import CaseError, Train, merge_case
from celltrain.parameters.routing import LEAVES, SI_LEAVES, flatten
from celltrain.parameters.section import Real, Section, Whole
from celltrain.study.columns import further

#: What a study file may hold.
PARTS = ("title", "units", "unusual", "case", "axes", "compute")
#: More cases than this are taken for a mistake.
MOST_CASES = 100_000

AxisValue = float | int | str


class Range(Section):
    """Values of an axis from a first to a last one."""

    first: Real = Field(validation_alias="from", description="first value")
    last: Real = Field(validation_alias="to", description="last value")
    points: Whole = Field(ge=2, le=1000, description="number of values")
    spacing: Literal["linear", "logarithmic"] = Field(
        default="linear", description="spacing of the values"
    )

    def values(self) -> tuple[float, ...]:
        """The values; those of a linear range are rounded to 12 digits, as if typed."""
        if self.spacing == "linear":
            steps = np.linspace(self.first, self.last, self.points)
        else:
            steps = np.geomspace(self.first, self.last, self.points)
        return tuple(float(f"{value:.12g}") for value in steps)


def _as_tuple(given: object) -> object:
    return tuple(given) if isinstance(given, list) else given


class Computed(Section):
    """What is computed of each case, and from where its steady train is sought."""

    estimate_error: bool = Field(
        default=True, description="whether each growth rate comes with an estimate of its error"
    )
    analyses: Annotated[tuple[str, ...], BeforeValidator(_as_tuple)] = Field(
        default=(),
        description="further analyses of each case, such as mechanisms or transient, whose numbers"
        " become columns",
    )
    azimuthal_numbers: tuple[int, ...] | None = Field(
        default=None,
        strict=False,
        description="azimuthal numbers m that are looked at, all up to the degree unless given",
    )
    start: Literal["rest", "neighbour"] = Field(
        default="rest",
        description="where a steady train is sought from first: the resting shape, or the nearest"
        " finished case; the other is tried when that fails",
    )


@dataclass(frozen=True)
class Axis:
    """A parameter that varies, by its name in a case file, and its values in ascending order."""

    name: str
    values: tuple[AxisValue, ...]
    logarithmic: bool = False

    def place(self, index: int) -> float:
        """Where a value lies between the axis' least (0) and largest (1) value.

        Values that are no numbers are evenly spaced.
        """
        if len(self.values) == 1:
            return 0.0
        if any(isinstance(value, str) for value in self.values):
            return index / (len(self.values) - 1)
        numbers = np.array(self.values, dtype=float)
        if self.logarithmic:
            numbers = np.log(numbers)
        return float((numbers[index] - numbers[0]) / (numbers[-1] - numbers[0]))


@dataclass(frozen=True)
class Case:
    """One case of a study: its place on the axes, and the train."""

    index: tuple[int, ...]
    values: Mapping[str, AxisValue]
    train: Train

    def __str__(self) -> str:
        return describe(self.values)


@dataclass(frozen=True)
class Study:
    """A grid of cases, checked when it is made by `make_study`."""

    title: str
    axes: tuple[Axis, ...]
    computed: Computed
    cases: tuple[Case, ...]
    units: str = "dimensionless"

    def distance(self, one: Case, other: Case) -> float:
        """Distance of two cases, each axis scaled by its range."""
        steps = (
            axis.place(i) - axis.place(j)
            for axis, i, j in zip(self.axes, one.index, other.index, strict=True)
        )
        return float(np.sqrt(sum(step**2 for step in steps)))


def describe(values: Mapping[str, AxisValue]) -> str:
    """Values by name in a line: ``diameter = 6, packing = 0.2``."""
    return ", ".join(
        f"{name} = {value}" if isinstance(value, str) else f"{name} = {value:g}"
        for name, value in values.items()
    )


def make_study(content: Mapping[str, object]) -> Study:
    """A study from the content of a study file.

    Raises:
        CaseError: if the study or one of its cases is not allowed; the message names the axis, the
            value and what is allowed.
    """
    unknown_part(content, PARTS)
    parts = {name: section_of(name, content) for name in ("case", "axes", "compute")}
    units = str(content.get("units", "dimensionless"))
    case = {**parts["case"], "units": units, "unusual": content.get("unusual", False)}
    fixed = flatten(parts["case"], SI_LEAVES if units == "SI" else LEAVES)
    axes = tuple(_axis(name, given, fixed, units) for name, given in parts["axes"].items())
    if not axes:
        raise CaseError("[axes] has no parameter; allowed: at least one, with its values")
    count = int(np.prod([len(axis.values) for axis in axes], dtype=float))
    if count > MOST_CASES:
        raise CaseError(f"a study of {count} cases is not allowed; allowed: at most {MOST_CASES}")
    computed = Computed.read(parts["compute"])
    further(computed.analyses)  # refused before anything is computed
    return Study(
        title=str(content.get("title", "study")),
        axes=axes,
        computed=computed,
        cases=tuple(_cases(case, axes)),
        units=units,
    )


def unknown_part(content: Mapping[str, object], allowed: tuple[str, ...]) -> None:
    """Refuse parts of a study file that there are not.

    Raises:
        CaseError: for the first of them.
    """
    unknown = [name for name in content if name not in allowed]
    if unknown:
        raise CaseError(
            f"unknown name {unknown[0]!r} in a study; allowed are: {', '.join(allowed)}"
        )


def section_of(name: str, content: Mapping[str, object]) -> Mapping[str, object]:
    """A section of a study file, empty if it is not there.

    Raises:
        CaseError: if it is no section.
    """
    given = content.get(name, {})
    if not isinstance(given, Mapping):
        raise CaseError(f"{name} = {given!r} is not allowed: [{name}] is a section")
    return given


def _axis(name: str, given: Any, fixed: Mapping[str, Any], units: str) -> Axis:
    sections = SI_LEAVES if units == "SI" else LEAVES
    if name in sections:
        raise CaseError(
            f"axis {name} is a section; an axis is one of its leaves: {', '.join(sections[name])}"
        )
    try:
        flatten({name: None}, sections)
    except CaseError as error:
        raise CaseError(f"axes: {error}") from None
    if name in fixed:
        raise CaseError(f"{name} is given twice: as {fixed[name]!r} in the case and as an axis")
    logarithmic = False
    if isinstance(given, Mapping):
        values, logarithmic = _range(name, given)
    elif isinstance(given, list):
        values = given
    else:
        raise CaseError(
            f"axis {name} = {given!r} is not allowed; allowed: a list of values or"
            " {from = ..., to = ..., points = ...}"
        )
    wrong = [each for each in values if isinstance(each, bool) or not isinstance(each, AxisValue)]
    if wrong or not values:
        raise CaseError(
            f"axis {name}: {wrong[0]!r} is not allowed; allowed: numbers or words"
            if wrong
            else f"axis {name} has no values; allowed: at least one"
        )
    if len({type(each) is str for each in values}) > 1:
        raise CaseError(f"axis {name} mixes numbers and words; allowed: only one of them")
    if len(set(values)) < len(values):
        raise CaseError(f"axis {name} has a value twice; allowed: each value once")
    return Axis(name, tuple(sorted(values)), logarithmic)


def _range(name: str, given: Mapping[str, Any]) -> tuple[list[AxisValue], bool]:
    try:
        limits = Range(**given)
    except CaseError as error:
        lines = (f"axis {name}: {line}" for line in str(error).split("\n"))
        raise CaseError("\n".join(lines)) from None
    logarithmic = limits.spacing == "logarithmic"
    if limits.first == limits.last or (logarithmic and min(limits.first, limits.last) <= 0):
        allowed = "two different values" + (" > 0" if logarithmic else "")
        raise CaseError(
            f"axis {name} from {limits.first:g} to {limits.last:g} is not allowed;"
            f" allowed: {allowed}"
        )
    values = limits.values()
    # Whole numbers where both ends are, as some parameters take no others.
    whole = all(isinstance(given[end], int) for end in ("from", "to"))
    if whole and all(value.is_integer() for value in values):
        return [int(value) for value in values], logarithmic
    return list(values), logarithmic


def _cases(case: Mapping[str, Any], axes: tuple[Axis, ...]) -> Iterator[Case]:
    for index in itertools.product(*(range(len(axis.values)) for axis in axes)):
        values = {axis.name: axis.values[i] for axis, i in zip(axes, index, strict=True)}
        try:
            yield Case(index, values, merge_case(case, values))
        except CaseError as error:
            raise CaseError(f"the case {describe(values)} is not allowed:\n{error}") from None
