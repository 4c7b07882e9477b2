"""Links of the pages lead to files and headings that are there, as a code host shows them."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md"] + [
    path
    for path in sorted((ROOT / "docs").rglob("*.md"))
    # What is made when the site is built is checked there.
    if not {"generated", "_site", "jupyter_execute"} & {*path.relative_to(ROOT).parts}
]
CODE = re.compile(r"^(`{3,}|~{3,}).*?^\1[ ]*$|^ {4}.*$|`[^`\n]+`", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"!?\[(?:[^\[\]]|\[[^\[\]]*\])*\]\(([^()\s]+)\)")


def headings(path: Path) -> set[str]:
    """The anchors of a page's headings."""
    text = re.sub(r"^(`{3,}).*?^\1[ ]*$", "", path.read_text(), flags=re.MULTILINE | re.DOTALL)
    found = re.findall(r"^#{1,6} (.+)$", text, flags=re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", each.lower()).strip().replace(" ", "-") for each in found}


@pytest.mark.parametrize("page", PAGES, ids=lambda path: str(path.relative_to(ROOT)))
def test_links_lead_somewhere(page: Path) -> None:
    # Code in the text of a link is no reason to pass it over.
    text = re.sub(r"\[`([^`\n]+)`\]", r"[\1]", page.read_text())
    for target in LINK.findall(CODE.sub("", text)):
        if re.match(r"\w+:", target):
            continue
        name, _, anchor = target.partition("#")
        path = (page.parent / name).resolve() if name else page
        assert path.is_relative_to(ROOT), target
        assert path.exists(), target
        if anchor and path.suffix == ".md":
            assert anchor in headings(path), target
