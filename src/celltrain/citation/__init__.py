"""What to cite: the package, the paper, and the sources that a result's methods rest on."""

from celltrain.citation.source import Source
from celltrain.citation.sources import PAPER, SOFTWARE, SOURCES
from celltrain.citation.used import sources_of

__all__ = ["PAPER", "SOFTWARE", "SOURCES", "Source", "sources_of"]
