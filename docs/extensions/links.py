"""Links of pages that a code host shows, too: files of the source become their pages here."""

import re
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
#: Pages that stand beside the package.
AT_ROOT = {
    "CONTRIBUTING.md": "generated/contributing.md",
    "CHANGELOG.md": "generated/changelog.md",
    "README.md": "index.md",
}
LINK = re.compile(r"\[((?:[^\[\]]|\[[^\]]*\])*)\]\(((?:\.\./)+[^)\s#]+)(#[^)\s]*)?\)")


def rewrite(app: Any, page: str, source: list[str]) -> None:
    """Let links to what is outside of `docs` lead to where the site has it."""
    here = (DOCS / page).parent

    def changed(match: re.Match[str]) -> str:
        text, path, anchor = match.group(1), match.group(2), match.group(3) or ""
        target = Path(here, path).resolve()
        if target.is_relative_to(DOCS) or not target.is_relative_to(ROOT):
            return match.group()
        if not target.exists():
            return match.group()  # which fails the build
        inner = target.relative_to(ROOT)
        up = "../" * (len(Path(page).parts) - 1)
        if str(inner) in AT_ROOT:
            if anchor.startswith("#units"):
                return f"[{text}]({up}units.md)"
            kept = anchor if str(inner) != "README.md" else ""
            return f"[{text}]({up}{AT_ROOT[str(inner)]}{kept})"
        if inner.parts[0] == "examples":
            slug = inner.name.lower().replace(".", "").replace("_", "_")
            return f"[{text}]({up}generated/examples.md{f'#{slug}' if inner.suffix else ''})"
        if inner.parts[:2] == ("src", "celltrain") and inner.suffix == ".py":
            module = ".".join(inner.with_suffix("").parts[1:])
            name = text.strip("`")
            if re.fullmatch(r"[A-Za-z_][\w.]*", name) and text.startswith("`"):
                return f"[{text}](#{module}.{name})"
            return f"[{text}](#{module})"
        return text

    source[0] = LINK.sub(changed, source[0])


def setup(app: Any) -> dict[str, bool]:
    """Read pages with these links."""
    app.connect("source-read", rewrite)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
