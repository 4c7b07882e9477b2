/* Points of figures by keys: in a figure that has the focus, arrows go from point to point. */
"use strict";
window.celltrain = window.celltrain || {};

celltrain.DIRECTIONS = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, -1],
  ArrowDown: [0, 1],
};

/* The points of a plot that can be chosen and lie inside its axes, and the ring, in pixels. */
celltrain.pointsOf = function (plot) {
  const { xaxis, yaxis } = plot._fullLayout;
  const inside = (place, axis) => place >= 0 && place <= axis._length;
  const points = [];
  let ring = null;
  for (const trace of plot.data) {
    const open = trace.marker && trace.marker.symbol === "circle-open" && !trace.customdata;
    if (!open && !trace.customdata) continue;
    Array.from(trace.x).forEach((x, index) => {
      const place = [xaxis.d2p(x), yaxis.d2p(trace.y[index])];
      if (open) ring = ring || place;
      else if (inside(place[0], xaxis) && inside(place[1], yaxis)) {
        points.push({ key: String(trace.customdata[index]), place });
      }
    });
  }
  return { points, ring };
};

/* The point that an arrow leads to from the one in the ring, or null: the nearest one ahead, what is
   aside counting twice. Without a ring the point farthest to the right is the first. */
celltrain.pointAhead = function ({ points, ring }, direction) {
  const least = (found, cost) => {
    const costs = found.map(cost);
    const best = Math.min(...costs);
    return Number.isFinite(best) ? found[costs.indexOf(best)] : null;
  };
  if (!ring) return least(points, ({ place }) => -place[0]);
  const away = ({ place }) => Math.hypot(place[0] - ring[0], place[1] - ring[1]);
  const here = least(points, away);
  const [dx, dy] = direction;
  return least(points, (point) => {
    const [x, y] = [point.place[0] - ring[0], point.place[1] - ring[1]];
    const ahead = x * dx + y * dy;
    const aside = Math.abs(x * dy - y * dx);
    // Of a mode and its conjugate both are the same.
    const same = here && away(here) < 1 && point.key === here.key;
    return same || ahead < 0.5 ? Infinity : ahead + 2 * aside;
  });
};

/* Let arrows choose points in an element with a plot: `choose` is called with the point's key. */
celltrain.chooseByKeys = function (host, choose) {
  host.addEventListener("keydown", (event) => {
    const direction = celltrain.DIRECTIONS[event.key];
    const plot = host.matches(".js-plotly-plot") ? host : host.querySelector(".js-plotly-plot");
    if (!direction || !plot || !plot._fullLayout) return;
    event.preventDefault();
    const point = celltrain.pointAhead(celltrain.pointsOf(plot), direction);
    if (point) choose(point.key);
  });
};
