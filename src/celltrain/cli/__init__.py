"""The command line: ``celltrain stability``, ``celltrain base``, ``celltrain case``."""

from celltrain.cli.app import main

__all__ = ["main"]
