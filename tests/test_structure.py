"""Rooms of the package stand in the order in which data pass them; imports point one way."""

import ast
import importlib
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

import celltrain

SOURCE = Path(celltrain.__file__).parent
ROOT = Path(__file__).resolve().parent.parent
#: Each may import those before it.
ROOMS = (
    "xla_flags",
    "environment",
    "extras",
    "later",
    "version",
    "clock",
    "interruption",
    "runtime",
    "programs",
    "parts",
    "laws",
    "quantities",
    "parameters",
    "harmonics",
    "membrane",
    "meridian",
    "compiled",
    "proximity",
    "steady",
    "stability",
    "continuation",
    "flow",
    "surroundings",
    "train",
    "diagnostics",
    "results",
    "contract",
    "citation",
    "evolution",
    "study",
    "pictures",
    "paper",
    "analyses",
    "explore",
    "cli",
    "__main__",
)
#: What the main job passes through; none of it imports JAX.
WITHOUT_JAX = (
    "laws",
    "parameters",
    "harmonics",
    "membrane",
    "meridian",
    "proximity",
    "steady",
    "stability",
    "study",
)
#: Modules for cells of any shape that stand beside those of their subject.
WITH_JAX = {
    f"harmonics/{name}.py"
    for name in ("grid", "jax_shapes", "longitude", "polar", "rotation", "tables")
} | {"membrane/energy.py", "membrane/geometry.py"}
WITH_JAX |= {f"proximity/{name}.py" for name in ("nearest", "chunks", "close_pairs")}


def files() -> list[Path]:
    return sorted(SOURCE.rglob("*.py"))


def imported(path: Path) -> set[str]:
    """Names of the modules that a file imports, wherever it does so."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and node.module:
            found.add(node.module)
        elif isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
    return found


def room(path: Path) -> str:
    return path.relative_to(SOURCE).parts[0].removesuffix(".py")


@pytest.mark.parametrize("name", ROOMS)
def test_imports_point_one_way(name: str) -> None:
    allowed = set(ROOMS[: ROOMS.index(name) + 1])
    for path in files():
        if room(path) != name:
            continue
        inner = {each for each in imported(path) if each.startswith("celltrain.")}
        reached = {each.split(".")[1] for each in inner}
        assert reached <= allowed, path


def test_every_room_has_its_place() -> None:
    assert {room(path) for path in files()} - {"__init__"} == set(ROOMS)


def test_the_main_job_names_no_jax() -> None:
    for path in files():
        if room(path) in WITHOUT_JAX and str(path.relative_to(SOURCE)) not in WITH_JAX:
            names = {each.split(".")[0] for each in imported(path)}
            assert not names & {"jax", "equinox", "jaxlib"}, path


def module(path: Path) -> str:
    parts = ("celltrain", *path.relative_to(SOURCE).with_suffix("").parts)
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def test_no_modules_import_each_other() -> None:
    """Nor in a circle, wherever in a file they do it; a package counts for its own file."""
    known = {module(path): path for path in files()}
    graph: dict[str, set[str]] = {}
    for name, path in known.items():
        graph[name] = set()
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Import):
                graph[name] |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module:
                inner = {f"{node.module}.{alias.name}" for alias in node.names}
                graph[name] |= inner & known.keys() or {node.module}
        graph[name] &= known.keys() - {name}
    TopologicalSorter(graph).prepare()


def test_no_file_is_long() -> None:
    for path in files():
        assert len(path.read_text().splitlines()) <= 400, path


def test_no_two_classes_have_one_name() -> None:
    found: dict[str, Path] = {}
    for path in files():
        for node in ast.parse(path.read_text()).body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                assert node.name not in found, f"{node.name}: {found[node.name]} and {path}"
                found[node.name] = path


def test_what_is_public_says_what_it_is() -> None:
    def look(node: ast.AST, path: Path) -> None:
        for each in ast.iter_child_nodes(node):
            if not isinstance(each, ast.FunctionDef | ast.ClassDef) or each.name.startswith("_"):
                continue
            if any(getattr(made, "id", "") == "overload" for made in each.decorator_list):
                continue
            assert ast.get_docstring(each), f"{path}: {each.name}"
            if isinstance(each, ast.ClassDef):
                look(each, path)

    for path in files():
        tree = ast.parse(path.read_text())
        assert ast.get_docstring(tree), path
        look(tree, path)


SCRIPTS = sorted(
    path
    for folder in ("validation", "benchmarks", "examples", "docs/extensions", "docs/images")
    for path in (ROOT / folder).glob("*.py")
)


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: f"{path.parent.name}/{path.name}")
def test_what_scripts_take_from_the_package_is_there(path: Path) -> None:
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if not isinstance(node, ast.ImportFrom) or not (node.module or "").startswith("celltrain"):
            continue
        module = importlib.import_module(str(node.module))
        for each in node.names:
            if not hasattr(module, each.name):
                importlib.import_module(f"{node.module}.{each.name}")
