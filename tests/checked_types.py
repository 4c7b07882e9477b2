"""How tests check annotations: by beartype, with what is in vain left out.

jaxtyping gives its checker two functions in place of each annotated one: one of its arguments, and
one of its arguments and its result, by when the arguments have been checked. Functions within
others it gives again whenever their definition is run.
"""

from collections.abc import Callable, Hashable
from typing import Any, TypeAlias

from beartype import beartype

# It has no body to speak of.
Signature: TypeAlias = Callable[..., Any]

_within_others: dict[Hashable, Signature] = {}


def checked(signature: Signature) -> Signature:
    """What checks the annotations of a function that jaxtyping made of one's signature."""
    annotations = signature.__annotations__
    if annotations.get("return", Any) is not Any:
        for name in annotations.keys() - {"return"}:
            del annotations[name]
    if "<locals>" not in signature.__qualname__:
        return beartype(signature)
    known = _known_by(signature)
    if known not in _within_others:
        _within_others[known] = beartype(signature)
    return _within_others[known]


def _known_by(signature: Signature) -> Hashable:
    code = signature.__code__
    return (
        signature.__module__,
        signature.__qualname__,
        # Places and names of arguments, and which of them may be left out.
        (code.co_posonlyargcount, code.co_argcount, code.co_kwonlyargcount, code.co_flags),
        code.co_varnames,
        len(signature.__defaults__ or ()),
        frozenset(signature.__kwdefaults__ or ()),
        # Those of jaxtyping are made anew with the function.
        repr(signature.__annotations__),
    )
