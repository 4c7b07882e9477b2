"""Which analyses there are: one for each file of `celltrain.analyses`, named as the file.

Names and first lines of help are known without importing any of them: by `result`, which the class
of an analysis has, or `argument`, which that of a computation of many cases has.
"""

import ast
import inspect
import sys
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from celltrain import analyses

if TYPE_CHECKING:
    from celltrain.contract.analysis import Analysis, Presentation
    from celltrain.contract.in_folder import InFolder

Wanted = TypeVar("Wanted")

#: Commands that are no analyses, after which none can be named.
TAKEN = ("case", "cite", "explore", "page", "plot", "show")


class _Declared(NamedTuple):
    """What is known of a file that is not imported."""

    #: The file's own name, without a leading underscore.
    name: str
    #: The name of its command, if it is another one.
    command: str
    #: The first line of its docstring.
    line: str
    #: Whether it computes many cases.
    of_many: bool


@cache
def _files() -> dict[str, Path]:
    """The file of each kind of result; the package's own come first."""
    found: dict[str, Path] = {}
    for folder in analyses.__path__:
        if not Path(folder).is_dir():
            _warn(f"the folder {folder!r} is not there")
        for path in sorted(Path(folder).glob("[!.]*.py")):
            name = path.stem.removeprefix("_")
            if path.stem == "__init__":
                continue
            if name in found or name in TAKEN:
                _warn(f"{path} is left out: there is a command or a kind of result {name!r}")
                continue
            found[name] = path
    return dict(sorted(found.items()))


def _warn(message: str) -> None:
    print(f"celltrain: CELLTRAIN_ANALYSES: {message}", file=sys.stderr)


def kinds() -> tuple[str, ...]:
    """The kinds of all results, in alphabetical order.

    Those whose file begins with an underscore are computed by commands of other names.
    """
    of_many = {each.name for each in _commands().values() if each.of_many}
    return tuple(name for name in _files() if name not in of_many)


@cache
def first_lines() -> dict[str, str]:
    """The first line of each analysis' docstring, by the name of its command."""
    return {command: each.line for command, each in sorted(_commands().items())}


def commands() -> tuple[str, ...]:
    """The names of all analyses' commands, in alphabetical order."""
    return tuple(first_lines())


@cache
def _commands() -> dict[str, _Declared]:
    """What the file of each command declares."""
    declared = (
        _declared(name, path) for name, path in _files().items() if not path.stem.startswith("_")
    )
    return {each.command or each.name: each for each in declared}


def analysis_named(name: str) -> "type[Analysis[Any] | InFolder]":
    """The analysis, or the computation of many cases, whose command has this name.

    Raises:
        KeyError: if there is none.
        TypeError: if its file does not define one.
    """
    from celltrain.contract.analysis import Analysis
    from celltrain.contract.in_folder import InFolder

    if name not in commands():
        raise KeyError(f"there is no analysis {name!r}; there are: {', '.join(commands())}")
    declared = _commands()[name]
    if declared.of_many:
        return _defined(declared.name, InFolder)
    found = presentation(declared.name)
    assert issubclass(found, Analysis)
    return found


@cache
def presentation(kind: str) -> "type[Presentation[Any]]":
    """How results of a kind are shown: an analysis, or what has a command of its own.

    Raises:
        KeyError: if there is no such kind.
        TypeError: if its file does not define one analysis whose results are of this kind.
    """
    if kind not in kinds():
        raise KeyError(f"there is no kind of result {kind!r}; there are: {', '.join(kinds())}")
    from celltrain.contract.analysis import Presentation  # and with it all that computes

    found = _defined(kind, Presentation)  # type: ignore[type-abstract]
    if found.result.kind != kind:
        raise TypeError(
            f"the results in {_files()[kind]} are of the kind {found.result.kind!r}; wanted is"
            f" the file's name, {kind!r}"
        )
    return found


def _defined(name: str, base: type[Wanted]) -> type[Wanted]:
    """The one class of this base that the file of a name defines.

    Raises:
        TypeError: if there is not one.
    """
    module = import_module(f"{analyses.__name__}.{_files()[name].stem}")
    found = [
        each
        for each in vars(module).values()
        if isinstance(each, type)
        and issubclass(each, base)
        and each.__module__ == module.__name__
        and not inspect.isabstract(each)
    ]
    if len(found) != 1:
        raise TypeError(f"{_files()[name]} defines {len(found)} analyses; wanted is one")
    return found[0]


def _assigned(node: ast.stmt) -> str:
    """The name that a statement gives a value."""
    targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
    return next((each.id for each in targets if isinstance(each, ast.Name)), "")


def first_line(path: Path, name: str) -> str:
    """The first line of the docstring of a function in a file, which is not imported."""
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.FunctionDef) and node.name == name:
            return _first_line(node)
    raise AttributeError(f"{path} defines no function {name!r}")


def _first_line(node: ast.FunctionDef | ast.ClassDef) -> str:
    return (ast.get_docstring(node) or "No description.").splitlines()[0]


def _declared(name: str, path: Path) -> _Declared:
    """What the class in a file says that is an analysis, or computes many cases."""
    try:
        parts = ast.parse(path.read_text(encoding="utf-8")).body
    except (OSError, SyntaxError, ValueError) as error:
        return _Declared(name, "", f"Cannot be used: {error}.", of_many=False)
    for node in parts:
        if not isinstance(node, ast.ClassDef):
            continue
        named = {_assigned(each): each for each in node.body}
        if "result" in named or "argument" in named:
            value = getattr(named.get("command"), "value", None)
            command = str(value.value) if isinstance(value, ast.Constant) else ""
            return _Declared(name, command, _first_line(node), of_many="argument" in named)
    line = f"Cannot be used: {path} defines no analysis."
    return _Declared(name, "", line, of_many=False)
