"""Where the two sides of a cell's skirt meet: why fast flow has no trains in the narrowest tubes.

Branches of trains along the speed in one tube, and along the diameter at one speed, followed until
two sides of the membrane are closer than the rules resolve. Kept as a small file; from nothing
fifteen minutes of one core.
"""

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass

import capillary_trains as trains
import numpy as np
from page import FOLDER, Page

from celltrain import Base, Train, steady
from celltrain.continuation.arclength import CurveLost
from celltrain.continuation.branch import follow_branch
from celltrain.harmonics import Profile
from celltrain.meridian.geometry import meridian_points
from celltrain.steady.parameters import parameter_value

FILE = FOLDER / "data" / "capillaries-sides.json"
PACKING = 0.25
#: Points of the meridian, and how opposed the normals of two sides are (the cosine, at most).
POINTS, OPPOSED = 1201, -0.8
#: Distance of the sides, r0, below which a branch is not followed, and distances that are shown.
LEAST = 0.01
SHOWN = (0.1, 0.05, 0.03, 0.02, LEAST)


@dataclass(frozen=True)
class Way:
    """A branch: along what, from and to which tube (r0) and speed (m/s), at which resolution."""

    parameter: str
    diameters: tuple[float, float]
    speeds: tuple[float, float]
    degree: int
    grading: float


WAYS = (
    Way("capillary_number", (2.0, 2.0), (1e-3, 1e-2), 24, 1.0),
    Way("capillary_number", (2.0, 2.0), (1e-3, 1e-2), 36, 1.0),
    Way("diameter", (3.0, 2.0), (1e-2, 1e-2), 24, 0.5),
    Way("diameter", (3.0, 2.0), (1e-2, 1e-2), 32, 0.5),
)
#: Speeds, m/s, on the way to the first train of a branch.
SPEEDS = (1e-3, 2e-3, 4e-3, 7e-3, 1e-2)


@dataclass(frozen=True)
class Point:
    """One train of a branch; lengths in r0, the speed in m/s."""

    diameter: float
    speed: float
    sides: float
    film: float
    cell_velocity: float
    viscosity: float
    truncation_error: float


@dataclass(frozen=True)
class Followed:
    """The trains of a branch, and how it ended."""

    points: tuple[Point, ...]
    ending: str


def sides_apart(profile: Profile) -> float:
    """Least distance of two parts of the meridian whose normals are opposed, in r0."""
    place = np.stack(meridian_points(profile, POINTS), axis=-1)
    along = np.gradient(place, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    distance = np.linalg.norm(place[:, None] - place[None], axis=-1)
    return float(distance[along @ along.T < OPPOSED].min(initial=np.inf))


def _case(way: Way, diameter: float, speed: float) -> Train:
    return Train.from_si(
        radius=trains.CELL_RADIUS,
        diameter=diameter * trains.CELL_RADIUS,
        mean_velocity=speed,
        packing=PACKING,
        cells=trains.CELLS,
        degree=way.degree,
        grading=way.grading,
    )


def _follow(way: Way, page: Page) -> Followed:
    start: Base | None = None
    for speed in (each for each in SPEEDS if each <= way.speeds[0]):
        start = steady(_case(way, way.diameters[0], speed), start=start, estimate_error=False)
    assert start is not None
    end = parameter_value(_case(way, way.diameters[1], way.speeds[1]), way.parameter)
    first = parameter_value(start.train, way.parameter)
    points = list[Point]()
    try:
        for found in follow_branch(start, way.parameter, to=end):
            base, share = found.base, found.value / first
            faster = way.parameter == "capillary_number"
            point = Point(
                diameter=base.train.tube.diameter,
                speed=way.speeds[0] * (share if faster else 1.0),
                sides=sides_apart(base.profile),
                film=base.train.radius - base.largest_radius,
                cell_velocity=base.cell_velocity,
                viscosity=base.effective_viscosity,
                truncation_error=base.truncation_error,
            )
            points.append(point)
            page.log(f"{way.parameter} M = {way.degree}: {point}")
            if point.sides < LEAST:
                return Followed(tuple(points), f"the sides are within {LEAST:g} r0")
    except CurveLost as lost:
        return Followed(tuple(points), str(lost))
    return Followed(tuple(points), "the end is reached")


def compute(page: Page) -> tuple[Followed, ...]:
    """All branches, from the file where it has them."""
    kept = json.loads(FILE.read_text()) if FILE.exists() else []
    for way in WAYS[len(kept) :]:
        kept.append(asdict(_follow(way, page)))
        FILE.write_text(json.dumps(kept, indent=0) + "\n")
    return tuple(
        Followed(tuple(Point(**each) for each in one["points"]), one["ending"]) for one in kept
    )


def _rows(way: Way, followed: Followed) -> Iterator[tuple[object, ...]]:
    """The first train, the first ones closer than each distance shown, and the last."""
    points = followed.points
    chosen = {0, len(points) - 1}
    for distance in SHOWN:
        closer = [place for place, each in enumerate(points) if each.sides < distance]
        chosen.update(closer[:1])
    for place in sorted(chosen):
        at = points[place]
        yield (
            way.degree,
            f"{at.diameter:.3f}",
            f"{at.speed * 1e3:.3f}",
            f"{at.sides:.4f}",
            f"{at.film:.4f}",
            f"{at.cell_velocity:.4f}",
            f"{at.viscosity:.4f}",
            f"{at.truncation_error:.0e}",
        )


def section(page: Page) -> None:
    """The section of the page."""
    page.heading("The fastest flow in the narrowest tubes")
    found = compute(page)
    page.table(
        ("M", "D, r0", "U, mm/s", "sides, r0", "film, r0", "U_c/U", "viscosity", "left out, U"),
        [row for way, one in zip(WAYS, found, strict=True) for row in _rows(way, one)],
    )
    endings = "; ".join(
        f"M = {way.degree}, {'U' if way.parameter == 'capillary_number' else 'D'}: {one.ending}"
        for way, one in zip(WAYS, found, strict=True)
    )
    page.text(
        f"""
Packing {PACKING:g}; two branches along the speed in a tube of {WAYS[0].diameters[0]:g} r0, two
along the diameter at {WAYS[-1].speeds[0] * 1e3:g} mm/s. *Sides* is the least distance of two parts
of the membrane that face each other. The faster the flow for the tube, the thinner the neck between
a cell's body and the bead around its rear, until the two sides of the membrane there meet: before
the flow of {max(trains.MAP_SPEEDS) * 1e3:g} mm/s is reached at D = {WAYS[0].diameters[0]:g}, and
before that tube is reached at this speed. Nothing keeps them apart in a steady train, and the rules
know only films between cells and at the wall, so what a branch does where the sides are closer than
some 0.03 r0 is not resolved. How the branches ended: {endings}.
"""
    )
