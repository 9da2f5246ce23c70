// SPDX-License-Identifier: MIT
// Working counters of the datagrams that the master repeats.
import { make, setText } from "./dom.js";
import { repeat } from "./poll.js";

const PAUSE = 1000;

function placeOf({ command, address, length }) {
  const hex = (value, digits) => value.toString(16).toUpperCase().padStart(digits, "0");
  const place = command.startsWith("L") ? hex(address, 8) : hex(Math.floor(address / 0x10000), 4);
  return `${command} ${place}h, ${length} bytes`;
}

function makeRow(line) {
  const counter = make("output", { "aria-label": `Working counter of ${placeOf(line)}` });
  const rate = make("td", { class: "number" });
  const lower = make("td", { class: "number" });
  const row = make("tr", { "data-datagram": line.command }, make("th", { scope: "row" }, placeOf(line)), make("td", { class: "number" }, counter), rate, lower);
  let before = line;
  let at = performance.now();
  row.show = (now) => {
    const span = (performance.now() - at) / 1000;
    setText(counter, now.counter === now.highest ? String(now.counter) : `${now.counter} of ${now.highest}`);
    counter.classList.toggle("bad", now.counter !== now.highest);
    if (span > 0.2) setText(rate, now.replies > before.replies ? String(Math.round((now.replies - before.replies) / span)) : "0");
    setText(lower, String(now.lower));
    lower.classList.toggle("bad", now.lower > before.lower);
    [before, at] = [now, performance.now()];
  };
  row.show(line);
  return row;
}

/** A table of the datagrams; the twins count them while it is read. */
export function makeCounters(context) {
  const none = make("p", { class: "label" }, "The datagrams of a master appear here.");
  const body = make("tbody", {});
  const table = make("table", { class: "counters", hidden: true }, make("thead", {}, make("tr", {},
    ...["Datagram", "Working counter", "Replies/s", "Below the highest"].map((title) => make("th", { scope: "col" }, title)))), body);
  const rows = new Map();
  const show = (lines) => {
    const recent = lines.filter((line) => line.time < 3);
    const keys = recent.map(placeOf);
    for (const [key, row] of rows) {
      if (keys.includes(key)) continue;
      row.remove();
      rows.delete(key);
    }
    recent.forEach((line, i) => {
      if (!rows.has(keys[i])) {
        rows.set(keys[i], makeRow(line));
        body.append(rows.get(keys[i]));
      }
      rows.get(keys[i]).show(line);
    });
    table.hidden = rows.size === 0;
    none.hidden = rows.size > 0;
  };
  repeat(async () => {
    const reply = await context.request({ op: "counters" });
    if (reply.ok) show(reply.lines ?? []);
  }, PAUSE);
  return make("div", { class: "counters-frame", tabindex: "0", role: "group", "aria-label": "Working counters" }, none, table);
}
