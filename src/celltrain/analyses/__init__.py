"""Everything that celltrain computes, one analysis in a file (see `celltrain.contract`).

Analyses of one's own are files like these in a folder that the environment variable
`CELLTRAIN_ANALYSES` names, or in several, separated as in `PATH`: they are commands, and what they
save is loaded, shown and drawn as everything else.
"""

import os

__path__ = [
    *__path__,
    *(each for each in os.environ.get("CELLTRAIN_ANALYSES", "").split(os.pathsep) if each),
]
