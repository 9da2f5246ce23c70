// SPDX-License-Identifier: MIT
// The front of a twin from an ESI file, from the entries of its PDOs: bits as lamps of a terminal, numbers as fields.
import { make, setText } from "./dom.js";
import { watch } from "./bus.js";
import { makeField, makeToggle } from "./front.js";
import { isSwitch } from "./signals.js";

// The meaning of an entry of a PDO begins with index and sub-index (docs/TWINS.md).
const entry = /^([0-9A-F]{4}):([0-9A-F]{2}) (.*)$/;

/** Signals of a twin that are process data. */
export function entriesOf(signals, slave) {
  return signals.all.filter((signal) => signal.slave === slave && entry.test(signal.meaning ?? ""));
}

function nameOf(signal) {
  return entry.exec(signal.meaning)[3];
}

function groupOf(signal) {
  const dot = signal.name.lastIndexOf(".");
  return dot > 0 ? signal.name.slice(0, dot) : "";
}

/** A bit: its lamp, and where the user sets it, a contact. */
function makeBit(context, signal) {
  const lamp = make("span", { class: "led", role: "img" });
  watch(signal, () => {
    lamp.classList.toggle("on", signal.value === 1);
    lamp.setAttribute("aria-label", `${signal.name}: ${signal.value === 1 ? "on" : "off"}`);
  });
  const isInput = signal.access === "rw";
  return make("li", { class: "bit-channel", title: signal.meaning, "data-bit": signal.name }, lamp, make("span", { class: "name" }, nameOf(signal)),
    isInput ? makeToggle(context, signal, "24 V", "contact") : make("span", { class: "contact out" }, "out"));
}

function makeGroup(context, name, signals) {
  const title = make("h3", {});
  setText(title, name || "Process data");
  const [bits, numbers] = [signals.filter(isSwitch), signals.filter((signal) => !isSwitch(signal))];
  return make("div", { class: "terminal", role: "group", "aria-label": name || "Process data" }, title, bits.length > 0 ? make("ul", { class: "bits" }, ...bits.map((bit) => makeBit(context, bit))) : null,
    ...numbers.map((signal) => makeField(context, signal, [nameOf(signal), signal.range?.unit].filter(Boolean).join(", "))));
}

export function makeTerminal(context, slave) {
  const groups = new Map();
  for (const signal of entriesOf(context.signals, slave)) {
    if (!groups.has(groupOf(signal))) groups.set(groupOf(signal), []);
    groups.get(groupOf(signal)).push(signal);
  }
  return make("div", { class: "terminals" }, ...[...groups].map(([name, signals]) => makeGroup(context, name, signals)));
}
