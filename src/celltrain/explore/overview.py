"""What is shown of a study, over axes or of distributions: figures, and the trains in them."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

from celltrain.explore.figures import Figure
from celltrain.explore.maps import first_place, ring_at, shown_numbers, study_figure, train_at
from celltrain.explore.samples import (
    sample_figure,
    sample_figures,
    sample_note,
    sample_ring,
    sample_train,
)
from celltrain.parameters import CaseError, Train
from celltrain.study import SampleResult, StudyResult


@dataclass(frozen=True, eq=False)
class Overview:
    """Figures of a study by their names; points of them are places, at each of which is a train.

    Attributes:
        names: of the figures, and how they are called.
        notes: what is seen in each.
        first: the train that is opened first.
        figure: a figure, by its name.
        train: the train at a place; raises `CaseError` where there is none.
        ring: where the ring around a place stands in a figure; None if the figure has no ring.
    """

    names: dict[str, str]
    notes: dict[str, str]
    first: Train
    figure: Callable[[str], Figure]
    train: Callable[[str], Train]
    ring: Callable[[str, str], dict[str, list[Any]] | None]


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
            partial(sample_figure, result),
            partial(sample_train, result),
            partial(sample_ring, result),
        )
    names = _some(shown_numbers(result))
    return Overview(
        names,
        dict.fromkeys(names, "white line: 0"),
        train_at(result, first_place(result)),
        partial(study_figure, result),
        partial(train_at, result),
        lambda place, _: ring_at(result, place),
    )


def _some(names: dict[str, str]) -> dict[str, str]:
    if not names:
        raise CaseError("this study cannot be shown: none of its cases has a steady train")
    return names
