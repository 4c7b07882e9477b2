"""Whether cases of the map of growth rates have other steady trains: searches for them.

Kept as a small file; from nothing half an hour.
"""

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass

import capillary_trains as trains
from page import FOLDER, Page

from celltrain import Base, Train, steady
from celltrain.continuation import BranchSearch, search_trains
from celltrain.continuation.tries import BACK

FILE = FOLDER / "data" / "capillaries-searches.json"
#: Speeds, m/s. At 10 mm/s the known trains themselves take long to be found at these degrees.
SPEEDS = (1e-4, 1e-3)
PACKING = 0.25
#: From this diameter on (r0) most guesses fit.
WIDE = 2.0


@dataclass(frozen=True)
class Searched:
    """One case and what a search found beside its train.

    `back` are the guesses from which the flow came back to a train that was known, `alone` roots
    that are a train at the degree of the search only, `crossed` those that are the shape of no
    cell, `found` each further train's form, velocity and growth rate of axisymmetric disturbances.
    """

    diameter: float
    speed: float
    form: str
    cell_velocity: float
    degree: int
    search_degree: int
    guesses: int
    tries: int
    back: int
    alone: int
    crossed: int
    found: tuple[tuple[str, float, float], ...]


def searches(page: Page) -> list[Searched]:
    """All that is kept, or computed anew."""
    if FILE.is_file():
        return [Searched(**each) for each in json.loads(FILE.read_text())]
    done = []
    for each in _computed():
        done.append(each)
        found = "; ".join(f"{form}, U_c = {velocity:.4f}" for form, velocity, _ in each.found)
        page.log(f"D = {each.diameter:g}, {each.speed * 1e3:g} mm/s: found: {found or 'nothing'}")
    FILE.write_text("[\n" + ",\n".join(json.dumps(asdict(each)) for each in done) + "\n]\n")
    return done


def _computed() -> Iterator[Searched]:
    for speed in SPEEDS:
        known: Base | None = None
        for diameter in sorted(trains.MAP_DIAMETERS, reverse=True):
            known = steady(_case(diameter, speed), start=known)
            yield _told(diameter, speed, search_trains(known))


def _case(diameter: float, speed: float) -> Train:
    return Train.from_si(
        radius=trains.CELL_RADIUS,
        diameter=diameter * trains.CELL_RADIUS,
        mean_velocity=speed,
        packing=PACKING,
        cells=1,
        unusual=True,
    )


def _told(diameter: float, speed: float, search: BranchSearch) -> Searched:
    known = search.known
    return Searched(
        diameter=diameter,
        speed=speed,
        form=known.form,
        cell_velocity=known.cell_velocity,
        degree=known.train.degree,
        search_degree=search.degree,
        guesses=len({each.guess for each in search.tries}),
        tries=len(search.tries),
        back=sum(each.way == "flow" and each.outcome == BACK for each in search.tries),
        alone=search.alone,
        crossed=search.crossed,
        found=tuple(
            (each.base.form, each.base.cell_velocity, each.axisymmetric_rate)
            for each in search.found
        ),
    )


def section(page: Page) -> None:
    """What the searches found."""
    done = searches(page)
    page.heading("Other trains of the same case")
    page.table(
        (
            *("D, r0", "U, mm/s", "known", "U_c/U", "M"),
            *("search at", "guesses", "back by the flow", "tries", "of that degree alone"),
            *("no cell", "found"),
        ),
        [
            (
                f"{each.diameter:g}",
                f"{each.speed * 1e3:g}",
                each.form,
                f"{each.cell_velocity:.4f}",
                str(each.degree),
                str(each.search_degree),
                str(each.guesses),
                str(each.back),
                str(each.tries),
                str(each.alone),
                str(each.crossed),
                "; ".join(f"{form}, {velocity:.4f}" for form, velocity, _ in each.found) or "none",
            )
            for each in done
        ],
    )
    page.text(_words(done))


def _words(done: list[Searched]) -> str:
    wide = [each for each in done if each.diameter >= WIDE]
    tight = [each for each in done if each.diameter < WIDE]
    alone, crossed = (sum(getattr(each, name) for each in done) for name in ("alone", "crossed"))
    found = [each for each in done if each.found]
    outcome = (
        "No further train was found in any of them."
        if not found
        else f"Further trains were found in {len(found)} of {len(done)} cases."
    )
    return f"""
`celltrain search` at packing {PACKING:g}: from each of some twenty guesses (the cell at rest
squeezed and bent, a bullet, a bullet with a dimple, a parachute, the known train turned round, of
other packings, tubes and flows, and disturbed) along the train's own flow, and by Newton's method
with the known train taken out. {outcome} In tubes from {WIDE:g} r0 on the flow leads from
{_part(wide)} guesses to the known train, or to a root found before it, so the form that is reached
mostly does not hang on where it begins. Of narrower tubes that is not shown: there {_part(tight)}
guesses lead back, the others to no train. {alone} roots are trains at the degree of the search
only, which no train of a higher degree continues; {crossed} are shapes that cross themselves. Not
found is no proof: what these guesses tell is that the trains of this page are no choice among
several.
"""


def _part(done: list[Searched]) -> str:
    return f"{sum(each.back for each in done)} of {sum(each.guesses for each in done)}"
