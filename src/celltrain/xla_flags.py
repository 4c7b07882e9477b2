"""How XLA is to compile, said before it is loaded."""

import os
from importlib.util import find_spec

EMITTERS = "xla_cpu_use_fusion_emitters"


def xla_flags() -> str:
    """`$XLA_FLAGS`, with XLA's older emitters of loops for processors unless they are named there.

    The newer ones build a pipeline of passes for each of a program's hundreds of loops, and compile
    for half as long again, for loops that are no faster. XLA ends the process when it meets a flag
    that it does not know: so only for versions tried.
    """
    given = os.environ.get("XLA_FLAGS", "")
    if EMITTERS in given or not _installed("jaxlib", "0.10."):
        return given
    return f"{given} --{EMITTERS}=false".strip()


def _installed(name: str, version: str) -> bool:
    """Whether a package is installed in a version that begins so, by the folder of its metadata.

    `importlib.metadata` takes longer to load than all else that comes before signals are heard.
    """
    found = find_spec(name)
    if found is None or found.origin is None:
        return False
    beside = os.listdir(os.path.dirname(os.path.dirname(found.origin)))
    return any(
        each.startswith(f"{name}-{version}") and each.endswith(".dist-info") for each in beside
    )
