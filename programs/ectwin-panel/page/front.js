// SPDX-License-Identifier: MIT
// Parts that the fronts of devices share.
import { make, setText, short } from "./dom.js";
import { parseNames, watch } from "./bus.js";
import { makeControls, makeReading, sender } from "./signals.js";

let labels = 0;

/** The name of a signal's present value, or the value with its unit. */
export function wordOf(signal) {
  const name = parseNames(signal.field)?.find((one) => one.value === signal.value)?.name;
  return name ?? [short(signal.value), signal.range?.unit].filter(Boolean).join(" ");
}

/** A reading under its label. */
export function makeFigure(signal, label) {
  const value = make("output", { "aria-label": label });
  watch(signal, () => setText(value, wordOf(signal)));
  return make("div", { class: "figure" }, make("span", { class: "label" }, label), value);
}

/** Figures of those signals that exist. @param names  pairs of name and label */
export function makeFigures(find, names) {
  return names.filter(([name]) => find(name)).map(([name, label]) => makeFigure(find(name), label));
}

/** A label with the control of a signal, or with its reading where nothing may be changed. */
export function makeField(context, signal, text) {
  if (!signal) return null;
  const id = `front-${++labels}`;
  const controls = signal.access === "rw" && !context.view ? makeControls(context, signal, id) : [makeReading(signal, id)];
  return make("div", { class: "field", "data-field": signal.name }, make("span", { class: "label", id }, text), make("span", { class: "control" }, ...controls));
}

/** A button that toggles a signal of 0 and 1. */
export function makeToggle(context, signal, text, className) {
  const send = sender(context, signal);
  const button = make("button", { type: "button", class: className, "aria-pressed": "false", "data-toggle": signal.name, disabled: context.view }, text);
  button.addEventListener("click", () => send(signal.value === 1 ? 0 : 1));
  watch(signal, () => button.setAttribute("aria-pressed", String(signal.value === 1)));
  return button;
}

/** A button that is on while it is held. */
export function makeHeld(context, signal, text, on = 1) {
  const send = sender(context, signal, 0);
  const button = make("button", { type: "button", class: "held", "data-held": signal.name, "aria-pressed": "false", disabled: context.view }, text);
  let held = false;
  const hold = (now) => {
    if (held !== now) send(now ? on : 0);
    held = now;
  };
  const isKey = (event) => event.key === " " || event.key === "Enter";
  button.addEventListener("pointerdown", (event) => {
    button.setPointerCapture(event.pointerId);
    hold(true);
  });
  for (const end of ["pointerup", "pointercancel", "blur"]) button.addEventListener(end, () => hold(false));
  button.addEventListener("keydown", (event) => { if (isKey(event)) hold(true); });
  button.addEventListener("keyup", (event) => { if (isKey(event)) hold(false); });
  watch(signal, () => button.setAttribute("aria-pressed", String(signal.value !== 0)));
  return button;
}

/** A button that sends one value. */
export function makeAction(context, signal, text, value = 1) {
  return make("button", { type: "button", disabled: context.view, "data-action": signal.name, on: { click: () => context.set(signal, value) } }, text);
}

/** The named values of a signal in a row, the present one lit. */
export function makeChain(signal, label, names = parseNames(signal.field) ?? []) {
  const chips = new Map(names.map(({ value, name }) => [value, make("li", { class: "chip" }, name)]));
  const list = make("ul", { class: "chips", "aria-label": label }, ...chips.values());
  watch(signal, () => {
    for (const [value, chip] of chips) {
      chip.classList.toggle("lit", value === signal.value);
      if (value === signal.value) chip.setAttribute("aria-current", "true");
      else chip.removeAttribute("aria-current");
    }
    list.dataset.lit = chips.get(signal.value)?.textContent ?? "";
  });
  return list;
}

/** Buttons for the values of a signal, of which one is pressed. @param choices  pairs of value and text */
export function makeChoices(context, signal, label, choices) {
  const buttons = choices.map(([value, text]) => make("button", { type: "button", "aria-pressed": "false", "data-choice": value, disabled: context.view,
    on: { click: () => context.set(signal, value) } }, text));
  watch(signal, () => buttons.forEach((button, i) => button.setAttribute("aria-pressed", String(choices[i][0] === signal.value))));
  return make("div", { class: "choices", role: "group", "aria-label": label }, make("span", { class: "label" }, label), ...buttons);
}
