"""What the header xla/ffi/api/c_api.h of the installed jaxlib says of a call's frame.

Compiled loops read their arguments at fixed places (`call_frame`). Whether these are right is seen
from the header before any loop is used: version of the interface, numbers of the types, and places
of the fields, as a C compiler for 64-bit machines would set them out.
"""

import re
from functools import cached_property
from pathlib import Path

HEADER = Path("xla") / "ffi" / "api" / "c_api.h"

# Sizes, in bytes, of the types that are neither pointers, enumerations nor structures.
_SIZES = {"size_t": 8, "int64_t": 8, "uint64_t": 8, "int32_t": 4, "uint32_t": 4, "int": 4}

_COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)
_DEFINE = re.compile(r"#define\s+(\w+)\s+(\d+)\s*$", re.MULTILINE)
_ENUM = re.compile(r"typedef\s+enum\s*\w*\s*\{([^{}]*)\}\s*(\w+)\s*;")
_NUMBER = re.compile(r"(\w+)\s*=\s*(\d+)\s*(?:,|$)")
_STRUCT = re.compile(r"struct\s+(\w+)\s*\{([^{}]*)\}")
_FIELD = re.compile(r"(?:const\s+)?(?:struct\s+)?(\w+)\s*(\**)\s*(\w+)$")
# A field that is the address of a function and has the name of the function's type.
_FUNCTION_FIELD = re.compile(r"_XLA_FFI_API_STRUCT_FIELD\((\w+)\)")
_ALIAS = re.compile(r"typedef\s+(\w+)\s+(\w+)\s*;")


class Header:
    """Numbers and places that a header defines.

    **Raises:** on use, `LookupError` for what it does not have, or in no form that is understood.
    """

    def __init__(self, text: str) -> None:
        self._text = _FUNCTION_FIELD.sub(r"\1* \1", _COMMENT.sub("", text))

    @cached_property
    def numbers(self) -> dict[str, int]:
        """Macros and members of enumerations that are plain numbers."""
        found = {name: int(value) for name, value in _DEFINE.findall(self._text)}
        for members, _ in _ENUM.findall(self._text):
            found |= {name: int(value) for name, value in _NUMBER.findall(members)}
        return found

    def offset(self, structure: str, path: str) -> int:
        """Place of a field of a structure, in bytes; "args.size" is one of a field's own."""
        name, _, rest = path.partition(".")
        for field, kind, place in self._laid_out(structure)[0]:
            if field == name:
                return place + (self.offset(kind, rest) if rest else 0)
        raise LookupError(f"{structure} has no field {name}")

    @cached_property
    def _structures(self) -> dict[str, str]:
        return dict(_STRUCT.findall(self._text))

    @cached_property
    def _enumerations(self) -> set[str]:
        return {name for _, name in _ENUM.findall(self._text)}

    @cached_property
    def _aliases(self) -> dict[str, str]:
        return {name: kind for kind, name in _ALIAS.findall(self._text)}

    def _laid_out(self, structure: str) -> tuple[list[tuple[str, str, int]], int, int]:
        """Name, type and place of each field; size of the whole, and what it is aligned to."""
        if structure not in self._structures:
            raise LookupError(f"there is no structure {structure}")
        fields, place, widest = [], 0, 1
        for line in self._structures[structure].split(";"):
            if not line.strip():
                continue
            found = _FIELD.match(" ".join(line.split()))
            if found is None:
                raise LookupError(f"{structure} has a field that is not understood: {line.strip()}")
            kind, pointer, name = found.groups()
            size, alignment = (8, 8) if pointer else self._measured(kind)
            place += -place % alignment
            fields.append((name, kind, place))
            place, widest = place + size, max(widest, alignment)
        return fields, place + -place % widest, widest

    def _measured(self, kind: str) -> tuple[int, int]:
        """Size of a type, and what it is aligned to."""
        if kind in _SIZES:
            return _SIZES[kind], _SIZES[kind]
        if kind in self._enumerations:
            return 4, 4
        if kind in self._structures:
            return self._laid_out(kind)[1:]
        if kind in self._aliases:
            return self._measured(self._aliases[kind])
        raise LookupError(f"the size of {kind} is not known")
