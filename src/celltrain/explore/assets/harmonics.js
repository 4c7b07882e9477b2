/* Shapes from their harmonics, on a grid over the sphere: as `celltrain.harmonics` defines them. */
"use strict";
window.celltrain = window.celltrain || {};

/* A grid of rings from pole to pole, with the normalised Legendre functions on it. */
celltrain.Grid = class {
  constructor(degree, rings, azimuths) {
    this.degree = degree;
    this.rings = rings;
    this.azimuths = azimuths;
    this.size = 2 + (rings - 1) * azimuths;
    this.theta = Array.from({ length: rings + 1 }, (_, k) => (Math.PI * k) / rings);
    this.phi = Array.from({ length: azimuths }, (_, l) => (2 * Math.PI * l) / azimuths);
    this.legendre = this._legendre(degree + 1);
    this.cosine = [];
    this.sine = [];
    for (let m = 0; m <= degree; m++) {
      this.cosine.push(Float64Array.from(this.phi, (phi) => Math.cos(m * phi)));
      this.sine.push(Float64Array.from(this.phi, (phi) => Math.sin(m * phi)));
    }
  }

  /* P_no by order, degree and ring, by the stable recursion in the degree. */
  _legendre(orders) {
    const degree = this.degree;
    const points = this.theta.length;
    const cosine = this.theta.map(Math.cos);
    const sine = this.theta.map(Math.sin);
    let diagonal = new Float64Array(points).fill(Math.sqrt(0.25 / Math.PI));
    const table = [];
    for (let o = 0; o <= orders; o++) {
      const rows = Array.from({ length: degree }, () => new Float64Array(points));
      table.push(rows);
      if (o >= degree) continue;
      if (o > 0) {
        const scale = Math.sqrt((2 * o + 1) / (2 * o));
        diagonal = diagonal.map((value, k) => scale * sine[k] * value);
      }
      rows[o].set(diagonal);
      for (let n = o + 1; n < degree; n++) {
        const scale = Math.sqrt((4 * n * n - 1) / (n * n - o * o));
        const before = n > o + 1 ? Math.sqrt(((n - 1) ** 2 - o * o) / (4 * (n - 1) ** 2 - 1)) : 0;
        for (let k = 0; k < points; k++) {
          rows[n][k] = scale * cosine[k] * rows[n - 1][k];
          if (before) rows[n][k] -= scale * before * rows[n - 2][k];
        }
      }
    }
    return table;
  }

  /* Place of a ring's azimuth among the vertices; each pole is one vertex. */
  vertex(ring, azimuth) {
    if (ring === 0) return 0;
    if (ring === this.rings) return this.size - 1;
    return 1 + (ring - 1) * this.azimuths + (azimuth % this.azimuths);
  }

  /* Triangles, outward, as three lists of vertices. */
  faces() {
    const [i, j, k] = [[], [], []];
    const add = (a, b, c) => {
      i.push(a);
      j.push(b);
      k.push(c);
    };
    for (let ring = 0; ring < this.rings; ring++) {
      for (let l = 0; l < this.azimuths; l++) {
        const [a, b] = [this.vertex(ring, l), this.vertex(ring, l + 1)];
        const [c, d] = [this.vertex(ring + 1, l), this.vertex(ring + 1, l + 1)];
        if (ring < this.rings - 1) add(a, c, d);
        if (ring > 0) add(a, d, b);
      }
    }
    return { i, j, k };
  }

  /* Calls `each(vertex, ring, azimuth)` for all vertices. */
  eachVertex(each) {
    each(0, 0, 0);
    for (let ring = 1; ring < this.rings; ring++) {
      for (let l = 0; l < this.azimuths; l++) each(this.vertex(ring, l), ring, l);
    }
    each(this.size - 1, this.rings, 0);
  }

  _sum(coefficients, order, first) {
    const sum = new Float64Array(this.theta.length);
    coefficients.forEach((value, index) => {
      const row = this.legendre[order][first + index];
      for (let k = 0; k < sum.length; k++) sum[k] += value * row[k];
    });
    return sum;
  }

  /* The cell of a profile [z_n, rho_n], as coordinates x, y, z of its vertices. */
  axisymmetric(profile) {
    const z = this._sum(profile[0], 0, 0);
    const rho = this._sum(profile[1], 1, 0);
    const points = [0, 1, 2].map(() => new Float64Array(this.size));
    this.eachVertex((v, k, l) => {
      points[0][v] = rho[k] * this.cosine[1][l];
      points[1][v] = rho[k] * this.sine[1][l];
      points[2][v] = z[k];
    });
    return points;
  }

  /* The displacement by a real vector in `azimuthal_basis(degree, m)`. */
  displacement(vector, m) {
    const M = this.degree;
    const split = m === 0 ? [M, 2 * M - 1] : [M - m, M - m + Math.max(M - m - 1, 0)];
    const [axial, plus, minus] = [
      vector.slice(0, split[0]),
      vector.slice(split[0], split[1]),
      vector.slice(split[1]),
    ];
    const Z = this._sum(axial, m, m).map((value) => (m ? Math.SQRT2 : 1) * value);
    const one = this._sum(plus, m + 1, m + 1);
    const other = m ? this._sum(minus, m - 1, m - 1) : this._sum(minus, 1, 1);
    const points = [0, 1, 2].map(() => new Float64Array(this.size));
    this.eachVertex((v, k, l) => {
      const R = m ? one[k] + other[k] : one[k];
      const Phi = m ? one[k] - other[k] : other[k];
      const radial = R * this.cosine[m][l];
      const turning = m ? Phi * this.sine[m][l] : Phi;
      const [c, s] = [this.cosine[1][l], this.sine[1][l]];
      points[0][v] = radial * c - turning * s;
      points[1][v] = radial * s + turning * c;
      points[2][v] = Z[k] * this.cosine[m][l];
    });
    return points;
  }

  /* One coordinate of a cell of any shape, from its M^2 coefficients, into `target` at `offset`. */
  surface(coefficients, target, offset) {
    const M = this.degree;
    const even = new Float64Array(M);
    const odd = new Float64Array(M);
    for (let k = 0; k <= this.rings; k++) {
      for (let m = 0; m < M; m++) {
        let [a, b] = [0, 0];
        for (let n = m; n < M; n++) {
          const value = this.legendre[m][n][k];
          a += coefficients[n * n + n + m] * value;
          if (m) b += coefficients[n * n + n - m] * value;
        }
        even[m] = m ? Math.SQRT2 * a : a;
        odd[m] = Math.SQRT2 * b;
      }
      const count = k === 0 || k === this.rings ? 1 : this.azimuths;
      for (let l = 0; l < count; l++) {
        let sum = even[0];
        for (let m = 1; m < M; m++) sum += even[m] * this.cosine[m][l] + odd[m] * this.sine[m][l];
        target[offset + this.vertex(k, l)] = sum;
      }
    }
  }
};
