"""What is easily misread: units, marks at the beginning of files, files of other places."""

import os
import subprocess
import sys
import tomllib
import warnings
from pathlib import Path

import numpy as np
import pytest

from celltrain import Base, load
from celltrain.cli import main
from celltrain.parameters import (
    CaseError,
    Scales,
    Train,
    UnusualCase,
    load_case,
    merge_case,
    read_case,
    relative_volume,
)
from celltrain.results import save
from celltrain.study import read_study

CASE = ["case", "--diameter", "6", "--packing", "0.2"]
PROFILE = ["--reference", "profile", "--profile"]


def ellipse(size: float = 1.0) -> np.ndarray:
    """The meridian of an oblate spheroid; its volume is 1.92 `size`^3 times a healthy cell's."""
    angle = np.linspace(0.0, np.pi, 41)
    rho = 1.6 * np.sin(angle)
    rho[[0, -1]] = 0.0
    return size * np.column_stack([rho, 0.75 * np.cos(angle)])


@pytest.mark.parametrize(
    ("size", "read"), [(2.8, "4.48 r0"), (0.05, "0.08 r0"), (2.8e-6, "4.48e-06 r0")]
)
def test_profiles_in_other_units(size: float, read: str, tmp_path: Path, capsys) -> None:
    path = tmp_path / "profile.csv"
    np.savetxt(path, ellipse(size), delimiter=",")
    words = [*CASE, *PROFILE, str(path)]
    if size > 1e-5:
        assert main(words) == 2
        [line] = capsys.readouterr().err.splitlines()
        assert read in line
        assert f"{1.916 * size**3:.2g}"[:3] in line
        assert "1/3 to 3 times" in line
        assert "--unusual" in line
        assert main([*words, "--unusual"]) == 0
        text = capsys.readouterr().out
        kept = tmp_path / "kept.toml"
        kept.write_text(text)
        assert main(["case", str(kept)]) == 0
        assert capsys.readouterr().out == text
    else:
        assert main(words) == 2
        assert len(capsys.readouterr().err.splitlines()) == 1


def test_a_profile_is_that_beside_the_case_file(tmp_path: Path, monkeypatch) -> None:
    folder = tmp_path / "a folder with späces"
    folder.mkdir()
    np.savetxt(folder / "profile.csv", ellipse(), delimiter=",")
    words = "reference = 'profile'\nprofile = 'profile.csv'\n"
    (folder / "short.toml").write_text(f"diameter = 6\npacking = 0.2\n{words}")
    (folder / "long.toml").write_text(f"diameter = 6\npacking = 0.2\n[cell]\n{words}")
    (folder / "study.toml").write_text(f"[case]\npacking = 0.2\n{words}[axes]\ndiameter = [6, 7]\n")
    monkeypatch.chdir(tmp_path)
    for name in ("short", "long"):
        train = load_case(f"{folder.name}/{name}.toml")
        assert relative_volume(train.cell) == pytest.approx(1.916, rel=1e-3)
    assert read_study(f"{folder.name}/study.toml").cases[0].train == train
    # On the command line it is relative to where the command runs.
    with pytest.raises(CaseError, match="No such file"):
        merge_case(read_case(folder / "long.toml"), {"profile": "profile.csv"})


def test_marks_of_byte_order_are_read(tmp_path: Path) -> None:
    lines = "\n".join(f"{rho!r},{z!r}" for rho, z in ellipse().tolist())
    (tmp_path / "profile.csv").write_text(lines, encoding="utf-8-sig")
    case = "diameter = 6\r\npacking = 0.2\r\nreference = 'profile'\r\nprofile = 'profile.csv'\r\n"
    (tmp_path / "case.toml").write_bytes(b"\xef\xbb\xbf" + case.encode())
    points = load_case(tmp_path / "case.toml").cell.profile
    assert points is not None
    assert np.array_equal(points, ellipse())


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "a profile of 0 points"),
        (b"\n".join(b"%d,nan" % i for i in range(9)), "point 1 of the profile, 0 and nan"),
        ("0,1\n1,0\n".encode("utf-16"), "lines of two numbers"),
        (b"rho;z\n0;1\n", "lines of two numbers"),
        (b"\xff\xfe\xfa", "lines of two numbers"),
    ],
)
def test_files_that_are_no_profiles(content: bytes, said: str, tmp_path: Path, capsys) -> None:
    path = tmp_path / "profile.csv"
    path.write_bytes(content)
    assert main([*CASE, *PROFILE, str(path)]) == 2
    [line] = capsys.readouterr().err.splitlines()
    assert said in line


SI = ["case", "--units", "SI", "--diameter", "16.8e-6", "--packing", "0.2"]


@pytest.mark.parametrize(
    ("option", "value", "said"),
    [
        ("--radius", "2.8", "radius = 2.8 m "),
        ("--mean-velocity", "2.875", "mean_velocity = 2.875 m/s "),
        ("--plasma-viscosity", "1.2", "plasma_viscosity = 1.2 Pa s "),
    ],
)
def test_scales_in_other_units(option: str, value: str, said: str, capsys) -> None:
    assert main([*SI, option, value]) == 2
    [line] = capsys.readouterr().err.splitlines()
    assert said in line
    assert "--unusual" in line


def test_scales_that_are_meant(tmp_path: Path, capsys) -> None:
    words = "units = 'SI'\ndiameter = 16.8e-6\npacking = 0.2\nmean_velocity = 0.1\n"
    path = tmp_path / "case.toml"
    path.write_text(words)
    assert main(["case", str(path)]) == 2
    path.write_text(f"unusual = true\n{words}")
    assert main(["case", str(path)]) == 0
    path.write_text(f"unusual = 1\n{words}")
    capsys.readouterr()
    assert main(["case", str(path)]) == 2
    assert "unusual = 1 is not allowed; allowed: true or false" in capsys.readouterr().err
    # Within tenfold nothing is asked.
    assert main([*SI, "--mean-velocity", "2.8e-2"]) == 0


EVOLVE = ["evolve", "--diameter", "6", "--packing", "0.2", "-o", "run.nc"]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ([*EVOLVE, "--until", "1", "--save-seconds", "nan"], "save_seconds = nan"),
        ([*EVOLVE, "--until", "1", "--save-seconds", "-1"], "save_seconds = -1.0"),
        ([*EVOLVE, "--until", "inf"], "until = inf"),
        ([*EVOLVE, "--until", "1", "--every", "nan"], "every = nan"),
        ([*EVOLVE, "--until", "1", "--disturbance", "mode:0"], "mode 0"),
        ([*EVOLVE, "--until", "1", "--disturbance", "random:-1"], "'random:-1'"),
        (["evolve", "--resume", "-o", "run.nc", "--until", "nan"], "until = nan"),
        ([*EVOLVE[:-1], "n" * 300, "--until", "1"], "File name too long"),
        ([*CASE, "--cells", "1e23"], "1e23 is not allowed; allowed: a whole number 1 to 10000"),
        ([*CASE, "--cells", "1" + 23 * "0"], "a whole number 1 to 10000"),
        (["base", *CASE[1:], "-o", "n" * 300], "File name too long"),
        (["show", "n" * 300], "there is no such file"),
        (["show", "empty.nc"], "'empty.nc' is not a result of celltrain"),
    ],
)
def test_each_has_one_clear_line(words, said, tmp_path: Path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    Path("empty.nc").write_bytes(b"")
    assert main(words) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    [line] = printed.err.splitlines()
    assert said in line
    assert [each.name for each in tmp_path.iterdir()] == ["empty.nc"]


def command(words: list[str], redirect: str = "", **changes: str) -> subprocess.CompletedProcess:
    """A command in a process of its own, its output redirected by the shell."""
    program = "import sys; from celltrain.cli import main; sys.exit(main())"
    return subprocess.run(
        ["bash", "-c", f'"$@" {redirect}', "bash", sys.executable, "-c", program, *words],
        capture_output=True,
        text=True,
        env=os.environ | changes,
        check=False,
    )


@pytest.mark.parametrize(
    ("redirect", "status", "said"),
    [
        ("> /dev/full", 4, "standard output could not be written: No space left on device"),
        ("| true; exit ${PIPESTATUS[0]}", 4, "standard output could not be written: Broken pipe"),
        (">&-", 4, "standard output could not be written: it is closed"),
        ("2> /dev/full", 0, ""),
        ("2>&-", 0, ""),
    ],
)
def test_outputs_that_cannot_be_written(redirect: str, status: int, said: str) -> None:
    ended = command(CASE, redirect)
    assert ended.returncode == status
    assert [line.removeprefix("celltrain: ") for line in ended.stderr.splitlines()] == (
        [said] if said else []
    )


def test_a_backend_of_matplotlib_that_is_none_does_not_matter(make_base, tmp_path: Path) -> None:
    path = save(make_base(), tmp_path / "base.nc")
    ended = command(["plot", str(path), "--quiet"], MPLBACKEND="nonsense")
    assert (ended.returncode, ended.stderr) == (0, "")
    assert all(Path(line).is_file() for line in ended.stdout.splitlines())


def test_what_is_no_number_is_told_what_is_allowed() -> None:
    ended = command(["evolve", "--until", " "])
    assert ended.returncode == 2
    assert ended.stderr.startswith("celltrain: Invalid value for --until")
    assert ended.stderr.endswith(" is not allowed; allowed: numbers > 0\n")


def test_a_report_that_nobody_reads_takes_no_file_along(tmp_path: Path) -> None:
    path = tmp_path / "base.nc"
    closed = "| true; exit ${PIPESTATUS[0]}"
    ended = command(["base", *CASE[1:], "--degree", "6", "-o", str(path), "--quiet"], closed)
    assert ended.returncode == 4
    assert ended.stderr == "celltrain: standard output could not be written: Broken pipe\n"
    assert isinstance(load(path), Base)


@pytest.mark.parametrize("home", ["", "/proc/nowhere"])
def test_without_a_home_to_write_to(home: str) -> None:
    program = "import celltrain.cli.computations, celltrain.meridian.bessel, matplotlib.figure"
    without = {name: value for name, value in os.environ.items() if name != "XDG_CACHE_HOME"}
    ended = subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True,
        text=True,
        env=without | {"HOME": home},
        check=False,
    )
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, "", "")


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (
            lambda **more: Train.from_si(diameter=17, packing=0.2, radius=2.8, **more),
            "radius = 2.8 m",
        ),
        (
            lambda **more: Train(
                diameter=6, packing=0.2, scales=Scales(mean_velocity=2.875), **more
            ),
            "mean_velocity = 2.875 m/s",
        ),
        (
            lambda **more: Train(
                diameter=16, packing=0.01, reference="profile", profile=ellipse(2.8), **more
            ),
            "largest radius is 4.48 r0",
        ),
        (
            lambda **more: Train(diameter=16, packing=0.01).changed(
                reference="profile", profile=ellipse(2.8), **more
            ),
            "largest radius is 4.48 r0",
        ),
    ],
    ids=["from_si", "scales", "profile", "changed"],
)
def test_in_python_what_is_unusual_is_told_where_it_is_said(make, words: str) -> None:
    with pytest.warns(UnusualCase) as told:
        train = make()
    [one] = told
    assert words in str(one.message)
    assert "usual: " in str(one.message)
    assert one.filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert make(unusual=True) == train
        # It has been said: what follows from the train does not say it again.
        assert train.changed(cells=3).cells == 3
        assert merge_case(tomllib.loads(train.to_toml()), {"unusual": True}) == train
    with pytest.raises(CaseError, match="unusual = 'yes'"):
        make(unusual="yes")


def test_usual_trains_are_made_in_silence() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Train.from_si(diameter=17e-6, packing=0.2, radius=1e-6)
        Train(diameter=16, packing=0.01, reference="profile", profile=ellipse())
