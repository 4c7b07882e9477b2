"""The commands for studies and for the paper's maps; nothing is computed here."""

import importlib.util
import json
import math
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import pytest
import xarray as xr
from matplotlib.figure import Figure

from celltrain.cli import in_folder, main
from celltrain.paper import FIGURES, Finding, PaperFigure
from celltrain.paper.resolutions import Resolutions
from celltrain.parameters import Train
from celltrain.steady import Base, NotConverged
from celltrain.study import Computed, Outcome, StabilityOfCase, Workers, WorkersLost, engine
from celltrain.study.columns import COLUMNS


@dataclass(frozen=True)
class Cheap:
    """Takes no time, and ends at a diameter in the way it is told to."""

    base: Base
    diameter: float = 0.0
    error: type[BaseException] = NotConverged

    @property
    def settings(self) -> dict[str, str]:
        return {"kind": "cheap"}

    def __call__(self, train: Train, start: Base | None) -> Outcome:
        if train.tube.diameter == self.diameter:
            raise self.error("no steady train", self.base)
        values = dict.fromkeys(COLUMNS, 1.0) | {"error_estimate": math.nan}
        return Outcome(replace(self.base, train=train), values)


@contextmanager
def one_thread(count: int | None = None) -> Iterator[Workers]:
    with ThreadPoolExecutor(1) as executor:
        yield Workers(executor, lambda: 1, "one thread")


@pytest.fixture
def use(monkeypatch, make_base):
    """Makes the commands compute cheaply."""

    def use(**options: object) -> None:
        cheap = Cheap(make_base(), **options)
        monkeypatch.setattr(engine, "StabilityOfCase", lambda computed: cheap)
        monkeypatch.setattr(in_folder, "local_workers", one_thread)

    return use


@pytest.fixture
def study(tmp_path: Path) -> Path:
    path = tmp_path / "wide.toml"
    path.write_text("[case]\npacking = 0.2\n[axes]\ndiameter = [6, 7, 8]\n")
    return path


def test_a_sweep_writes_everything_and_goes_on(use, study, tmp_path: Path, capsys) -> None:
    folder = tmp_path / "out"
    use(diameter=7)
    assert main(["sweep", str(study), "-o", str(folder)]) == 3
    printed = capsys.readouterr()
    assert "diameter = 7: NotConverged: no steady train" in printed.out
    assert "3/3" in printed.err
    names = {path.name for path in folder.iterdir()}
    assert {"study.nc", "table.md", "spectral_abscissa.png", "gap.png"} <= names
    assert (folder / "table.md").read_text() == printed.out
    use()
    assert main(["sweep", str(study), "-o", str(folder), "--quiet"]) == 3
    assert capsys.readouterr().err == ""
    assert main(["sweep", str(study), "-o", str(folder), "--retry", "--json", "--quiet"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["data_vars"]["status"]["data"] == ["finished"] * 3
    assert printed["data_vars"]["error_estimate"]["data"] == [None] * 3
    assert main(["show", str(folder / "study.nc"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == printed


@pytest.mark.parametrize(
    ("error", "status", "said"), [(KeyboardInterrupt, 130, "interrupted"), (WorkersLost, 4, "lost")]
)
def test_what_stops_a_sweep_says_what_is_kept(
    use, study, tmp_path: Path, capsys, monkeypatch, error, status, said
) -> None:
    use()
    run_study = engine.run_study

    def stopped(*arguments, progress, **options):
        def tell(state) -> None:
            progress(state)
            if state.finished == 2:
                raise error("all workers lost") if error is WorkersLost else error

        return run_study(*arguments, progress=tell, **options)

    monkeypatch.setattr(engine, "run_study", stopped)
    folder = tmp_path / "out"
    assert main(["sweep", str(study), "-o", str(folder), "--quiet"]) == status
    message = " ".join(capsys.readouterr().err.split())
    assert said in message
    assert "2 of 3 cases are finished and kept in" in message
    assert len(list(folder.glob("*.json"))) == 2


def test_figures_of_the_paper_share_a_study(use, tmp_path: Path, capsys) -> None:
    use()
    folder = tmp_path / "map"
    assert main(["paper", "fig6", "--quick", "-o", str(folder)]) == 0
    printed = capsys.readouterr()
    assert "| P8 |" in printed.out
    assert "coarse grid at M = 1:" in printed.out
    assert "0 of 18 cases were there already" in printed.err
    assert main(["paper", "fig8", "--quick", "-o", str(folder), "--json"]) == 0
    printed = capsys.readouterr()
    assert "18 of 18 cases were there already" in printed.err
    shown = json.loads(printed.out)
    assert shown["figure"] == "fig8"
    assert {finding["name"] for finding in shown["findings"]} == {"P11", "P12"}
    assert (folder / "fig6.png").exists()
    assert (folder / "fig8.md").exists()


def test_a_computed_figure_shows_the_other_resolution_beside_it(
    tmp_path: Path, capsys, monkeypatch
) -> None:
    computed: list[int | None] = []

    def data(degree: int | None) -> xr.Dataset:
        computed.append(degree)
        return xr.Dataset({"degree": -1 if degree is None else degree})

    drawn: list[list[str]] = []

    def draw(found: Resolutions) -> Figure:
        drawn.append(sorted(found))
        return Figure()

    figure = PaperFigure("some", draw, lambda _: [Finding("P4", "so", "found", True)], data)
    monkeypatch.setitem(FIGURES, "fig3", figure)
    monkeypatch.chdir(tmp_path)
    assert main(["paper", "fig3", "--resolution", "paper"]) == 0
    assert "| P4 | so | found | yes |" in capsys.readouterr().out
    # What is kept is not computed again.
    assert main(["paper", "fig3", "--resolution", "paper", "--quiet"]) == 0
    assert main(["paper", "fig3", "--quiet"]) == 0
    assert computed == [12, None]
    assert drawn == [["paper"], ["paper"], ["converged", "paper"]]
    assert main(["paper", "fig3", "--retry", "--quiet"]) == 0
    assert computed == [12, None, None]


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        (["sweep", "missing.toml"], ["missing.toml", "cannot be read"]),
        (["sweep", "STUDY", "--workers", "0"], ["workers = 0", ">= 1"]),
        (["sweep", "STUDY", "--workers", "two"], ["two", "a whole number >= 1"]),
        (
            ["sweep", "STUDY", "--workers", "2", "--scheduler", "tcp://a:1"],
            ["not allowed together"],
        ),
        (["sweep", "STUDY", "-o", "STUDY"], ["output = ", "cannot be used"]),
        (
            ["sweep", "STUDY", "--scheduler", "nowhere"],
            ["scheduler = 'nowhere'", "cannot be reached"],
        ),
        (["paper", "fig2"], ["fig2", "fig6"]),
        (["paper", "fig7", "--quick"], ["quick", "fig7", "maps and curves"]),
        (["paper", "fig6", "--quick", "--resolution", "paper"], ["quick", "resolution = 'paper'"]),
    ],
)
def test_bad_input(study, tmp_path: Path, capsys, monkeypatch, arguments, parts) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("celltrain.study.workers.PATIENCE", 0.2)
    assert main([str(study) if each == "STUDY" else each for each in arguments]) == 2
    message = capsys.readouterr().err
    assert all(part in message for part in parts), message


def test_without_dask_a_message_says_what_to_install(
    study, tmp_path: Path, capsys, monkeypatch
) -> None:
    monkeypatch.chdir(tmp_path)
    find = importlib.util.find_spec
    monkeypatch.setattr(
        "celltrain.extras.find_spec",
        lambda name: None if name == "distributed" else find(name),
    )
    assert main(["sweep", str(study)]) == 2
    assert "pip install 'celltrain[studies]'" in capsys.readouterr().err


def test_what_is_computed_follows_the_study_file() -> None:
    plain, other = Computed(), Computed(estimate_error=False)
    settings = [StabilityOfCase(each).settings for each in (plain, other)]
    assert settings[0] != settings[1]
