"""The physical sections of a case: tube, cell, train and flow.

A field says here, and only here, what it is measured in, how formulas call it and what it allows
(see `dimension`). In r0, U and mu; defaults with a dimension are given in SI at the reference
scales, and are the same in SI at any other scales.
"""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from celltrain.laws import BENDINGS, LAWS
from celltrain.parameters.dimension import (
    BENDING_MODULUS,
    CURVATURE,
    LENGTH,
    NUMBER,
    SURFACE_MODULUS,
    Symbol,
)
from celltrain.parameters.errors import CaseError
from celltrain.parameters.fields import Choice
from celltrain.parameters.profile import Profile
from celltrain.parameters.scales import REFERENCE
from celltrain.parameters.section import Real, Section, Whole


class Tube(Section):
    """A straight round tube."""

    diameter: Annotated[Real, LENGTH, Symbol("D")] = Field(
        gt=0, le=100, description="diameter of the tube"
    )


class Cell(Section):
    """Mechanics and resting shape of a cell; the defaults are a red blood cell's.

    The moduli are Es = 4.2e-6 N/m, Ed = 67.7e-6 N/m and Eb = 1.8e-19 N m at the reference scales.

    r0 is the radius of the sphere of the *healthy* cell's volume whatever the shape: only
    "biconcave", "sphere" and "spheroid" have the volume 4 pi/3. With `reduced_volume` v the healthy
    cell's area is kept, and the volume is v times that of the sphere of this area; a `profile` is
    taken as it is.
    """

    shear_modulus: Annotated[Real, SURFACE_MODULUS, Symbol("E_s")] = Field(
        default=REFERENCE.dimensionless(SURFACE_MODULUS, 4.2e-6),
        gt=0,
        description="shear modulus Es of the membrane",
    )
    dilatation_modulus: Annotated[Real, SURFACE_MODULUS, Symbol("E_d")] = Field(
        default=REFERENCE.dimensionless(SURFACE_MODULUS, 67.7e-6),
        gt=0,
        description="dilatation modulus Ed of the membrane",
    )
    bending_modulus: Annotated[Real, BENDING_MODULUS, Symbol("E_b")] = Field(
        default=REFERENCE.dimensionless(BENDING_MODULUS, 1.8e-19),
        ge=0,
        description="bending modulus Eb of the membrane",
    )
    law: Annotated[str, Choice(LAWS)] = Field(
        default="skalak", description="constitutive law of the membrane"
    )
    bending: Annotated[str, Choice(BENDINGS)] = Field(
        default="elastic",
        description="bending: energy about the shape at rest, energy of a fluid membrane, moments"
        " about the shape at rest as the paper's solver has them (no energy), or the same moments"
        " balanced also about the normal",
    )
    spontaneous_curvature: Annotated[Real, CURVATURE, Symbol("c_0")] = Field(
        default=0.0,
        description="curvature c0 that a helfrich membrane prefers, positive for a sphere",
    )
    reference: Literal["biconcave", "sphere", "spheroid", "profile"] = Field(
        default="biconcave", description="shape of the cell at rest"
    )
    reduced_volume: Annotated[Real | None, NUMBER, Symbol("v")] = Field(
        default=None,
        ge=0.4,
        le=1,
        description="reduced volume of the biconcave cell, deflated or inflated at constant area;"
        " the healthy cell's own, 0.6444, unless given",
    )
    aspect_ratio: Annotated[Real | None, NUMBER] = Field(
        default=None,
        ge=0.2,
        le=5,
        description="length along the axis over diameter of a spheroid",
    )
    profile: Profile | None = Field(
        default=None,
        description="meridian of the shape at rest: a CSV file of points, distance from the axis"
        " and height, r0 also in SI",
    )

    @model_validator(mode="after")
    def _parameters_belong_to_the_shape(self) -> Self:
        owners = {"reduced_volume": "biconcave", "aspect_ratio": "spheroid", "profile": "profile"}
        for name, owner in owners.items():
            value = getattr(self, name)
            if value is not None and self.reference != owner:
                shown = "" if name == "profile" else f" = {value:g}"
                raise CaseError(
                    f"{name}{shown} is not allowed with reference = {self.reference!r}:"
                    f" allowed with reference = {owner!r}"
                )
            if value is None and self.reference == owner and owner != "biconcave":
                raise CaseError(f"reference = {owner!r} needs {name}, which is missing")
        if self.spontaneous_curvature != 0.0 and self.bending != "helfrich":
            raise CaseError(
                f"spontaneous_curvature = {self.spontaneous_curvature:g} is not allowed with"
                f" bending = {self.bending!r}: allowed with bending = 'helfrich'"
            )
        return self

    @property
    def capillary_number(self) -> float:
        """Ca = mu U/Es, with U the mean velocity in the tube (not the paper's; see units)."""
        return 1 / self.shear_modulus


class Spacing(Section):
    """How many cells there are, and how close; a case calls this section ``train``."""

    packing: Annotated[Real, NUMBER, Symbol(r"\phi")] = Field(
        gt=0, description="packing fraction phi = r0 N/L"
    )
    cells: Annotated[Whole, NUMBER, Symbol("N")] = Field(
        default=8, ge=1, le=10_000, description="number of cells N in the period of the train"
    )


class Flow(Section):
    """The flow through the tube; its mean velocity and plasma viscosity are the units."""

    viscosity_ratio: Annotated[Real, NUMBER, Symbol(r"\lambda")] = Field(
        default=1.0, gt=0, description="viscosity inside the cells over that of the plasma"
    )


class Strength(Section):
    """The strength of the flow: no field of a case, but a number that stands for several of them.

    A case to which it is given takes it by changing what depends on the velocity U: every field
    whose dimension has a power of U, and U itself among the scales. So the values in SI stay.
    """

    capillary_number: Annotated[Real, NUMBER, Symbol(r"\mathrm{Ca}")] = Field(
        gt=0,
        description="strength of the flow, Ca = mu U/Es, to which all moduli of the case are"
        " changed in proportion, in SI the mean velocity",
        json_schema_extra={"default": "as the shear modulus says"},
    )
