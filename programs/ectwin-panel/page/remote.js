// SPDX-License-Identifier: MIT
// The fronts of a Vision Remote base unit and of its remote units.
import { draw, make, setText } from "./dom.js";
import { parseNames, watch, watchAll } from "./bus.js";
import { makeAction, makeChain, makeField, makeFigures, makeHeld, makeToggle, wordOf } from "./front.js";
import { makeGamepadButton, makeStick } from "./stick.js";
import { sender } from "./signals.js";

const REMOTES = 8;
const SWITCHES = 8;

/* --- remote units -------------------------------------------------------------------------------------------------- */

function makeBattery(context, signal) {
  const fill = draw("rect", { x: 3, y: 3, height: 12, width: 0, rx: 1 });
  const picture = draw("svg", { class: "battery", viewBox: "0 0 44 18", role: "img" },
    draw("rect", { class: "case", x: 1, y: 1, width: 38, height: 16, rx: 2 }), draw("rect", { class: "pole", x: 40, y: 6, width: 3, height: 6 }), fill);
  watch(signal, () => {
    fill.setAttribute("width", String(34 * signal.value / 100));
    picture.classList.toggle("low", signal.value < 20);
    picture.setAttribute("aria-label", `Battery ${signal.value} %`);
  });
  return make("div", { class: "gauge" }, picture, makeField(context, signal, "Battery"));
}

function makeRadio(context, signal) {
  const bars = [0, 1, 2, 3, 4].map((i) => draw("rect", { x: 1 + 8 * i, y: 14 - 3 * i, width: 6, height: 4 + 3 * i, rx: 1 }));
  const picture = draw("svg", { class: "radio", viewBox: "0 0 44 18", role: "img" }, ...bars);
  watch(signal, () => {
    bars.forEach((bar, i) => bar.classList.toggle("lit", signal.value > 20 * i));
    picture.setAttribute("aria-label", `Radio ${signal.value} %`);
  });
  return make("div", { class: "gauge" }, picture, makeField(context, signal, "Radio"));
}

/** The control of a position, by the kind of switch that is fitted there. */
function makeFitted(context, signal, kind, label) {
  const send = sender(context, signal);
  if (kind === 1) return makeHeld(context, signal, label);
  if (kind === 2) return makeToggle(context, signal, label, "toggle");
  const highest = { 3: 1, 4: 1000, 5: 3, 6: 3 }[kind];
  const control = make("input", { type: "range", min: kind === 3 ? -1 : 0, max: highest, step: 1, "aria-label": label, disabled: context.view });
  control.addEventListener("input", () => send(Number(control.value)));
  watch(signal, () => { control.value = String(signal.value); });
  return make("label", { class: "position-label" }, make("span", { class: "label" }, label), control);
}

function makePositions(context, find) {
  const places = make("div", { class: "positions" });
  for (let number = 1; number <= SWITCHES; number++) {
    const [signal, fitted] = [find(`switch${number}`), find(`fitted${number}`)];
    const place = make("span", { class: "fitted" });
    let kind = null;
    watch(fitted, () => {
      if (fitted.value === kind) return;
      kind = fitted.value;
      place.hidden = kind === 0;
      place.replaceChildren(...(kind > 0 ? [makeFitted(context, signal, kind, `S${number}`)] : []));
    });
    places.append(place);
  }
  return places;
}

/** The bytes of a command as printable text. */
function textOf(digits) {
  return (String(digits ?? "").match(/../g) ?? []).map((pair) => {
    const code = Number.parseInt(pair, 16);
    return code >= 32 && code < 127 ? String.fromCharCode(code) : "·";
  }).join("");
}

function makeDisplay(find) {
  const lines = [make("p", {}), make("p", {}), make("p", {})];
  const [state, disabled, received, count] = ["state", "disabled", "received", "received_count"].map(find);
  const show = () => {
    setText(lines[0], `${wordOf(state)}${disabled.value > 0 ? `: ${wordOf(disabled)}` : ""}`);
    setText(lines[1], count.value > 0 ? textOf(received.value) : "");
    setText(lines[2], count.value > 0 ? `command ${count.value}: ${received.value}` : "no command received");
  };
  watchAll([state, disabled, received, count], show);
  return make("div", { class: "display", role: "status", "aria-label": "Display" }, ...lines);
}

function makeEncoder(context, find) {
  const encoder = find("encoder");
  const turn = (by) => context.set(encoder, ((encoder.value ?? 0) + by + 256) % 256);
  const value = make("output", { "aria-label": "Encoder" });
  watch(encoder, () => setText(value, String(encoder.value)));
  return make("div", { class: "encoder", role: "group", "aria-label": "Encoder" },
    make("button", { type: "button", "aria-label": "Encoder to the left", disabled: context.view, on: { click: () => turn(-1) } }, "↺"), value,
    make("button", { type: "button", "aria-label": "Encoder to the right", disabled: context.view, on: { click: () => turn(1) } }, "↻"),
    makeHeld(context, find("encoder_switch"), "push"));
}

function makeRemoteBody(context, find, number) {
  const sticks = [["joystick1", "joystick2"], ["joystick3", "joystick4"]].map((names, i) => makeStick(context, names.map(find), `Joysticks ${2 * i + 1} and ${2 * i + 2}`));
  return make("div", { class: "remote-body" }, makeDisplay(find),
    make("div", { class: "sticks" }, sticks[0], makeToggle(context, find("stop"), "STOP", "mushroom"), sticks[1]),
    makePositions(context, find),
    make("div", { class: "tools" }, makeEncoder(context, find), context.view ? null : makeGamepadButton(sticks)),
    make("div", { class: "gauges" }, makeBattery(context, find("battery")), makeRadio(context, find("rssi"))),
    make("div", { class: "tools" }, ...[["cable", "Cable"], ["docked", "Docked"], ["g_link_lost", "Out of reach"], ["shock", "Shock"]]
      .map(([name, text]) => makeToggle(context, find(name), text, "toggle"))),
    make("div", { class: "figures" }, ...makeFigures(find, [["c_link", "C-Link"], ["g_link", "G-Link"], ["commands_dropped", "Dropped"]])),
    make("details", {}, make("summary", {}, `More of RU ${number}`), ...[["disabled", "Movements"], ["id", "Id"], ["command", "Command"]]
      .map(([name, text]) => makeField(context, find(name), text))));
}

function makeRemote(context, slave, number) {
  const find = (name) => context.signals.find(slave, `ru${number}.${name}`);
  const [on, state] = [find("on"), find("state")];
  const word = make("span", { class: "chip" });
  const card = make("article", { class: "remote", "aria-label": `Remote unit ${number}`, "data-remote": number },
    make("header", {}, make("h3", {}, `RU ${number}`), word, makeToggle(context, on, "On", "toggle"), makeToggle(context, find("armed"), "Armed", "toggle")));
  let body = null;
  watch(on, () => {
    card.dataset.on = String(on.value);
    if (on.value === 1 && !body) card.append(body = makeRemoteBody(context, find, number));
    if (body) body.hidden = on.value !== 1;
  });
  watch(state, () => {
    setText(word, wordOf(state));
    word.classList.toggle("lit", state.value === 3);
    word.classList.toggle("bad", state.value >= 4);
  });
  return card;
}

/* --- base unit ----------------------------------------------------------------------------------------------------- */

/** The contacts of the E-stop relays. */
function makeRelays(signal) {
  const arms = [18, 46].map((y) => draw("line", { class: "arm", x1: 30, y1: y, x2: 66, y2: y }));
  const picture = draw("svg", { class: "relays", viewBox: "0 0 100 60", role: "img" },
    ...[18, 46].flatMap((y) => [draw("line", { class: "wire", x1: 2, y1: y, x2: 30, y2: y }), draw("line", { class: "wire", x1: 68, y1: y, x2: 98, y2: y }),
      draw("circle", { class: "contact", cx: 30, cy: y, r: 3 }), draw("circle", { class: "contact", cx: 68, cy: y, r: 3 })]), ...arms);
  const word = make("output", {});
  watch(signal, () => {
    const closed = signal.value === 1;
    arms.forEach((arm, i) => arm.setAttribute("transform", closed ? "" : `rotate(-24 30 ${18 + 28 * i})`));
    picture.classList.toggle("closed", closed);
    picture.setAttribute("aria-label", `ES-Link relays ${closed ? "closed" : "open"}`);
    setText(word, closed ? "closed" : "open");
  });
  return make("div", { class: "figure" }, make("span", { class: "label" }, "ES-Link relays"), picture, word);
}

function makeLcd(message, cause) {
  const lines = [make("p", {}), make("p", { class: "small" })];
  watchAll([message, cause], () => [message, cause].forEach((signal, i) => setText(lines[i], String(signal.value))));
  return make("div", { class: "display", role: "status", "aria-label": "Message of the base unit" }, ...lines);
}

export const isBaseUnit = (signals, slave) => Boolean(signals.find(slave, "bu.state") && signals.find(slave, "ru1.joystick1"));

export function makeBaseUnit(context, slave) {
  const find = (name) => context.signals.find(slave, `bu.${name}`);
  const states = parseNames(find("state").field) ?? [];
  return make("div", { class: "base" },
    make("div", { class: "base-states" }, makeChain(find("state"), "State of the base unit", states), makeLcd(find("message"), find("cause"))),
    makeRelays(find("es_link")),
    make("div", { class: "figures" }, ...makeFigures(find, [["eg_link", "EG-Link"], ["ec_link", "EC-Link"], ["armed", "Armed"], ["unarmed", "Unarmed"], ["pci", "PCI"],
      ["cci", "CCI"], ["pai", "PAI"], ["cai", "CAI"], ["periodic_sets", "Periodic sets"]])),
    make("div", { class: "tools" }, ...[["failed", "Fatal error"], ["module_error", "Module error"], ["frozen", "Frozen"]]
      .map(([name, text]) => makeToggle(context, find(name), text, "toggle")), makeAction(context, find("restart"), "Power cycle"),
    makeField(context, find("vlaps"), "VLAPs"), makeField(context, find("eg_link"), "EG-Link")));
}

export function makeRemotes(context, slave) {
  return make("div", { class: "remotes" }, ...Array.from({ length: REMOTES }, (_, i) => makeRemote(context, slave, i + 1)));
}
