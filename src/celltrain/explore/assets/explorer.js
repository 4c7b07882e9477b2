/* The explorer's page: controls, address, and what Dash brings from the server. */
"use strict";
window.celltrain = window.celltrain || {};

celltrain.explorer = {
  pending: null,
  busy: false,
  sliders: {},
  view: {},

  start() {
    if (this.player) return;
    this.player = new celltrain.Player(document.getElementById("player"), () => this._address());
    this.player.wantMode = () => this.chooseMode("leading");
    this.player.framed = () => this._timeLine();
    for (const host of document.querySelectorAll(".graph[tabindex]")) {
      const map = host.classList.contains("map");
      celltrain.chooseByKeys(host, (key) => (map ? this.send({ place: key }) : this.chooseMode(key)));
    }
    const query = new URLSearchParams(location.search);
    this.view = Object.fromEntries(query);
    const state = {};
    for (const name of ["amplitude", "phase"]) {
      if (query.has(name) && isFinite(query.get(name))) state[name] = Number(query.get(name));
    }
    this.player.set(state, true);
    dash_clientside.set_props("page", { data: Math.random().toString(36).slice(2) });
    if (query.has("mode")) {
      this.still = true;
      dash_clientside.set_props("asked-mode", { data: query.get("mode") });
    }
    const own = ["token", "mode", "amplitude", "phase", "time", "show"];
    own.forEach((name) => query.delete(name));
    this.send({ address: query.toString() });
  },

  /* Changes go to the server one at a time; those that come meanwhile go together after it, or
     after two seconds: what takes longer, as where there is no train, is then given up. */
  send(change) {
    this.pending = this._together(this.pending, change);
    clearTimeout(this.waiting);
    if (!this.busy) this._flush();
    else {
      const left = 2000 - (performance.now() - this.asked);
      this.waiting = setTimeout(() => this.pending && this._flush(), Math.max(left, 0));
    }
  },

  /* Two changes as one; what is newer takes the place of what is older. */
  _together(older, newer) {
    const merged = { ...older, ...newer };
    for (const kind of ["places", "values"]) {
      // Another case of a study has values of its own.
      if (!older || "place" in newer) {
        merged[kind] = newer[kind] || {};
        continue;
      }
      const kept = Object.entries(older[kind] || {}).filter(
        ([name]) => !(name in (newer.places || {})) && !(name in (newer.values || {}))
      );
      merged[kind] = { ...Object.fromEntries(kept), ...newer[kind] };
    }
    return merged;
  },

  _flush() {
    // What has not been answered is asked for again.
    this.sent = this._together(this.busy ? this.sent : null, this.pending);
    this.busy = true;
    this.asked = performance.now();
    const change = { ...this.sent, count: (this.count = (this.count || 0) + 1) };
    this.pending = null;
    this.status("computing", "computing");
    dash_clientside.set_props("change", { data: change });
  },

  status(kind, words) {
    const chip = document.getElementById("status");
    chip.textContent = words;
    chip.dataset.kind = kind;
  },

  /* An answer of the server: numbers, train, mode, and figures, which wait for the train. */
  show(shown) {
    if (!shown) return;
    const answered = this.busy && shown.number !== this.number;
    this.number = shown.number;
    if (answered) {
      this.busy = false;
      if (this.pending) this._flush();
    }
    this._controls(shown.controls, shown.wrong || []);
    const message = document.getElementById("message");
    message.hidden = !shown.message;
    message.textContent = shown.message;
    this.case = shown.address;
    this._links();
    document.querySelector("main").classList.toggle("stale", Boolean(shown.message));
    if (shown.report) {
      const { report } = shown;
      document.getElementById("title").textContent = report.title;
      document.getElementById("headline").textContent = report.headline;
      celltrain.showNumbers(
        document.getElementById("cards"),
        document.getElementById("numbers"),
        report.rows
      );
      this.player.resting = report.motion;
      this.player.follow(shown.train, shown.mode);
      if (shown.mode && this.still !== undefined) this._restore(shown.mode);
    }
    if (shown.message) this.status("wrong", shown.report ? "coarse only" : "no picture");
    else if (!this.busy) {
      const degree = `degree ${shown.report.degree}`;
      const how = shown.report.given ? "as given" : "converged";
      if (shown.converged) this.status("converged", `${how} · ${degree}`);
      else this.status("coarse", `coarse · ${degree}, refining`);
    }
    this._address();
    if (answered) this._measure(shown);
    if (shown.figures) this._draw(shown.figures);
  },

  /* Figures, once the train is on the screen: they take longer than it does. */
  _draw(figures) {
    const waiting = Boolean(this.figures);
    this.figures = figures;
    if (waiting) return;
    const draw = () => {
      for (const [name, figure] of Object.entries(this.figures)) {
        dash_clientside.set_props(name, { figure });
      }
      this.figures = null;
    };
    const drawn = () => requestAnimationFrame(() => setTimeout(draw, 0));
    this.player.canvas.addEventListener("drawn", drawn, { once: true });
  },

  /* Time from what somebody did until the train is drawn, for tests and curious people. */
  _measure(shown) {
    const { asked } = this;
    const done = () => {
      this.player.canvas.removeEventListener("drawn", done);
      document.body.dataset.milliseconds = String(Math.round(performance.now() - asked));
      document.body.dataset.answered = String(shown.number);
    };
    if (shown.train) this.player.canvas.addEventListener("drawn", done);
    else done();
  },

  _restore(mode) {
    this.still = undefined;
    this.player.setMode(mode, { playing: false });
  },

  chooseMode(key) {
    dash_clientside.set_props("asked-mode", { data: key });
  },

  /* The mode that was asked for by a click. */
  showMode(mode) {
    if (!mode) return;
    this.mode = mode.key;
    if (this.still) this._restore(mode);
    else this.player.setMode(mode);
    for (const name of ["spectrum-all", "spectrum-close"]) {
      const plot = document.querySelector(`#${name} .js-plotly-plot`);
      const [growth, frequency] = mode.place;
      if (plot && plot.data.length) {
        Plotly.restyle(plot, { x: [[growth, growth]], y: [[frequency, -frequency]] }, [0]);
      }
    }
  },

  clicked(click) {
    const point = click && click.points.find((each) => each.customdata);
    if (point) this.chooseMode(String(point.customdata));
  },

  clickedMap(click) {
    const point = click && click.points.find((each) => each.customdata !== undefined);
    if (point) this.send({ place: String(point.customdata) });
  },

  async film() {
    const answer = await fetch("film.json");
    if (!answer.ok) return;
    const film = await celltrain.Film.of(await answer.json());
    if (this.view.time) this.player.state.frame = film.nearest(Number(this.view.time));
    this.player.setFilm(film);
    const { show } = this.view;
    if (show === "train" || (show === "mode" && this.player.mode)) this.player.set({ show });
  },

  /* The address: the case, and what is played on it. */
  _address() {
    if (this.case === undefined || !this.player) return;
    const query = new URLSearchParams(this.case);
    const { show, amplitude, phase, frame, playing } = this.player.state;
    if (show === "mode" && this.player.mode) {
      query.set("mode", this.player.mode.key);
      query.set("amplitude", String(amplitude));
      query.set("phase", String(playing ? 0 : Math.round(phase)));
    }
    if (show === "film" && this.player.film) query.set("time", this.player.film.times[frame]);
    if (this.player.film && show !== "film") query.set("show", show);
    const address = `?${query.toString().replaceAll("%2C", ",")}`;
    // Browsers refuse too many changes of the address in a short time.
    clearTimeout(this.addressing);
    if (address !== location.search) {
      this.addressing = setTimeout(() => history.replaceState(null, "", address), 60);
    }
    this._timeLine();
  },

  /* The line in the figure of growth is at the film's time. */
  _timeLine() {
    const plot = document.querySelector("#simulation .js-plotly-plot");
    const { film, state } = this.player;
    if (!plot || !film || !plot.layout.meta) return;
    if (!plot.followed) {
      // Also after it was drawn anew, in other units.
      plot.followed = true;
      plot.on("plotly_afterplot", () => this._timeLine());
    }
    const x = film.times[state.frame] * plot.layout.meta.time;
    if (plot.layout.shapes[0].x0 === x) return;
    Plotly.relayout(plot, { "shapes[0].x0": x, "shapes[0].x1": x });
  },

  _links() {
    for (const [id, name] of [
      ["save-case", "celltrain.toml"],
      ["save-result", "celltrain.nc"],
    ]) {
      document.getElementById(id).href = `save/${name}?${this.case}`;
    }
  },

  /* Sliders and fields; made once for the units, then moved. */
  _controls(panel, wrong) {
    const host = document.getElementById("controls");
    if (this.units !== panel.units) {
      this.units = panel.units;
      host.replaceChildren(...this._made(panel));
    }
    for (const control of panel.sliders) {
      const { slider, field } = this.sliders[control.name];
      // What somebody holds must not be taken from the hand.
      if (document.activeElement !== slider || !this.busy) slider.value = control.place;
      slider.setAttribute("aria-valuetext", `${control.text} ${control.unit}`);
      const bad = wrong.includes(control.name);
      field.setAttribute("aria-invalid", String(bad));
      if (!bad && (document.activeElement !== field || !field.dirty)) field.value = control.text;
    }
    const bad = wrong.includes("cells");
    this.cells.field.setAttribute("aria-invalid", String(bad));
    if (!bad) this.cells.field.value = panel.cells;
    this.cells.slider.value = Math.min(panel.cells, panel.most_cells);
    this.cells.infinite.checked = panel.infinite;
    this.cells.slider.disabled = this.cells.field.disabled = panel.infinite;
  },

  _field(name, label) {
    const field = celltrain.element("input", {
      type: "text",
      inputmode: "decimal",
      id: `field-${name}`,
      "aria-label": label,
      autocomplete: "off",
      oninput: () => (field.dirty = true),
      onchange: () => {
        field.dirty = false;
        this.send({ values: { [name]: field.value } });
      },
    });
    return field;
  },

  _made(panel) {
    const make = celltrain.element;
    const units = make(
      "div",
      { class: "units", role: "group", "aria-label": "Units" },
      ...[
        ["dimensionless", "r₀, U, µ"],
        ["SI", "SI"],
      ].map(([name, words]) =>
        make(
          "button",
          {
            type: "button",
            id: `units-${name}`,
            "aria-pressed": String(name === panel.units),
            onclick: () => this.send({ units: name }),
          },
          words
        )
      )
    );
    this.sliders = {};
    const rows = panel.sliders.map((control) => {
      const slider = make("input", {
        type: "range",
        id: `slider-${control.name}`,
        min: 0,
        max: 1,
        step: 0.0025,
        "aria-label": control.label,
        oninput: () => this.send({ places: { [control.name]: Number(slider.value) } }),
      });
      const field = this._field(control.name, `${control.label}, value`);
      this.sliders[control.name] = { slider, field };
      return make(
        "div",
        { class: "control" },
        make("label", { for: slider.id }, control.label),
        field,
        make("span", { class: "unit" }, control.unit),
        slider
      );
    });
    const slider = make("input", {
      type: "range",
      id: "slider-cells",
      min: 1,
      max: panel.most_cells,
      step: 1,
      "aria-label": "Number of cells",
      oninput: () => this.send({ values: { cells: slider.value } }),
    });
    const infinite = make("input", {
      type: "checkbox",
      id: "infinite",
      onchange: () => this.send({ infinite: infinite.checked }),
    });
    this.cells = { slider, field: this._field("cells", "Number of cells, value"), infinite };
    const cells = make(
      "div",
      { class: "control" },
      make("label", { for: slider.id }, "Number of cells"),
      this.cells.field,
      make("span", { class: "unit" }),
      slider,
      make("label", { class: "check" }, infinite, "infinite train")
    );
    return [units, ...rows, cells];
  },
};

window.dash_clientside = window.dash_clientside || {};
window.dash_clientside.celltrain = {
  show(shown, film) {
    const ready = () => {
      if (!window.Plotly || !document.getElementById("player")) return void setTimeout(ready, 30);
      celltrain.explorer.start();
      if (shown) celltrain.explorer.show(shown);
      else if (film) celltrain.explorer.film();
    };
    ready();
    return "";
  },
  mode(mode) {
    celltrain.explorer.showMode(mode);
    return "";
  },
  curves(curves) {
    if (!curves) return "";
    for (const chip of document.querySelectorAll(".curves-stage")) {
      chip.textContent = curves.converged ? "" : "coarse";
    }
    document.body.dataset.curves = curves.converged ? "converged" : "coarse";
    return "";
  },
  clicked(...clicks) {
    const { triggered } = dash_clientside.callback_context;
    if (triggered.length) celltrain.explorer.clicked(triggered[0].value);
    return "";
  },
  clickedMap(click) {
    celltrain.explorer.clickedMap(click);
    return "";
  },
};
