// SPDX-License-Identifier: MIT
// The twins in the order of the chain, as modules on a rail: lamps, AL state, plugs and cables.
import { make, setText } from "./dom.js";
import { watch } from "./bus.js";

const states = { 0: "off the bus", 1: "INIT", 2: "PREOP", 3: "BOOT", 4: "SAFEOP", 8: "OP" };
// Plugs of the ports, with the words for them. The lamp of a junction is that of the input at the other end: a wire has one link.
const ports = [["ecat.plug_in", "input"], ["ecat.plug_out", "output"], ["ecat.plug_2", "port 2"], ["ecat.plug_3", "port 3"]];
const junctions = [3, 2]; // in the order of the frames

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

/** @param link  the signal of the lamp */
function makePlug(context, slave, port, link) {
  const [plugName, label] = ports[port];
  const plug = context.signals.find(slave.number, plugName);
  const lamp = makeLamp(`link at the ${label}`, "green small");
  const button = make("button", { type: "button", class: `plug ${label.split(" ")[0]}`, "data-slave": slave.number, "data-port": label }, make("span", { class: "jack" }), lamp);
  watch(plug, () => {
    const isIn = plug.value === 1;
    button.setAttribute("aria-pressed", String(isIn));
    button.setAttribute("aria-label", `Plug at the ${label} of twin ${slave.number}: ${isIn ? "in" : "pulled"}`);
    button.title = isIn ? `Pull the plug at the ${label}` : `Plug the ${label} in again`;
  });
  button.addEventListener("click", () => context.set(plug, plug.value === 1 ? 0 : 1));
  button.disabled = context.view;
  watch(link, (signal) => lamp.show(String(signal.value)));
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

/** A cable, whole if the plugs at its ends are in. */
function makeCable(context, ...ends) {
  const cable = make("span", { class: "cable", "aria-hidden": "true" });
  const plugs = ends.map(({ slave, port }) => context.signals.find(slave.number, ports[port][0]));
  const update = () => cable.classList.toggle("cut", plugs.some((plug) => plug && plug.value === 0));
  for (const plug of plugs) watch(plug, update);
  return cable;
}

/** The twins below each twin, by port. @param wires  lines of `wires`; without them the twins are a line */
function treeOf(slaves, wires) {
  const nodes = new Map(slaves.map((slave) => [slave.number, { slave, down: {} }]));
  slaves.forEach((slave, i) => {
    const { up, port } = wires?.[i] ?? { up: slaves[i - 1]?.number ?? 0, port: 1 };
    if (up > 0) nodes.get(up).down[port] = nodes.get(slave.number);
  });
  return nodes.get(slaves[0].number);
}

/** The twins of a line: from port 1 to port 0 of the next one. */
function lineFrom(node) {
  const line = [];
  for (let at = node; at; at = at.down[1]) line.push(at);
  return line;
}

function makeSlot(context, modules, { slave, down }) {
  const link = (number, name) => context.signals.find(number, name);
  const wired = junctions.filter((port) => down[port]);
  const row = [makePlug(context, slave, 0, link(slave.number, "ecat.link_in")), modules.get(slave.number), makePlug(context, slave, 1, link(slave.number, "ecat.link_out"))];
  const below = wired.map((port) => make("div", { class: "junction" }, makePlug(context, slave, port, link(down[port].slave.number, "ecat.link_in")), make("span", { class: "label" }, `port ${port}`)));
  return make("div", { class: "slot" }, ...row, below.length > 0 ? make("div", { class: "junctions" }, ...below) : null);
}

/** A line with the branches at its junctions. @param start  the label before it; `from`: the port at which it begins */
function makeLine(context, modules, node, { start, label, from, last, ring }) {
  const line = lineFrom(node);
  const parts = line.flatMap((one, i) => {
    const before = i > 0 ? { slave: line[i - 1].slave, port: 1 } : from;
    return [makeCable(context, ...(before ? [before] : []), { slave: one.slave, port: 0 }), makeSlot(context, modules, one)];
  });
  const end = line.at(-1).slave;
  if (ring && end.number === last) parts.push(makeCable(context, { slave: end, port: 1 }), make("span", { class: "master" }, "Master, second interface"));
  const branches = line.flatMap((one) => junctions.filter((port) => one.down[port]).map((port) => makeLine(context, modules, one.down[port], {
    start: `${one.slave.number}, port ${port}`, label: `Branch at port ${port} of twin ${one.slave.number}`, from: { slave: one.slave, port }, last, ring,
  })));
  return make("div", { class: from ? "branch" : "trunk", role: "group", "aria-label": label }, make("div", { class: branches.length > 0 ? "rail junctioned" : "rail" }, make("span", { class: "master" }, start), ...parts), ...branches);
}

/**
 * The twins as they are wired.
 * @param select  called with the number of the twin whose front is clicked
 * @param wires   a promise of the lines of the request `wires`
 * @param ring    the last twin leads to a second interface of the master
 */
export function makeRail(context, devices, select, wires, ring) {
  const fronts = new Map();
  const modules = new Map();
  const slaves = context.signals.slaves();
  slaves.forEach((slave, position) => {
    const { module, front } = makeModule(context, slave, devices[position] ?? "", select);
    fronts.set(slave.number, front);
    modules.set(slave.number, module);
  });
  const rail = make("div", { class: "wiring" });
  wires.then((lines) => {
    if (slaves.length > 0) rail.append(makeLine(context, modules, treeOf(slaves, lines), { start: "Master", label: "Line at the master", from: null, last: slaves.at(-1).number, ring }));
  });
  rail.mark = (number) => fronts.forEach((front, own) => front.setAttribute("aria-pressed", String(own === number)));
  return rail;
}
