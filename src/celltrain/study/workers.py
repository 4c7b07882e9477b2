"""Workers for a study: processes of this machine, or those of a scheduler that runs already.

Uses dask.distributed, which comes with the extra `studies` and is imported only here, when needed.
"""

import logging
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from dataclasses import dataclass

from celltrain.environment import ONE_THREAD
from celltrain.extras import check_installed
from celltrain.parameters import CaseError

# Seconds to wait for a scheduler's answer.
PATIENCE = 20


@dataclass(frozen=True)
class Workers:
    """What computes the cases: an executor, how many cases at a time, and a line about it."""

    executor: Executor
    slots: Callable[[], int]
    description: str


@contextmanager
def local_workers(count: int | None = None) -> Iterator[Workers]:
    """Processes of this machine with one thread each, as many as there are processors unless given.

    Each may use its share of the machine's memory; one that takes more is ended and replaced.

    **Raises:** `CaseError` if `count` is not allowed, `MissingExtra` if dask.distributed is not
    installed.
    """
    check_installed("studies")
    if count is not None and count < 1:
        raise CaseError(f"workers = {count} is not allowed; allowed: a whole number >= 1")
    import dask
    from dask.system import CPU_COUNT
    from distributed import Client, LocalCluster

    number = CPU_COUNT if count is None else count
    settings = {
        # Whether a case is tried again is decided where its record is written.
        "distributed.scheduler.allowed-failures": 0,
        # A case that waits on a worker would go down with the one that it computes.
        "distributed.scheduler.worker-saturation": 1.0,
        # Results are small; what fills the memory is a computation, which cannot be put aside.
        "distributed.worker.memory.target": False,
        "distributed.worker.memory.spill": False,
        "distributed.worker.memory.pause": False,
        "distributed.worker.memory.terminate": 0.95,
    }
    with (
        dask.config.set(settings),
        LocalCluster(
            n_workers=number,
            threads_per_worker=1,
            processes=True,
            # Any free port: another study may be running.
            dashboard_address="127.0.0.1:0",
            silence_logs=logging.CRITICAL,
            env=dict(ONE_THREAD),
        ) as cluster,
        Client(cluster) as client,
    ):
        executor = client.get_executor(pure=False)
        # One that died is missing until it is replaced: no case should wait for another meanwhile.
        yield Workers(
            executor,
            lambda: sum(client.nthreads().values()),
            f"{number} processes of this machine",
        )


@contextmanager
def scheduled_workers(address: str) -> Iterator[Workers]:
    """The workers of the dask scheduler at an address such as ``tcp://node1:8786``.

    **Raises:** `CaseError` if it cannot be reached, `MissingExtra` if dask.distributed is not
    installed.
    """
    check_installed("studies")
    from distributed import Client

    try:
        client = Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError) as error:
        raise CaseError(f"scheduler = {address!r} cannot be reached: {error}") from None
    with client:
        yield Workers(
            client.get_executor(pure=False),
            lambda: sum(client.nthreads().values()),
            f"the workers of {address}",
        )
