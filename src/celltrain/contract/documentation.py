"""The page of documentation on everything that is computed, made from the analyses themselves.

python -m celltrain.contract.documentation > docs/diagnostics.md
"""

import dataclasses
from collections.abc import Iterator
from typing import get_args, get_type_hints

from celltrain.contract.analysis import Analysis, Setting
from celltrain.contract.catalogue import analysis_named, commands, kinds, presentation
from celltrain.contract.in_folder import InFolder
from celltrain.quantities import Quantity, quantities
from celltrain.quantities.fields import hints, split
from celltrain.results.columns import parts_of

INTRODUCTION = """\
# Diagnostics

Everything that celltrain computes. Each analysis is a command, and its result can be saved,
loaded, shown, drawn and used as a start in the same way. This page is made from them by
`python -m celltrain.contract.documentation`; a test holds it to what they say.

    celltrain NAME case.toml -o result.nc     # compute; --json, --plot FOLDER
    celltrain show result.nc                  # the report again; --json
    celltrain plot result.nc                  # its pictures
    celltrain OTHER result.nc                 # another analysis of its case and steady train
    celltrain.load("result.nc")               # in Python: equal to what was computed

Lengths are in r0, velocities in U, viscosities in mu. "Eq.", "Fig." and "Table" are those of
*Bryngelson & Freund 2018*, other sources in the [bibliography](bibliography.md). In files a part of
a result has its name before those of its quantities, as in `base_gap`.
"""


def page() -> str:
    """The page."""
    described = {kind: _analysis(kind) for kind in kinds()}
    described |= {name: _of_many(name) for name in commands() if _computes_many(name)}
    return "\n".join([INTRODUCTION, *(each for _, each in sorted(described.items())), _parts()])


def _computes_many(name: str) -> bool:
    return issubclass(analysis_named(name), InFolder)


def _analysis(kind: str) -> str:
    shown = presentation(kind)
    if issubclass(shown, Analysis):
        lines = _heading(kind, shown)
        if shown.command:
            lines += ["", f"The command is `celltrain {shown.command}`."]
        lines += ["", *_settings(shown)]
    else:
        lines = _heading(kind, shown.result)
    lines += ["", *_table(shown.result)]
    return "\n".join(lines) + "\n"


def _of_many(name: str) -> str:
    computation = analysis_named(name)
    return "\n".join([*_heading(name, computation), "", *_settings(computation)]) + "\n"


def _heading(name: str, described: type) -> list[str]:
    """Heading and docstring."""
    first, _, rest = (described.__doc__ or "").partition("\n")
    lines = [f"## {name}", "", first.strip()]
    return [*lines, "", *map(str.strip, rest.strip().splitlines())] if rest.strip() else lines


def _settings(described: type) -> Iterator[str]:
    known = get_type_hints(described, include_extras=True)
    for each in dataclasses.fields(described):
        setting = next(note for note in get_args(known[each.name]) if isinstance(note, Setting))
        option = f"--{setting.option or each.name.replace('_', '-')}"
        if each.name == getattr(described, "argument", ""):
            option = each.name.upper()
        notes = [f"allowed: {setting.allowed}"] if setting.allowed else []
        if each.default not in (None, dataclasses.MISSING):
            default = f"{each.default:.5g}" if isinstance(each.default, float) else each.default
            notes.append(f"default: {default}")
        yield f"- `{option}`: {setting.help}" + (f" ({'; '.join(notes)})" if notes else "")


def _table(kind: type) -> Iterator[str]:
    """The quantities of a class, and of which parts it consists."""
    of_parts = [
        f"`{name}`: {', '.join(f'*{each.__name__}*' for each in parts_of(hint))}"
        for name, (hint, _) in hints(kind).items()
        if parts_of(hint)
    ]
    if of_parts:
        yield f"Parts: {'; '.join(of_parts)}."
        yield ""
    known = quantities(kind) if dataclasses.is_dataclass(kind) else {}
    if known:
        yield "| quantity | symbol | unit | dimensions | what it is |"
        yield "|---|---|---|---|---|"
    for name, meaning in known.items():
        symbol = _symbol(meaning)
        dims = ", ".join(meaning.dims or _dims(kind, name))
        yield f"| `{name}` | {symbol} | {meaning.unit} | {dims} | {_what(meaning)} |"
        for part, each in meaning.parts.items():
            symbol = _symbol(each)
            dims = ", ".join(each.dims)
            yield f'| `{name}["{part}"]` | {symbol} | {each.unit} | {dims} | {_what(each)} |'


def _symbol(meaning: Quantity) -> str:
    return f"${meaning.symbol}$".replace("|", r"\vert{}") if meaning.symbol else ""


def _what(meaning: Quantity) -> str:
    words = meaning.description.replace("|", "\\|")
    if meaning.equation:
        words += f"; ${meaning.equation}$".replace("|", r"\vert{}")
    return f"{words} ({meaning.source})" if meaning.source else words


def _dims(kind: type, name: str) -> tuple[str, ...]:
    hint = hints(kind)[name][0] if name in hints(kind) else None
    return tuple(getattr(split(hint)[0], "dim_str", "").split())


def _parts() -> str:
    """Each class that results consist of, apart from the results themselves."""
    results = {presentation(kind).result for kind in kinds()}
    found: dict[str, type] = {}
    waiting = list(results)
    while waiting:
        for hint, _ in hints(waiting.pop()).values():
            for each in parts_of(hint):
                if each not in results and each.__name__ not in found:
                    found[each.__name__] = each
                    waiting.append(each)
    lines = ["## Parts of results", ""]
    for name in sorted(found):
        first = (found[name].__doc__ or "").splitlines()[0]
        lines += [f"### {name}", "", first, "", *_table(found[name]), ""]
    return "\n".join(lines)


if __name__ == "__main__":
    print(page(), end="")
