// SPDX-License-Identifier: MIT
// The page: the list of buses, and the bus that is shown.
import { make, setText, short, withoutFolders } from "./dom.js";
import { collect, Connection, Signals, Tracer } from "./bus.js";
import { makeRail } from "./rail.js";
import { makeSignals } from "./signals.js";
import { makeEvents } from "./events.js";
import { makeFaults } from "./faults.js";
import { makeObjects } from "./objects.js";
import { makePdos } from "./pdos.js";
import { makeCounters } from "./counters.js";
import { makeCapture } from "./capture.js";
import { makeWaves } from "./waves.js";
import { readAll } from "./poll.js";
import { makeRecorder } from "./record.js";
import { Plot } from "./plot.js";
import { frontsOf } from "./fronts.js";

const stateNames = { 0: "off", 1: "INIT", 2: "PREOP", 3: "BOOT", 4: "SAFEOP", 8: "OP" };
const view = { buses: [], shown: 0, slave: 0, readOnly: false, signals: new Signals(), parts: null, last: null };
const main = document.getElementById("main");
const list = document.getElementById("buses");
const messages = document.getElementById("messages");

function report(text) {
  const message = make("p", {}, text);
  messages.append(message);
  while (messages.children.length > 3) messages.firstChild.remove();
  setTimeout(() => message.remove(), 8000);
}

const context = {
  get signals() { return view.signals; },
  get view() { return view.readOnly; },
  tracer: new Tracer((message) => connection.send(message)),
  async set(signal, value, rest) {
    const reply = await connection.request(view.shown, { op: "set", slave: signal.slave, name: signal.name, value }, rest);
    if (!reply.ok) report(`${signal.name}: ${reply.message}`);
    if (!reply.ok) for (const watcher of signal.watchers) watcher(signal, performance.now());
  },
  request: (request) => connection.request(view.shown, request),
  async fault(line) {
    const reply = await connection.request(view.shown, { op: "fault", fault: line });
    if (!reply.ok) report(reply.message);
  },
};

/* --- the list of buses --------------------------------------------------------------------------------------------- */

function nameOf(bus) {
  return bus.about.name || withoutFolders(bus.about.devices ?? "") || `process ${bus.process}`;
}

function stateOf(about) {
  if (about.lowest === undefined) return "";
  const [low, high] = [stateNames[about.lowest] ?? about.lowest, stateNames[about.highest] ?? about.highest];
  return low === high ? low : `${low} to ${high}`;
}

function showBuses(buses) {
  view.buses = buses;
  const focused = document.activeElement?.dataset?.bus;
  list.replaceChildren(...buses.map((bus) => make("button", { type: "button", "data-bus": bus.bus, "aria-pressed": String(bus.bus === view.shown), on: { click: () => open(bus.bus) } },
    make("span", { class: "bus-name" }, nameOf(bus)), make("span", { class: `bus-state ${bus.about.errors > 0 ? "bad" : ""}` }, stateOf(bus.about)))));
  if (focused) list.querySelector(`[data-bus="${Number(focused)}"]`)?.focus();
  const shown = buses.find((bus) => bus.bus === view.shown);
  if (!shown && buses.length > 0) open(buses[0].bus);
  else if (!shown) showNothing();
  else if (view.parts) showAbout(shown.about);
}

function showNothing() {
  view.shown = 0;
  view.parts = null;
  main.replaceChildren(make("section", { class: "empty" }, make("h2", {}, "No twin is running"),
    make("p", {}, "Start one, and it appears here:"), make("pre", {}, "ectwin with fzm1 -- ./my_master {}")));
}

function open(number) {
  view.shown = number;
  view.slave = 0;
  view.parts = null;
  view.signals.clear();
  context.tracer.restart();
  connection.send({ open: number });
  for (const button of list.children) button.setAttribute("aria-pressed", String(Number(button.dataset.bus) === number));
  main.replaceChildren(make("p", { class: "none" }, "Reading the signals …"));
}

/* --- one bus ------------------------------------------------------------------------------------------------------- */

function makeFigure(label) {
  const value = make("output", {}, "–");
  return { element: make("div", { class: "figure" }, make("span", { class: "label" }, label), value), value };
}

function section(title, className, ...children) {
  return make("section", { class: className }, make("h2", {}, title), ...children);
}

function makeHistogram() {
  const bars = make("div", { class: "bars", role: "img", "aria-label": "Replies by response time" });
  const edges = make("div", { class: "edges" });
  let before = null;
  const show = ({ answers: own, kernel_answers: kernel = [], edges_us: limits }) => {
    const answers = own.map((count, i) => count + (kernel[i] ?? 0));
    const last = answers.findLastIndex((count) => count > 0);
    const shown = Math.max(last + 1, 12);
    const most = Math.log1p(Math.max(...answers, 1));
    if (!before || bars.children.length !== shown) {
      bars.replaceChildren(...answers.slice(0, shown).map(() => make("span", { class: "bar" })));
      edges.replaceChildren(...answers.slice(0, shown).map((_, i) => make("span", {}, limits[i] >= 1000 ? `${limits[i] / 1000} ms` : `${limits[i] ?? ""}`)));
    }
    answers.slice(0, shown).forEach((count, i) => {
      bars.children[i].style.height = `${100 * Math.log1p(count) / most}%`;
      bars.children[i].title = `${count} replies below ${limits[i] ?? "…"} µs`;
    });
    before = answers;
  };
  return { element: make("div", { class: "histogram", tabindex: "0", role: "group", "aria-label": "Histogram of response times" }, make("div", { class: "scale" }, bars, edges), make("p", { class: "label" }, "µs, upper edges; heights are logarithmic")), show };
}

function presetsOf(slave) {
  const has = (name) => view.signals.find(slave, name);
  const sets = [["Timing chart", ["step", "exe", "ready", "busy", "flg", "gate", "or", "overall"]], ["Motion", ["position", "demand", "speed", "torque", "following_error"]]];
  return sets.map(([title, names]) => [title, names.map(has).filter((signal) => signal?.range)]).filter(([, found]) => found.length >= 3);
}

/** The twins that the bus arranges (--panel), as numbers. */
function arrangementOf(about, slaves) {
  if (!about.panel) return null;
  return String(about.panel).split(",").map((part) => slaves.find((slave) => slave.name === part)?.number ?? Number(part));
}

/** The fronts of the selected twin, of all, or of those that the bus arranges. */
function showFronts() {
  const { parts } = view;
  const twins = view.signals.slaves().filter((slave) => (parts.all ? !parts.arranged || parts.arranged.includes(slave.number) : slave.number === view.slave));
  if (parts.all && parts.arranged) twins.sort((a, b) => parts.arranged.indexOf(a.number) - parts.arranged.indexOf(b.number));
  parts.endFronts?.();
  parts.endFronts = collect(() => parts.fronts.replaceChildren(...twins.flatMap((twin) => frontsOf(context, twin.number).map((front) => section(
    parts.all ? `${twin.number} ${twin.name} ${front.title}` : front.title, front.wide ? "front-of wide" : "front-of", front.make())))));
  parts.fronts.hidden = parts.fronts.children.length === 0;
  parts.allButton.setAttribute("aria-pressed", String(parts.all));
}

function select(number) {
  const { parts } = view;
  view.slave = number;
  parts.rail.mark(number);
  const twin = view.signals.slaves().find((slave) => slave.number === number);
  setText(parts.twinTitle, `Signals of ${number}${twin?.name ? ` ${twin.name}` : ""}`);
  parts.end?.();
  parts.plot.forgetListeners();
  parts.end = collect(() => parts.signals.replaceChildren(makePdos(context, number), makeSignals(context, number, parts.plot), makeObjects(context, number)));
  parts.waves.choose(number);
  showFronts();
  parts.presets.replaceChildren(...presetsOf(number).map(([title, found]) => make("button", { type: "button", on: { click: () => parts.plot.choose(found) } }, title)));
}

/** @return a promise of the wire at port 0 of each twin, NULL: the twins do not report it */
async function readWires(slaves) {
  const lines = await readAll(context, { op: "wires" }, (last) => (last.slave < slaves.length ? { op: "wires", slave: last.slave + 1 } : null));
  return lines?.length === slaves.length ? lines : null;
}

function showBus() {
  const about = view.buses.find((bus) => bus.bus === view.shown)?.about ?? {};
  const names = withoutFolders(String(about.devices ?? "")).split(",").map((name) => name.replace(/^[^=]*=/, ""));
  const slaves = view.signals.slaves();
  const devices = names.length === slaves.length ? names : [];
  const figures = Object.fromEntries(["Frames/s", "Replied", "Dropped", "Median", "99 %", "Longest", "Scenario"].map((label) => [label, makeFigure(label)]));
  const parts = {
    rail: makeRail(context, devices, select, readWires(slaves), Boolean(about.iface2)), events: makeEvents(), plot: new Plot(context.tracer), faults: makeFaults(context), histogram: makeHistogram(), figures,
    signals: make("div"), presets: make("span", { class: "presets" }), twinTitle: make("h2", {}, "Signals"), about: make("p", { class: "about" }),
  };
  parts.fronts = make("div", { class: "fronts" });
  parts.arranged = arrangementOf(about, slaves);
  parts.all = parts.arranged !== null;
  view.endRecorder?.();
  let recorder = null;
  let [counters, capture, waves] = [null, null, null];
  view.endRecorder = collect(() => {
    recorder = makeRecorder(context, parts.plot);
    counters = makeCounters(context);
    if (!context.view) capture = makeCapture(context);
    waves = makeWaves(context);
  });
  parts.allButton = make("button", { type: "button", "aria-pressed": "false", on: { click: () => { parts.all = !parts.all; showFronts(); } } }, parts.arranged ? "Fronts of the machine" : "Fronts of all twins");
  figures.Scenario.element.hidden = true;
  parts.waves = waves;
  view.parts = parts;
  view.last = null;
  main.replaceChildren(
    make("section", { class: "overview" }, parts.about, make("div", { class: "figures" }, ...Object.values(figures).map((figure) => figure.element))),
    make("section", { class: "wide" }, make("header", {}, make("h2", {}, "Bus"), parts.allButton), make("div", { class: "rail-frame", tabindex: "0", role: "group", "aria-label": "Twins as they are wired" }, parts.rail)),
    parts.fronts,
    make("div", { class: "columns" },
      make("section", { class: "panel-signals" }, make("header", {}, parts.twinTitle), parts.signals),
      make("div", { class: "side" },
        make("section", {}, make("header", {}, make("h2", {}, "Plot"), parts.presets), parts.plot.element, recorder),
        section("Waves", "", waves),
        section("Working counters", "", counters),
        ...(capture ? [section("Capture", "", capture)] : []),
        section("Events", "", parts.events.element),
        section("Faults", "", parts.faults),
        section("Response time", "", parts.histogram.element))));
  parts.plot.changed();
  showAbout(about);
  if (slaves.length > 0) select(slaves[0].number);
}

function showAbout(about) {
  const parts = [about.name, withoutFolders(String(about.devices ?? "")), about.iface && `on ${about.iface}`].filter(Boolean);
  setText(view.parts.about, parts.join(" · "));
}

function microseconds(value) {
  return value >= 1000 ? `${short(value / 1000)} ms` : `${short(value)} µs`;
}

/** Steps of the script that are over, and its expectations. */
function showScenario({ element, value }, counters) {
  element.hidden = counters.steps === undefined;
  const expectations = counters.expected > 0 ? `, ${counters.met} of ${counters.expected} met` : "";
  const failed = counters.failed > 0 ? `, ${counters.failed} failed` : "";
  setText(value, `${counters.steps_over} of ${counters.steps} steps${expectations}${failed}`);
  value.classList.toggle("bad", counters.failed > 0);
}

function showStats({ counters, answers }) {
  if (!view.parts) return;
  const { figures, histogram } = view.parts;
  const span = view.last ? counters.time - view.last.time : 0;
  if (span > 0) setText(figures["Frames/s"].value, short(Math.round((counters.frames - view.last.frames) / span)));
  setText(figures["Replied"].value, short(counters.answered) + (counters.hook ? `, ${short(counters.in_kernel)} in the kernel` : ""));
  setText(figures["Dropped"].value, short(counters.dropped));
  setText(figures["Median"].value, microseconds(counters.p50_us));
  setText(figures["99 %"].value, microseconds(counters.p99_us));
  setText(figures["Longest"].value, microseconds(counters.longest_us));
  showScenario(figures.Scenario, counters);
  view.last = counters;
  histogram.show(answers);
}

/* --- the connection ------------------------------------------------------------------------------------------------ */

const ofShown = (take) => (message) => { if (message.bus === view.shown) take(message); };

const connection = new Connection(location.hash.slice(1), {
  state(text, good) {
    const line = document.getElementById("connection");
    setText(line, text);
    line.classList.toggle("good", good);
  },
  hello: (message) => { view.readOnly = message.view; },
  buses: (message) => showBuses(message.buses),
  signals: ofShown((message) => {
    if (message.from === 0) context.tracer.restart();
    if (view.signals.describe(message)) showBus();
  }),
  values: ofShown((message) => view.signals.change(message)),
  changes: ofShown((message) => context.tracer.take(message)),
  stats: ofShown(showStats),
  events: ofShown((message) => view.parts?.events.add(message.events)),
  faults: ofShown((message) => view.parts?.faults.show(message.faults)),
  trouble: ofShown((message) => main.replaceChildren(make("p", { class: "none" }, message.message))),
  lost() {
    view.shown = 0;
    view.parts = null;
  },
});
