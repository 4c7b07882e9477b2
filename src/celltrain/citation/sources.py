"""All sources by their keys; `docs/bibliography.md` is made from them."""

from celltrain.citation.analysis import ANALYSIS
from celltrain.citation.comparisons import COMPARISONS
from celltrain.citation.membranes_and_flow import MEMBRANES_AND_FLOW
from celltrain.citation.source import Source
from celltrain.version import __version__

SOFTWARE = Source(
    key="celltrain",
    kind="misc",
    authors=("the celltrain developers",),
    title="celltrain: trains of red blood cells in narrow tubes and their stability",
    where=f"Python package, version {__version__}",
    note="This package.",
)
PAPER = Source(
    key="Bryngelson & Freund 2018",
    kind="article",
    authors=("S. H. Bryngelson", "J. B. Freund"),
    title="Global stability of flowing red blood cell trains",
    where="Physical Review Fluids",
    volume="3",
    pages="073101",
    year=2018,
    doi="10.1103/PhysRevFluids.3.073101",
    note="The study that this package makes fast; its equations are the ones quoted by number.",
    modules=("laws.constitutive", "stability.norms"),
)
#: All of them, by their keys.
SOURCES = tuple(
    sorted((PAPER, *MEMBRANES_AND_FLOW, *ANALYSIS, *COMPARISONS), key=lambda source: source.key)
)
