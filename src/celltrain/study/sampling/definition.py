"""What a study of distributions is: trains whose parameters are drawn, and how many of them.

A study file in which the numbers of the cells differ from train to train is

    [case]                       # as a case file; every parameter that does not differ
    diameter = 6
    packing = 0.2

    [distributions]              # each of one form; a mean that is not given is the case's own
    reduced_volume = {normal = {relative_deviation = 0.12}}
    shear_modulus = {lognormal = {relative_deviation = 0.3}}
    viscosity_ratio = {uniform = {from = 1, to = 5}}

    [sample]                     # may be left out
    points = 256
    seed = 0

Points are Sobol's, scrambled by the seed (Owen 1998), in twice as many dimensions as there are
parameters: the first half of a point's coordinates are a row of a matrix A, the second half one of
B. Sobol indices need, beside the trains of A and of B, those of A with the column of one parameter
taken from B (Saltelli et al. 2010): parameters + 2 trains a point. More points begin with the same
ones.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy  # loads its parts when they are used
from jaxtyping import Float
from pydantic import Field

from celltrain.membrane import healthy_reduced_volume
from celltrain.parameters import CaseError, Train, merge_case
from celltrain.parameters.resolution import LARGEST_DEGREE
from celltrain.parameters.routing import LEAVES, SI_LEAVES, flatten
from celltrain.parameters.section import Section, Whole
from celltrain.stability import NUMBERS, check_linearisable
from celltrain.study.definition import MOST_CASES, Case, describe, section_of, unknown_part
from celltrain.study.sampling.distributions import (
    Distribution,
    Spread,
    check_name,
    complete,
    read_form,
)

#: What the file of such a study may hold.
PARTS = ("title", "units", "unusual", "case", "distributions", "sample", "compute")
#: Points of which the error of the growth rate is estimated, as a sample of all.
CHECKED = 4
# Digits of Sobol's points, and what moves them to the middle of their cells: never 0 or 1.
_BITS = 30
_HALF = 0.5 ** (_BITS + 1)


class Sample(Section):
    """How many points are drawn, and how."""

    points: Whole = Field(
        default=256, ge=16, le=65536, description="number of Sobol points, a power of two"
    )
    seed: Whole = Field(default=0, ge=0, description="seed of the points' scrambling")
    indices: bool = Field(
        default=True,
        description="whether Sobol indices are asked for, which take parameters + 2 trains a point"
        " in place of one",
    )


class ComputedOfDraws(Section):
    """What is computed of each train."""

    azimuthal_numbers: tuple[int, ...] = Field(
        default=NUMBERS, strict=False, description="azimuthal numbers m that are looked at"
    )


@dataclass(frozen=True)
class DrawnTrain(Case):
    """One train of a sample: `index` is its matrix (A, B, A with columns of B) and its point.

    `scores` are the parameters' places in their distributions as deviations of a normal one, from
    those of the means.
    """

    scores: tuple[float, ...]

    @property
    def checked(self) -> bool:
        """Whether the error of its growth rate is estimated."""
        return self.index[0] == 0 and self.index[1] < CHECKED


@dataclass(frozen=True)
class SampledStudy:
    """A sample of trains, checked when it is made by `make_sampled_study`.

    `central` is the train of the means; `points` has the draws of each point.
    """

    title: str
    distributions: tuple[Distribution, ...]
    sample: Sample
    computed: ComputedOfDraws
    central: Train
    points: tuple[tuple[DrawnTrain, ...], ...]
    case: Mapping[str, object]
    units: str

    @property
    def names(self) -> tuple[str, ...]:
        """The parameters that differ."""
        return tuple(each.name for each in self.distributions)

    @property
    def draws(self) -> Iterator[DrawnTrain]:
        """All trains, point by point."""
        return (draw for point in self.points for draw in point)

    @property
    def total(self) -> int:
        """How many trains there are."""
        return sum(map(len, self.points))

    def neighbour(self, parameter: int, step: float) -> Train:
        """The central train with the score of one parameter changed by a step.

        Raises:
            CaseError: if it is not allowed.
        """
        means = {each.name: each.mean for each in self.distributions}
        chosen = self.distributions[parameter]
        even = scipy.stats.norm.cdf(np.array([chosen.central_score + step]))
        value = float(chosen.values(even)[0])
        return merge_case(self.case, {**means, chosen.name: value})

    @property
    def matrices(self) -> tuple[str, ...]:
        """The names of the matrices, in the order of the draws' first index."""
        return matrices(self.names, indices=self.sample.indices)


def matrices(names: tuple[str, ...], *, indices: bool) -> tuple[str, ...]:
    """A, B, and A with the column of each parameter from B; A alone without indices."""
    return ("A", "B", *(f"A, {name} of B" for name in names)) if indices else ("A",)


def sobol_points(count: int, dimensions: int, seed: int) -> Float[np.ndarray, "point dimension"]:
    """The first of Sobol's points, scrambled, inside (0, 1)."""
    generator = np.random.default_rng(seed)
    engine = scipy.stats.qmc.Sobol(dimensions, scramble=True, bits=_BITS, rng=generator)
    return np.asarray(engine.random(count)) + _HALF


def design(even: Float[np.ndarray, "point columns"]) -> Float[np.ndarray, "matrix point parameter"]:
    """A, B, and A with each column from B, side by side."""
    count = even.shape[1] // 2
    first, second = even[:, :count], even[:, count:]
    mixed = [np.where(np.arange(count) == i, second, first) for i in range(count)]
    return np.stack([first, second, *mixed])


def make_sampled_study(content: Mapping[str, object]) -> SampledStudy:
    """A study of distributions from the content of its file.

    Raises:
        CaseError: if it, or one of its trains, is not allowed.
    """
    if "axes" in content:
        raise CaseError(
            "axes and distributions are not allowed together; allowed: one of them, so one study"
            " for each value of an axis"
        )
    unknown_part(content, PARTS)
    case, given, sample, compute = (
        section_of(name, content) for name in ("case", "distributions", "sample", "compute")
    )
    units = str(content.get("units", "dimensionless"))
    settings = {"units": units, "unusual": content.get("unusual", False)}
    drawn = _sample(sample, indices=len(given) > 1)
    computed = ComputedOfDraws.read(compute)
    # In an order of their own: the one in the file changes no point.
    names = tuple(sorted(given))
    if not names:
        raise CaseError("[distributions] has no parameter; allowed: at least one")
    distributions, central = _distributions(case, {n: given[n] for n in names}, settings)
    check_linearisable(central, computed.azimuthal_numbers)
    each = len(matrices(names, indices=drawn.indices))
    if drawn.points * each > MOST_CASES:
        raise CaseError(
            f"a study of {drawn.points} points with {each} trains each is not allowed; allowed: at"
            f" most {MOST_CASES} trains"
        )
    fixed = {**case, **settings}
    return SampledStudy(
        title=str(content.get("title", "study")),
        distributions=distributions,
        sample=drawn,
        computed=computed,
        central=central,
        points=tuple(_points(fixed, distributions, drawn)),
        case=fixed,
        units=units,
    )


def _sample(given: Mapping[str, Any], *, indices: bool) -> Sample:
    """How to draw; of a single parameter there are no indices, as all variance comes from it."""
    sample = Sample(**given)
    if not indices:
        sample = sample.model_copy(update={"indices": False})
    count = sample.points
    if count & (count - 1):
        below = 1 << (count.bit_length() - 1)
        raise CaseError(
            f"points = {count} is not allowed; allowed: a power of two, such as {below} or"
            f" {2 * below}, as only these many Sobol points fill the space evenly"
        )
    return sample


def _distributions(
    case: Mapping[str, Any], given: Mapping[str, Any], settings: Mapping[str, Any]
) -> tuple[tuple[Distribution, ...], Train]:
    """All distributions, complete, and the train of their means."""
    units = str(settings["units"])
    fixed = flatten(case, SI_LEAVES if units == "SI" else LEAVES)
    forms, means = {}, {}
    for name, content in given.items():
        check_name(name, units)
        form, numbers = forms[name] = read_form(name, content)
        if not isinstance(numbers, Spread):
            means[name] = complete(name, form, numbers, 0.0, units).mean
        elif numbers.mean is not None:
            means[name] = numbers.mean
        if name in means and name in fixed:
            raise CaseError(
                f"{name} is given twice: as {fixed[name]!r} in the case and as a distribution"
            )
    central = merge_case({**case, **settings}, means)
    known = {**central.leaves(), **central.scales.model_dump()}
    if units == "SI":
        known = central.leaves("SI")
    known["capillary_number"] = central.leaf("capillary_number")
    found = []
    for name, (form, numbers) in forms.items():
        mean = means.get(name, known[name])
        if mean is None and name == "reduced_volume" and central.cell.reference == "biconcave":
            mean = healthy_reduced_volume(central.resolution.degree or LARGEST_DEGREE)
            means[name] = mean
        if mean is None:
            raise CaseError(
                f"distribution {name}: mean is missing; the case has no value of its own"
            )
        found.append(complete(name, form, numbers, float(mean), units))
    return tuple(found), merge_case({**case, **settings}, means)


def _points(
    case: Mapping[str, Any], distributions: tuple[Distribution, ...], sample: Sample
) -> Iterator[tuple[DrawnTrain, ...]]:
    names = tuple(each.name for each in distributions)
    even = sobol_points(sample.points, 2 * len(names), sample.seed)
    cube = design(even) if sample.indices else even[None, :, : len(names)]
    scores = scipy.stats.norm.ppf(cube) - np.array([each.central_score for each in distributions])
    numbers = np.stack([each.values(cube[..., i]) for i, each in enumerate(distributions)], axis=-1)
    for point in range(sample.points):
        yield tuple(
            _draw(case, (matrix, point), dict(zip(names, found, strict=True)), tuple(places))
            for matrix, (found, places) in enumerate(
                zip(numbers[:, point].tolist(), scores[:, point].tolist(), strict=True)
            )
        )


def _draw(
    case: Mapping[str, Any],
    index: tuple[int, int],
    values: dict[str, float],
    scores: tuple[float, ...],
) -> DrawnTrain:
    try:
        return DrawnTrain(index, values, merge_case(case, values), scores)
    except CaseError as error:
        raise CaseError(f"the train {describe(values)} is not allowed:\n{error}") from None
