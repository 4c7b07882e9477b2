"""The page of sources: ``python -m celltrain.citation.page > docs/bibliography.md``."""

from celltrain.citation.sources import SOURCES

INTRODUCTION = """\
# Bibliography

Sources by the keys that the code and the documentation use. Made by `python -m
celltrain.citation.page`; `celltrain cite RESULT.nc` prints those of a result as BibTeX.
"""


def page() -> str:
    """The page."""
    return "\n".join([INTRODUCTION, "\n\n".join(source.paragraph() for source in SOURCES)])


if __name__ == "__main__":
    print(page())
