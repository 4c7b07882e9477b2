"""Loops of tests whose parts several threads compute; importing this compiles them."""

import math

from celltrain.compiled.call_frame import numbers, result, set_word, word
from celltrain.compiled.shared_work import frame_of, next_part, task

COUNTING, SEEING, DIVIDING, MARKING, FAILING = (
    f"celltrain_test_{name}" for name in ("counting", "seeing", "dividing", "marking", "failing")
)
# Words of the work: the frame, the loop, who computes, whether it is closed, who holds it.
FRAME, LOOP, COMPUTING, CLOSED, HOLDERS, WORDS = 0, 1, 3, 4, 5, 6


@task(COUNTING)
def count(work: int) -> int:
    frame = frame_of(work)
    given, found = numbers(frame, 0), result(frame)
    part = next_part(work)
    while part < found.size:
        value = given[part % given.size]
        for _ in range(2000):
            value = math.cos(value)
        found[part] += 1.0 + 0.0 * value
        part = next_part(work)
    return 1


@task(MARKING)
def mark(work: int) -> int:
    set_word(frame_of(work), 1)
    return 1


@task(SEEING)
def see(work: int) -> int:
    found = result(frame_of(work))
    part = next_part(work)
    while part < found.size:
        for _ in range(2000):
            now = word(work + 8 * COMPUTING)
            if now > found[part]:
                found[part] = now
        part = next_part(work)
    return 1


@task(DIVIDING)
def divide(work: int) -> int:
    frame = frame_of(work)
    given, found = numbers(frame, 0), result(frame)
    part = next_part(work)
    while part < found.size:
        found[part] = 1.0 / given[part]
        part = next_part(work)
    return 1


@task(FAILING)
def fail(work: int) -> int:
    given = numbers(frame_of(work), 0)
    if given[0] < 0.0:
        raise ValueError("negative")
    result(frame_of(work))[:] = given
    return 1
