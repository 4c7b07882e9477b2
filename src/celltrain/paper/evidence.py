"""What the verdicts on the paper's statements follow from: data that are kept, read at once."""

import json
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from celltrain.paper import checks
from celltrain.paper.comparison import Compared, compared
from celltrain.paper.figures import FIGURES
from celltrain.paper.finding import Finding
from celltrain.paper.resolutions import CONVERGED, PAPER, Resolutions
from celltrain.paper.simulated import breakup_findings, early_findings
from celltrain.paper.statements import distance_findings

#: Names of kept data by resolution.
ENDINGS = {CONVERGED: "", PAPER: "-degree-12"}
CHECKS = "checks"
#: Simulations of breakup, by the names of their reports.
BREAKUP = ("leading", "random", "sparse", "eight", "twelve")
#: Change of alpha from M = 12 to 16 that the paper states.
DEGREE_CHANGE = 0.01


@dataclass(frozen=True)
class Evidence:
    """All kept data.

    `studies` by the name of the study, both resolutions; `degrees` alpha of the map's trains
    [train, degree] at `ladder`; `disputed`, `double_point`, `initial` and `ad_hoc` those of the
    pages of these names; `solver` what the paper's own solver gives; `panels` and `reports` of
    simulations.
    """

    studies: dict[str, Resolutions]
    degrees: np.ndarray
    ladder: tuple[int, ...]
    places: np.ndarray
    disputed: xr.Dataset
    double_point: xr.Dataset
    initial: xr.Dataset
    ad_hoc: xr.Dataset
    solver: dict[str, Any]
    panels: dict[str, Any]
    reports: dict[str, Any]


def read_evidence(folder: Path) -> Evidence:
    """Read what lies in a folder's `data`, and the reports beside that.

    Raises:
        OSError: if something is not there.
    """
    data = folder / "data"

    def dataset(name: str) -> xr.Dataset:
        with xr.open_dataset(data / f"{name}.nc") as found:
            return found.load()

    names = sorted({figure.study for figure in FIGURES.values()} | {CHECKS})
    trains = [
        each
        for each in json.loads((data / "map-degrees.json").read_text())
        if each["diameter"] >= 6.0
    ]
    return Evidence(
        studies={
            name: {key: dataset(f"{name}{ending}") for key, ending in ENDINGS.items()}
            for name in names
        },
        degrees=np.array([each["alpha"] for each in trains]),
        ladder=(12, 16, 20, 24, 32, 40, 48),
        places=np.array([(each["diameter"], each["packing"]) for each in trains]),
        disputed=dataset("disputed"),
        double_point=dataset("double-point"),
        initial=dataset("initial-growth"),
        ad_hoc=dataset("ad-hoc"),
        solver=tomllib.loads((data / "paper-solver.toml").read_text()),
        panels=json.loads((data / "transients.json").read_text())["panels"],
        reports={
            name: json.loads((folder / f"breakup-{name}.json").read_text()) for name in BREAKUP
        },
    )


def all_parts(evidence: Evidence) -> list[Compared]:
    """Every part of every statement, at both resolutions where there are two."""
    parts: list[Compared] = []
    for figure in FIGURES.values():
        found = {key: figure.findings(each) for key, each in evidence.studies[figure.study].items()}
        parts += compared(found[PAPER], found[CONVERGED])
    for name, findings in ((CHECKS, checks.findings), ("map", distance_findings)):
        found = {key: findings(each) for key, each in evidence.studies[name].items()}
        parts += compared(found[PAPER], found[CONVERGED])
    parts += [
        Compared(each.name, each.statement, each, None)
        for each in (
            *early_findings(evidence.panels),
            *breakup_findings(evidence.reports),
            degree_finding(evidence),
        )
    ]
    return sorted(parts, key=lambda each: int(each.name[1:]))


def degree_finding(evidence: Evidence) -> Finding:
    """Whether M = 16 changes alpha of the map's trains as little as the paper says (P3)."""
    first, second = evidence.degrees[:, :2].T
    change = np.abs(second / first - 1.0)
    return Finding(
        "P3",
        "M = 16 in place of 12 changes alpha by 1 %",
        f"by {np.median(change):.0%} in the median of the map's {change.size} trains, by less than"
        f" 1 % in {int((change < DEGREE_CHANGE).sum())}",
        bool((change < 1.5 * DEGREE_CHANGE).mean() > 0.9),
    )
