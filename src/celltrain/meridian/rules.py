"""Sizes of the rules on a meridian, chosen from the shape, the tube and an accuracy.

The own surface's polar rule grows with the degree, and with the length of the cell; smooth sources
(images, tail, wall) need n points in theta where the nearest target or its image in the wall is at
the distance d, since Gauss-Legendre errs by about 30 exp(-2 n d/h), h = |dx/dtheta| there: each
place of the meridian asks with its own d and h. Uniform points around the axis at the radius r err
by exp(-2 n d/r) with n of them on half of the circle.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from celltrain.harmonics import Profile
from celltrain.meridian.grids import Meridian, meridian_grid

#: Relative error of the parts of the flow that is aimed at.
TOLERANCE = 1e-8
# Polar rule about a target, per degree: along alpha and around (the whole circle). At 12 of them
# blocks are right to 4e-6, at 5 and 6 per degree to 5e-8.
RADIAL, AROUND = 4.0, 5.0
# |dx/dtheta| of a cell (r0) that these serve; longer cells take more in proportion.
USUAL_STRETCH = 1.6
# Longitudes per colatitude of a product grid whose targets are far.
LONGITUDES = 1.6
# Images whose axial distance is below this are summed one by one.
NEAREST_IMAGE = 0.8
#: Most points of smooth sources along a meridian: where they are not enough nothing is computed.
MOST_SOURCES = 1200
# Points of a meridian among which distances are taken.
POINTS = 200


@dataclass(frozen=True)
class Rules:
    """Sizes of all rules for one shape.

    `targets`: colatitudes at which the velocity is evaluated; `radial`, `half_circle`: nodes of the
    polar rule; `sources`: colatitudes of smooth sources; `image_sources`, `image_half_circle`: of
    the nearest images, `nearest` of which are on each side; `tolerance` of tail and wall.
    """

    targets: int
    radial: int
    half_circle: int
    sources: int
    image_sources: int
    image_half_circle: int
    nearest: int
    tolerance: float

    @property
    def possible(self) -> bool:
        """Whether the cells are far enough apart, and from the wall, to be computed."""
        return max(self.sources, self.image_sources, self.image_half_circle) <= MOST_SOURCES

    @property
    def work(self) -> float:
        """What an evaluation takes, roughly, in nodes of the polar rule for each target.

        The wall's waves are about as many as the smooth sources.
        """
        images = 2 * self.nearest * self.image_sources * self.image_half_circle
        return float(self.radial * self.half_circle + images + self.sources**2)

    def covers(self, other: "Rules") -> bool:
        """Whether these rules serve where others are asked for, without being twice as fine."""
        return self.tolerance == other.tolerance and all(
            asked <= here <= 2 * asked
            for here, asked in (
                (self.targets, other.targets),
                (self.radial, other.radial),
                (self.half_circle, other.half_circle),
                (self.sources, other.sources),
                (self.image_sources, other.image_sources),
                (self.image_half_circle, other.image_half_circle),
                (self.nearest + 1, other.nearest + 1),
            )
        )

    def finer(self) -> "Rules":
        """More of everything but the degree, for an estimate of what the rules leave."""
        return replace(
            self,
            targets=math.ceil(1.75 * self.targets),
            radial=math.ceil(1.25 * self.radial),
            half_circle=math.ceil(1.25 * self.half_circle),
            sources=math.ceil(1.25 * self.sources),
            image_sources=math.ceil(1.25 * self.image_sources),
            image_half_circle=math.ceil(1.25 * self.image_half_circle),
            tolerance=max(0.1 * self.tolerance, 1e-13),
        )


def choose_rules(
    profile: Profile,
    *,
    period: float,
    radius: float,
    targets: int,
    tolerance: float = TOLERANCE,
    radial: int | None = None,
    around: int | None = None,
) -> Rules:
    """The rules for a shape.

    **Arguments:** `period`, `radius` of the tube, r0; `targets`: their number; `radial` and
    `around`: the polar rule's nodes, instead of what the degree and the shape ask for.
    """
    degree = profile.shape[1]
    grid = meridian_grid(degree, POINTS)
    tables = grid.tables(1)
    z, rho = grid.places(profile)
    stretch = np.hypot(profile[0] @ tables.slope[0], profile[1] @ tables.slope[1])
    digits = math.log(30.0 / tolerance)
    # In steps, so that shapes that differ by little share their rules and tables.
    longer = max(1.0, math.ceil(4.0 * float(stretch.max()) / USUAL_STRETCH) / 4.0)
    finer = math.log(1.0 / tolerance) / math.log(1.0 / TOLERANCE)

    def points(length: Meridian, distance: Meridian | float) -> int:
        """Points for sources of a length for each radian with targets at a distance."""
        with np.errstate(divide="ignore", invalid="ignore"):
            wanted = 0.5 * digits * float(np.max(length / distance))
        # More than can be had is as good as any number, and so is none.
        return min(_rung(wanted), MOST_SOURCES + 1) if wanted < MOST_SOURCES else MOST_SOURCES + 1

    nearest = 0
    length = float(z.max() - z.min())
    while (nearest + 1) * period - length < NEAREST_IMAGE:
        nearest += 1
    least = max(math.ceil(2.5 * degree), 12)
    beside = radius - rho
    mirrored = beside + beside.min() if beside.min() > 0.0 else np.zeros_like(beside)
    image = np.full_like(z, math.inf)
    for shift in (period, -period):
        across = (rho - rho[:, None]) ** 2 + (z + shift - z[:, None]) ** 2
        image = np.minimum(image, np.sqrt(across.min(axis=0)))
    image_sources = max(least, points(stretch, image))
    return Rules(
        targets=targets,
        radial=math.ceil(RADIAL * degree * longer * finer) if radial is None else radial,
        half_circle=math.ceil(0.5 * (AROUND * degree * longer * finer))
        if around is None
        else around // 2,
        sources=max(least, points(stretch, mirrored), points(stretch, NEAREST_IMAGE)),
        image_sources=image_sources,
        image_half_circle=max(math.ceil(0.5 * LONGITUDES * least), points(rho, image)),
        nearest=nearest,
        tolerance=tolerance,
    )


def _rung(number: float) -> int:
    """The next of a ladder of sizes, of which each is an eighth larger than the one before."""
    rung = math.ceil(math.log(max(number, 1.0)) / math.log(1.125))
    return math.ceil(1.125**rung)
