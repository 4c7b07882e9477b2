"""How XLA is to compile, said before it is loaded."""

import os
from importlib.metadata import version

EMITTERS = "xla_cpu_use_fusion_emitters"


def xla_flags() -> str:
    """`$XLA_FLAGS`, with XLA's older emitters of loops for processors unless they are named there.

    The newer ones build a pipeline of passes for each of a program's hundreds of loops, and compile
    for half as long again, for loops that are no faster. XLA ends the process when it meets a flag
    that it does not know: so only for versions tried.
    """
    given = os.environ.get("XLA_FLAGS", "")
    if EMITTERS in given or not version("jaxlib").startswith("0.10."):
        return given
    return f"{given} --{EMITTERS}=false".strip()
