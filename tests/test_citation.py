"""What `celltrain cite` prints, and that each source is where the package says."""

import re
from collections.abc import Callable
from pathlib import Path

import pytest

import celltrain
from celltrain.citation import SOFTWARE, SOURCES, Source, sources_of
from celltrain.citation.page import page
from celltrain.cli import main
from celltrain.results import save
from celltrain.stability import Stability

SOURCE = Path(celltrain.__file__).parent
PAGE = SOURCE.parents[1] / "docs" / "bibliography.md"


def keys(text: str) -> list[str]:
    return re.findall(r"^@\w+\{([A-Za-z0-9]+),$", text, flags=re.MULTILINE)


@pytest.mark.parametrize("source", SOURCES, ids=lambda source: source.key)
def test_modules_name_their_sources(source: Source) -> None:
    first = re.split(r"[,& ]", source.key)[0]
    for module in source.modules:
        text = (SOURCE / f"{module.replace('.', '/')}.py").read_text()
        assert first in text, module


def test_labels_differ() -> None:
    labels = [source.label for source in (SOFTWARE, *SOURCES)]
    assert len(set(labels)) == len(labels)


@pytest.mark.parametrize("source", [SOFTWARE, *SOURCES], ids=lambda source: source.key)
def test_entries_are_whole(source: Source) -> None:
    entry = source.bibtex()
    assert entry.isascii()
    assert entry.count("{") == entry.count("}")
    assert all(f"  {name} = " in entry for name in ("author", "title"))


def test_the_page_is_made_of_them() -> None:
    assert PAGE.read_text() == page() + "\n"


def test_without_a_result_package_and_paper(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["cite"]) == 0
    assert keys(capsys.readouterr().out) == ["celltrain", "Bryngelson2018"]


def test_of_a_result_what_its_case_uses(
    make_stability: Callable[..., Stability], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "train.nc"
    save(make_stability(law="neo_hookean", reduced_volume=0.7), path)
    assert main(["cite", str(path)]) == 0
    found = keys(capsys.readouterr().out)
    assert {"BarthesBiesel2002", "Nocedal2006"} <= {*found}
    assert "Trefethen2005" in found
    assert not {"Skalak1973", "Helfrich1973", "Sommeijer1998"} & {*found}


def test_a_steady_train_alone_rests_on_less(
    make_stability: Callable[..., Stability],
) -> None:
    result = make_stability()
    alone, dynamics = ({each.key for each in sources_of(each)} for each in (result.base, result))
    assert dynamics - alone == {"Trefethen & Embree 2005"}
    assert "Skalak, Tozeren, Zarda & Chien 1973" in alone


def test_a_file_that_is_not_there(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["cite", "nothing.nc"]) == 2
    assert "there is no such file" in capsys.readouterr().err
