"""Ways to install: what the conda recipe asks for is what the package asks for."""

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest

from celltrain import __version__

yaml = pytest.importorskip("yaml")

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
#: What conda-forge calls otherwise: the part of matplotlib without windows is enough.
NAMES = {"matplotlib": "matplotlib-base"}


def recipe() -> dict[str, Any]:
    content: dict[str, Any] = yaml.safe_load(
        (ROOT / "packaging" / "conda" / "recipe.yaml").read_text(encoding="utf-8")
    )
    return content


def required(*lists: list[str]) -> dict[str, str]:
    """Conditions on versions by name, of requirements as pip or conda writes them."""
    found = {}
    for requirement in (each for some in lists for each in some):
        name, condition = re.fullmatch(r"([\w.-]+) *(.*)", requirement).groups()
        found[NAMES.get(name, name)] = condition
    return found


def test_the_recipe_asks_for_what_the_package_asks_for() -> None:
    python = {"python": PROJECT["requires-python"]}
    asked = recipe()["requirements"]
    assert required(asked["run"]) == required(PROJECT["dependencies"]) | python
    extras = PROJECT["optional-dependencies"]
    users = (extras[name] for name in ("simulations", "studies", "explore"))
    assert required(asked["run_constraints"]) == required(*users)
    assert recipe()["context"]["version"] == __version__


def test_the_recipe_builds_as_the_package_does() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    host = required(recipe()["requirements"]["host"])
    assert required(project["build-system"]["requires"]).items() <= host.items()
    [entry] = recipe()["build"]["python"]["entry_points"]
    name, _, function = entry.partition(" = ")
    assert PROJECT["scripts"] == {name: function}
