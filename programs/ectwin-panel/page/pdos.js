// SPDX-License-Identifier: MIT
// The process data of a twin: the entries of its assigned PDOs by name, with their values.
import { make, setText } from "./dom.js";
import { readAll, repeat } from "./poll.js";

const PAUSE = 300; // ms between two readings

function hexOf(number, digits) {
  return number.toString(16).toUpperCase().padStart(digits, "0");
}

/** Byte and bit of an entry in the data of its SyncManager. */
function offsetOf(bit) {
  return bit % 8 === 0 ? String(bit / 8) : `${Math.floor(bit / 8)}.${bit % 8}`;
}

function nameOf({ object, name }) {
  if (!object || object === name) return name ?? "";
  return name ? `${object}: ${name}` : object;
}

/** Entries with their place in the data of their SyncManager; gaps have no row. */
export function placesOf(lines) {
  const used = new Map();
  return lines.map((line) => {
    const bit = used.get(line.sm) ?? 0;
    used.set(line.sm, bit + line.bits);
    return { ...line, bit };
  }).filter((line) => line.index !== 0);
}

function makeRow(entry) {
  const value = make("output", { "aria-label": `Value of ${nameOf(entry)}` });
  const row = make("tr", { "data-entry": `${hexOf(entry.index, 4)}h:${entry.sub}` }, make("td", { class: "number" }, offsetOf(entry.bit)),
    make("td", { class: "number" }, `${hexOf(entry.index, 4)}h:${entry.sub}`), make("th", { scope: "row" }, nameOf(entry)), make("td", { class: "number" }, value), make("td", { class: "unit" }, `${entry.type ?? ""}, ${entry.bits}`));
  row.show = ({ value: number, data }) => setText(value, String(number ?? data ?? ""));
  row.show(entry);
  return row;
}

function makeTable(direction, entries, rows) {
  const body = make("tbody", {});
  let pdo = null;
  for (const entry of entries) {
    if (pdo !== entry.pdo) body.append(make("tr", { class: "pdo" }, make("th", { colspan: 5, scope: "rowgroup" }, `${hexOf(entry.pdo, 4)}h ${entry.pdo_name ?? ""}`.trim())));
    pdo = entry.pdo;
    rows.push(makeRow(entry));
    body.append(rows.at(-1));
  }
  return make("table", { class: "pdos" }, make("caption", {}, `${direction === "outputs" ? "Outputs, from the master" : "Inputs, to the master"}`),
    make("thead", {}, make("tr", {}, ...["Byte", "Entry", "Name", "Value", "Type, bits"].map((title) => make("th", { scope: "col" }, title)))), body);
}

/** The process data of a twin, which are read while it is open. */
export function makePdos(context, slave) {
  const status = make("p", { class: "label", role: "status" });
  const tables = make("div", { class: "pdo-tables", tabindex: "0", role: "group", "aria-label": "Entries of the PDOs" });
  const details = make("details", { class: "group process-data" }, make("summary", {}, make("span", { class: "group-name" }, "Process data by PDO")), status, tables);
  let shown = "";
  let rows = [];
  const show = (entries) => {
    const layout = entries.map((entry) => `${entry.place}:${entry.index}:${entry.sub}:${entry.bits}`).join();
    if (layout !== shown || rows.length === 0) {
      rows = [];
      tables.replaceChildren(...["outputs", "inputs"].map((direction) => [direction, entries.filter((entry) => entry.direction === direction)])
        .filter(([, some]) => some.length > 0).map(([direction, some]) => makeTable(direction, some, rows)));
      setText(status, entries.length > 0 ? `${entries.length} entries of the PDOs that are assigned now` : "No PDO is assigned.");
      shown = layout;
    } else {
      const order = [...entries.filter((entry) => entry.direction === "outputs"), ...entries.filter((entry) => entry.direction === "inputs")];
      order.forEach((entry, i) => rows[i].show(entry));
    }
  };
  repeat(async () => {
    const lines = await readAll(context, { op: "pdos", slave }, (last) => ({ op: "pdos", slave, place: last.place + 1 }));
    if (lines) show(placesOf(lines));
  }, PAUSE, () => details.open);
  return details;
}
