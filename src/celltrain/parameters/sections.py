"""The physical sections of a case: tube, cell and flow. All lengths in r0, moduli in mu U."""

from typing import Literal, Self

from pydantic import Field, model_validator

from celltrain.parameters.errors import CaseError
from celltrain.parameters.profile import Profile
from celltrain.parameters.scales import Scales
from celltrain.parameters.section import Real, Section
from celltrain.parameters.units import BENDING_MODULUS, DILATATION_MODULUS, SHEAR_MODULUS

_SCALES = Scales()


class Tube(Section):
    """A straight round tube."""

    diameter: Real = Field(gt=0, le=100, description="diameter of the tube, r0")


class Cell(Section):
    """Mechanics and resting shape of a cell; the defaults are a red blood cell's.

    The moduli are Es = 4.2e-6 N/m, Ed = 67.7e-6 N/m and Eb = 1.8e-19 N m at the reference scales.

    r0 is the radius of the sphere of the *healthy* cell's volume whatever the shape: only
    "biconcave", "sphere" and "spheroid" have the volume 4 pi/3. With `reduced_volume` v the healthy
    cell's area is kept, and the volume is v times that of the sphere of this area; a `profile` is
    taken as it is.
    """

    shear_modulus: Real = Field(
        default=_SCALES.dimensionless("shear_modulus", SHEAR_MODULUS),
        gt=0,
        description="shear modulus Es of the membrane, mu U",
    )
    dilatation_modulus: Real = Field(
        default=_SCALES.dimensionless("dilatation_modulus", DILATATION_MODULUS),
        gt=0,
        description="dilatation modulus Ed of the membrane, mu U",
    )
    bending_modulus: Real = Field(
        default=_SCALES.dimensionless("bending_modulus", BENDING_MODULUS),
        ge=0,
        description="bending modulus Eb of the membrane, mu U r0^2",
    )
    law: Literal["skalak", "neo_hookean"] = Field(
        default="skalak", description="constitutive law of the membrane"
    )
    bending: Literal["elastic", "helfrich", "moments", "balanced_moments"] = Field(
        default="elastic",
        description="bending: energy about the shape at rest, energy of a fluid membrane, moments"
        " about the shape at rest as the paper's solver has them (no energy), or the same moments"
        " balanced also about the normal",
    )
    spontaneous_curvature: Real = Field(
        default=0.0,
        description="curvature c0 that a helfrich membrane prefers, positive for a sphere, 1/r0",
    )
    reference: Literal["biconcave", "sphere", "spheroid", "profile"] = Field(
        default="biconcave", description="shape of the cell at rest"
    )
    reduced_volume: Real | None = Field(
        default=None,
        ge=0.4,
        le=1,
        description="reduced volume of the biconcave cell, deflated or inflated at constant area;"
        " the healthy cell's own, 0.6444, unless given",
    )
    aspect_ratio: Real | None = Field(
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


class Flow(Section):
    """The flow through the tube; its mean velocity and plasma viscosity are the units."""

    viscosity_ratio: Real = Field(
        default=1.0, gt=0, description="viscosity inside the cells over that of the plasma"
    )
