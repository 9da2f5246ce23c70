// SPDX-License-Identifier: MIT
// Waves: the twin sets a signal to a function of the time, until the wave is ended.
import { make, setText } from "./dom.js";
import { repeat } from "./poll.js";

const PAUSE = 1500;

function labelled(text, control) {
  return make("label", {}, make("span", {}, text), control);
}

function makeForm(context, report) {
  const signal = make("select", { name: "signal" });
  const shape = make("select", { name: "shape" }, ...["sine", "ramp", "square"].map((word) => make("option", { value: word }, word)));
  const [low, high, period] = [["low", "0"], ["high", "1"], ["period", "2"]].map(([name, value]) => make("input", { name, type: "number", step: "any", value, required: true }));
  const start = make("button", { type: "submit", class: "primary" }, "Start");
  const form = make("form", { class: "wave-form" }, labelled("Signal", signal), labelled("Shape", shape), labelled("Low", low), labelled("High", high),
    labelled("Period, s", period), start);
  let signals = [];
  const chooseRange = () => {
    const range = signals[signal.value]?.range;
    if (range) [low.value, high.value] = [Math.max(range.low, -1000), Math.min(range.high, 1000)];
  };
  signal.addEventListener("change", chooseRange);
  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    const one = signals[signal.value];
    const reply = await context.request({ op: "wave", slave: one.slave, name: one.name, shape: shape.value, low: Number(low.value), high: Number(high.value), period: Number(period.value) });
    report(reply);
  });
  form.choose = (slave) => {
    signals = context.signals.all.filter((one) => one.slave === slave && one.access === "rw" && one.range);
    signal.replaceChildren(...signals.map((one, i) => make("option", { value: i }, one.name)));
    start.disabled = signals.length === 0;
    chooseRange();
  };
  return form;
}

/** @return an element with `choose(slave)`, the twin whose signals the form lists */
export function makeWaves(context) {
  const status = make("p", { class: "label", role: "status" });
  const list = make("ul", { class: "wave-list", "aria-label": "Waves that run" });
  let shown = "";
  const update = async () => {
    const reply = await context.request({ op: "waves" });
    const waves = reply.ok ? reply.lines ?? [] : [];
    if (JSON.stringify(waves) === shown) return;
    shown = JSON.stringify(waves);
    list.replaceChildren(...waves.map((wave) => {
      const name = `${wave.twin ?? wave.slave}: ${wave.name}`;
      const text = `${name}: ${wave.shape} from ${wave.low} to ${wave.high}, ${wave.period} s`;
      const stop = make("button", { type: "button", "aria-label": `Stop the wave of ${name}`, on: { click: () => end({ slave: wave.slave, name: wave.name }) } }, "Stop");
      return make("li", { "data-wave": wave.name }, text, ...(context.view ? [] : [" ", stop]));
    }));
    setText(status, waves.length > 0 ? "" : "No wave runs.");
  };
  const report = async (reply) => {
    await update();
    if (!reply.ok) setText(status, reply.message);
  };
  const end = async (wave) => report(await context.request({ op: "wave", shape: "off", ...wave }));
  const form = makeForm(context, report);
  repeat(update, PAUSE);
  const part = make("div", { class: "waves" }, ...(context.view ? [] : [form]), list, status);
  part.choose = form.choose;
  return part;
}
