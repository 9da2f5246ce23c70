// SPDX-License-Identifier: MIT
// The twins in the order of the chain, as modules on a rail: lamps, AL state, plugs and cables.
import { make, setText } from "./dom.js";
import { watch } from "./bus.js";

const states = { 0: "off the bus", 1: "INIT", 2: "PREOP", 3: "BOOT", 4: "SAFEOP", 8: "OP" };
const ports = [["ecat.plug_in", "ecat.link_in", "input"], ["ecat.plug_out", "ecat.link_out", "output"]];

/** A lamp that blinks as the twin reports: "off", "on", "blinking", "flickering", "single flash", "double flash". */
export function makeLamp(label, colour) {
  const lamp = make("span", { class: `lamp ${colour}`, role: "img", "aria-label": `${label}: off` });
  lamp.show = (pattern) => {
    lamp.dataset.pattern = pattern.replace(" ", "-");
    lamp.setAttribute("aria-label", `${label}: ${pattern}`);
    lamp.title = `${label}: ${pattern}`;
  };
  return lamp;
}

function makePlug(context, slave, [plugName, linkName, label]) {
  const plug = context.signals.find(slave.number, plugName);
  const lamp = makeLamp(`link at the ${label}`, "green small");
  const button = make("button", { type: "button", class: `plug ${label}`, "data-slave": slave.number, "data-port": label }, make("span", { class: "jack" }), lamp);
  watch(plug, () => {
    const isIn = plug.value === 1;
    button.setAttribute("aria-pressed", String(isIn));
    button.setAttribute("aria-label", `Plug at the ${label} of twin ${slave.number}: ${isIn ? "in" : "pulled"}`);
    button.title = isIn ? `Pull the plug at the ${label}` : `Plug the ${label} in again`;
  });
  button.addEventListener("click", () => context.set(plug, plug.value === 1 ? 0 : 1));
  button.disabled = context.view;
  watch(context.signals.find(slave.number, linkName), (signal) => lamp.show(String(signal.value)));
  return button;
}

function makeLamps(context, slave) {
  const run = makeLamp("RUN", "green");
  const error = makeLamp("ERR", "red");
  watch(context.signals.find(slave.number, "ecat.run"), (signal) => run.show(String(signal.value)));
  watch(context.signals.find(slave.number, "ecat.err"), (signal) => error.show(String(signal.value)));
  return make("div", { class: "lamps" }, make("span", { class: "lamp-name" }, "RUN"), run, make("span", { class: "lamp-name" }, "ERR"), error);
}

function makeModule(context, slave, device, select) {
  const state = make("span", { class: "state" });
  const code = make("span", { class: "code" });
  const title = slave.name || device || `Twin ${slave.number}`;
  const front = make("button", { type: "button", class: "front", "aria-pressed": "false", "data-select": slave.number },
    make("span", { class: "position" }, String(slave.number)), make("span", { class: "title" }, title),
    make("span", { class: "device" }, slave.name ? device : " "));
  front.addEventListener("click", () => select(slave.number));
  const module = make("article", { class: "module", "data-module": slave.number, "aria-label": `Twin ${slave.number}, ${title}` },
    front, makeLamps(context, slave), make("p", { class: "al" }, state, code));
  watch(context.signals.find(slave.number, "ecat.state"), (signal) => {
    setText(state, states[signal.value] ?? String(signal.value));
    module.dataset.state = states[signal.value] ?? "";
  });
  watch(context.signals.find(slave.number, "ecat.code"), (signal) => {
    setText(code, signal.value > 0 ? `AL status ${signal.value.toString(16).toUpperCase().padStart(4, "0")}h` : "");
  });
  return { module, front };
}

/** The cable between two plugs, whole if both are in. */
function makeCable(context, before, behind) {
  const cable = make("span", { class: "cable", "aria-hidden": "true" });
  const plugs = [before && context.signals.find(before.number, "ecat.plug_out"), context.signals.find(behind.number, "ecat.plug_in")];
  const update = () => cable.classList.toggle("cut", plugs.some((plug) => plug && plug.value === 0));
  for (const plug of plugs) watch(plug, update);
  return cable;
}

/** @param select  called with the number of the twin whose front is clicked */
export function makeRail(context, devices, select) {
  const fronts = new Map();
  const slaves = context.signals.slaves();
  const rail = make("div", { class: "rail" }, make("span", { class: "master" }, "Master"));
  slaves.forEach((slave, position) => {
    const { module, front } = makeModule(context, slave, devices[position] ?? "", select);
    fronts.set(slave.number, front);
    const [input, output] = ports.map((port) => makePlug(context, slave, port));
    rail.append(makeCable(context, slaves[position - 1], slave), make("div", { class: "slot" }, input, module, output));
  });
  rail.mark = (number) => fronts.forEach((front, own) => front.setAttribute("aria-pressed", String(own === number)));
  return rail;
}
