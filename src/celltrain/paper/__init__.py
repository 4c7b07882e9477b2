"""The paper's figures: studies that compute them, and what it says about them beside ours."""

from celltrain.paper.figures import FIGURES, PaperFigure, paper_study
from celltrain.paper.finding import Finding, findings_table
from celltrain.paper.statements import growth_findings, transient_findings

__all__ = [
    "FIGURES",
    "Finding",
    "PaperFigure",
    "findings_table",
    "growth_findings",
    "paper_study",
    "transient_findings",
]
