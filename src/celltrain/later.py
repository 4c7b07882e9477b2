"""Names of packages whose modules are imported when the names are asked for: some take seconds."""

from collections.abc import Callable, Mapping, Sequence
from importlib import import_module

from celltrain.extras import check_installed


def imported_later(
    package: str, names: Mapping[str, Sequence[str]], extra: str = ""
) -> Callable[[str], object]:
    """A package's `__getattr__`, by the names that each of its modules has.

    **Arguments:** `extra`: with which these modules are installed, if they need one.
    """
    owners = {name: module for module, each in names.items() for name in each}

    def find(name: str) -> object:
        if name not in owners:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        if extra:
            check_installed(extra)
        return getattr(import_module(f"{package}.{owners[name]}"), name)

    return find
