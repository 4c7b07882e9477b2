"""``python -m celltrain``: the command line, for whichever Python is meant."""

import sys

from celltrain.cli import main

# Workers of a study import this module, too.
if __name__ == "__main__":
    sys.exit(main())
