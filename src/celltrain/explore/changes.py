"""What somebody did on the page, as a change of what is explored; and the controls after it."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, TypedDict

from celltrain.explore.address import View, view_of
from celltrain.explore.controls import MOST_CELLS, changed, controls, parsed
from celltrain.explore.opened import Opened
from celltrain.parameters import CaseError
from celltrain.parameters.train import Units


class Change(TypedDict, total=False):
    """What somebody did, any of these.

    Attributes:
        address: to open.
        place: of a study's case.
        units: as in a case file.
        infinite: whether the train is.
        places: of sliders, 0 to 1, by name.
        values: as written in fields, by name.
    """

    address: str
    place: str
    units: str
    infinite: bool
    places: dict[str, float]
    values: dict[str, str]


def view_after(view: View, change: Change, opened: Opened) -> View:
    """What is explored after a change.

    Raises:
        CaseError: for a value that is not allowed, in the words of the command line.
    """
    if "address" in change:
        view = view_of(change["address"], opened.view.train)
        if change["address"].strip("?") == "":
            view = opened.view
    if "place" in change and opened.study is not None:
        view = replace(view, train=opened.study.train(change["place"]))
    if "units" in change:
        units: Units = "SI" if change["units"] == "SI" else "dimensionless"
        view = replace(view, units=units)
    if "infinite" in change:
        view = replace(view, infinite=bool(change["infinite"]))
    given = {**_of_sliders(view, change.get("places", {})), **_of_fields(view, change)}
    return replace(view, train=changed(view.train, given, view.units)) if given else view


def control_panel(view: View) -> dict[str, object]:
    """The controls as they stand: for each its place, its value in words, its unit."""
    panel = []
    for control in controls(view.units):
        value = control.value(view.train, view.units)
        low, high = control.range(view.units)
        panel.append(
            {
                "name": control.name,
                "label": control.label,
                "unit": control.unit(view.units)[0],
                "place": control.place(value, view.units),
                "text": f"{value:.4g}",
                "least": f"{low:.3g}",
                "most": f"{high:.3g}",
            }
        )
    return {
        "sliders": panel,
        "cells": view.train.cells,
        "most_cells": MOST_CELLS,
        "infinite": view.infinite,
        "units": view.units,
    }


def _of_sliders(view: View, places: Mapping[str, float]) -> dict[str, object]:
    known = {each.name: each for each in controls(view.units)}
    found = {}
    for name, place in places.items():
        if name not in known:
            raise CaseError(f"unknown name {name!r}; allowed are: {', '.join(known)}")
        control = known[name]
        found[name] = control.at(min(max(float(place), 0.0), 1.0), view.units)
    return _in_units(view, found)


def _of_fields(view: View, change: Change) -> dict[str, object]:
    values = {
        name: parsed(name, str(text).strip().replace(",", "."))
        for name, text in change.get("values", {}).items()
    }
    return _in_units(view, values)


def _in_units(view: View, values: Mapping[str, Any]) -> dict[str, object]:
    """Values as shown, in r0, U and mu or in SI."""
    units = {each.name: each.unit(view.units)[1] for each in controls(view.units)}
    return {
        name: value if units.get(name, 1.0) == 1.0 else value * units[name]
        for name, value in values.items()
    }
