// SPDX-License-Identifier: MIT
// The front of a CiA 402 drive: its state machine with the present state lit, and the shaft as a dial.
import { draw, make, setText, short } from "./dom.js";
import { watch } from "./bus.js";

const BOX = { width: 128, height: 26 };
// Places of the states: those in which the power stage is off above, on below, faults at the right.
const places = {
  "not ready to switch on": [4, 4], "switch on disabled": [4, 52], "ready to switch on": [4, 100], "switched on": [4, 148],
  "operation enabled": [4, 196], "quick stop active": [160, 124], "fault reaction active": [160, 196], fault: [160, 52],
};
// Transitions that a master or a fault causes (CiA 402), as pairs of states.
const transitions = [
  ["not ready to switch on", "switch on disabled"], ["switch on disabled", "ready to switch on"], ["ready to switch on", "switched on"],
  ["switched on", "operation enabled"], ["operation enabled", "quick stop active"], ["quick stop active", "switch on disabled"],
  ["operation enabled", "fault reaction active"], ["fault reaction active", "fault"], ["fault", "switch on disabled"],
];

function centre([x, y]) {
  return [x + BOX.width / 2, y + BOX.height / 2];
}

/** The point at which the line from a state to another one leaves its box. */
function edge(from, to) {
  const [x, y] = centre(from);
  const [dx, dy] = [centre(to)[0] - x, centre(to)[1] - y];
  const reach = Math.min(Math.abs(BOX.width / 2 / (dx || 1e-9)), Math.abs(BOX.height / 2 / (dy || 1e-9)));
  return [x + dx * reach, y + dy * reach];
}

/** The way from a fault's reaction to the fault, around the state between them. */
function makeDetour(from, to) {
  const right = from[0] + BOX.width;
  const [below, above] = [from[1] + BOX.height / 2, to[1] + BOX.height / 2];
  return draw("path", { class: "arrow", d: `M${right} ${below}H${right + 12}V${above}H${right}m6 -3l-6 3l6 3` });
}

function makeArrow(from, to) {
  if (to === "fault") return makeDetour(places[from], places[to]);
  const [x1, y1] = edge(places[from], places[to]);
  const [x2, y2] = edge(places[to], places[from]);
  const length = Math.hypot(x2 - x1, y2 - y1);
  const [ux, uy] = [(x2 - x1) / length, (y2 - y1) / length];
  const head = `M${x2 - 6 * ux + 3 * uy} ${y2 - 6 * uy - 3 * ux}L${x2} ${y2}L${x2 - 6 * ux - 3 * uy} ${y2 - 6 * uy + 3 * ux}`;
  return draw("path", { class: "arrow", d: `M${x1} ${y1}L${x2} ${y2}${head}` });
}

function makeStates(state) {
  const boxes = new Map();
  const picture = draw("svg", { class: "states", viewBox: "0 0 304 226", role: "img" }, ...transitions.map(([from, to]) => makeArrow(from, to)));
  for (const [name, [x, y]] of Object.entries(places)) {
    const label = draw("text", { x: x + BOX.width / 2, y: y + BOX.height / 2 + 4, "text-anchor": "middle" });
    label.textContent = name;
    const box = draw("g", { class: "box" }, draw("rect", { x, y, width: BOX.width, height: BOX.height, rx: 4 }), label);
    boxes.set(name, box);
    picture.append(box);
  }
  watch(state, () => {
    picture.setAttribute("aria-label", `CiA 402 state: ${state.value}`);
    for (const [name, box] of boxes) box.classList.toggle("lit", name === state.value);
    picture.classList.toggle("fault", String(state.value).startsWith("fault"));
  });
  return picture;
}

function makeDial(turns) {
  const marks = Array.from({ length: 36 }, (_, i) => draw("line", { class: "mark", x1: 60, x2: 60, y1: 6, y2: i % 9 === 0 ? 15 : 10, transform: `rotate(${i * 10} 60 60)` }));
  const hand = draw("g", {}, draw("line", { class: "hand", x1: 60, y1: 60, x2: 60, y2: 16 }), draw("circle", { class: "hub", cx: 60, cy: 60, r: 5 }));
  watch(turns, () => {
    const angle = (turns.value - Math.floor(turns.value)) * 360;
    hand.setAttribute("transform", `rotate(${angle.toFixed(2)} 60 60)`);
  });
  return draw("svg", { class: "dial", viewBox: "0 0 120 120", role: "img", "aria-label": "Angle of the shaft" }, draw("circle", { class: "rim", cx: 60, cy: 60, r: 56 }), ...marks, hand);
}

function makeFigure(signal, label) {
  const value = make("output", {});
  watch(signal, () => setText(value, `${short(signal.value)} ${signal.range?.unit ?? ""}`));
  return make("div", { class: "figure" }, make("span", { class: "label" }, label), value);
}

/** The axes of a twin: the part of their signals' names before the last word. */
export function axesOf(signals, slave) {
  return ["", ...Array.from({ length: 8 }, (_, i) => `axis${i + 1}.`)].filter((axis) => {
    const state = signals.find(slave, `${axis}state`);
    return state && !state.range && signals.find(slave, `${axis}turns`) && signals.find(slave, `${axis}speed`);
  });
}

/** @param axis  one of ::axesOf */
export function makeDrive(signals, slave, axis) {
  const find = (name) => signals.find(slave, axis + name);
  const figures = [["position", "Position"], ["speed", "Speed"], ["torque", "Torque"], ["mode", "Mode"], ["fault", "Fault"]]
    .map(([name, label]) => [find(name), label]).filter(([signal]) => signal);
  return make("div", { class: "drive", "data-axis": axis || "axis" }, makeStates(find("state")),
    make("div", { class: "shaft" }, makeDial(find("turns")), ...figures.map(([signal, label]) => makeFigure(signal, label))));
}
