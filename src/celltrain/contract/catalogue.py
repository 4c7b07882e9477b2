"""Which analyses there are: one for each file of `celltrain.analyses`, named as the file.

Names and first lines of help are known without importing any of them.
"""

import ast
import inspect
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from celltrain.contract.analysis import Analysis, Presentation

PACKAGE = "celltrain.analyses"


@cache
def _folder() -> Path:
    spec = find_spec(PACKAGE)
    assert spec is not None
    assert spec.submodule_search_locations
    return Path(next(iter(spec.submodule_search_locations)))


@cache
def commands() -> tuple[str, ...]:
    """The names of all analyses, in alphabetical order."""
    return tuple(name for name in kinds() if not (_folder() / f"_{name}.py").exists())


@cache
def kinds() -> tuple[str, ...]:
    """The kinds of all results, in alphabetical order.

    Those whose file begins with an underscore are computed by commands of their own.
    """
    files = (path.stem for path in _folder().glob("*.py") if path.stem != "__init__")
    return tuple(sorted(name.removeprefix("_") for name in files))


def first_lines() -> dict[str, str]:
    """The first line of each analysis' docstring, by name."""
    return {name: _first_line(_folder() / f"{name}.py") for name in commands()}


def analysis_named(name: str) -> "type[Analysis[Any]]":
    """The analysis of a name.

    Raises:
        KeyError: if there is none.
    """
    from celltrain.contract.analysis import Analysis

    if name not in commands():
        raise KeyError(f"there is no analysis {name!r}; there are: {', '.join(commands())}")
    found = presentation(name)
    assert issubclass(found, Analysis)
    return found


@cache
def presentation(kind: str) -> "type[Presentation[Any]]":
    """How results of a kind are shown: an analysis, or what has a command of its own.

    Raises:
        KeyError: if there is no such kind.
    """
    if kind not in kinds():
        raise KeyError(f"there is no kind of result {kind!r}; there are: {', '.join(kinds())}")
    from celltrain.contract.analysis import Presentation  # and with it all that computes

    module = import_module(f"{PACKAGE}.{kind if kind in commands() else f'_{kind}'}")
    found = [
        each
        for each in vars(module).values()
        if isinstance(each, type)
        and issubclass(each, Presentation)
        and each.__module__ == module.__name__
        and not inspect.isabstract(each)
    ]
    assert len(found) == 1, f"{module.__name__} defines {len(found)} analyses, not one"
    return found[0]


def _first_line(path: Path) -> str:
    """Of the class in a file that is a result's analysis: the one with a field `result`."""
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.ClassDef) and any(
            isinstance(each, ast.Assign) and getattr(each.targets[0], "id", "") == "result"
            for each in node.body
        ):
            return (ast.get_docstring(node) or "").splitlines()[0]
    raise AssertionError(f"{path} defines no analysis")
