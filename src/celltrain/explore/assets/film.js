/* Frames of a simulation: coefficients of all cells, packed as `celltrain.explore.film` does. */
"use strict";
window.celltrain = window.celltrain || {};

celltrain.unpacked = async function (text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).arrayBuffer();
};

celltrain.Film = class {
  /* `packed` as the package makes it: differences from frame to frame in whole steps, the lowest
     bytes of all of them, then the next ones. */
  static async of(packed) {
    const bytes = new Uint8Array(await celltrain.unpacked(packed.data));
    const count = bytes.length / 4;
    const frame = packed.cells * 3 * packed.degree ** 2;
    const values = new Int32Array(count);
    for (let index = 0; index < count; index++) {
      let change = 0;
      for (let plane = 0; plane < 4; plane++) change |= bytes[plane * count + index] << (8 * plane);
      values[index] = change + (index >= frame ? values[index - frame] : 0);
    }
    return new celltrain.Film(packed, values);
  }

  constructor(packed, values) {
    Object.assign(this, packed);
    this.values = values;
  }

  get frames() {
    return this.times.length;
  }

  /* The frame nearest to a time. */
  nearest(time) {
    let best = 0;
    this.times.forEach((each, index) => {
      if (Math.abs(each - time) < Math.abs(this.times[best] - time)) best = index;
    });
    return best;
  }

  /* Coefficients of one coordinate of a cell in a frame, r0. */
  coefficients(frame, cell, coordinate) {
    const size = this.degree ** 2;
    const start = ((frame * this.cells + cell) * 3 + coordinate) * size;
    const chosen = this.values.subarray(start, start + size);
    return Float64Array.from(chosen, (value) => value * this.step);
  }
};
