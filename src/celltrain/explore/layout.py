"""The parts of the explorer's page, in Dash's terms; the scripts fill in controls and stage."""

from typing import Any

from dash import dcc, html
from dash.development.base_component import Component

from celltrain.explore.figures import figure
from celltrain.explore.opened import Opened
from celltrain.pictures.style import COLORS
from celltrain.version import __version__

#: How all figures behave.
CONFIG: dcc.Graph.Config = {
    "displaylogo": False,
    "displayModeBar": False,
    "responsive": True,
    "doubleClick": "reset",
}
_MARKS = ("●", "◆", "■", "▲")


def page(opened: Opened) -> Component:
    """The whole page of what was opened."""
    return html.Div(
        [
            *(dcc.Store(id=name) for name in ("change", "shown", "asked-mode", "mode", "curves")),
            dcc.Store(id="page"),
            dcc.Store(id="chosen"),
            dcc.Store(id="has-film", data=opened.run is not None),
            html.Div(id="nowhere", hidden=True),
            html.Header(
                [
                    html.H1("celltrain"),
                    html.P(id="title", className="case"),
                    html.Span(
                        "loading", id="status", className="status", role="status", **_live("polite")
                    ),
                ]
            ),
            html.Div([_side(opened), html.Main(_main(opened))], className="columns"),
        ],
        className="explorer",
    )


def _side(opened: Opened) -> Component:
    return html.Aside(
        [
            html.Div(id="controls"),
            html.Div(
                [
                    html.A("Save case", id="save-case", href="#", download="celltrain.toml"),
                    html.A("Save result", id="save-result", href="#", download="celltrain.nc"),
                ],
                className="buttons",
            ),
            html.P(
                [f"celltrain {__version__}", *([f" · {opened.name}"] if opened.name else [])],
                className="version",
            ),
        ],
        **_named("Parameters of the train"),
    )


def _main(opened: Opened) -> list[Component]:
    parts: list[Component] = [
        html.Div(id="message", className="message above", role="alert", hidden=True),
    ]
    if opened.study is not None:
        names = opened.study.names
        notes = "; ".join(dict.fromkeys(opened.study.notes.values()))
        parts.append(
            html.Section(
                [
                    html.Div(
                        [
                            html.H2("Study"),
                            html.Span(
                                f"{notes}; click a point to open its train",
                                className="note",
                            ),
                            dcc.RadioItems(
                                [{"label": words, "value": name} for name, words in names.items()],
                                next(iter(names)),
                                id="map-number",
                                className="choice",
                                inline=True,
                            ),
                        ],
                        className="heading",
                    ),
                    _graph("map", "map", "Study"),
                ],
                className="panel above",
            )
        )
    parts.append(
        html.Section(
            [
                html.P(id="headline", className="headline"),
                html.Div(id="cards", className="cards"),
                html.Div(id="player", className="player"),
            ],
            className="panel above",
        )
    )
    if opened.run is not None:
        parts.append(
            _panel("Growth of the disturbance, beside the linear theory", "simulation", "wide")
        )
    parts += [
        legend(),
        html.Div(
            [
                _panel("Spectrum", "spectrum-all", note="all modes"),
                _panel(
                    "Near the imaginary axis",
                    "spectrum-close",
                    note="click a point to play its mode",
                ),
                _panel(
                    "Waves of an infinite train", "dispersion", "curves", note="★ most unstable"
                ),
                _panel("Growth of disturbances", "growth", "curves", note="dashed eᵅᵗ, dotted eᵑᵗ"),
            ],
            className="figures",
        ),
        html.Details(
            [html.Summary("All numbers"), html.Table(id="numbers")], className="panel", open=True
        ),
    ]
    return parts


def legend() -> Component:
    """What the colours of azimuthal numbers are; the same in all figures."""
    parts = [
        html.Span([html.Span(mark, style={"color": color}), f" m = {m}"])
        for m, (mark, color) in enumerate(zip(_MARKS, COLORS, strict=True))
    ]
    others = html.Span([html.Span("●", className="others"), " m ≥ 4"])
    hollow = html.Span([html.Span("○"), " neutral"])
    return html.P([*parts, others, hollow], className="legend")


def _panel(title: str, name: str, kind: str = "", *, note: str = "") -> Component:
    parts = [html.H2(title), html.Span(note, className="note")]
    if kind == "curves":
        parts.append(html.Span(className="curves-stage"))
    heading = html.Div(parts, className="heading")
    points = title if name.startswith("spectrum") else ""
    return html.Section([heading, _graph(name, kind, points)], className="panel")


def _graph(name: str, kind: str, points: str = "") -> Component:
    """A figure; with the words for `points` those can be chosen by keys as well."""
    graph = dcc.Graph(
        id=name, figure=figure([]), config=CONFIG, responsive=True, style={"height": "100%"}
    )
    keys: Any = {}
    if points:
        words = f"{points}; arrow keys go from point to point"
        keys = {"tabIndex": 0, "role": "application", **_named(words)}
    return html.Div(graph, className=f"graph {kind}".strip(), **keys)


def _named(words: str) -> dict[str, Any]:
    return {"aria-label": words}


def _live(how: str) -> dict[str, Any]:
    return {"aria-live": how}
