"""A result as one page that opens anywhere: data, scripts and Plotly in a single file.

What is large is compressed, and unpacked by the browser: Plotly itself, vectors of modes, and the
frames of a simulation. Nothing is loaded from elsewhere.
"""

import base64
import gzip
import html
import json
from importlib.resources import files
from pathlib import Path
from typing import TypedDict

import numpy as np

from celltrain.contract import presentation
from celltrain.evolution import Run
from celltrain.explore.drawing import (
    LEADING,
    Drawn,
    drawing_of_mode,
    mode_drawing,
    mode_key,
    train_drawing,
)
from celltrain.explore.figures import (
    Figure,
    dispersion_figure,
    growth_figure,
    spectrum_figures,
    transient_curves,
    wave_figures,
)
from celltrain.explore.film import film_drawing
from celltrain.explore.overview import overview_of
from celltrain.explore.reading import Reading
from celltrain.explore.report import headline, motion, rows, title
from celltrain.explore.samples import sample_headline, sample_rows
from celltrain.explore.simulation import simulation_figure
from celltrain.pictures.style import COLORS
from celltrain.quantities import Record
from celltrain.stability import InfiniteTrain, Stability, TransientGrowth
from celltrain.steady import Base
from celltrain.study import SampleResult, StudyResult
from celltrain.version import __version__

ASSETS = Path(__file__).parent / "assets"
SCRIPTS = ("harmonics.js", "film.js", "stage.js", "player.js", "numbers.js", "keys.js", "page.js")
#: Modes with m above this can be played only if they are among the leading ones.
MOST_NUMBER, LEADING_MODES = 3, 200


def page_of(result: Record, *, name: str = "") -> str:
    """The page of a result, as HTML.

    **Arguments:** `name`: what the page is called, such as the file's name.
    """
    return assembled(_content(result), name)


class Content(TypedDict, total=False):
    """What a page shows, in the words of its script, `page.js`."""

    version: str
    title: str
    headline: object
    rows: object
    motion: object
    train: Drawn
    figures: dict[str, dict[str, object]]
    modes: dict[str, Drawn]
    leading: str
    film: dict[str, object]


def assembled(content: Content, name: str) -> str:
    """The page of what the script `page.js` draws: title, numbers, train, modes, figures, film."""
    content = {"version": __version__, **content}
    shown = " · ".join(part for part in (name, content["title"]) if part)
    text = (ASSETS / "page.html").read_text(encoding="utf-8")
    parts = {
        "TITLE": html.escape(f"{shown} · celltrain"),
        "STYLE": (ASSETS / "celltrain.css").read_text(encoding="utf-8"),
        "LEGEND": _legend(),
        "PLOTLY": _compressed(_plotly()),
        "DATA": _compressed(json.dumps(content, allow_nan=False).encode()),
        "SCRIPTS": "\n".join((ASSETS / each).read_text(encoding="utf-8") for each in SCRIPTS),
    }
    for key, value in parts.items():
        text = text.replace(f"@@{key}@@", value)
    return text


def _plotly() -> bytes:
    """Plotly's script, from its Python package."""
    return (files("plotly") / "package_data" / "plotly.min.js").read_bytes()


def _compressed(content: bytes) -> str:
    return base64.b64encode(gzip.compress(content, 9, mtime=0)).decode()


def _legend() -> str:
    marks = "".join(
        f'<span><span style="color:{color}">{mark}</span> m = {m}</span>'
        for m, (mark, color) in enumerate(zip("●◆■▲", COLORS, strict=True))
    )
    return f'{marks}<span><span class="others">●</span> m ≥ 4</span><span>○ neutral</span>'


def _content(result: Record) -> Content:
    """What a page holds of a result, whatever its kind."""
    if isinstance(result, StudyResult | SampleResult):
        return _of_study(result)
    if isinstance(result, Run):
        return _of_simulation(result)
    if isinstance(result, TransientGrowth):
        content = train_content(result.result)
        reading = Reading("dimensionless", result.base.train.scales)
        drawn = growth_figure(transient_curves(result), result.spectral_abscissa, reading)
        content["figures"]["growth"] = _titled("Growth of disturbances", drawn)
        return content
    if isinstance(result, Stability | InfiniteTrain | Base):
        return train_content(result)
    found = getattr(result, "result", None)
    if isinstance(found, Stability):
        return train_content(found)
    return train_content(presentation(result.kind).steady_train(result))


def train_content(result: Stability | InfiniteTrain | Base) -> Content:
    """What a page holds of a train, and of its linear dynamics if they are known."""
    base = result if isinstance(result, Base) else result.base
    reading = Reading("dimensionless", base.train.scales)
    infinite = isinstance(result, InfiniteTrain)
    content: Content = {
        "title": title(base.train, reading, infinite=infinite),
        "headline": headline(result, reading),
        "rows": rows(result, reading),
        "motion": motion(base),
        "train": train_drawing(base, infinite=infinite),
        "figures": {},
        "modes": {},
    }
    if isinstance(result, Stability):
        content["modes"] = _modes(result, reading)
        leading = mode_drawing(result, LEADING, reading)
        assert leading is not None
        content["leading"] = mode_key(result.leading)
        whole, close = spectrum_figures(result, reading, leading)
        content["figures"] |= {
            "spectrum": _titled("Spectrum", whole, "all modes"),
            "close": _titled("Near the imaginary axis", close, "click a point to play its mode"),
        }
    elif isinstance(result, InfiniteTrain):
        content["modes"] = _waves(result, reading)
        content["leading"] = LEADING
        whole, close = wave_figures(result, reading, content["modes"][LEADING])
        content["figures"] |= {
            "waves": _titled("Waves of the infinite train", dispersion_figure(result, reading)),
            "close": _titled("Near the imaginary axis", close, "click a point to play its wave"),
        }
    return content


def _of_study(result: StudyResult | SampleResult) -> Content:
    study = overview_of(result)
    content: Content = {
        "title": result.data.attrs.get("title", "Study"),
        "figures": {
            name: _titled(words, study.figure(name), study.notes[name])
            for name, words in study.names.items()
        },
    }
    if isinstance(result, SampleResult):
        content |= {"headline": sample_headline(result), "rows": sample_rows(result)}
    return content


def _of_simulation(run: Run) -> Content:
    content = train_content(run.start)
    reading = Reading("dimensionless", run.train.scales)
    growth = _titled(
        "Growth of the disturbance", simulation_figure(run, reading), "beside the linear theory"
    )
    content["figures"] = {"simulation": growth, **content["figures"]}
    content["film"] = film_drawing(run)
    return content


def _titled(name: str, figure: Figure, note: str = "") -> dict[str, object]:
    return {"title": name, "note": note, **figure}


def _modes(result: Stability, reading: Reading) -> dict[str, Drawn]:
    """The modes that can be played, by their keys; vectors in few digits."""
    chosen = [
        mode
        for number, mode in enumerate(result.modes)
        if number < LEADING_MODES or mode.azimuthal_number <= MOST_NUMBER
    ]
    keys = {mode_key(mode): mode for mode in chosen}
    return {key: _short(drawing_of_mode(result, mode, key, reading)) for key, mode in keys.items()}


def _waves(result: InfiniteTrain, reading: Reading) -> dict[str, Drawn]:
    keys = [f"{m},{place},0" for m in result.leading for place in range(len(result.phases))]
    found = {key: mode_drawing(result, key, reading) for key in (LEADING, *keys)}
    return {key: _short(drawn) for key, drawn in found.items() if drawn is not None}


def _short(drawn: Drawn) -> Drawn:
    """Vectors to a ten-thousandth of their largest part, as whole numbers."""
    parts = {name: np.array(drawn[name]) for name in ("real", "imaginary")}
    largest = max(float(np.abs(each).max()) for each in parts.values()) or 1.0
    whole = {name: np.rint(1e4 * each / largest).astype(int) for name, each in parts.items()}
    return {**drawn, **{name: each.tolist() for name, each in whole.items()}}
