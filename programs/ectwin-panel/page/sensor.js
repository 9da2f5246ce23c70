// SPDX-License-Identifier: MIT
// The front of an optoNCDT 2300: sensor, beam and target to scale.
import { draw, make, setText } from "./dom.js";
import { watch, watchAll } from "./bus.js";
import { makeField, makeFigures, makeToggle } from "./front.js";
import { sender } from "./signals.js";

const START = 150; // of the measuring range, in the picture
const END = 390;
const MARGIN = 0.15; // of the range, before and behind it
const FIRST_ERROR = 2147483637; // distances from here on are errors (A 7.2.5)
const MILLIMETRE = 1e6; // in nm

function isDistance(value) {
  return value < FIRST_ERROR;
}

function makeScale(range) {
  const marks = Array.from({ length: 11 }, (_, i) => {
    const x = START + (END - START) * i / 10;
    return draw("line", { class: "mark", x1: x, x2: x, y1: 118, y2: i % 5 === 0 ? 128 : 123 });
  });
  const labels = [0, 0.5, 1].map((part) => draw("text", { x: START + (END - START) * part, y: 142, "text-anchor": "middle" }));
  watch(range, () => labels.forEach((label, i) => setText(label, `${range.value * i / 2} mm`)));
  return [draw("rect", { class: "range", x: START, y: 20, width: END - START, height: 98 }), ...marks, ...labels];
}

/** A surface at a measured distance; without one it is where it was set. */
function makeSurface(find, number, moved) {
  const [reading, set, present, range] = [find(`distance${number}`), find(`surface${number}.distance`), find(`surface${number}.present`), find("range")];
  const plate = draw("rect", { class: `surface surface-${number}`, x: 0, y: 24, width: 7, height: 90, rx: 1 });
  const update = () => {
    const distance = isDistance(reading.value) ? reading.value / MILLIMETRE : set.value;
    const part = Math.max(-MARGIN, Math.min(1 + MARGIN, distance / range.value));
    const x = START + (END - START) * part;
    plate.setAttribute("x", x.toFixed(1));
    plate.style.display = present.value === 1 ? "" : "none";
    plate.classList.toggle("missed", !isDistance(reading.value));
    moved(present.value === 1 ? x : END + 40);
  };
  watchAll([reading, set, present, range], update);
  return plate;
}

function makePicture(find) {
  const beam = draw("line", { class: "beam", x1: 88, y1: 69, y2: 69, x2: 420 });
  const back = draw("line", { class: "beam back", x1: 88, y1: 96, y2: 69, x2: 420 });
  const meet = (x) => {
    beam.setAttribute("x2", x.toFixed(1));
    back.setAttribute("x2", x.toFixed(1));
  };
  const picture = draw("svg", { class: "sensor-picture", viewBox: "0 0 440 150", role: "img" },
    ...makeScale(find("range")), draw("rect", { class: "head", x: 8, y: 34, width: 80, height: 80, rx: 4 }), beam, back,
    makeSurface(find, 2, () => {}), makeSurface(find, 1, meet));
  const [laser, reading, error] = ["laser", "distance1", "error1"].map(find);
  const update = () => {
    picture.classList.toggle("off", laser.value !== 1);
    picture.setAttribute("aria-label", isDistance(reading.value) ? `Distance ${(reading.value / MILLIMETRE).toFixed(3)} mm` : `No distance: ${error.value}`);
  };
  watchAll([laser, reading, error], update);
  return picture;
}

/** Distance in mm, or the reason of its absence. */
function makeReading(find, number) {
  const [reading, error] = [find(`distance${number}`), find(`error${number}`)];
  const value = make("output", { "aria-label": `Distance ${number}` });
  const update = () => {
    setText(value, isDistance(reading.value) ? `${(reading.value / MILLIMETRE).toFixed(3)} mm` : String(error.value));
    value.classList.toggle("bad", !isDistance(reading.value));
  };
  watchAll([reading, error], update);
  return make("div", { class: "figure distance" }, make("span", { class: "label" }, `Distance ${number}`), value);
}

/** Moves the target over the picture's scale. */
function makeTarget(context, find) {
  const [set, range] = [find("surface1.distance"), find("range")];
  const send = sender(context, set);
  const slider = make("input", { type: "range", class: "target", step: 0.01, "aria-label": "Target of surface 1, mm", disabled: context.view });
  slider.addEventListener("input", () => send(Number(slider.value)));
  watchAll([set, range], () => {
    slider.min = String(-MARGIN * range.value);
    slider.max = String((1 + MARGIN) * range.value);
    slider.value = String(set.value);
  });
  return slider;
}

export const isSensor = (signals, slave) => ["distance1", "surface1.distance", "laser", "range"].every((name) => signals.find(slave, name));

export function makeSensor(context, slave) {
  const find = (name) => context.signals.find(slave, name);
  return make("div", { class: "sensor" }, make("div", { class: "sensor-scale" }, makePicture(find), makeTarget(context, find)),
    make("div", { class: "figures" }, makeReading(find, 1), makeReading(find, 2), ...makeFigures(find, [["intensity1", "Intensity"], ["rate", "Rate"], ["counter", "Record"]])),
    make("div", { class: "tools" }, makeToggle(context, find("laser"), "Laser", "toggle"), makeToggle(context, find("surface1.present"), "Target 1", "toggle"),
      makeToggle(context, find("surface2.present"), "Target 2", "toggle"), makeField(context, find("surface1.noise"), "Noise, mm")));
}
