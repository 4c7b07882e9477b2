"""Which sources a result rests on: those of the modules that its kind and its case take part in."""

from celltrain.citation.source import Source
from celltrain.citation.sources import PAPER, SOURCES
from celltrain.contract import presentation
from celltrain.parameters import CaseError, Train
from celltrain.quantities import Record

#: Modules of every steady train, and what results of further kinds are made with besides.
STEADY = ("laws", "membrane", "harmonics", "meridian", "steady")
DYNAMICS = (*STEADY, "stability.spectrum", "stability.norms")
THREE_DIMENSIONS = ("flow", "train")
KINDS = {
    "base": STEADY,
    "branch": (*DYNAMICS, "continuation.arclength"),
    "boundary": (*DYNAMICS, "continuation.arclength"),
    "sample": (*DYNAMICS, "study.sampling"),
    "search": (*STEADY, "continuation.deflation"),
    "transient": (*DYNAMICS, "stability.transient"),
    "pseudospectrum": (*DYNAMICS, "stability.pseudospectrum"),
    "sensitivity": (*DYNAMICS, "stability.adjoint"),
    "streamlines": (*STEADY, *THREE_DIMENSIONS),
    "simulation": (*DYNAMICS, *THREE_DIMENSIONS, "evolution"),
}
#: For what depends on the case: its source's key, and whether a case uses it.
ONLY_WITH = {
    "Barthes-Biesel, Diaz & Dhenin 2002": lambda train: train.cell.law == "neo_hookean",
    "Evans & Fung 1972": lambda train: train.cell.reference == "biconcave",
    "Helfrich 1973": lambda train: train.cell.bending == "helfrich",
    "Nocedal & Wright 2006": lambda train: train.cell.reduced_volume is not None,
    "RBC3D": lambda train: train.cell.bending in ("moments", "balanced_moments"),
    "Saad & Schultz 1986": lambda train: train.flow.viscosity_ratio != 1.0,
    "Skalak, Tozeren, Zarda & Chien 1973": lambda train: train.cell.law == "skalak",
}


def sources_of(result: Record) -> tuple[Source, ...]:
    """The sources that the methods of a result rest on, but for the paper, by their keys.

    Of a result without one case, such as a study, what depends on the case is left out.
    """
    used = KINDS.get(result.kind, DYNAMICS)
    train = _train(result)
    found = []
    for source in SOURCES:
        depends = ONLY_WITH.get(source.key)
        if source is PAPER or (depends is not None and (train is None or not depends(train))):
            continue
        if source.key == "Neu & Meiselman 2002" and not _repels(result):
            continue
        if any(
            module == name or module.startswith(f"{name}.")
            for module in source.modules
            for name in used
        ):
            found.append(source)
    return tuple(found)


def _train(result: Record) -> Train | None:
    try:
        return presentation(result.kind).steady_train(result).train
    except (AttributeError, CaseError):  # it holds numbers only
        return None


def _repels(result: Record) -> bool:
    repulsion = getattr(result, "repulsion", None)
    return repulsion is not None and repulsion.range > 0.0
