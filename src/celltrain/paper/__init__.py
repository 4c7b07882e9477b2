"""The paper's maps: studies that compute them, and what the paper says about them beside ours."""

from celltrain.paper.figures import FIGURES, PaperFigure, paper_study
from celltrain.paper.statements import (
    Finding,
    findings_table,
    growth_findings,
    transient_findings,
)

__all__ = [
    "FIGURES",
    "Finding",
    "PaperFigure",
    "findings_table",
    "growth_findings",
    "paper_study",
    "transient_findings",
]
