"""What is computed for the page: a coarse answer at once, and the converged one when it rests.

The coarse answer follows the nearest steady train that is known; the converged one starts from
rest, and is what the command line gives. A computation that nobody waits for any more is given up
at its next step.
"""

import math
import threading
import time
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Generic, TypeAlias, TypeVar

import numpy as np

from celltrain.explore.address import USUAL, View
from celltrain.explore.controls import HEALTHY
from celltrain.explore.curves import GrowthCurves, growth_curves
from celltrain.parameters import CaseError, Train
from celltrain.parameters.strength import MODULI
from celltrain.stability import NUMBERS, InfiniteTrain, Stability, infinite_train, stability
from celltrain.steady import Base, NotConverged, steady

#: Degree of the answers at once.
COARSE = 12
#: Seconds without a change after which the converged answer is computed.
REST = 0.4
#: Phases of the coarse curves, and the last time of G(t), r0/U.
COARSE_PHASES, UNTIL = 7, 10.0
# Steady trains to start from, and results that are kept for curves, modes and files.
_BASES, _RESULTS = 32, 3
# Leaves by which trains are near or far, relative changes of all of them counting alike.
_NEAR = ("diameter", "packing", "viscosity_ratio", "reduced_volume", *MODULI)


class Superseded(Exception):
    """Something else was asked for meanwhile."""


@dataclass(frozen=True)
class Picture:
    """What is known of a case: its linear dynamics, coarse or converged."""

    view: View
    converged: bool
    result: Stability | InfiniteTrain

    @property
    def base(self) -> Base:
        """The steady train."""
        return self.result.base


@dataclass(frozen=True)
class Curves:
    """What else is drawn of a case: alpha(q) of the infinite train, and G(t) of a finite one."""

    picture: Picture
    waves: InfiniteTrain
    growth: GrowthCurves | None

    @property
    def alpha(self) -> float:
        """The largest growth rate of the picture's own train, U/r0."""
        result = self.picture.result
        if isinstance(result, Stability):
            return result.spectral_abscissa
        return result.most_unstable.growth_rate


# A case, whatever its units, and whether it is converged.
_Key: TypeAlias = tuple[View, bool]
_Result = TypeVar("_Result")


class _Place(Generic[_Result]):
    """Where a result is, or will be once the one who computes it has it."""

    def __init__(self) -> None:
        self.computing = threading.Lock()
        self.result: _Result | None = None


class _Kept(Generic[_Result]):
    """The results that were asked for last; several threads that ask for the same wait for one."""

    def __init__(self) -> None:
        self._changing = threading.Lock()
        self._places: OrderedDict[_Key, _Place[_Result]] = OrderedDict()

    def known(self, key: _Key) -> _Result | None:
        """What there is already."""
        with self._changing:
            place = self._places.get(key)
            if place is not None:
                self._places.move_to_end(key)
        return None if place is None else place.result

    def get(self, key: _Key, compute: Callable[[], _Result]) -> _Result:
        """The result, computed if it is not there; what `compute` raises is raised."""
        with self._changing:
            place = self._places.setdefault(key, _Place())
        with place.computing:
            if place.result is None:
                try:
                    place.result = compute()
                finally:
                    self._put(key, place)
            return place.result

    def _put(self, key: _Key, place: _Place[_Result]) -> None:
        """Keep a place with a result as the newest one; drop what has none."""
        with self._changing:
            self._places.pop(key, None)
            if place.result is not None:
                self._places[key] = place
            while len(self._places) > _RESULTS:
                self._places.popitem(last=False)


class Engine:
    """Computes for the pages of one process; `start` is a steady train that is known already."""

    def __init__(self, start: Base | None = None) -> None:
        self._computing = threading.Lock()
        self._changed = threading.Condition()
        self._newest: OrderedDict[str, int] = OrderedDict()
        self._bases: list[Base] = [] if start is None else [start]
        self._pictures: _Kept[Picture] = _Kept()
        self._curves: _Kept[Curves] = _Kept()

    def warm_up(self, view: View | None = None) -> None:
        """Load what is compiled, and the first picture: the page then answers at once."""
        try:
            self.curves(self.coarse(view or View(USUAL)), _never)
        except (CaseError, NotConverged):
            if view is not None:
                self.warm_up()

    def ask(self, page: str) -> int:
        """A number for something new that a page asks for; what it asked before is given up."""
        with self._changed:
            self._newest[page] = self._newest.pop(page, 0) + 1
            while len(self._newest) > 100:
                self._newest.popitem(last=False)
            self._changed.notify_all()
            return self._newest[page]

    def coarse(self, view: View, check: Callable[[], None] = lambda: None) -> Picture:
        """The case at a low degree and for m = 0 to 3; `check` may raise.

        Raises:
            CaseError, NotConverged: if there is no steady train.
        """
        known = self._known(view, False) or self._known(view, True)
        if known is not None:
            return known
        degree = min(view.train.resolution.degree or COARSE, COARSE)
        train = view.train.changed(degree=degree)

        def compute() -> Picture:
            with self._computing:
                base = self._near(train, check)
                result: Stability | InfiniteTrain
                if view.infinite:
                    phases = np.linspace(0.0, np.pi, COARSE_PHASES)
                    result = infinite_train(base, phases=phases, estimate_error=False, search=False)
                else:
                    result = stability(base, azimuthal_numbers=NUMBERS, estimate_error=False)
            return Picture(view, False, result)

        return replace(self._pictures.get(_key(view, False), compute), view=view)

    def converged(self, view: View, check: Callable[[], None]) -> Picture:
        """The case as the command line computes it; `check` may raise.

        Raises:
            CaseError, NotConverged: if there is no steady train.
        """

        def look(*_: object) -> None:
            check()

        def compute() -> Picture:
            of_kind = infinite_train if view.infinite else stability
            return Picture(
                view, True, of_kind(view.train, progress=look, iteration=look, tell=look)
            )

        return replace(self._pictures.get(_key(view, True), compute), view=view)

    def curves(self, picture: Picture, check: Callable[[], None]) -> Curves:
        """What else is drawn of a picture, as coarse or exact as it is."""
        result = picture.result

        def look(*_: object) -> None:
            check()

        if isinstance(result, InfiniteTrain):
            return Curves(picture, result, None)

        def compute() -> Curves:
            waves = infinite_train(
                result.base,
                phases=None if picture.converged else np.linspace(0.0, np.pi, COARSE_PHASES),
                estimate_error=False,
                search=picture.converged,
                progress=look,
                tell=look,
            )
            check()
            growth = growth_curves(result, until=UNTIL, check=check, fine=picture.converged)
            return Curves(picture, waves, growth)

        found = self._curves.get(_key(picture.view, picture.converged), compute)
        return replace(found, picture=picture)

    def check(self, page: str, number: int) -> Callable[[], None]:
        """Raises `Superseded` once the page has asked for something else."""

        def check() -> None:
            if self._newest.get(page) != number:
                raise Superseded

        return check

    def rest(self, page: str, number: int) -> None:
        """Wait until a page has rested.

        Raises:
            Superseded: if it asks for something else meanwhile.
        """
        end = time.monotonic() + REST
        with self._changed:
            while (left := end - time.monotonic()) > 0.0 and self._newest.get(page) == number:
                self._changed.wait(left)
        self.check(page, number)()

    def latest(self, view: View) -> Picture:
        """The best that is known of a case; computed if there is nothing.

        Raises:
            CaseError, NotConverged: if there is no steady train.
        """
        return self._known(view, True) or self.coarse(view)

    def _near(self, train: Train, check: Callable[[], None]) -> Base:
        """The steady train, followed from the nearest one that is known, or else from rest."""

        def look(*_: object) -> None:
            check()

        alike = [each for each in self._bases if _kind(each.train) == _kind(train)]
        base = None
        if alike:
            nearest = min(alike, key=lambda each: _distance(each.train, train))
            try:
                base = steady(train, start=nearest, estimate_error=False, progress=look)
            except NotConverged:
                base = None
        if base is None:
            base = steady(train, estimate_error=False, progress=look)
        self._bases = [*self._bases[1 - _BASES :], base]
        return base

    def _known(self, view: View, converged: bool) -> Picture | None:
        found = self._pictures.known(_key(view, converged))
        return None if found is None else replace(found, view=view)


def _key(view: View, converged: bool) -> _Key:
    # Units are nothing to compute by.
    return replace(view, units="dimensionless"), converged


def _never() -> None: ...


def _kind(train: Train) -> tuple[object, ...]:
    """What two trains must have in common for one to be followed to the other."""
    numbers = {*_NEAR, "cells"}
    return tuple(value for name, value in train.leaves().items() if name not in numbers)


def _distance(one: Train, other: Train) -> float:
    """How far trains are from each other, by the relative changes of their numbers."""

    def number(train: Train, name: str) -> float:
        value = train.leaf(name)
        return value if isinstance(value, float) and value else HEALTHY

    pairs = ((number(one, name), number(other, name)) for name in _NEAR)
    return math.fsum(((a - b) / (a + b)) ** 2 for a, b in pairs)
