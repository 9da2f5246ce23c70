// SPDX-License-Identifier: MIT
// The signals of a twin, in groups, each with the control that fits its range.
import { make, setText, short } from "./dom.js";
import { parseNames, watch } from "./bus.js";

const LONGEST_SLIDER = 100000;

export function isSwitch(signal) {
  return signal.range && signal.range.low === 0 && signal.range.high === 1 && !signal.range.unit;
}

/**
 * @param rest  the value of the signal without this page, undefined: the last one
 * @return a function that sends the newest value of a control, one request at a time
 */
export function sender(context, signal, rest) {
  let next = null;
  let busy = false;
  return async (value) => {
    next = value;
    if (busy) return;
    busy = true;
    while (next !== null) {
      const sent = next;
      next = null;
      await context.set(signal, sent, rest);
    }
    busy = false;
  };
}

function makeSwitch(context, signal, label) {
  const send = sender(context, signal);
  if (/^writ(e|ing) 1\b/.test(signal.meaning ?? "")) {
    return make("button", { type: "button", class: "push", "aria-label": `do ${signal.name}`, on: { click: () => send(1) } }, "do");
  }
  const control = make("button", { type: "button", class: "switch", role: "switch", "aria-checked": "false", "aria-labelledby": label },
    make("span", { class: "knob" }));
  control.addEventListener("click", () => send(signal.value === 1 ? 0 : 1));
  watch(signal, () => control.setAttribute("aria-checked", String(signal.value === 1)));
  return control;
}

/** A text or number: sent with Enter, or when it is left. */
function makeInput(context, signal, label, type) {
  const send = sender(context, signal);
  const control = make("input", { type, class: type === "number" ? "number" : "text", "aria-labelledby": label, autocomplete: "off", spellcheck: "false" });
  if (type === "number") control.step = "any";
  let changed = false;
  control.addEventListener("input", () => { changed = true; });
  control.addEventListener("change", () => {
    changed = false;
    if (type !== "number") send(control.value);
    else if (control.value !== "") send(Number.isSafeInteger(Number(control.value)) ? Number(control.value) : control.value);
  });
  control.addEventListener("blur", () => { changed = false; });
  watch(signal, () => { if (!changed) control.value = String(signal.value); });
  return control;
}

function makeSlider(context, signal, label) {
  const send = sender(context, signal);
  const { low, high } = signal.range;
  const control = make("input", { type: "range", min: low, max: high, step: high - low > 20 ? 1 : "any", "aria-labelledby": label });
  let held = false;
  control.addEventListener("pointerdown", () => { held = true; });
  control.addEventListener("pointerup", () => { held = false; });
  control.addEventListener("input", () => send(Number(control.value)));
  watch(signal, () => { if (!held) control.value = String(signal.value); });
  return control;
}

function makeChoice(context, signal, label, names) {
  const send = sender(context, signal);
  const control = make("select", { "aria-labelledby": label }, ...names.map((one) => make("option", { value: one.value }, `${one.value} ${one.name}`)));
  control.addEventListener("change", () => send(Number(control.value)));
  watch(signal, () => { control.value = String(signal.value); });
  return control;
}

/** The controls that fit the range of a signal. @param label  id of the element that names it */
export function makeControls(context, signal, label) {
  const names = parseNames(signal.field);
  if (isSwitch(signal) && !names) return [makeSwitch(context, signal, label)];
  if (names) return [makeChoice(context, signal, label, names)];
  if (!signal.range) return [makeInput(context, signal, label, "text")];
  const controls = [makeInput(context, signal, label, "number")];
  if (signal.range.high - signal.range.low <= LONGEST_SLIDER) controls.unshift(makeSlider(context, signal, label));
  return controls;
}

export function makeReading(signal, label) {
  const names = parseNames(signal.field);
  const reading = make("output", { class: isSwitch(signal) && !names ? "bit" : "reading", "aria-labelledby": label });
  watch(signal, () => {
    const name = names?.find((one) => one.value === signal.value)?.name;
    setText(reading, name ?? short(signal.value));
    reading.dataset.value = String(signal.value);
  });
  return reading;
}

function makeRow(context, signal, plot) {
  const label = `signal-${signal.index}`;
  const settable = signal.access === "rw" && !context.view;
  const controls = settable ? makeControls(context, signal, label) : [makeReading(signal, label)];
  const unit = signal.range?.unit ?? "";
  let trace = null;
  if (signal.range) {
    trace = make("button", { type: "button", class: "trace", "aria-pressed": "false", "aria-label": `Plot ${signal.name}`, title: "Plot" });
    trace.addEventListener("click", () => trace.setAttribute("aria-pressed", String(plot.toggle(signal))));
    trace.setAttribute("aria-pressed", String(plot.traces.has(signal)));
    plot.onChange((chosen) => trace.setAttribute("aria-pressed", String(chosen.has(signal))));
  }
  return make("div", { class: "signal", "data-signal": signal.name, "data-slave": signal.slave },
    make("span", { class: "name", id: label }, signal.name), make("span", { class: "control" }, ...controls),
    make("span", { class: "unit" }, unit), trace ?? make("span"), make("span", { class: "meaning", title: signal.text }, signal.meaning ?? ""));
}

function groupOf(signal) {
  const dot = signal.name.indexOf(".");
  if (dot > 0) return signal.name.slice(0, dot);
  return signal.access === "rw" ? "Settings" : "Readings";
}

/** The signals of one twin with a filter. */
export function makeSignals(context, slave, plot) {
  const groups = new Map();
  for (const signal of context.signals.all) {
    if (signal.slave !== slave) continue;
    const name = groupOf(signal);
    if (!groups.has(name)) groups.set(name, []);
    groups.get(name).push(signal);
  }
  const order = [...groups].sort(([a], [b]) => rank(a) - rank(b));
  const filter = make("input", { type: "search", placeholder: "Filter", "aria-label": "Filter signals", class: "filter" });
  const blocks = order.map(([name, signals]) => make("details", { class: "group", open: rank(name) < 3 },
    make("summary", {}, make("span", { class: "group-name" }, name), make("span", { class: "count" }, String(signals.length))),
    ...signals.map((signal) => makeRow(context, signal, plot))));
  filter.addEventListener("input", () => applyFilter(blocks, filter.value.toLowerCase()));
  return make("div", { class: "signals" }, filter, ...blocks);
}

function rank(group) {
  return { Readings: 0, Settings: 1, edit: 4, ecat: 5 }[group] ?? 2;
}

function applyFilter(blocks, word) {
  for (const block of blocks) {
    let shown = 0;
    for (const row of block.querySelectorAll(".signal")) {
      row.hidden = word !== "" && !row.textContent.toLowerCase().includes(word);
      shown += row.hidden ? 0 : 1;
    }
    block.hidden = shown === 0;
    if (word !== "") block.open = true;
  }
}
