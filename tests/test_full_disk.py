"""Files on a disk that is full: the system's limit of a file's size stands for it."""

import errno
import os
import resource
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
import xarray as xr

from celltrain.analyses import base as command
from celltrain.cli import main
from celltrain.contract.drawing import draw_file
from celltrain.evolution import evolve
from celltrain.evolution.disturbances import RandomDisplacement
from celltrain.results import read, replace_file, save
from celltrain.steady import Base

CASE = ["base", "--diameter", "6", "--packing", "0.2", "--quiet"]


@pytest.fixture
def small_disk() -> Iterator[int]:
    """Files of this process may have 2000 bytes; what it compiles is not kept."""
    import jax

    seconds = jax.config.jax_persistent_cache_min_compile_time_secs
    jax.config.update("jax_persistent_cache_min_compile_time_secs", float("inf"))
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (2000, before[1]))
    yield 2000
    resource.setrlimit(resource.RLIMIT_FSIZE, before)
    signal.signal(signal.SIGXFSZ, handler)
    jax.config.update("jax_persistent_cache_min_compile_time_secs", seconds)


def test_a_result_is_printed_before_its_loss_is_told(
    make_base, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys, request
) -> None:
    made = make_base()
    monkeypatch.setattr(command, "steady", lambda train, **_: made)
    path = tmp_path / "base.nc"
    older = save(make_base(packing=0.3), path).read_bytes()
    request.getfixturevalue("small_disk")
    assert main([*CASE, "-o", str(path), "--plot", str(tmp_path / "pictures")]) == 4
    printed = capsys.readouterr()
    assert f"{made.cell_velocity:.5f}" in printed.out
    lines = printed.err.splitlines()
    assert lines[0] == f"celltrain: {str(path)!r} could not be written: File too large"
    assert all(line.endswith("could not be drawn: File too large") for line in lines[1:])
    assert len(lines) > 1
    assert path.read_bytes() == older
    assert read(path, Base) == make_base(packing=0.3)
    assert sorted(each.name for each in tmp_path.iterdir()) == ["base.nc", "pictures"]
    assert list((tmp_path / "pictures").iterdir()) == []


def test_a_simulation_ends_with_what_it_has(coarse_base, tmp_path: Path, request) -> None:
    request.getfixturevalue("small_disk")
    run = evolve(
        coarse_base, RandomDisplacement(0.1), degree=6, until=1.0, path=tmp_path / "run.nc"
    )
    assert run.ending.kind == "not_saved"
    assert run.ending.message == "the file could not be written: File too large"
    assert len(run.times) == 1
    assert list(tmp_path.iterdir()) == []


PROGRAM = """
import resource, signal, sys
from celltrain.cli.kept_programs import mended_programs
with mended_programs():
    import celltrain.runtime, jax
    if sys.argv[1:]:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[1]), -1))
    def doubled(x):
        return 2 * x
    def halved(x):
        return x / 2
    print(jax.jit(doubled)(2.0), jax.jit(halved)(2.0))
"""


def test_compiled_programs_that_were_cut_short_are_made_anew(tmp_path: Path) -> None:
    def run(*limit: str) -> str:
        done = subprocess.run(
            [sys.executable, "-c", PROGRAM, *limit],
            env=os.environ | {"XDG_CACHE_HOME": str(tmp_path)},
            capture_output=True,
            text=True,
            check=True,
        )
        assert done.stdout == "4.0 1.0\n"
        return done.stderr

    kept = tmp_path / "celltrain" / "compiled"
    assert run("500").startswith("celltrain: what was compiled cannot be kept: File too large")
    assert list(kept.glob("jit_doubled*-cache")) == []
    assert run() == ""
    (entry,) = kept.glob("jit_doubled*-cache")
    whole = entry.stat().st_size
    entry.write_bytes(entry.read_bytes()[: whole // 2])
    assert run() == ""
    (entry,) = kept.glob("jit_doubled*-cache")
    assert entry.stat().st_size == whole


def test_symbolic_links_are_followed(make_base, tmp_path: Path) -> None:
    (tmp_path / "far").mkdir()
    there, missing = tmp_path / "far" / "base.nc", tmp_path / "far" / "new.nc"
    save(make_base(), there)
    for target in (there, missing):
        link = tmp_path / f"link to {target.name}"
        link.symlink_to(target)
        save(make_base(packing=0.3), link)
        assert link.is_symlink()
        assert read(target, Base).train.packing == 0.3
    assert len(list(tmp_path.rglob("*"))) == 5


@pytest.mark.parametrize("name", ["a" * 252 + ".nc", "ä" * 126 + ".nc", "a name\twith 'all'.nc"])
def test_any_name_that_the_system_allows(name: str, make_base, tmp_path: Path) -> None:
    save(make_base(), tmp_path / name)
    assert xr.load_dataset(tmp_path / name, engine="netcdf4").attrs["kind"] == "base"
    assert [each.name for each in tmp_path.iterdir()] == [name]


def test_pictures_are_the_same_under_any_style(
    make_base, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import matplotlib as mpl

    from celltrain.contract.files import pictures

    [(name, draw), *_] = pictures(make_base()).items()
    plain = draw_file(draw, tmp_path / f"{name}.png").read_bytes()
    unusual = {
        "text.usetex": True,
        "font.family": "NoSuchFont",
        "savefig.dpi": 40,
        "savefig.format": "pdf",
        "savefig.bbox": "tight",
        "axes.formatter.use_locale": True,
        "figure.constrained_layout.use": True,
    }
    with mpl.rc_context(unusual):
        styled = draw_file(draw, tmp_path / "other.png").read_bytes()
        assert mpl.rcParams["text.usetex"]
    assert styled == plain


def test_a_failure_leaves_no_part_behind(tmp_path: Path) -> None:
    def fail(part: Path) -> None:
        part.write_text("half")
        raise OSError(errno.EIO, "Input/output error")

    with pytest.raises(OSError, match="Input/output"):
        replace_file(tmp_path / "table.md", fail)
    assert list(tmp_path.iterdir()) == []
