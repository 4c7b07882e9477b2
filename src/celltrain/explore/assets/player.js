/* The stage with what plays on it: the train, a mode, a simulation's film. */
"use strict";
window.celltrain = window.celltrain || {};

/* An element with attributes and children. */
celltrain.element = function (tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (value === true) made.setAttribute(name, "");
    else if (value !== false && value !== null) made.setAttribute(name, value);
  }
  made.append(...children);
  return made;
};

celltrain.Player = class {
  /* Builds itself into `host`; `changed` is called with what is played after anybody changed it. */
  constructor(host, changed = () => {}) {
    this.changed = changed;
    this.state = { show: "train", amplitude: 0.35, phase: 0, frame: 0, playing: false };
    const make = celltrain.element;
    const slider = (name, label, most, step) =>
      make("input", {
        type: "range",
        "aria-label": label,
        class: `player-${name}`,
        min: 0,
        max: most,
        step,
        value: this.state[name],
        oninput: (event) => this.set({ [name]: Number(event.target.value) }),
      });
    this.sliders = {
      amplitude: slider("amplitude", "Amplitude of the mode, r0", 0.6, 0.01),
      phase: slider("phase", "Phase of the mode, degrees", 360, 1),
      frame: slider("frame", "Time of the simulation", 1, 1),
    };
    this.outputs = Object.fromEntries(
      Object.keys(this.sliders).map((name) => [name, make("output", {})])
    );
    const group = (name, label) =>
      make("label", { class: `play-item play-${name}` }, label, this.sliders[name], this.outputs[name]);
    this.tabs = {
      train: this._tab("train", "Steady train"),
      mode: this._tab("mode", "Mode"),
      film: this._tab("film", "Simulation"),
    };
    this.play = make(
      "button",
      { type: "button", class: "play", onclick: () => this.set({ playing: !this.state.playing }) },
      "Play"
    );
    this.caption = make("p", { class: "caption", "aria-live": "polite" });
    this.canvas = make("div", {
      class: "stage",
      role: "application",
      "aria-label":
        "The train in three dimensions; arrow keys turn it, plus and minus zoom, or use the mouse",
    });
    this.bar = make(
      "div",
      { class: "player-bar" },
      make("div", { class: "tabs", role: "group", "aria-label": "What is shown" }, ...Object.values(this.tabs)),
      this.play,
      group("amplitude", "amplitude"),
      group("phase", "phase"),
      group("frame", "time")
    );
    const corner = make(
      "div",
      { class: "corner" },
      make("button", { type: "button", class: "plain", onclick: () => this.stage.reset() }, "Reset view"),
      make(
        "button",
        { type: "button", class: "plain", onclick: () => this.stage.picture("celltrain") },
        "Save picture"
      )
    );
    host.replaceChildren(this.canvas, make("div", { class: "below" }, this.caption, corner), this.bar);
    this.stage = new celltrain.Stage(this.canvas);
    this._show();
  }

  _tab(name, label) {
    const click = () => (name === "mode" && !this.mode ? this.wantMode() : this.set({ show: name }));
    return celltrain.element("button", { type: "button", onclick: click }, label);
  }

  /* Called when a mode is asked for and none is chosen. */
  wantMode() {}

  /* Called a few times a second while a film plays. */
  framed() {}

  setTrain(train) {
    this.train = train;
    this.stage.setTrain(train);
    if (this.mode) this.stage.setMode(this.mode);
    this._draw();
  }

  /* A mode to play, or null; `state` says how. */
  setMode(mode, state = {}) {
    this.mode = mode;
    this.stage.setMode(mode);
    const still = window.matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.set(mode ? { show: "mode", playing: !still, ...state } : { show: "train", playing: false });
  }

  /* A train together with the mode that goes on playing on it. */
  follow(train, mode) {
    this.train = train;
    this.mode = mode;
    this.stage.setTrain(train);
    this.stage.setMode(mode);
    if (!mode && this.state.show === "mode") this.state.show = "train";
    this._show();
    this._draw();
  }

  setFilm(film) {
    this.film = film;
    this.sliders.frame.max = film.frames - 1;
    this.set({ show: "film", frame: Math.min(this.state.frame, film.frames - 1) });
  }

  /* Change some of what is played; `quiet` tells nobody. */
  set(state, quiet = false) {
    Object.assign(this.state, state);
    if (this.state.show === "train") this.state.playing = false;
    this._show();
    this._draw();
    if (this.state.playing && !this.running) this._run();
    if (!quiet) this.changed(this.state);
  }

  _show() {
    const { show, amplitude, phase, frame, playing } = this.state;
    for (const [name, tab] of Object.entries(this.tabs)) {
      tab.setAttribute("aria-pressed", String(name === show));
      tab.hidden = name === "film" && !this.film;
    }
    this.play.textContent = playing ? "Pause" : "Play";
    this.play.hidden = show === "train";
    for (const name of ["amplitude", "phase"]) {
      this.sliders[name].parentElement.hidden = show !== "mode";
    }
    this.sliders.frame.parentElement.hidden = show !== "film";
    for (const name of Object.keys(this.sliders)) this.sliders[name].value = this.state[name];
    this.outputs.amplitude.textContent = `${amplitude.toFixed(2)} r₀`;
    this.outputs.phase.textContent = `${Math.round(phase)}°`;
    if (this.film) {
      this.outputs.frame.textContent = `${this.film.times[frame].toFixed(1)} r₀/U`;
    }
    if (show === "mode" && this.mode) this.caption.textContent = `Mode ${this.mode.words}`;
    else if (show === "film") this.caption.textContent = this.film.words;
    else this.caption.textContent = this.resting || "";
  }

  _draw() {
    if (!this.train) return;
    const { show, amplitude, phase, frame } = this.state;
    if (show === "film" && this.film) {
      const places = this.film.cells * Math.ceil(3 / this.film.cells);
      this.stage.train = { ...this.stage.train, period: this.film.period, radius: this.film.radius };
      this.stage.draw(this.stage.frame(this.film, frame), places, this.stage.filmGrid);
      return;
    }
    this.stage.train = this.train;
    const shown = show === "mode" ? amplitude : 0;
    const points = this.stage.linear(shown, (phase * Math.PI) / 180);
    this.stage.draw(points, this.stage.places(), this.stage.grid);
  }

  /* One turn of a mode, or a film, in some seconds; frames are left out rather than late. */
  _run() {
    this.running = true;
    let before = performance.now();
    let told = before;
    let place = this.state.frame;
    const step = (now) => {
      if (!this.state.playing) {
        this.running = false;
        return;
      }
      requestAnimationFrame(step);
      if (this.stage.busy) return;
      // The first frame's time may lie before the call.
      const seconds = Math.min(Math.max((now - before) / 1000, 0), 0.5);
      before = now;
      if (this.state.show === "mode") {
        this.state.phase = (this.state.phase + (360 * seconds) / 4) % 360;
      } else if (this.film) {
        if (Math.floor(place) !== this.state.frame) place = this.state.frame;
        place += (this.film.frames * seconds) / Math.max(12, this.film.frames / 30);
        if (place > this.film.frames - 1) place = 0;
        this.state.frame = Math.floor(place);
        if (now - told > 150) {
          told = now;
          this.framed();
        }
      }
      this._show();
      this._draw();
    };
    requestAnimationFrame(step);
  }
};
