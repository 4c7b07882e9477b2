"""How a breakup ends: whether the disorder lasts, and what the films' model has to do with it.

The fastest mode's simulation is kept here thinned, as a file of its own from which anybody can go
on. From its state at t = 970 r0/U the flow is computed again with films of other ranges and
strengths.
"""

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from breakup_runs import (
    DENSE,
    EVERY,
    FOLDER,
    PAPER_TIMES,
    distances_ahead,
    first_time,
    load,
    order_measures,
)
from page import Page

from celltrain import Base, CaseError, Run, Stability, evolve, resume
from celltrain.cli.progress import Reporter
from celltrain.evolution import Disturbance, Repulsion
from celltrain.evolution.record.recompute import pressure_drops
from celltrain.harmonics import Shapes
from celltrain.proximity.film_points import film_grid
from celltrain.results import save

STATES = FOLDER / "data" / "breakup-leading.nc"
FILE = FOLDER / "data" / "breakup-ends.json"
# Frames of the leading simulation that are kept: these, and at the paper's times.
KEPT_EVERY = 50.0
BEGIN, END = PAPER_TIMES[3], PAPER_TIMES[-1]
# Over how long flows are compared, r0/U: their last part.
LAST_PART = 140.0
FILMS: dict[str, Repulsion] = {
    "range-half": Repulsion(range=0.0125),
    "range-double": Repulsion(range=0.05),
    "strength-tenth": Repulsion(strength=0.01),
    "strength-tenfold": Repulsion(strength=1.0),
}


@dataclass(frozen=True)
class Statistics:
    """A flow between two times: means over its frames and cells, and deviations from these.

    Lengths in periods or r0, velocities in U, angles in degrees; pressure drops are relative to
    plasma's, beyond it.
    """

    begin: float
    end: float
    cell_velocity: float
    velocity_along: float
    velocity_across: float
    spacing: float
    radial: float
    inclination: float
    pressure_drop: float
    pressure_drop_deviation: float


@dataclass(frozen=True)
class End:
    """How one simulation from t = 970 r0/U ended; times from the beginning of the leading one."""

    range: float
    strength: float
    reached: float
    out_of_order: float | None
    thinnest: float
    energy_share: float
    last: Statistics


@dataclass(frozen=True)
class FromLeading(Disturbance):
    """The state of the leading simulation at t = 970 r0/U."""

    def __str__(self) -> str:
        return f"that of the fastest mode at t = {BEGIN:g} r0/U"

    def shapes(self, start: Base | Stability) -> Shapes:
        """The change of the shapes, r0."""
        del start
        run = Run.load(STATES)
        return np.asarray(run.disturbances[int(np.abs(run.times - BEGIN).argmin())])


def simulate_films(name: str, path: Path) -> None:
    """Run the simulation with one of the films, or go on with its file."""
    until = END - BEGIN
    with Reporter() as progress:
        if path.exists():
            run = Run.load(path)
            if (run.repulsion, run.disturbance) != (FILMS[name], str(FromLeading())):
                raise CaseError(
                    f"{str(path)!r} is not allowed as {name!r}: it is another simulation"
                )
            resume(path, until=until, progress=progress.step)
            return
        path.parent.mkdir(parents=True, exist_ok=True)
        evolve(
            Run.load(STATES).base,
            FromLeading(),
            until=until,
            every=EVERY,
            repulsion=FILMS[name],
            path=path,
            progress=progress.step,
        )


def keep_states(path: Path) -> None:
    """Keep the leading simulation thinned, without its linear dynamics and its history."""
    run = load("leading", path)
    wanted = np.concatenate([np.arange(0.0, run.times[-1], KEPT_EVERY), PAPER_TIMES])
    chosen = sorted({int(np.abs(run.times - time).argmin()) for time in (*wanted, run.times[-1])})
    steps = [0, len(run.history["time"]) - 1]
    thinned = replace(
        run,
        start=run.base,
        history={name: column[steps] for name, column in run.history.items()},
        times=run.times[chosen],
        shapes=run.shapes[chosen],
        frames={name: column[chosen] for name, column in run.frames.items()},
    )
    save(thinned, STATES)


def statistics(run: Run, begin: float, end: float, offset: float = 0.0) -> Statistics:
    """The flow between two times, that of the run's beginning being `offset`."""
    times = run.times + offset
    within = (times >= begin) & (times <= end)
    part = replace(
        run,
        times=run.times[within],
        shapes=run.shapes[within],
        frames={name: column[within] for name, column in run.frames.items()},
    )
    velocity = part.frames["centroid_velocity"]
    along = velocity[..., 2] - velocity[..., 2].mean(axis=1, keepdims=True)
    drops = pressure_drops(part) - 1.0
    train = run.train
    measures = order_measures(part)
    return Statistics(
        begin=begin,
        end=end,
        cell_velocity=float(velocity[..., 2].mean()),
        velocity_along=float(np.sqrt(np.mean(along**2))),
        velocity_across=float(np.sqrt(np.mean(np.sum(velocity[..., :2] ** 2, axis=-1)))),
        spacing=float(np.std(distances_ahead(part) / train.period)),
        radial=float(np.sqrt(np.mean(measures["radial"] ** 2))),
        inclination=float(measures["inclination"].mean()),
        pressure_drop=float(drops.mean()),
        pressure_drop_deviation=float(drops.std()),
    )


def collected(folder: Path, page: Page) -> dict[str, Any]:
    """All that the page says of the ends: from simulations that are there, or as it was kept."""
    content: dict[str, Any] = json.loads(FILE.read_text()) if FILE.exists() else {}
    leading = folder / "leading.nc"
    if leading.exists():
        run = load("leading", leading)
        keep_states(leading)
        content["disorder"] = [asdict(each) for each in _parts(run)]
        content["leading"] = asdict(_end(run, 0.0))
        content["own_sides"] = _own_sides(run)
        page.log("disorder: statistics of the leading simulation")
    for name in FILMS:
        path = folder / f"{name}.nc"
        if path.exists():
            content[name] = asdict(_end(Run.load(path), BEGIN))
            page.log(f"films: {name}")
    if content:
        FILE.write_text(json.dumps(content, indent=1) + "\n")
    return content


def _parts(run: Run) -> Iterator[Statistics]:
    """The train as it was disturbed, then its flow in two halves from when it was out of order."""
    last, lost = float(run.times[-1]), _out_of_order(run)
    yield statistics(run, 0.0, EVERY)
    if lost is not None and last >= lost + 4.0 * EVERY:
        middle = 0.5 * (lost + last)
        yield statistics(run, lost, middle)
        yield statistics(run, middle, last)


def _out_of_order(run: Run) -> float | None:
    """When the order was lost, in the run's own time, if it was."""
    return first_time(run.times, order_measures(run)["spacing"] > 0.5)


def _own_sides(run: Run) -> dict[str, float | None]:
    """When two parts of one membrane first were in a film, and how close they came, in r0."""
    grid = film_grid(run.train.degree)
    least = []
    for shapes in run.shapes:
        found = grid.own_sides.find(
            shapes, grid.coarse.surfaces(shapes), within=run.repulsion.range
        )
        least.append(min((float(sides.gap.min()) for _, sides in found), default=np.inf))
    within = np.isfinite(least)
    return {
        "since": float(run.times[within][0]) if within.any() else None,
        "least": float(np.min(least)) if within.any() else None,
        "share": float(within[np.argmax(within) :].mean()) if within.any() else None,
    }


def _end(run: Run, offset: float) -> End:
    times, history = run.times + offset, run.history
    reached = float(min(times[-1], END))
    early = history["time"] + offset <= END
    lost = _out_of_order(run)
    return End(
        range=run.repulsion.range,
        strength=run.repulsion.strength,
        reached=reached,
        out_of_order=None if lost is None or lost + offset > END else lost + offset,
        thinnest=float(history["gap"][early].min()),
        energy_share=float((history["film_energy"] / history["energy"])[early].max()),
        last=statistics(run, reached - LAST_PART, reached, offset),
    )


def ends_section(page: Page, folder: Path) -> None:
    """Both sections, as far as there is something to say."""
    content = collected(folder, page)
    if "disorder" in content:
        page.heading("The disorder")
        _disorder(page, [Statistics(**each) for each in content["disorder"]])
        sides = content.get("own_sides", {})
        if sides.get("since") is not None:
            page.text(
                f"""
From t = {sides["since"]:.0f} r0/U on there are cells so thin somewhere that two parts of their
membrane are within the repulsion's range, in {sides["share"]:.0%} of the frames since; the closest
are {sides["least"]:.4f} r0 apart. The repulsion alone keeps them from crossing: what comes later
hangs on it, and on M = {DENSE.degree}.
"""
            )
    ends = {
        name: End(**{**content[name], "last": Statistics(**content[name]["last"])})
        for name in ("leading", *FILMS)
        if name in content
    }
    if len(ends) > 1:
        page.heading("What the films have to do with the end")
        _films(page, ends)


def _disorder(page: Page, parts: list[Statistics]) -> None:
    page.table(
        (
            *("t, r0/U", "mean velocity of cells, U", "deviations along, U", "across, U"),
            *("deviation of the spacing, periods", "off the axis, r0", "inclination, degrees"),
            "pressure drop beyond plasma's, %",
        ),
        [(f"{each.begin:.0f} to {each.end:.0f}", *_numbers(each)) for each in parts],
    )
    page.text(
        f"""
The leading simulation: the train as it was disturbed, then its flow in two halves from when it was
out of order, as far as it was followed. Root mean squares over cells and frames, the pressure drop
with its standard deviation in time. Its states every {KEPT_EVERY:g} r0/U and its last one are in
`docs/validation/data/{STATES.name}`, a simulation's file without the steps: `celltrain evolve
--resume` goes on with it.
"""
    )


def _films(page: Page, ends: dict[str, End]) -> None:
    page.table(
        (
            *("range, r0", "strength, mu U", "until", "out of order at", "thinnest film, r0"),
            *("largest energy of films", "mean velocity of cells, U", "deviations along, U"),
            *("across, U", "deviation of the spacing, periods", "off the axis, r0"),
            *("inclination, degrees", "pressure drop beyond plasma's, %"),
        ),
        [
            (
                *(f"{each.range:g}", f"{each.strength:g}", f"{each.reached:.0f}"),
                "in order" if each.out_of_order is None else f"{each.out_of_order:.0f}",
                *(f"{each.thinnest:.4f}", f"{each.energy_share:.1e}"),
                *_numbers(each.last),
            )
            for each in ends.values()
        ],
    )
    lost = [each.out_of_order for each in ends.values() if each.out_of_order is not None]
    missing = ", ".join(name for name in FILMS if name not in ends)
    page.text(
        f"""
Of these {len(ends)} simulations {len(lost)} are out of order at the end{_between(lost)}.
{f"Not computed: {missing}." if missing else ""}
"""
    )
    page.text(
        f"""
From the state at t = {BEGIN:.0f} r0/U, where no film is within {Repulsion().range:g} r0 yet, until
{END:.0f}: the leading simulation, whose films are the default ones, and with one number of them
changed. The columns from the mean velocity on are of the last {LAST_PART:.0f} r0/U. "Largest
energy of films": over that of the membranes.
"""
    )


def _between(times: list[float]) -> str:
    return f", since t = {min(times):.0f} to {max(times):.0f} r0/U" if times else ""


def _numbers(each: Statistics) -> tuple[str, ...]:
    return (
        f"{each.cell_velocity:.4f}",
        f"{each.velocity_along:.4f}",
        f"{each.velocity_across:.4f}",
        f"{each.spacing:.3f}",
        f"{each.radial:.3f}",
        f"{each.inclination:.1f}",
        f"{100.0 * each.pressure_drop:.3f} ({100.0 * each.pressure_drop_deviation:.3f})",
    )
