"""Signals: a command ends soon, once, with the right status; a second one ends it at once."""

import gc
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator

import pytest

from celltrain import interruption
from celltrain.cli import main

#: Seconds that a process may take to end, on a machine with other work to do.
SOON = 6.0

#: What a command does until the signal comes: Python, machine code, and a callback that drops
#: exceptions, as the garbage collector's do.
WAITS = {
    "in Python": "while True: time.sleep(0.01)",
    "in machine code": "hashlib.pbkdf2_hmac('sha256', b'', b'', 200_000_000)",
    "in a callback": """
def callback(phase, info):
    end = time.monotonic() + 0.05
    while time.monotonic() < end: pass
gc.callbacks.append(callback)
while True: gc.collect()
""",
    # As workers of a study have them.
    "with semaphores": """
import multiprocessing
sys.kept = multiprocessing.get_context("spawn").Lock()
while True: time.sleep(0.01)
""",
    "in a handler of all": """
while True:
    try: time.sleep(0.01)
    except BaseException: pass
""",
}

# Whatever starts the tests may ignore SIGINT, as shells do for what is in the background.
PROGRAM = """
import gc, hashlib, os, signal, sys, threading, time
{ignored}
from celltrain import cli, interruption
import celltrain.cli.app as app

def run(arguments):
    with interruption.kept_by(lambda: "all is in run.nc"):
        print("ready", flush=True)
{body}

app.run = run
sys.exit(cli.main())
"""


@pytest.fixture(autouse=True)
def heard() -> Iterator[None]:
    """SIGINT is heard, also where whatever started the tests ignores it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


HEARD = "signal.signal(signal.SIGINT, signal.default_int_handler)"


def start(body: str) -> subprocess.Popen[str]:
    lines = "\n".join(f"        {line}" for line in body.strip().splitlines())
    process = subprocess.Popen(
        [sys.executable, "-c", PROGRAM.format(body=lines, ignored=HEARD)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "ready\n"
    return process


@pytest.mark.parametrize("where", WAITS)
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_a_command_once(where: str, number: signal.Signals) -> None:
    process = start(WAITS[where])
    time.sleep(0.1)
    begin = time.monotonic()
    process.send_signal(number)
    try:
        _, said = process.communicate(timeout=30.0)
    finally:
        process.kill()
    assert time.monotonic() - begin < SOON
    assert process.returncode == 128 + number
    [line] = said.splitlines()
    assert line.startswith("celltrain: interrupted; ")
    # Where nobody took the exception, another thread has kept what there was.
    if where in ("in machine code", "in a handler of all"):
        assert line.endswith("all is in run.nc")


def test_a_second_signal_ends_at_once() -> None:
    process = start("""
try:
    print("waiting", flush=True)
    time.sleep(60)
except KeyboardInterrupt:
    interruption.take()
    print("taken", flush=True)
    time.sleep(60)
""")
    assert process.stdout is not None
    # Within the `try`, and not on the way there.
    assert process.stdout.readline() == "waiting\n"
    process.send_signal(signal.SIGINT)
    assert process.stdout.readline() == "taken\n"
    process.send_signal(signal.SIGTERM)
    _, said = process.communicate(timeout=SOON)
    assert process.returncode == 143
    assert said == ""


def test_a_command_in_the_background_goes_on() -> None:
    """There SIGINT is ignored, as shells start it, and stays so."""
    ignored = "signal.signal(signal.SIGINT, signal.SIG_IGN)"
    words = PROGRAM.format(body="        time.sleep(0.5); return 0", ignored=ignored)
    process = subprocess.Popen([sys.executable, "-c", words], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stdout.readline() == "ready\n"
    process.send_signal(signal.SIGINT)
    assert process.wait(timeout=30.0) == 0


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_all_is_as_before_afterwards(
    number: signal.Signals, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from celltrain.cli import app

    before = [signal.getsignal(each) for each in (signal.SIGINT, signal.SIGTERM, signal.SIGURG)]
    hook, wakeup = sys.unraisablehook, signal.set_wakeup_fd(-1)
    signal.set_wakeup_fd(wakeup)

    def run(arguments: object) -> int:
        with interruption.kept_by(lambda: ""):
            os.kill(os.getpid(), number)
            while True:
                time.sleep(0.01)

    monkeypatch.setattr(app, "run", run)
    assert main(["base"]) == 128 + number
    assert capsys.readouterr().err == "celltrain: interrupted; nothing was saved\n"
    after = [signal.getsignal(each) for each in (signal.SIGINT, signal.SIGTERM, signal.SIGURG)]
    assert after == before
    assert sys.unraisablehook is hook
    assert signal.set_wakeup_fd(wakeup) == wakeup
    assert gc.isenabled()


def test_what_is_kept_is_said_innermost_first() -> None:
    def fail() -> str:
        raise OSError("the disk is full")

    keepers: list[Callable[[], str]] = [lambda: "outer", fail, lambda: "inner"]
    with (
        interruption.kept_by(keepers[0]),
        interruption.kept_by(keepers[1]),
        interruption.kept_by(keepers[2]),
    ):
        assert interruption.keep_all() == "inner; not saved: the disk is full; outer"
    assert interruption.keep_all() == ""
