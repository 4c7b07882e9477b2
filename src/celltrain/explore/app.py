"""The explorer as a Dash application: what is asked of it, and what it answers.

The page keeps its state in its address. A change goes to `respond`, one at a time, which answers
with the coarse picture; `rest` follows with the converged one when nothing has changed for a while,
and `curves` with what is drawn of either.
"""

from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, cast

from dash import ClientsideFunction, Dash, Input, Output, Patch, State, no_update
from dash.exceptions import PreventUpdate
from flask import Response, request

from celltrain.explore.address import View, view_of
from celltrain.explore.changes import Change, control_panel, view_after
from celltrain.explore.drawing import mode_drawing, train_drawing
from celltrain.explore.engine import Engine, Picture, Superseded
from celltrain.explore.figures import (
    dispersion_figure,
    empty_figure,
    growth_figure,
    spectrum_figures,
    wave_figures,
)
from celltrain.explore.film import film_drawing
from celltrain.explore.layout import page
from celltrain.explore.opened import Opened
from celltrain.explore.reading import Reading
from celltrain.explore.report import report
from celltrain.explore.simulation import simulation_figure
from celltrain.parameters import CaseError
from celltrain.results import save
from celltrain.stability import InfiniteTrain
from celltrain.steady import NotConverged

ASSETS = Path(__file__).parent / "assets"
_SPECTRA = ("spectrum-all", "spectrum-close")


def make_app(opened: Opened, engine: Engine) -> Dash:
    """The application; everything that it loads comes from this machine."""
    app = Dash(
        "celltrain",
        title="celltrain explorer",
        update_title="",
        assets_folder=str(ASSETS),
        assets_ignore=r"page\..*",
        serve_locally=True,
        compress=False,
        add_log_handler=False,
    )
    app.layout = page(opened)
    _add_pictures(app, opened, engine)
    _add_scripts(app, opened)
    _add_curves(app, opened, engine)
    _add_files(app, opened, engine)
    return app


def _add_pictures(app: Dash, opened: Opened, engine: Engine) -> None:
    """Answers that draw the train and its spectrum: the train first, by the scripts."""

    @app.callback(
        Output("shown", "data"),
        Input("change", "data"),
        State("shown", "data"),
        State("asked-mode", "data"),
        State("page", "data"),
        prevent_initial_call=True,
    )
    def respond(
        change: Mapping[str, Any], before: Mapping[str, Any] | None, mode: str | None, page: str
    ) -> dict[str, Any]:
        number = engine.ask(page)
        view = opened.view if before is None else view_of(before["address"], opened.view.train)
        asked = {"number": number, "place": change.get("place")}
        try:
            view = view_after(view, cast(Change, change), opened)
        except CaseError as error:
            return _refused(view, asked, str(error), change)
        try:
            picture = engine.coarse(view, engine.check(page, number))
        except Superseded:
            raise PreventUpdate from None
        except (CaseError, NotConverged) as error:
            return _refused(view, asked, _words(error), {})
        return _answer(picture, asked, mode)

    @app.callback(
        Output("shown", "data", allow_duplicate=True),
        Input("shown", "data"),
        State("asked-mode", "data"),
        State("page", "data"),
        prevent_initial_call=True,
    )
    def rest(shown: Mapping[str, Any], mode: str | None, page: str) -> dict[str, Any]:
        if shown.get("message") or shown["converged"]:
            raise PreventUpdate
        number = shown["number"]
        view = view_of(shown["address"], opened.view.train)
        try:
            engine.rest(page, number)
            picture = engine.converged(view, engine.check(page, number))
        except Superseded:
            raise PreventUpdate from None
        except (CaseError, NotConverged) as error:
            message = f"Only coarse: {_words(error)}"
            return {**shown, "message": message, "stage": "coarse"}
        return _answer(picture, {"number": number}, mode)

    @app.callback(
        Output("mode", "data"),
        Input("asked-mode", "data"),
        State("shown", "data"),
        prevent_initial_call=True,
    )
    def mode(key: str | None, shown: Mapping[str, Any] | None) -> Any:
        if key is None or shown is None:
            return None
        view = view_of(shown["address"], opened.view.train)
        return mode_drawing(engine.latest(view).result, key, _reading(view))


def _add_scripts(app: Dash, opened: Opened) -> None:
    """What the scripts in the browser do with answers and clicks (`assets/explorer.js`)."""

    def script(name: str, *inputs: Input | State) -> None:
        function = ClientsideFunction("celltrain", name)
        output = Output("nowhere", "children", allow_duplicate=True)
        app.clientside_callback(function, output, *inputs, prevent_initial_call="initial_duplicate")

    script("show", Input("shown", "data"), State("has-film", "data"))
    script("mode", Input("mode", "data"))
    script("curves", Input("curves", "data"))
    script("clicked", *(Input(name, "clickData") for name in _SPECTRA))
    if opened.study is not None:
        script("clickedMap", Input("map", "clickData"))


def _add_curves(app: Dash, opened: Opened, engine: Engine) -> None:
    """Answers that draw what follows from the linear dynamics, and what was opened."""

    @app.callback(
        Output("dispersion", "figure"),
        Output("growth", "figure"),
        Output("curves", "data"),
        Input("shown", "data"),
        State("page", "data"),
        prevent_initial_call=True,
    )
    def curves(shown: Mapping[str, Any], page: str) -> tuple[Any, Any, Any]:
        if shown.get("message"):
            raise PreventUpdate
        view = view_of(shown["address"], opened.view.train)
        check = engine.check(page, shown["number"])
        try:
            found = engine.curves(engine.latest(view), check)
        except Superseded:
            raise PreventUpdate from None
        reading = _reading(view)
        if found.growth is None:
            growth = empty_figure("an infinite train has no finite number of disturbances")
        else:
            growth = growth_figure(found.growth, found.alpha, reading)
        converged = found.picture.converged
        return dispersion_figure(found.waves, reading), growth, {"converged": converged}

    if opened.study is not None:
        study = opened.study

        @app.callback(
            Output("map", "figure"), Input("map-number", "value"), State("chosen", "data")
        )
        def show_map(name: str, chosen: str | None) -> Any:
            return study.drawn(name, chosen)

        @app.callback(
            Output("map", "figure", allow_duplicate=True),
            Output("chosen", "data"),
            Input("shown", "data"),
            State("map-number", "value"),
            State("chosen", "data"),
            prevent_initial_call=True,
        )
        def mark(shown: Mapping[str, Any], name: str, before: str | None) -> tuple[Any, Any]:
            """The ring around the train that is shown, where it is one of the study's."""
            place = study.place(view_of(shown["address"], opened.view.train).train)
            if place == before:
                raise PreventUpdate
            ring = study.ring(place, name)
            if ring is None:
                return no_update, place
            patch = Patch()
            patch["data"][-1].update(ring)
            return patch, place

    if opened.run is not None:
        run = opened.run

        @app.callback(Output("simulation", "figure"), Input("shown", "data"))
        def show_simulation(shown: Mapping[str, Any] | None) -> Any:
            units = "SI" if shown and "units=SI" in shown["address"] else "dimensionless"
            return simulation_figure(run, Reading(units, run.train.scales))  # type: ignore[arg-type]


def _add_files(app: Dash, opened: Opened, engine: Engine) -> None:
    """What can be saved, and the film, which is too large for an answer."""

    def asked() -> View:
        return view_of(request.query_string.decode(), opened.view.train)

    @app.server.route("/save/celltrain.toml")
    def save_case() -> Response:
        return _file(asked().train.to_toml().encode(), "celltrain.toml", "application/toml")

    @app.server.route("/save/celltrain.nc")
    def save_result() -> Response:
        picture = engine.converged(asked(), lambda: None)
        with TemporaryDirectory() as folder:
            content = save(picture.result, Path(folder) / "celltrain.nc").read_bytes()
        return _file(content, "celltrain.nc", "application/x-netcdf")

    @app.server.errorhandler(CaseError)
    @app.server.errorhandler(NotConverged)
    def refuse(error: Exception) -> Response:
        return Response(str(error), 400, mimetype="text/plain")

    if opened.run is not None:
        run = opened.run

        @app.server.route("/film.json")
        def film() -> dict[str, Any]:
            return film_drawing(run)


def _file(content: bytes, name: str, kind: str) -> Response:
    headers = {"Content-Disposition": f'attachment; filename="{name}"'}
    return Response(content, headers=headers, mimetype=kind)


def _answer(picture: Picture, asked: Mapping[str, Any], mode: str | None) -> dict[str, Any]:
    """What the page shows of a picture."""
    view, result = picture.view, picture.result
    reading = _reading(view)
    draw = wave_figures if isinstance(result, InfiniteTrain) else spectrum_figures
    drawn = mode_drawing(result, mode, reading)
    spectra = draw(result, reading, drawn)  # type: ignore[arg-type]
    return {
        **asked,
        "address": view.address,
        "controls": control_panel(view),
        "report": report(picture, reading),
        "train": train_drawing(picture.base, infinite=view.infinite),
        "mode": drawn,
        "converged": picture.converged,
        "message": "",
        "figures": dict(zip(_SPECTRA, spectra, strict=True)),
    }


def _refused(
    view: View, asked: Mapping[str, Any], message: str, change: Mapping[str, Any]
) -> dict[str, Any]:
    """What the page shows in place of a picture: why there is none."""
    return {
        **asked,
        "address": view.address,
        "controls": control_panel(view),
        "converged": False,
        "message": message,
        "wrong": list(change.get("values", {})),
    }


def _words(error: Exception) -> str:
    return f"not converged: {error}" if isinstance(error, NotConverged) else str(error)


def _reading(view: View) -> Reading:
    return Reading(view.units, view.train.scales)
