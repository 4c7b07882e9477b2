"""The command that completes a case: ``celltrain case``."""

import sys

from celltrain.cli.arguments import CaseFile
from celltrain.cli.keeping import Keeper
from celltrain.cli.options import CaseOptions, given_leaves
from celltrain.parameters import merge_case, read_case


def case(case: CaseFile = None, /, *, options: CaseOptions = None) -> int:
    """Print the complete case as TOML, dimensionless: what a computation would use."""
    leaves = given_leaves(options)
    if case is not None and case.suffix.lower() == ".nc":
        # What files need takes a second to load.
        from celltrain.cli.compute import Request, read_request

        content: dict[str, object] = {}
        train, _, _ = read_request(Request(case=case), leaves)
    else:
        content = read_case(case) if case else {}
        train = merge_case(content, leaves)
    unusual = leaves.get("unusual", content.get("unusual", False))
    keeper = Keeper()
    text = train.to_toml()
    if unusual:
        text = f"unusual = true\n{text}"
    keeper.show(lambda: sys.stdout.write(text))
    return keeper.status
