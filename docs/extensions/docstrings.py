"""Docstrings and signatures of the package for Sphinx.

Docstrings are plain text with single backticks for names, "Raises:" and "Attributes:" in the way of
Google, and formulas that are no markup. They become reStructuredText here: names become literals,
indented blocks stay as they are, and what would be read as markup is escaped. Signatures are shown
as they stand in the source, so that `Float[np.ndarray, "cell 3 coefficient"]` is.
"""

import ast
import inspect
import re
import textwrap
from typing import Any

SECTIONS = ("Raises", "Attributes", "Arguments", "Returns")
CODE = re.compile(r"(``[^`]+``|:\w+:`[^`]+`|`[^`]+`|\*\*[A-Z][\w ]*[:.]?\*\*)")


def shape_docstring(
    app: Any, what: str, name: str, value: object, options: Any, lines: list[str]
) -> None:
    """Replace a docstring by what Sphinx reads in the same way as people do."""
    blocks = re.split(r"\n\s*\n", textwrap.dedent("\n".join(lines)).strip("\n"))
    written: list[str] = []
    for block in blocks:
        written += [*_block(block.splitlines()), ""]
    lines[:] = written


def _block(lines: list[str]) -> list[str]:
    if not lines or not lines[0].strip():
        return []
    heading = lines[0].strip().removesuffix(":")
    if lines[0].strip() == f"{heading}:" and heading in SECTIONS:
        return [f"**{heading}:**", "", *_entries(textwrap.dedent("\n".join(lines[1:])))]
    if all(line.startswith("    ") for line in lines):
        return ["::", "", *(f"    {line}" for line in lines)]
    return [_escaped(line) for line in _separate_lists(lines)]


def _entries(text: str) -> list[str]:
    """A list of `name: what it is`, whose entries may go on over lines that are indented."""
    found: list[str] = []
    for line in text.splitlines():
        name, colon, rest = line.partition(":")
        if line.startswith(" ") or not colon or not re.fullmatch(r"[\w.,` ]+", name):
            found.append(f"  {_escaped(line.strip())}")
        else:
            quoted = name if "`" in name else f"`{name}`"
            found.append(f"- {_escaped(f'{quoted}: {rest.strip()}')}")
    return found if found and found[0].startswith("- ") else [each.strip() for each in found]


def _separate_lists(lines: list[str]) -> list[str]:
    """With the empty lines that a list needs around it and its inner lists."""
    found: list[str] = []
    for line in lines:
        item = re.match(r"\s*([-*]|\d+\.) ", line)
        if item and found and not re.match(r"\s*([-*]|\d+\.) ", found[-1]) and found[-1].strip():
            indent = len(line) - len(line.lstrip())
            before = len(found[-1]) - len(found[-1].lstrip())
            if indent != before or not any(re.match(r"\s*([-*]|\d+\.) ", each) for each in found):
                found.append("")
        found.append(line)
    return found


def _escaped(line: str) -> str:
    bullet = re.match(r"\s*([-*] )?", line)
    assert bullet is not None
    start, rest = bullet.group(), line[bullet.end() :]
    parts = CODE.split(rest)
    for index, part in enumerate(parts):
        if index % 2 == 0:
            parts[index] = re.sub(r"([\\*|_`])", r"\\\1", part)
        elif part.startswith("`") and not part.startswith("``"):
            parts[index] = f"`{part}`"
    # What follows a literal at once would keep it from being closed.
    return start + "".join(
        f"{part}\\ " if index % 2 and re.match(r"\w", parts[index + 1]) else part
        for index, part in enumerate(parts)
    )


def shape_signature(
    app: Any, what: str, name: str, value: Any, options: Any, signature: str, returns: str
) -> tuple[str | None, str | None] | None:
    """The signature as the source has it, without what the class or `Annotated` says besides."""
    if what == "class" and signature:
        return _without_notes(signature), None
    function = inspect.unwrap(getattr(value, "__func__", value))
    if not inspect.isfunction(function):
        return None
    try:
        node = ast.parse(textwrap.dedent(inspect.getsource(function))).body[0]
    except (OSError, SyntaxError, IndexError):
        return None
    if not isinstance(node, ast.FunctionDef):
        return None
    arguments = node.args
    if what == "method" and arguments.args and arguments.args[0].arg in ("self", "cls"):
        arguments.args.pop(0)
    given = f"({ast.unparse(arguments)})"
    return given, ast.unparse(node.returns) if node.returns else None


def _without_notes(signature: str) -> str:
    """Names and defaults only: the fields' own entries say what they are."""
    found, depth, name, skip = [], 0, "", False
    for letter in signature[1 : signature.rindex(")")]:
        depth += (letter in "([{<") - (letter in ")]}>")
        if depth == 0 and letter == ",":
            found.append(name.strip())
            name, skip = "", False
        elif depth == 0 and letter == ":":
            skip = True
        elif depth == 0 and letter == "=" and skip:
            skip = False
            name = name.rstrip() + "="
        elif not skip:
            name += letter
    found.append(name.strip())
    return f"({', '.join(each for each in found if each)})"


def setup(app: Any) -> dict[str, bool]:
    """Take the place of what Sphinx does itself."""
    app.connect("autodoc-process-docstring", shape_docstring)
    app.connect("autodoc-process-signature", shape_signature)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
