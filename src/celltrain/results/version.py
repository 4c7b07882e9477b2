"""The version of the package that made a result."""

from importlib.metadata import PackageNotFoundError
from importlib.metadata import version as installed_version


def version() -> str:
    """Version of the installed package; "unknown" when it runs from a bare source folder."""
    try:
        return installed_version("celltrain")
    except PackageNotFoundError:
        return "unknown"
