"""What is shown of a study, over axes or of distributions: figures, and the trains in them."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from celltrain.explore.figures import Figure
from celltrain.explore.maps import (
    Ring,
    first_place,
    place_of,
    ring_at,
    shown_numbers,
    study_figure,
    train_at,
    units_of,
)
from celltrain.explore.samples import (
    sample_figure,
    sample_figures,
    sample_note,
    sample_place,
    sample_ring,
    sample_train,
    sample_units,
)
from celltrain.parameters import CaseError, Train
from celltrain.parameters.train import Units
from celltrain.study import SampleResult, StudyResult


@dataclass(frozen=True, eq=False)
class Overview:
    """Figures of a study by their names; points of them are places, at each of which is a train.

    Attributes:
        names: of the figures, and how they are called.
        notes: what is seen in each.
        first: the train that is opened first.
        units: of the study, in which the train is shown as well.
        figure: a figure, by its name.
        train: the train at a place; raises `CaseError` where there is none.
        place: of a train; None if it is none of the study's.
        ring: where the ring around a place stands in a figure; None if the figure has no ring.
    """

    names: dict[str, str]
    notes: dict[str, str]
    first: Train
    units: Units
    figure: Callable[[str], Figure]
    train: Callable[[str], Train]
    place: Callable[[Train], str | None]
    ring: Callable[[str | None, str], Ring | None]

    def drawn(self, name: str, place: str | None) -> Figure:
        """A figure, with the ring around a place if it has one."""
        figure = self.figure(name)
        ring = self.ring(place, name)
        if ring is not None:
            traces = figure["data"]
            assert isinstance(traces, list)
            traces[-1].update(ring)
        return figure


def overview_of(result: StudyResult | SampleResult) -> Overview:
    """What is shown of a study.

    Raises:
        CaseError: if none of its cases has a steady train.
    """
    if isinstance(result, SampleResult):
        names = _some(sample_figures(result))
        return Overview(
            names,
            {name: sample_note(name) for name in names},
            sample_train(result),
            sample_units(result),
            partial(sample_figure, result),
            partial(sample_train, result),
            partial(sample_place, result),
            partial(sample_ring, result),
        )
    names = _some(shown_numbers(result))
    return Overview(
        names,
        dict.fromkeys(names, "white line: 0"),
        train_at(result, first_place(result)),
        units_of(result),
        partial(study_figure, result),
        partial(train_at, result),
        partial(place_of, result),
        partial(ring_at, result),
    )


def _some(names: dict[str, str]) -> dict[str, str]:
    if not names:
        raise CaseError("this study cannot be shown: none of its cases has a steady train")
    return names
