"""A clock that tells compilation from running."""

import time
from collections.abc import Iterator
from contextlib import contextmanager


class CompileClock:
    """Seconds spent in tracing, lowering and compiling, overlapping reports counted once."""

    def __init__(self) -> None:
        self._spans: list[tuple[float, float]] = []
        self._settled = 0.0

    def listen(self, event: str, duration_secs: float, **_: str | int) -> None:
        """Take one of JAX's reports."""
        if event.startswith("/jax/core/compile/"):
            self.add(duration_secs)

    def add(self, duration_secs: float) -> None:
        """Count what has just ended."""
        end = time.perf_counter()
        start = end - duration_secs
        # Reports come when a span ends, so a longer one replaces those that it encloses.
        while self._spans and self._spans[-1][0] >= start:
            self._spans.pop()
        self._spans.append((start, end))
        if len(self._spans) > 1000:
            oldest = self._spans.pop(0)
            self._settled += oldest[1] - oldest[0]

    def seconds(self) -> float:
        """All of them so far."""
        return self._settled + sum(end - start for start, end in self._spans)


#: What JAX reports to where it is used (see `runtime`); it stands still otherwise.
compilation = CompileClock()


@contextmanager
def timed(seconds: dict[str, float], stage: str) -> Iterator[None]:
    """Add the time of a block to `seconds[stage]`, its compilation to `seconds["compile"]`.

    What a block computes must be fetched or waited for inside it.
    """
    begin, compiled = time.perf_counter(), compilation.seconds()
    try:
        yield
    finally:
        compiling = compilation.seconds() - compiled
        seconds["compile"] = seconds.get("compile", 0.0) + compiling
        elapsed = time.perf_counter() - begin - compiling
        seconds[stage] = seconds.get(stage, 0.0) + max(elapsed, 0.0)
