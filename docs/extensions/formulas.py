"""Formulas as MathML, which browsers draw by themselves: pages need no network and no script."""

import re
from html import escape
from typing import Any

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.util import logging

# Browsers know no `mathvariant` but "normal": bold letters are characters of their own.
_BOLD = re.compile(r'<mi mathvariant="bold">([A-Za-z])</mi>')
_FIRST_BOLD = {"A": 0x1D400, "a": 0x1D41A}

LOG = logging.getLogger(__name__)


def _mathml(translator: Any, node: nodes.Element, display: str) -> str:
    text = node.astext()
    try:
        return _BOLD.sub(_bold, convert(text, display=display))
    except Exception as error:  # whatever the converter finds wrong with it
        LOG.warning("formula %r: %r", text, error, location=node)
        return f"<code>{escape(text)}</code>"


def _bold(found: re.Match[str]) -> str:
    letter = found[1]
    first = "A" if letter.isupper() else "a"
    return f"<mi>&#x{_FIRST_BOLD[first] + ord(letter) - ord(first):X};</mi>"


def inline(translator: Any, node: nodes.Element) -> None:
    """A formula in the text."""
    translator.body.append(translator.starttag(node, "span", "", CLASS="math"))
    translator.body.append(_mathml(translator, node, "inline") + "</span>")
    raise nodes.SkipNode


def block(translator: Any, node: nodes.Element) -> None:
    """A formula by itself, with its number if it has one."""
    translator.body.append(translator.starttag(node, "div", "", CLASS="math"))
    if node["number"]:
        translator.body.append(f'<span class="eqno">({node["number"]})')
        translator.add_permalink_ref(node, "Link to this equation")
        translator.body.append("</span>")
    translator.body.append(_mathml(translator, node, "block") + "</div>\n")
    raise nodes.SkipNode


def setup(app: Any) -> dict[str, bool]:
    """Offer it as `html_math_renderer`."""
    app.add_html_math_renderer("mathml", (inline, None), (block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
