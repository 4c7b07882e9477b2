"""How many compiled programs a process keeps.

JAX keeps all programs that it has compiled. Those of one train at one set of rules (its base flow
and linear dynamics) take about 0.25 GiB and 9000 memory areas; Linux gives a process 65530 of
these, and ends it with a segmentation fault where one more is needed. A process that goes from
train to train therefore forgets its programs now and then; the persistent cache still has them.
"""

import gc
import os
from dataclasses import dataclass
from pathlib import Path

import jax

import celltrain.runtime  # noqa: F401

_PROCESS = Path("/proc/self")
_MOST_AREAS = Path("/proc/sys/vm/max_map_count")
# Growth of the memory, in bytes, that is always allowed.
LEAST_GROWTH = 2**30


@dataclass(frozen=True)
class _Taken:
    """Memory areas and bytes of memory that this process takes."""

    areas: int
    memory: int


# What it took when programs were last forgotten, or when it was first asked for.
_last: _Taken | None = None


def forget_many_programs() -> bool:
    """Drop this process's compiled programs if they have become many, and say whether.

    Many: since the last time the process has grown by half of the memory areas that it may have, or
    by a third of its share of the memory, the machine's by the number of its processors (1 GiB at
    least). It is the growth that counts, so that a process with much else in its memory does not
    drop them over and over. Where the system does not tell, nothing is dropped.
    """
    global _last
    taken = _taken()
    if taken is None:
        return False
    if _last is None:
        _last = taken
    share = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") // (os.cpu_count() or 1)
    many_areas = 2 * (taken.areas - _last.areas) > int(_MOST_AREAS.read_text())
    if not many_areas and taken.memory - _last.memory <= max(LEAST_GROWTH, share // 3):
        return False
    jax.clear_caches()
    gc.collect()
    _last = _taken()
    return True


def _taken() -> _Taken | None:
    if not _MOST_AREAS.exists():
        return None
    with (_PROCESS / "maps").open("rb") as areas:
        count = sum(1 for _ in areas)
    pages = int((_PROCESS / "statm").read_text().split()[1])
    return _Taken(count, pages * os.sysconf("SC_PAGE_SIZE"))
