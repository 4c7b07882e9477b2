"""The command that completes a case: ``celltrain case``."""

import sys

from celltrain.cli.arguments import CaseFile
from celltrain.cli.options import CaseOptions, given_leaves
from celltrain.parameters import merge_case, read_case


def case(case: CaseFile = None, /, *, options: CaseOptions = None) -> int:
    """Print the complete case as TOML, dimensionless: what a computation would use."""
    train = merge_case(read_case(case) if case else {}, given_leaves(options))
    sys.stdout.write(train.to_toml())
    return 0
