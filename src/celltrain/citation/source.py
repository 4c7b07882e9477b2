"""A source, as BibTeX and as a paragraph of the bibliography."""

import re
import textwrap
import unicodedata
from dataclasses import dataclass
from typing import Literal

WIDTH = 108
#: Letters that BibTeX files of seven bits write with a command.
ACCENTS = {"\u0300": "`", "\u0301": "'", "\u0308": '"'}


@dataclass(frozen=True, kw_only=True)
class Source:
    """A publication, or software.

    Attributes:
        key: how code and documentation name it: authors and year.
        kind: type of the BibTeX entry.
        authors: each with the initials first, or the name of a group.
        where: journal, book or publisher; whoever published it.
        note: what it is a source of.
        modules: parts of the package that rest on it, without "celltrain."; each names it.
    """

    key: str
    kind: Literal["article", "book", "incollection", "inproceedings", "techreport", "misc"]
    authors: tuple[str, ...]
    title: str
    note: str
    where: str = ""
    volume: str = ""
    number: str = ""
    pages: str = ""
    year: int | None = None
    doi: str = ""
    modules: tuple[str, ...] = ()

    @property
    def label(self) -> str:
        """The key of its BibTeX entry: first author and year."""
        first = unicodedata.normalize("NFKD", self.key).encode("ascii", "ignore").decode()
        word = re.split(r"[,& ]", first)[0]
        return f"{word.replace('-', '')}{self.year or ''}"

    def bibtex(self) -> str:
        """The BibTeX entry, in seven bits."""
        place = {
            "article": "journal",
            "book": "publisher",
            "incollection": "booktitle",
            "inproceedings": "booktitle",
            "techreport": "institution",
            "misc": "howpublished",
        }[self.kind]
        names = " and ".join(
            name if re.match(r"(\w\.)", name) else f"{{{name}}}" for name in self.authors
        )
        fields = {
            "author": names,
            "title": f"{{{self.title}}}",
            place: self.where,
            "volume": self.volume,
            "number": self.number,
            "pages": self.pages.replace("-", "--"),
            "year": str(self.year or ""),
            "doi": self.doi,
        }
        lines = [f"  {name} = {{{_seven_bits(text)}}}," for name, text in fields.items() if text]
        return "\n".join([f"@{self.kind}{{{self.label},", *lines, "}"])

    def paragraph(self) -> str:
        """The same in Markdown, for people."""
        issue = f" ({self.number})" if self.number else ""
        if self.kind == "techreport":
            issue = f" Report {self.number}"
        italic = self.kind in ("article", "inproceedings")
        where = f"*{self.where}*" if italic and self.where else self.where
        if self.kind == "incollection":
            where = f"In: {where}"
        volume = f" {self.volume}{issue}" if self.volume else issue
        title = f"*{self.title}*" if self.kind == "book" else self.title
        parts = [f"{', '.join(self.authors)}.", f"{title}."]
        # An article's year stands in its key.
        end = f"{where}{volume}" + (f", {self.pages}" if self.pages else "")
        if end:
            parts.append(f"{end}.")
        if self.doi:
            parts.append(f"doi:{self.doi}.")
        text = " ".join([*parts, self.note])
        filled = textwrap.fill(text, WIDTH, break_on_hyphens=False, break_long_words=False)
        return f"**{self.key}**\n{filled}"


def _seven_bits(text: str) -> str:
    found = ""
    for letter in unicodedata.normalize("NFKD", text):
        if letter in ACCENTS:
            found = f"{found[:-1]}{{\\{ACCENTS[letter]}{found[-1]}}}"
        else:
            found += {"&": r"\&", "_": r"\_"}.get(letter, letter)
    return found
