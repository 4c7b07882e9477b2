"""How many compiled programs a process keeps.

JAX keeps all programs that it has compiled. Those of one train at one set of rules (its base flow
and linear dynamics) take about 0.25 GiB and 9000 memory areas; Linux gives a process 65530 of
these, and ends it with a segmentation fault where one more is needed. A process that goes from
train to train therefore forgets its programs now and then; the persistent cache still has them.
"""

import gc
import os
from pathlib import Path

import jax

import celltrain.runtime  # noqa: F401

_PROCESS = Path("/proc/self")
_MOST_AREAS = Path("/proc/sys/vm/max_map_count")
# Memory, in bytes, that a process may always take.
LEAST_MEMORY = 2 * 2**30


def forget_many_programs() -> bool:
    """Drop this process's compiled programs if they are many, and say whether.

    Many: they take half of the memory areas that a process may have, or with all its other data
    more memory (2 GiB or more) than half of its share, the machine's memory by the number of its
    processors. Where the system does not tell, nothing is dropped.
    """
    if not _too_many():
        return False
    jax.clear_caches()
    gc.collect()
    return True


def _too_many() -> bool:
    if not (_PROCESS / "maps").exists():
        return False
    with (_PROCESS / "maps").open("rb") as areas:
        if 2 * sum(1 for _ in areas) > int(_MOST_AREAS.read_text()):
            return True
    page = os.sysconf("SC_PAGE_SIZE")
    share = os.sysconf("SC_PHYS_PAGES") * page // (os.cpu_count() or 1)
    resident = int((_PROCESS / "statm").read_text().split()[1]) * page
    return resident > max(LEAST_MEMORY, share // 2)
