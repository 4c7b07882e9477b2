"""The command that draws what a file holds. Nothing is simulated here."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from celltrain import Base, Run, save
from celltrain.cli import main
from celltrain.contract import draw_all
from celltrain.diagnostics import frame
from celltrain.evolution import Ending, ForwardEuler, Repulsion
from celltrain.evolution.methods import EulerMemory
from celltrain.evolution.record.archive import Archive
from celltrain.evolution.record.quantities import STEP_QUANTITIES
from celltrain.evolution.record.recompute import FrameProgress
from celltrain.evolution.state import Measures, State
from celltrain.harmonics import UNIT_DISPLACEMENT
from celltrain.membrane import place_cells
from celltrain.pictures import run as run_pictures
from celltrain.pictures.run import spread
from celltrain.study import collect, make_study

PICTURES = ["growth.png", "growth_log_time.png", "snapshots.png", "record.png"]


@pytest.fixture
def run(make_base) -> Run:
    """A simulation under way that nobody computed: two cells that drift off the axis."""
    base: Base = make_base(cells=2, degree=6)
    train = base.train
    shapes = np.stack([place_cells(base.coefficients, train, 2)] * 3)
    shapes[:, 0, 0, 0] += UNIT_DISPLACEMENT * np.array([0.1, 0.2, 0.4])
    still = np.zeros_like(shapes[0])
    measured = [frame(train, each, still) for each in shapes]
    sizes = np.geomspace(0.1, 0.4, 5)
    history = dict.fromkeys(STEP_QUANTITIES, sizes) | {"time": np.linspace(0.0, 2.5, 5)}
    return Run(
        start=base,
        disturbance="made up",
        growth_rate=0.5,
        integrator=ForwardEuler(0.625),
        repulsion=Repulsion(),
        every=1.0,
        until=50.0,
        history=history,
        times=np.array([0.0, 1.0, 2.0]),
        shapes=shapes,
        frames={name: np.stack([each[name] for each in measured]) for name in measured[0]}
        | dict.fromkeys(("eps", "eps_x", "eps_linear"), sizes[:3])
        | {"laps": np.zeros((3, 2), dtype=int)},
        state=State(
            shapes=shapes[-1],
            laps=np.zeros(2, dtype=int),
            measures=Measures(*[0.5] * 8),
            time=2.5,
            rates=still,
            wall_gap=0.5,
        ),
        memory=EulerMemory(4),
        ending=Ending("running", "not ended yet"),
    )


@pytest.fixture
def path(run: Run, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Its file."""
    path = tmp_path_factory.mktemp("simulation") / "run.nc"
    Archive(path).save(run)
    return path


def assert_drawn(paths: list[Path]) -> None:
    for path in paths:
        with Image.open(path) as picture:
            values = np.asarray(picture.convert("L"))
        assert values.shape[0] > 300
        # Neither empty nor black.
        assert 0.5 < np.mean(values > 200) < 0.999


def test_the_command_draws_a_simulation_under_way(
    path: Path, tmp_path: Path, capsys, monkeypatch: pytest.MonkeyPatch
) -> None:
    def rates(run: Run, *, progress: FrameProgress) -> np.ndarray:
        progress(3, 3)
        return np.zeros_like(run.shapes)

    monkeypatch.setattr("celltrain.evolution.record.recompute.frame_rates", rates)
    monkeypatch.setattr(run_pictures, "MOST_FILM_FRAMES", 2)
    folder, film, frames = tmp_path / "new" / "folder", tmp_path / "film.gif", tmp_path / "view"
    # Pictures are drawn again while it runs: old ones are replaced.
    folder.mkdir(parents=True)
    (folder / "growth.png").write_text("old")
    before = path.read_bytes()
    arguments = ["plot", str(path), "-o", str(folder)]
    assert main([*arguments, "--animation", str(film), "--paraview", str(frames)]) == 0
    printed = capsys.readouterr()
    drawn = [Path(line) for line in printed.out.splitlines()]
    assert drawn == [*(folder / name for name in PICTURES), film, frames / "frames.pvd"]
    assert_drawn(drawn[:4])
    with Image.open(film) as moving:
        assert moving.n_frames == 2
    assert len(list(frames.glob("cells_*.vtp"))) == 3
    assert "t = 2.5 of 50 r0/U, 3 frames: not ended yet" in printed.err
    assert "velocities: 3 of 3" in printed.err
    assert path.read_bytes() == before


@pytest.mark.parametrize(
    "words", [["show"], ["plot", "-o", "pictures"], ["page", "-o", "page.html"]]
)
def test_a_simulation_is_seen_without_jax(words: list[str], path: Path, tmp_path: Path) -> None:
    """JAX takes a second to load; what steps cells is not asked for."""
    program = f"""
import sys
from celltrain.cli import main
status = main([{words[0]!r}, {str(path)!r}, *{words[1:]!r}])
assert status == 0, status
assert not {{"jax", "equinox"}} & set(sys.modules)
"""
    subprocess.run([sys.executable, "-c", program], check=True, cwd=tmp_path)


def test_a_simulation_is_explored_without_jax(path: Path) -> None:
    program = f"""
import sys
from pathlib import Path
from celltrain.explore.app import make_app
from celltrain.explore.engine import Engine
from celltrain.explore.opened import opened

what = opened(Path({str(path)!r}))
client = make_app(what, Engine(what.start)).server.test_client()
assert client.get("/film.json").json["cells"] == 2
assert not {{"jax", "equinox"}} & set(sys.modules)
"""
    subprocess.run([sys.executable, "-c", program], check=True)


def test_the_command_draws_results_beside_their_files(make_base, tmp_path: Path, capsys) -> None:
    save(make_base(), tmp_path / "train.nc")
    assert main(["plot", str(tmp_path / "train.nc"), "--quiet"]) == 0
    printed = capsys.readouterr()
    assert printed.err == ""
    drawn = [Path(line) for line in printed.out.splitlines()]
    assert drawn == [
        tmp_path / "train-pictures" / name for name in ("base_train.png", "profile.png")
    ]
    assert_drawn(drawn)


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        (["{}/none.nc"], ["none.nc", "no such file"]),
        (["{}"], ["no such file"]),
        (["{}/text.nc"], ["text.nc", "is not a result of celltrain"]),
        (["{}/base.nc", "--animation", "{}/film.gif"], ["film.gif", "holds no simulation"]),
        (["{}/base.nc", "--paraview", "{}/view"], ["view", "holds no simulation"]),
        (["{}/base.nc", "-o", "{}/text.nc"], ["output", "text.nc", "cannot be used"]),
        (["{run}", "--animation", "{}/film.avi"], ["film.avi", ".gif"]),
        (["{run}", "--animation", "{}/none/film.gif"], ["animation = ", "is no folder"]),
        (["{run}", "--paraview", "{}/text.nc"], ["paraview = ", "text.nc", "cannot be used"]),
    ],
)
def test_what_the_command_refuses(
    arguments, parts, make_base, path: Path, tmp_path: Path, capsys
) -> None:
    save(make_base(), tmp_path / "base.nc")
    (tmp_path / "text.nc").write_text("text")
    given = [each.format(tmp_path, run=path) for each in arguments]
    assert main(["plot", *given]) == 2
    message = capsys.readouterr().err
    assert all(part in message for part in parts), message
    assert sorted(each.name for each in tmp_path.iterdir()) == ["base.nc", "text.nc"]


def test_a_study_of_which_nothing_is_drawn_says_so(tmp_path: Path, capsys) -> None:
    study = make_study(
        {"axes": {"law": ["skalak", "neo_hookean"]}, "case": {"diameter": 6, "packing": 0.2}}
    )
    path = save(collect(study, {}), tmp_path / "study.nc")
    assert main(["plot", str(path)]) == 2
    assert "nothing of it is drawn" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == [path]


def test_a_simulation_that_has_only_begun_is_drawn(run: Run, tmp_path: Path) -> None:
    begun = replace(
        run,
        history={name: column[:1] for name, column in run.history.items()},
        times=run.times[:1],
        shapes=run.shapes[:1],
        frames={name: each[:1] for name, each in run.frames.items()},
    )
    assert [path.name for path in draw_all(begun, tmp_path)] == ["snapshots.png"]
    assert_drawn([tmp_path / "snapshots.png"])


def test_chosen_frames_are_spread_from_the_first_to_the_last() -> None:
    assert spread(1, 6).tolist() == [0]
    assert spread(4, 6).tolist() == [0, 1, 2, 3]
    assert spread(101, 6).tolist() == [0, 20, 40, 60, 80, 100]
