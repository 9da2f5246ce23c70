// SPDX-License-Identifier: MIT
// The object dictionary of a twin: a list, read and written entry by entry.
import { make, setText } from "./dom.js";

function addressOf({ index, sub }) {
  return `${index.toString(16).toUpperCase().padStart(4, "0")}h:${sub}`;
}

function makeEntry(context, slave, entry) {
  const address = addressOf(entry);
  const place = { slave, index: entry.index, sub: entry.sub };
  const value = make("output", { "aria-label": `Value of ${address}` });
  const show = (reply, text) => {
    setText(value, reply.ok ? text : reply.message);
    value.classList.toggle("bad", !reply.ok);
  };
  const read = async () => {
    const reply = await context.request({ op: "read", ...place });
    const line = reply.lines?.[0];
    show(reply, line ? String(line.value ?? line.data) + (line.data.length < 2 * line.size ? ` … ${line.size} bytes` : "") : "");
  };
  const controls = [];
  if (entry.access.startsWith("r")) controls.push(make("button", { type: "button", "aria-label": `Read ${address}`, on: { click: read } }, "Read"));
  if (entry.access.endsWith("w") || entry.access === "wo") {
    const input = make("input", { type: "text", "aria-label": `New value of ${address}`, autocomplete: "off", spellcheck: "false", disabled: context.view });
    const write = async () => {
      const reply = await context.request({ op: "write", ...place, value: input.value });
      show(reply, "");
      if (reply.ok && entry.access === "rw") await read();
    };
    controls.push(input, make("button", { type: "button", "aria-label": `Write ${address}`, disabled: context.view, on: { click: write } }, "Write"));
  }
  return make("div", { class: "object", "data-object": address, title: `${entry.type}, ${entry.bits} bits, ${entry.access}` }, make("span", { class: "address" }, address),
    make("span", { class: "name" }, entry.name === entry.object ? entry.name : `${entry.object}: ${entry.name}`), value, make("span", { class: "control" }, ...controls));
}

/** The dictionary of a twin, which is listed when it is opened. */
export function makeObjects(context, slave) {
  const status = make("p", { class: "label", role: "status" });
  const filter = make("input", { type: "search", placeholder: "Filter", "aria-label": "Filter objects", class: "filter" });
  const list = make("div", { class: "objects" });
  const details = make("details", { class: "group dictionary" }, make("summary", {}, make("span", { class: "group-name" }, "Object dictionary")), filter, status, list);
  const apply = () => {
    const word = filter.value.toLowerCase();
    for (const row of list.children) row.hidden = word !== "" && !row.textContent.toLowerCase().includes(word);
  };
  const load = async () => {
    let place = { index: 0, sub: 0 };
    while (details.isConnected && place.index <= 0xFFFF) {
      const reply = await context.request({ op: "objects", slave, ...place });
      const last = reply.lines?.at(-1);
      if (!last) {
        setText(status, reply.ok ? `${list.children.length} entries` : reply.message);
        return;
      }
      list.append(...reply.lines.map((entry) => makeEntry(context, slave, entry)));
      place = last.sub < 0xFF ? { index: last.index, sub: last.sub + 1 } : { index: last.index + 1, sub: 0 };
      apply();
    }
  };
  let loaded = false;
  details.addEventListener("toggle", () => {
    if (details.open && !loaded) load();
    loaded = loaded || details.open;
  });
  filter.addEventListener("input", apply);
  return details;
}
