/* Words and numbers about a train: the cards of what matters most, and the whole table. */
"use strict";
window.celltrain = window.celltrain || {};

celltrain.CARDS = [
  "growth rate α",
  "initial growth rate η",
  "velocity of the cells",
  "gap between cells",
  "effective viscosity",
];

celltrain.showNumbers = function (cards, table, rows) {
  const make = celltrain.element;
  const value = (row) => [
    make("span", { class: "value" }, row.value.replace("-", "−")),
    ...(row.error ? [make("span", { class: "error" }, ` ± ${row.error.replace("-", "−")}`)] : []),
  ];
  const chosen = celltrain.CARDS.map((name) => rows.find((row) => row.name === name));
  cards.replaceChildren(
    ...chosen
      .filter((row) => row)
      .map((row) =>
        make(
          "div",
          { class: "card" },
          make("span", { class: "name" }, row.name),
          make("span", { class: "number" }, ...value(row)),
          make("span", { class: "unit" }, row.unit || " ")
        )
      )
  );
  table.replaceChildren(
    make(
      "tbody",
      {},
      ...rows.map((row) =>
        make(
          "tr",
          {},
          make("th", { scope: "row" }, row.name),
          make("td", { class: "number" }, ...value(row)),
          make("td", { class: "unit" }, row.unit)
        )
      )
    )
  );
};
