"""Pages that are written when the site is built: commands, Python, examples, what is at the root.

They go to `docs/generated`, which is not part of the repository. A page is only written anew when
its text changes, so that a second build is short.
"""

import ast
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import celltrain
from celltrain.cli.app import COMMANDS
from celltrain.cli.app import app as commands

PACKAGE = Path(celltrain.__file__).parent
ROOT = Path(__file__).parents[2]
#: Options that every command of a case has, told once.
CASE_GROUPS = ("Units", "Tube", "Cell", "Train", "Flow", "Resolution", 'Scales (with units "SI")')
#: Rooms without a page for each module: commands have their own page.
LEFT_OUT = {"cli", "analyses"}


def write(app: Any) -> None:
    """Write all pages."""
    folder = Path(app.srcdir) / "generated"
    pages = {
        "commands.md": command_page(),
        "examples.md": example_page(),
        "contributing.md": at_root("CONTRIBUTING.md"),
        "changelog.md": at_root("CHANGELOG.md"),
        **python_pages(),
    }
    for name, text in pages.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.is_file() or path.read_text() != text:
            path.write_text(text)
    for path in folder.rglob("*.md"):
        if str(path.relative_to(folder)) not in pages:
            path.unlink()


def command_page() -> str:
    """The commands, from their own descriptions."""
    lines = [
        "# Commands",
        "",
        "Made from the commands themselves; `celltrain NAME --help` prints the same. Exit statuses:"
        " [what is promised when something goes wrong](../reliability.md).",
        "",
        *(
            f"- [`celltrain {name}`](#celltrain-{name}): {line}"
            for name, (_, line) in COMMANDS.items()
        ),
        "",
    ]
    case: dict[str, str] = {}
    for name in COMMANDS:
        groups = _groups(commands[name].generate_docs(output_format="markdown"))
        head = groups.pop("")
        head = re.sub(r"\A# \S+", f"## celltrain {name}", head)
        lines.append(head.replace(f"console\n{name}", f"console\n$ celltrain {name}"))
        for title, text in groups.items():
            if title in CASE_GROUPS:
                case[title] = text
            else:
                lines += [f"**{title}**", "", text]
        if set(groups) & set(CASE_GROUPS):
            lines += ["and the [options of a case](#options-of-a-case).", ""]
    lines += [
        "## Options of a case",
        "",
        "Whoever takes a case takes these; they override those of a case file.",
        "",
    ]
    for title, text in case.items():
        lines += [f"**{title}**", "", text]
    return "\n".join(lines) + "\n"


def _groups(text: str) -> dict[str, str]:
    """What stands before the first group of options, as "", and each group by its title."""
    parts = re.split(r"^\*\*(.+)\*\*:$", text, flags=re.MULTILINE)
    found = {"": parts[0].strip() + "\n"}
    for title, body in zip(parts[1::2], parts[2::2], strict=True):
        # The name under which options of a group are collected is none of theirs.
        kept = [line for line in body.strip().splitlines() if not re.match(r"\* `\* ", line)]
        if kept:
            found[title] = "\n".join(kept) + "\n"
    return found


def example_page() -> str:
    """The examples, as they are."""
    lines = [
        "# Examples",
        "",
        "Programs in the folder `examples`; each says how long it takes.",
        "",
    ]
    for path in sorted((ROOT / "examples").glob("*.py")):
        first = (ast.get_docstring(ast.parse(path.read_text())) or "").splitlines()[0]
        lines += [f"## {path.name}", "", first, ""]
        lines += [
            f"```{{literalinclude}} ../../examples/{path.name}",
            ":language: python",
            "```",
            "",
        ]
    return "\n".join(lines)


def at_root(name: str) -> str:
    """A page that stands beside the package, with its links as they are from `docs/generated`."""
    text = (ROOT / name).read_text()
    return re.sub(r"\]\(docs/", "](../", re.sub(r"\]\((examples|src)/", r"](../../\1/", text))


def python_pages() -> dict[str, str]:
    """A page for each room, and one that leads to them from the names that users import."""
    rooms: dict[str, list[str]] = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        parts = path.relative_to(PACKAGE).with_suffix("").parts
        if parts[0] not in LEFT_OUT and not path.stem.startswith("_") and path.parent != PACKAGE:
            rooms.setdefault(parts[0], []).append(".".join(("celltrain", *parts)))
    rooms = dict(sorted(rooms.items(), key=lambda each: _order(each[0])))
    pages = {f"api/{room}.md": _room_page(room, modules) for room, modules in rooms.items()}
    return {"api/index.md": _python_index(list(rooms)), **pages}


def _python_index(rooms: list[str]) -> str:
    lines = ["# Python", "", "What `from celltrain import ...` gives:", ""]
    lines += ["| name | what it is |", "|---|---|"]
    lines += [_row(getattr(celltrain, name), name) for name in celltrain.__all__]
    lines += ["", "All other names are those of the package's rooms, in the order in which data"]
    lines += ["pass them:", "", "| room | what it is for |", "|---|---|"]
    lines += [f"| [celltrain.{room}]({room}.md) | {_summary(room)} |" for room in rooms]
    return "\n".join([*lines, "", "```{toctree}", ":hidden:", "", *rooms, "```", ""])


def _summary(room: str) -> str:
    tree = ast.parse((PACKAGE / room / "__init__.py").read_text())
    return (ast.get_docstring(tree) or "").splitlines()[0].replace("|", "\\|")


def _room_page(room: str, modules: list[str]) -> str:
    lines = [f"# celltrain.{room}", "", _summary(room), ""]
    public = list(_public(room))
    if public:
        lines += ["| name | what it is |", "|---|---|", *public, ""]
    for name in modules:
        lines += [f"## {name}", "", "```{eval-rst}", f".. automodule:: {name}", "```", ""]
    return "\n".join(lines)


def _order(room: str) -> int:
    """Where a room stands in the list of the contributors' page."""
    return (ROOT / "CONTRIBUTING.md").read_text().index(f"      {room}/")


def _public(room: str) -> Iterator[str]:
    """A row for each name that a room offers."""
    from importlib import import_module

    package = import_module(f"celltrain.{room}")
    for name in getattr(package, "__all__", ()):
        yield _row(getattr(package, name), name)


def _row(value: object, name: str) -> str:
    home, shown = getattr(value, "__module__", ""), f"`{name}`"
    path = PACKAGE.joinpath(*home.split(".")[1:]).with_suffix(".py")
    named = getattr(value, "__qualname__", None) == name
    if named and path.is_file() and home.split(".")[1] not in LEFT_OUT:
        shown = f"[`{name}`](#{home}.{name})"
    elif type(value).__module__.startswith("celltrain."):
        home = type(value).__module__
        shown = f"[`{name}`](#{home}.{type(value).__name__})"
    words = (getattr(value, "__doc__", "") or "").strip().splitlines()
    if isinstance(value, str | int | float | tuple) and shown[0] != "[" and len(repr(value)) < 70:
        return f"| {shown} | `{value!r}` |"
    said = words[0].replace("|", "\\|") if words and (named or shown[0] == "[") else ""
    return f"| {shown} | {said} |"


def setup(app: Any) -> dict[str, bool]:
    """Add the pages before any is read."""
    app.connect("builder-inited", write)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
