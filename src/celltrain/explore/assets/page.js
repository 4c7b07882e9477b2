/* A page of one file: its data unpacked, its figures drawn, its modes and its film played. */
"use strict";
window.celltrain = window.celltrain || {};

celltrain.page = {
  async start() {
    const text = async (id) =>
      new TextDecoder().decode(await celltrain.unpacked(document.getElementById(id).textContent));
    const status = document.getElementById("status");
    try {
      const content = JSON.parse(await text("page-data"));
      const script = document.createElement("script");
      script.textContent = await text("plotly-data");
      document.head.append(script);
      this.content = content;
      await this._show(content);
      status.textContent = `celltrain ${content.version}`;
      status.dataset.kind = "ready";
    } catch (error) {
      status.textContent = "cannot be shown";
      status.dataset.kind = "wrong";
      const message = document.getElementById("message");
      message.hidden = false;
      message.textContent =
        typeof DecompressionStream === "undefined"
          ? "This browser is too old for the page: one of 2023 or later is needed."
          : String(error);
    }
  },

  async _show(content) {
    document.getElementById("title").textContent = content.title;
    document.getElementById("train-panel").hidden = !content.headline;
    document.getElementById("headline").textContent = content.headline || "";
    if (content.rows) {
      document.getElementById("numbers-panel").hidden = false;
      celltrain.showNumbers(
        document.getElementById("cards"),
        document.getElementById("numbers"),
        content.rows
      );
    }
    document.getElementById("player").hidden = !content.train;
    if (content.train) {
      this.player = new celltrain.Player(document.getElementById("player"), (state) =>
        this._played(state)
      );
      this.player.resting = content.motion;
      this.player.wantMode = () => this.choose(content.leading);
      this.player.framed = () => this._played(this.player.state);
      this.player.tabs.mode.disabled = !content.leading;
      this.player.setTrain(content.train);
    }
    await this._figures(content.figures);
    if (content.film) this.player.setFilm(await celltrain.Film.of(content.film));
    else if (content.leading) this.choose(content.leading);
  },

  async _figures(figures) {
    const make = celltrain.element;
    const host = document.getElementById("figures");
    this.plots = {};
    document.getElementById("legend").hidden = !figures.close;
    for (const [name, drawn] of Object.entries(figures)) {
      const plot = make("div", { class: "graph" });
      const note = make("span", { class: "note" }, drawn.note || "");
      host.append(
        make(
          "section",
          { class: "panel" },
          make("div", { class: "heading" }, make("h2", {}, drawn.title), note),
          plot
        )
      );
      const config = { displaylogo: false, displayModeBar: false, responsive: true };
      await Plotly.newPlot(plot, drawn.data, drawn.layout, config);
      plot.on("plotly_click", (click) => {
        const point = click.points.find((each) => each.customdata);
        if (point) this.choose(String(point.customdata));
      });
      this.plots[name] = plot;
      const chosen = drawn.data.some((trace) => trace.customdata);
      if (chosen && this.content.leading) {
        plot.tabIndex = 0;
        plot.setAttribute("role", "application");
        plot.setAttribute("aria-label", `${drawn.title}; arrow keys go from point to point`);
        celltrain.chooseByKeys(plot, (key) => this.choose(key));
      }
    }
  },

  choose(key) {
    const mode = this.content.modes && this.content.modes[key];
    if (!mode) return;
    this.player.setMode(mode);
    const [growth, frequency] = mode.place;
    for (const name of ["spectrum", "close"]) {
      if (!this.plots[name]) continue;
      const ring = { x: [[growth, growth]], y: [[frequency, -frequency]] };
      Plotly.restyle(this.plots[name], ring, [0]);
    }
  },

  /* The line in the figure of growth follows the film. */
  _played(state) {
    const plot = this.plots && this.plots.simulation;
    if (plot && state.show === "film") {
      const x = this.content.film.times[state.frame];
      Plotly.relayout(plot, { "shapes[0].x0": x, "shapes[0].x1": x });
    }
  },
};

celltrain.page.start();
