"""The package's version, for `pyproject.toml` and for whatever says who made it."""

__version__ = "0.1.0"
