"""Random commands, case files and surroundings: none may end in a traceback or a crash.

    python validation/fuzz.py [--tries 300] [--seed 0]

Each try draws a command, values that are right, wrong or absurd, files in several encodings and
damaged ones, an output on a small disk or none, and an environment, and runs it in a process of its
own. It fails if the process ends with a status that `celltrain.cli.app` does not have, if a
traceback or a crash is said anywhere, or if a refusal does not say what is allowed. Tries that
fail are printed, with the seed that makes them again.
"""

import argparse
import collections
import os
import random
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

PROGRAM = "import sys; from celltrain.cli import main; sys.exit(main())"
STATUSES = (0, 2, 3, 4, 130, 143)
#: What no message may say.
CRASHES = ("Traceback", "Exception ignored", "Segmentation fault", "core dumped", "Fatal Python")
#: One of these is in each refusal.
REASONS = (
    "allowed",
    "missing",
    "cannot be",
    "is no ",
    "is not a result",
    "no such",
    "not valid",
    "needs",
    "nknown",
    "multiple times",
)
#: Seconds after which a computation is given up; that is no fault.
PATIENCE = 90.0
_MATPLOTLIB = "text.usetex: True\nfont.family: NoSuchFont\nsavefig.format: pdf\nbackend: TkAgg\n"

RIGHT = {
    "diameter": ("6", "5.5", "12"),
    "packing": ("0.2", "0.3"),
    "cells": ("1", "2"),
    "degree": ("6", "8"),
    "viscosity_ratio": ("1", "5"),
    "shear_modulus": ("1", "2.5"),
}
ABSURD = (
    "0",
    "-1",
    "nan",
    "inf",
    "-inf",
    "1e400",
    "1e-320",
    "1e23",
    "six",
    "",
    " ",
    "0x10",
    "1_0",
    "6,0",
    "٦",
    "true",
    "None",
    "[6]",
    "µm",
    "\\n",
    "1e5",
)
OPTIONS = (
    *RIGHT,
    "law",
    "bending",
    "reference",
    "profile",
    "aspect_ratio",
    "reduced_volume",
    "units",
    "radius",
    "mean_velocity",
    "capillary_number",
    "tolerance",
    "source_order",
    "diamter",
)
COMMANDS = ("case", "base", "stability", "show", "plot", "evolve", "sweep", "transient", "infinite")
#: Endings of a shell's line: where the outputs lead to.
OUTPUTS = (
    "",
    "",
    "",
    "> /dev/full",
    ">&-",
    "| true; exit ${PIPESTATUS[0]}",
    "2> /dev/full",
    "2>&-",
)
ENVIRONMENTS: tuple[dict[str, str], ...] = (
    {},
    {},
    {},
    {"HOME": ""},
    {"HOME": "/proc/nowhere", "XDG_CACHE_HOME": "/proc/nowhere"},
    {"MPLBACKEND": "nonsense"},
    {"MATPLOTLIBRC": "matplotlibrc"},
    {"LC_ALL": "C", "PYTHONIOENCODING": "ascii"},
    {"COLUMNS": "1"},
    {"TERM": "dumb"},
    {"JAX_PLATFORMS": "nowhere"},
)


@dataclass
class Attempt:
    """A command, the files it finds, and what is around it."""

    words: list[str]
    files: dict[str, bytes] = field(default_factory=dict)
    environment: dict[str, str] = field(default_factory=dict)
    output: str = ""
    #: Largest file in blocks of 1024 bytes, if there is a limit.
    disk: int | None = None


def attempt(draw: random.Random, commands: tuple[str, ...] = COMMANDS) -> Attempt:
    """A try."""
    command = draw.choice(commands)
    words, files = [command], {"matplotlibrc": _MATPLOTLIB.encode()}
    if command in ("show", "plot"):
        words.append(draw.choice(("damaged.nc", "empty.nc", "missing.nc", ".", "a" * 300)))
        files |= {"damaged.nc": draw.randbytes(3000), "empty.nc": b""}
    elif command == "sweep":
        files["study.toml"] = _encoded(draw, _study(draw))
        words += ["study.toml", "--workers", "1"]
    else:
        if draw.random() < 0.5:
            files["case.toml"] = _encoded(draw, _case(draw))
            words.append("case.toml")
        else:
            words += ["--diameter", "6", "--packing", "0.3", "--cells", "1", "--degree", "6"]
        for name in draw.sample(OPTIONS, draw.choice((0, 0, 1, 2))):
            words += [f"--{name.replace('_', '-')}", _value(draw, name)]
        if draw.random() < 0.3:
            files["profile.csv"] = _profile(draw)
            words += ["--reference", "profile", "--profile", "profile.csv"]
    if command == "evolve":
        until = draw.choice(("0.1", "0.1", *ABSURD))
        words += ["--until", until, "--disturbance", draw.choice(("random", "mode:0", "random:-1"))]
        words += ["-o", "run.nc"]
    elif command not in ("case", "show", "plot", "sweep"):
        words += draw.choice(
            ([], ["-o", "out.nc"], ["-o", "no/where.nc"], ["-o", "ä b.nc"], ["--plot", "pictures"])
        )
    return Attempt(
        words,
        files,
        draw.choice(ENVIRONMENTS),
        draw.choice(OUTPUTS),
        draw.choice((None, None, None, 1, 4)),
    )


def _value(draw: random.Random, name: str) -> str:
    return draw.choice(RIGHT.get(name, ABSURD) if draw.random() < 0.5 else ABSURD)


def _case(draw: random.Random) -> str:
    lines = {"diameter": "6", "packing": "0.3", "cells": "1", "degree": "6"}
    for name in draw.sample(OPTIONS, draw.choice((0, 0, 1, 2))):
        value = _value(draw, name)
        lines[name] = value if draw.random() < 0.6 else f'"{value}"'
    text = "".join(f"{name} = {value}\n" for name, value in lines.items())
    return draw.choice(("", "", "[tube]\n", "unusual = true\n", "units = 'SI'\n")) + text


def _study(draw: random.Random) -> str:
    axis = draw.choice(("[6]", "[6, nan]", "6", "[]", "{from = 1, to = 1e9, points = 3}", "['a']"))
    return f"[case]\ncells = 1\ndegree = 6\npacking = 0.3\n[axes]\ndiameter = {axis}\n"


def _profile(draw: random.Random) -> bytes:
    size = draw.choice((1.0, 2.8, 1e-6, float("nan"), 1e300))
    points = (
        (0, 1),
        (0.7, 0.9),
        (1, 0.5),
        (1.2, 0.2),
        (1.2, -0.2),
        (1, -0.5),
        (0.7, -0.9),
        (0, -1),
    )
    return _encoded(draw, "".join(f"{size * rho},{size * z}\n" for rho, z in points))


def _encoded(draw: random.Random, text: str) -> bytes:
    coding = draw.choice(("utf-8", "utf-8", "utf-8-sig", "utf-16", "cut", "bytes", "empty", "long"))
    if coding.startswith("utf"):
        return text.encode(coding)
    whole = text.encode()
    return {
        "cut": whole[: draw.randrange(len(whole))],
        "bytes": whole[:10] + draw.randbytes(30) + whole[10:],
        "empty": b"",
        "long": whole * 200,
    }[coding]


def fault(status: int, out: str, said: str) -> str:
    """What is wrong with the end of a try; empty if nothing is."""
    if status not in STATUSES:
        return f"status {status}"
    for crash in CRASHES:
        if crash in said or crash in out:
            return crash
    if status == 2 and said and not any(reason in said for reason in REASONS):
        return "a refusal that does not say what is allowed"
    return ""


def run(tried: Attempt, folder: Path) -> tuple[int | None, str, str]:
    """Status (None if it took too long), standard output and standard error of a try."""
    for name, content in tried.files.items():
        (folder / name).write_bytes(content)
    limit = "" if tried.disk is None else f"ulimit -f {tried.disk};"
    try:
        ended = subprocess.run(
            [
                "bash",
                "-c",
                f'{limit} "$@" {tried.output}',
                "bash",
                sys.executable,
                "-c",
                PROGRAM,
                *tried.words,
            ],
            capture_output=True,
            cwd=folder,
            env={**os.environ, **tried.environment},
            timeout=PATIENCE,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return None, "", ""
    return (
        ended.returncode,
        ended.stdout.decode(errors="replace"),
        ended.stderr.decode(errors="replace"),
    )


def main() -> None:
    parser = argparse.ArgumentParser(description="Run random commands and look how they end.")
    parser.add_argument("--tries", type=int, default=300)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    counts: collections.Counter[str] = collections.Counter()
    print(f"seed {options.seed}", flush=True)
    for number in range(options.tries):
        tried = attempt(random.Random(f"{options.seed}/{number}"))
        with tempfile.TemporaryDirectory() as folder:
            status, out, said = run(tried, Path(folder))
            left = [each.name for each in Path(folder).rglob("*") if ".part" in each.name]
        wrong = "given up" if status is None else fault(status, out, said)
        if left:
            wrong = wrong or f"left {left[0]}"
        counts[f"status {status}" if status is not None else "given up"] += 1
        if wrong:
            counts["FAULTS"] += status is not None
            print(f"{number}: {wrong}: {tried}\n{said[-1500:]}", flush=True)
    for what, count in sorted(counts.items()):
        print(f"{what}: {count}")


if __name__ == "__main__":
    main()
