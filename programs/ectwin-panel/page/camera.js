// SPDX-License-Identifier: MIT
// The front of an FZM1 vision sensor: the picture with its judgements, results, scenes, and the timing chart.
import { draw, make, setText, short } from "./dom.js";
import { atEnd, watch, watchAll } from "./bus.js";
import { makeAction, makeChoices, makeField, makeFigures } from "./front.js";
import { Plot } from "./plot.js";

const UNITS = 8;
const RESULTS = 8;
const CHART_SECONDS = 2;
const CHART = ["exe", "flg", "step", "ready", "busy", "gate"];

/** A region of the picture for each processing unit, in the colour of its judgement. */
function makeRegions(find) {
  const units = find("units");
  const regions = Array.from({ length: UNITS }, (_, i) => {
    const [x, y] = [14 + 76 * (i % 4), 40 + 86 * Math.floor(i / 4)];
    const label = draw("text", { x: x + 6, y: y + 16 });
    label.textContent = `U${i}`;
    const region = draw("g", { class: "region" }, draw("rect", { x, y, width: 64, height: 70, rx: 3 }),
      draw("path", { d: `M${x + 14} ${y + 52}L${x + 32} ${y + 24}L${x + 50} ${y + 52}Z` }), label);
    const judgement = find(`judgement${i}`);
    watch(judgement, () => {
      region.classList.toggle("ok", judgement.value === 1);
      region.classList.toggle("bad", judgement.value === -1);
    });
    return region;
  });
  watch(units, () => regions.forEach((region, i) => { region.style.display = i < units.value ? "" : "none"; }));
  return regions;
}

function makePicture(find) {
  const verdict = draw("text", { class: "verdict", x: 306, y: 26, "text-anchor": "end" });
  const caption = draw("text", { x: 14, y: 24 });
  const picture = draw("svg", { class: "camera-picture", viewBox: "0 0 320 220", role: "img" },
    draw("rect", { class: "frame", x: 0, y: 0, width: 320, height: 220, rx: 4 }), ...makeRegions(find), caption, verdict);
  watch(find("units"), (units) => picture.setAttribute("viewBox", `0 0 320 ${units.value > UNITS / 2 ? 220 : 130}`));
  const [scene, group, overall, count] = ["scene", "scene_group", "overall", "measurements"].map(find);
  const show = () => {
    const word = { 1: "OK", "-1": "NG" }[overall.value] ?? "–";
    setText(caption, `Scene ${scene.value}, group ${group.value}`);
    setText(verdict, word);
    verdict.classList.toggle("ok", overall.value === 1);
    verdict.classList.toggle("bad", overall.value === -1);
    picture.setAttribute("aria-label", `Picture with scene ${scene.value}, measurement ${count.value}: ${word}`);
  };
  watchAll([scene, group, overall, count], show);
  return picture;
}

function makeResults(find) {
  const rows = Array.from({ length: RESULTS }, (_, i) => {
    const [result, output, comment] = [`result${i + 1}`, `output${i + 1}`, `comment${i + 1}`].map(find);
    const cells = [make("th", { scope: "row" }, `Data ${i + 1}`), make("td", {}), make("td", {}), make("td", {})];
    watch(result, () => setText(cells[1], short(result.value)));
    watch(output, () => setText(cells[2], short(output.value)));
    watch(comment, () => setText(cells[3], String(comment.value)));
    return make("tr", {}, ...cells);
  });
  return make("table", { class: "results" }, make("thead", {}, make("tr", {}, make("td", {}), ...["Result", "Output", "Comment"].map((text) => make("th", { scope: "col" }, text)))),
    make("tbody", {}, ...rows));
}

/** The causes of the counters above 0. */
function makeTroubles(find) {
  const list = make("ul", { class: "troubles", "aria-label": "Errors" });
  const kinds = [["err", "error_cause", "ERR"], ["steps_ignored", "step_ignored_cause", "STEP ignored"], ["exes_ignored", "exe_ignored_cause", "EXE ignored"],
    ["commands_refused", "command_refused_cause", "Command refused"], ["saves_failed", "save_failed_cause", "Save failed"]].map((names) => [find(names[0]), find(names[1]), names[2]]);
  const show = () => list.replaceChildren(...kinds.filter(([counter]) => counter.value > 0)
    .map(([counter, cause, text]) => make("li", {}, `${text}${counter.value > 1 ? ` ${counter.value} times` : ""}: ${cause.value || "set manually"}`)));
  watchAll(kinds.flatMap(([counter, cause]) => [counter, cause]), show);
  return list;
}

export const isCamera = (signals, slave) => CHART.every((name) => signals.find(slave, name)) && Boolean(signals.find(slave, "overall"));

export function makeCamera(context, slave) {
  const find = (name) => context.signals.find(slave, name);
  const chart = new Plot(context.tracer, CHART_SECONDS);
  chart.choose(CHART.map(find));
  atEnd(() => chart.choose([]));
  return make("div", { class: "camera" },
    make("div", { class: "camera-left" }, makePicture(find),
      make("div", { class: "tools" }, makeAction(context, find("trigger"), "Trigger"), makeChoices(context, find("judgement"), "Judgement", [[1, "OK"], [0, "each unit"], [-1, "NG"]])),
      make("div", { class: "tools" }, makeField(context, find("scene"), "Scene"), makeField(context, find("scene_group"), "Group")),
      makeTroubles(find)),
    make("div", { class: "camera-right" }, chart.element, make("div", { class: "figures" },
      ...makeFigures(find, [["measurements", "Measured"], ["images", "Images"], ["pending", "Pending"], ["outputs", "Outputs"], ["lost", "Lost"]])), makeResults(find)));
}
