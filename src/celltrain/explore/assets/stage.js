/* The train in three dimensions: cells and tube, drawn by Plotly, turned by mouse or keys. */
"use strict";
window.celltrain = window.celltrain || {};

celltrain.CELL = "#d42a1d";
celltrain.GLASS = "#5f87a8";

celltrain.Stage = class {
  constructor(div) {
    this.div = div;
    this.zoom = 1;
    this.camera = null;
    this.shown = null;
    this.drawing = null;
    this.busy = false;
    this.draws = 0;
    div.tabIndex = 0;
    div.addEventListener("keydown", (event) => this._key(event));
    new ResizeObserver(() => this.train && this._fitSoon()).observe(div);
  }

  /* A train as `train_drawing` gives it. */
  setTrain(train) {
    const rings = train.cells > 10 ? 18 : 24;
    const same = this.train && this.train.degree === train.degree && this.grid.rings === rings;
    if (!same) this.grid = new celltrain.Grid(train.degree, rings, Math.round(1.5 * rings));
    this.train = train;
    this.rest = this.grid.axisymmetric(train.profile);
    this.mode = null;
  }

  /* A mode as `mode_drawing` gives it, or null. */
  setMode(mode) {
    this.mode = null;
    if (!mode) return;
    const real = this.grid.displacement(mode.real, mode.m);
    const imaginary = this.grid.displacement(mode.imaginary, mode.m);
    let largest = 1e-300;
    for (let v = 0; v < this.grid.size; v++) {
      for (let turn = 0; turn < 8; turn++) {
        const [c, s] = [Math.cos((turn * Math.PI) / 8), Math.sin((turn * Math.PI) / 8)];
        let square = 0;
        for (let a = 0; a < 3; a++) square += (real[a][v] * c - imaginary[a][v] * s) ** 2;
        largest = Math.max(largest, Math.sqrt(square));
      }
    }
    this.mode = { q: mode.q, real, imaginary, largest };
  }

  /* As many places along the tube as are drawn: at least three, at most twelve. */
  places() {
    const cells = this.train.cells;
    return cells >= 3 ? Math.min(cells, 12) : cells * Math.ceil(3 / cells);
  }

  /* Coordinates of all cells: at rest, or with the mode at an amplitude (r0) and a phase. */
  linear(amplitude, phase) {
    const { places, size, points } = this._room(this.grid, this.places());
    const factor = this.mode ? amplitude / this.mode.largest : 0;
    for (let p = 0; p < places; p++) {
      const turn = this.mode ? this.mode.q * p + phase : 0;
      const [c, s] = [factor * Math.cos(turn), factor * Math.sin(turn)];
      for (let a = 0; a < 3; a++) {
        const shift = a === 2 ? (p - (places - 1) / 2) * this.train.period : 0;
        const [rest, target] = [this.rest[a], points[a]];
        for (let v = 0; v < size; v++) {
          let value = rest[v] + shift;
          if (factor) value += this.mode.real[a][v] * c - this.mode.imaginary[a][v] * s;
          target[p * size + v] = value;
        }
      }
    }
    return points;
  }

  /* Coordinates of all cells in a frame of a film, which shows one period or three of few cells. */
  frame(film, number) {
    if (!this.filmGrid || this.filmGrid.degree !== film.degree) {
      // Two rings for each half wave of the finest harmonic, but for a picture's own limits.
      const rings = Math.min(Math.max(20, 2 * film.degree), 40);
      this.filmGrid = new celltrain.Grid(film.degree, rings, Math.round(1.5 * rings));
    }
    const repeats = Math.ceil(3 / film.cells);
    const { places, size, points } = this._room(this.filmGrid, film.cells * repeats);
    const middle = (places - 1) / 2;
    for (let p = 0; p < places; p++) {
      const cell = p % film.cells;
      for (let a = 0; a < 3; a++) {
        const coefficients = film.coefficients(number, cell, a);
        this.filmGrid.surface(coefficients, points[a], p * size);
      }
      // Cells are where they have gone, the first one's place at first being 0; a cell that has left
      // the window at one end comes in at the other.
      const length = places * film.period;
      let shift = Math.floor(p / film.cells) * film.cells * film.period - film.start;
      const mean = film.coefficients(number, cell, 2)[0] / Math.sqrt(4 * Math.PI) + shift;
      shift -= length * Math.floor((mean + film.period / 2) / length) + middle * film.period;
      for (let v = p * size; v < (p + 1) * size; v++) points[2][v] += shift;
    }
    return points;
  }

  _room(grid, places) {
    const size = grid.size;
    const points = [0, 1, 2].map(() => new Float32Array(places * size));
    return { places, size, points };
  }

  /* Draw coordinates; while one drawing is under way only the last one asked for waits. */
  draw(points, places, grid) {
    this.waiting = { points, places, grid };
    if (!this.busy) this._next();
  }

  async _next() {
    this.busy = true;
    while (this.waiting) {
      const { points, places, grid } = this.waiting;
      this.waiting = null;
      const key = `${grid.degree} ${grid.rings} ${places} ${this.train.period} ${this.train.radius}`;
      try {
        if (this.shown === key) await this._move(points);
        else await this._make(points, places, grid);
        this.shown = key;
      } catch (error) {
        console.error(error);
      }
      this.draws += 1;
      this.div.dataset.draws = String(this.draws);
      this.div.dispatchEvent(new CustomEvent("drawn"));
    }
    this.busy = false;
  }

  _move([x, y, z]) {
    return Plotly.restyle(this.div, { x: [z], y: [y.map((value) => -value)], z: [x] }, [0]);
  }

  /* Along the tube is to the right, the x of a mode's cos(m phi) upwards. */
  _make([x, y, z], places, grid) {
    const faces = grid.faces();
    const all = { i: [], j: [], k: [] };
    for (let p = 0; p < places; p++) {
      for (const name of ["i", "j", "k"]) {
        for (const vertex of faces[name]) all[name].push(vertex + p * grid.size);
      }
    }
    this.half = (places * this.train.period) / 2;
    const cells = {
      type: "mesh3d",
      x: z,
      y: y.map((value) => -value),
      z: x,
      ...all,
      color: celltrain.CELL,
      hoverinfo: "skip",
      lighting: {
        ambient: 0.34,
        diffuse: 0.62,
        specular: 0.55,
        roughness: 0.28,
        fresnel: 0.25,
        vertexnormalsepsilon: 0,
        facenormalsepsilon: 0,
      },
      // In the camera's frame: from above, left and before.
      lightposition: { x: -40000, y: 90000, z: -55000 },
    };
    const scene = this._fitted();
    return Plotly.react(
      this.div,
      [cells, this._tube(), ...this._rings()],
      {
        margin: { l: 0, r: 0, t: 0, b: 0 },
        paper_bgcolor: "rgba(0,0,0,0)",
        showlegend: false,
        hovermode: false,
        scene,
      },
      { displayModeBar: false, displaylogo: false, scrollZoom: true, responsive: true }
    ).then(() => {
      if (this.listening) return;
      this.listening = true;
      this.div.on("plotly_relayout", (change) => this._moved(change));
    });
  }

  _tube() {
    const around = 72;
    const [x, y, z, i, j, k] = [[], [], [], [], [], []];
    for (let l = 0; l < around; l++) {
      const angle = (2 * Math.PI * l) / around;
      for (const end of [-this.half, this.half]) {
        x.push(end);
        y.push(this.train.radius * Math.cos(angle));
        z.push(this.train.radius * Math.sin(angle));
      }
      const [a, b] = [2 * l, 2 * ((l + 1) % around)];
      i.push(a, a + 1);
      j.push(b, b);
      k.push(a + 1, b + 1);
    }
    return {
      type: "mesh3d",
      ...{ x, y, z, i, j, k },
      color: celltrain.GLASS,
      opacity: 0.1,
      flatshading: false,
      hoverinfo: "skip",
      lighting: { ambient: 0.85, diffuse: 0.2, specular: 0.1, fresnel: 0.6 },
    };
  }

  _rings() {
    const ring = (place, width, color) => {
      const [x, y, z] = [[], [], []];
      for (let l = 0; l <= 72; l++) {
        const angle = (2 * Math.PI * l) / 72;
        x.push(place);
        y.push(1.005 * this.train.radius * Math.cos(angle));
        z.push(1.005 * this.train.radius * Math.sin(angle));
      }
      const line = { color, width };
      return { type: "scatter3d", mode: "lines", x, y, z, line, hoverinfo: "skip" };
    };
    return [ring(-this.half, 3, "#8fa6b8"), ring(this.half, 3, "#8fa6b8")];
  }

  /* The scene, with the whole tube in view at the zoom that was chosen. */
  _fitted() {
    const width = Math.max(this.div.clientWidth, 200);
    const height = Math.max(this.div.clientHeight, 120);
    const [length, wide] = [2 * this.half, 2 * this.train.radius];
    // Half the view's height is 1; looked at aslant, the tube's near end adds to its length.
    const slant = Math.abs(celltrain.Stage.ASIDE[0]);
    const seen = length * Math.cos(slant) + wide * Math.sin(slant);
    this.scale = Math.min((1.94 * width) / height / seen, 1.5 / wide);
    const size = this.scale * this.zoom;
    const hidden = (low, high) => ({
      visible: false,
      range: [low, high],
      showspikes: false,
    });
    // A little more than what is drawn: what reaches the edge of the box is cut off.
    const reach = 1.02 * this.train.radius;
    const end = 1.01 * this.half;
    return {
      xaxis: hidden(-end, end),
      yaxis: hidden(-reach, reach),
      zaxis: hidden(-reach, reach),
      aspectmode: "manual",
      aspectratio: { x: 2 * end * size, y: 2 * reach * size, z: 2 * reach * size },
      camera: this.camera || celltrain.Stage.look(...celltrain.Stage.ASIDE),
      dragmode: "turntable",
    };
  }

  /* Where one looks from unless told otherwise. */
  static ASIDE = [-0.34, 0.13];

  /* A camera at angles (radians) to the right and upwards. */
  static look(right, up) {
    const level = Math.cos(up);
    return {
      eye: {
        x: 2 * level * Math.sin(right),
        y: -2 * level * Math.cos(right),
        z: 2 * Math.sin(up),
      },
      center: { x: 0, y: 0, z: 0 },
      up: { x: 0, y: 0, z: 1 },
      projection: { type: "orthographic" },
    };
  }

  reset() {
    this.camera = null;
    this.zoom = 1;
    this._fit();
  }

  _fit() {
    if (this.shown) Plotly.relayout(this.div, { scene: this._fitted() });
  }

  _fitSoon() {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this._fit(), 120);
  }

  _moved(change) {
    if (change["scene.camera"]) this.camera = change["scene.camera"];
    const ratio = change["scene.aspectratio"];
    if (ratio) this.zoom = ratio.x / (2.02 * this.half * this.scale);
  }

  _key(event) {
    const turn = {
      ArrowLeft: [-0.1, 0],
      ArrowRight: [0.1, 0],
      ArrowUp: [0, 0.1],
      ArrowDown: [0, -0.1],
    }[event.key];
    const zoom = { "+": 1.15, "=": 1.15, "-": 1 / 1.15 }[event.key];
    if (!turn && !zoom) return;
    event.preventDefault();
    if (zoom) this.zoom *= zoom;
    if (turn) {
      const { x, y, z } = (this.camera || celltrain.Stage.look(...celltrain.Stage.ASIDE)).eye;
      const right = Math.atan2(x, -y) + turn[0];
      const up = Math.atan2(z, Math.hypot(x, y)) + turn[1];
      this.camera = celltrain.Stage.look(right, Math.min(Math.max(up, -1.5), 1.5));
    }
    this._fit();
  }

  picture(name) {
    const [width, height] = [2 * this.div.clientWidth, 2 * this.div.clientHeight];
    return Plotly.downloadImage(this.div, { format: "png", width, height, filename: name });
  }
};
