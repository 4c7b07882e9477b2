"""The resolution of a case: the degree of its shapes, and the sizes of the rules for it."""

from dataclasses import dataclass
from typing import Annotated, Self

from pydantic import Field, model_validator
from pydantic.config import JsonDict

from celltrain.parameters.dimension import NUMBER
from celltrain.parameters.errors import CaseError
from celltrain.parameters.section import Real, Section, Whole

#: Least and largest degree of a case.
LEAST_DEGREE, LARGEST_DEGREE = 6, 64
#: Default of a size, in words.
FOLLOWS: JsonDict = {"default": "follows from the degree"}


@dataclass(frozen=True)
class Sizes:
    """Degree M and grading of the shapes, and all sizes of the rules.

    The energy's and the targets' grid serve the operator of three-dimensional and that of
    axisymmetric shapes, the others the three-dimensional operator only.
    """

    degree: int
    energy_order: int
    source_order: int
    target_order: int
    polar_radial: int
    polar_azimuthal: int
    grading: float = 0.0


class Resolution(Section):
    """Degree of the shapes, and sizes of the rules, which follow the degree unless given.

    `energy_order` and `target_order` serve both operators; the other sizes, `near_cutoff` and
    `tolerance` serve the three-dimensional one.
    """

    degree: Whole | None = Field(
        default=None,
        ge=LEAST_DEGREE,
        le=LARGEST_DEGREE,
        description="degree M: a shape has the harmonics of degree below M; unless given it rises"
        " until the growth rate is as accurate as asked for",
        json_schema_extra={
            "reason": "the resting cell itself has harmonics of degree 5",
            "default": "as the accuracy asks for",
        },
    )
    grading: Annotated[Real, NUMBER] = Field(
        default=0.0,
        ge=0,
        le=1,
        description="how much the points of a cell are drawn together about its rear rim and its"
        " nose, for narrow tubes, where a degree leaves somewhat less out with 1 than with 0",
    )
    energy_order: Whole | None = Field(
        default=None,
        ge=6,
        le=400,
        description="order of the grid on which the membrane energy is integrated",
        json_schema_extra=FOLLOWS,
    )
    source_order: Whole | None = Field(
        default=None,
        ge=6,
        le=400,
        description="order of the grid that carries the forces, three-dimensional operator",
        json_schema_extra=FOLLOWS,
    )
    target_order: Whole | None = Field(
        default=None,
        ge=6,
        le=400,
        description="order of the grid on which the velocity is evaluated",
        json_schema_extra=FOLLOWS,
    )
    polar_radial: Whole | None = Field(
        default=None,
        ge=4,
        le=400,
        description="radial nodes of the polar rule around a target, three-dimensional operator",
        json_schema_extra=FOLLOWS,
    )
    polar_azimuthal: Whole | None = Field(
        default=None,
        ge=4,
        le=600,
        multiple_of=2,
        description="azimuthal nodes of the polar rule around a target (even), three-dimensional"
        " operator",
        json_schema_extra=FOLLOWS,
    )
    near_cutoff: Annotated[Real, NUMBER] = Field(
        default=2.5,
        gt=0,
        le=20,
        description="distance to which the near sum is taken, r0 also in SI, three-dimensional"
        " operator",
    )
    tolerance: Annotated[Real, NUMBER] = Field(
        default=1e-6,
        ge=1e-12,
        le=1e-3,
        description="relative error aimed at in the fast sums, three-dimensional operator",
    )

    @model_validator(mode="after")
    def _grids_hold_the_shape(self) -> Self:
        for name in ("energy_order", "source_order", "target_order"):
            order = getattr(self, name)
            if self.degree is not None and order is not None and order < self.degree:
                raise CaseError(
                    f"{name} = {order} is not allowed: a grid that holds shapes of degree"
                    f" {self.degree} has an order >= {self.degree}"
                )
        return self

    @property
    def sizes(self) -> Sizes:
        """The degree and all sizes, those that are not given as they follow from it.

        Raises:
            CaseError: if the degree is not given.
        """
        degree = self.degree
        if degree is None:
            raise CaseError(
                "degree is not given, so neither are the sizes that follow from it: give the case"
                f" one ({LEAST_DEGREE} to {LARGEST_DEGREE}), or take the train of a result"
            )
        usual = {
            "energy_order": 3 * degree,
            "source_order": 2 * -(-5 * degree // 4),
            "target_order": degree + 2,
            "polar_radial": -(-7 * degree // 3),
            "polar_azimuthal": 2 * -(-7 * degree // 4),
        }
        given = {name: getattr(self, name) for name in usual}
        return Sizes(
            degree,
            **{name: usual[name] if size is None else size for name, size in given.items()},
            grading=self.grading,
        )
