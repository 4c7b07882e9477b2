"""Build the sdist, from it the wheel, install that in a clean environment, and run the main job.

python packaging/wheel_test.py [PYTHON ...]; each is a Python to install for, this one unless given.
Needs hatchling here, and takes the locked versions there. Nothing of the repository is on the path
where the job runs.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).parents[1]
CASE = ["--diameter", "6", "--packing", "0.2", "--cells", "8", "--degree", "12"]
# What the documentation states of this case (docs/numbers.md).
EXPECTED = {"cell_velocity": (1.771955, 1e-6), "spectral_abscissa": (0.011784, 1e-6)}
EXTRA = "python -m pip install 'celltrain[simulations]'"


def run(*command: str | Path, **options: object) -> subprocess.CompletedProcess[str]:
    """Run a command outside of the repository."""
    kept = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    words = [str(word) for word in command]
    return subprocess.run(words, env=kept, text=True, capture_output=True, **options)


def must(*command: str | Path, **options: object) -> str:
    """Run a command that has to succeed; its standard output."""
    done = run(*command, **options)
    if done.returncode:
        words = " ".join(map(str, command))
        sys.exit(f"{words}\nended with {done.returncode}\n{done.stdout}\n{done.stderr}")
    return done.stdout


def build(folder: Path) -> Path:
    """The wheel, made from the sdist as an installer makes it."""
    must(sys.executable, "-m", "hatchling", "build", "-t", "sdist", "-d", folder, cwd=ROOT)
    [sdist] = folder.glob("*.tar.gz")
    must(
        *(sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation"),
        *("--wheel-dir", folder, sdist),
        cwd=folder,
    )
    [wheel] = folder.glob("*.whl")
    print(
        f"{sdist.name}: {sdist.stat().st_size / 1024:.0f} KiB; {wheel.name}: "
        f"{wheel.stat().st_size / 1024:.0f} KiB"
    )
    return wheel


def check(python: str, wheel: Path, folder: Path) -> None:
    """Install the wheel for a Python and run the main job with it."""
    began = time.perf_counter()
    place = folder / "environment"
    must(python, "-m", "venv", "--clear", place)
    there = place / "bin" / "python"
    lock = ROOT / "requirements.lock"
    must(there, "-m", "pip", "install", "--quiet", "--constraint", lock, wheel, cwd=folder)
    installed = time.perf_counter()
    command = place / "bin" / "celltrain"
    result = json.loads(must(command, "stability", *CASE, "--json", "-o", "train.nc", cwd=folder))
    found = {**result["base"], **result}
    for name, (value, tolerance) in EXPECTED.items():
        assert abs(found[name] - value) <= tolerance, (name, found[name], value)
    must(command, "show", "train.nc", cwd=folder)
    must(command, "plot", "train.nc", "-o", "pictures", cwd=folder)
    assert (folder / "pictures" / "spectrum.png").stat().st_size > 10_000
    lacking = run(command, "evolve", "train.nc", "--until", "1", "-o", "run.nc", cwd=folder)
    assert lacking.returncode == 2, lacking
    assert lacking.stderr.strip().endswith(EXTRA), lacking.stderr
    ended = time.perf_counter()
    size = sum(path.stat().st_size for path in place.rglob("*") if path.is_file())
    alpha = found["spectral_abscissa"]
    version = must(there, "-c", "import platform; print(platform.python_version())").strip()
    print(
        f"Python {version}: installed in {installed - began:.0f} s ({size / 2**20:.0f} MiB), main"
        f" job, report and pictures in {ended - installed:.0f} s, alpha = {alpha:.6f}"
    )


def main() -> None:
    """Build once, check for each Python."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        wheel = build(folder)
        for python in sys.argv[1:] or [sys.executable]:
            check(python, wheel, folder)


if __name__ == "__main__":
    main()
