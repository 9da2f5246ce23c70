// SPDX-License-Identifier: MIT
// A strip chart: a lane for each chosen signal, the newest values at the right edge.
import { make, setText, short } from "./dom.js";

const LANES = 20;
const COLOURS = 8;
const BUCKETS = 1500; // of a lane: about one a pixel

/** The changes of a signal. A bucket of time has its first, least, greatest and last value, so no pulse is lost. */
class Trace {
  constructor(signal, seconds, tracer) {
    this.signal = signal;
    this.seconds = seconds;
    this.buckets = [];
    this.traced = false;
    this.watcher = (changed, now) => { if (!this.traced) this.add(now, Number(changed.value)); };
    signal.watchers.push(this.watcher);
    if (signal.value !== null) this.add(performance.now(), Number(signal.value));
    this.endTrace = tracer.add(signal, (time, value) => {
      this.traced = true;
      this.add(time, value);
    });
  }

  end() {
    this.signal.watchers = this.signal.watchers.filter((watcher) => watcher !== this.watcher);
    this.endTrace();
  }

  add(time, value) {
    if (!Number.isFinite(value)) return;
    const span = this.seconds * 1000 / BUCKETS;
    const last = this.buckets.at(-1);
    if (last && time < last.time + span) {
      last.low = Math.min(last.low, value);
      last.high = Math.max(last.high, value);
      last.last = value;
      return;
    }
    this.buckets.push({ time, first: value, low: value, high: value, last: value });
    const old = time - (this.seconds + 1) * 1000;
    let drop = 0;
    while (drop + 1 < this.buckets.length && this.buckets[drop + 1].time < old) drop++;
    if (drop > BUCKETS / 10) this.buckets.splice(0, drop);
  }

  limits() {
    const { low, high } = this.signal.range;
    if (high - low <= 10) return [low, high];
    let [least, most] = [Infinity, -Infinity];
    for (const bucket of this.buckets) {
      least = Math.min(least, bucket.low);
      most = Math.max(most, bucket.high);
    }
    return least < most ? [least, most] : [least - 1, most + 1];
  }
}

export class Plot {
  /** @param seconds  span of the chart */
  constructor(tracer, seconds = 20) {
    this.tracer = tracer;
    this.seconds = seconds;
    this.traces = new Map();
    this.listeners = [];
    this.canvas = make("canvas", { role: "img", "aria-label": "Strip chart of the chosen signals" });
    this.hint = make("p", { class: "none" }, "Choose signals with the button at the end of their row.");
    this.names = make("div", { class: "lanes" });
    this.element = make("div", { class: "plot" }, this.hint, make("div", { class: "chart" }, this.names, this.canvas));
    this.draw = this.draw.bind(this);
    this.running = false;
  }

  onChange(listener) {
    this.listeners.push(listener);
  }

  forgetListeners() {
    this.listeners = [];
  }

  /** @return whether the signal is plotted now */
  toggle(signal) {
    if (this.traces.has(signal)) {
      this.traces.get(signal).end();
      this.traces.delete(signal);
    } else if (this.traces.size < LANES) {
      this.traces.set(signal, new Trace(signal, this.seconds, this.tracer));
    }
    this.changed();
    return this.traces.has(signal);
  }

  /** Chooses these signals in place of the present ones. */
  choose(signals) {
    for (const signal of [...this.traces.keys()]) this.toggle(signal);
    for (const signal of signals) this.toggle(signal);
  }

  changed() {
    this.hint.hidden = this.traces.size > 0;
    this.names.parentElement.hidden = this.traces.size === 0;
    this.labels = [...this.traces.values()].map((trace, lane) => {
      const reading = make("output", { class: "reading" });
      const row = make("div", { class: `lane lane-${lane % COLOURS}` }, make("span", { class: "name" }, `${trace.signal.twin ?? trace.signal.slave}: ${trace.signal.name}`), reading,
        make("span", { class: "unit" }, trace.signal.range.unit));
      return { row, reading, trace };
    });
    this.names.classList.toggle("many", this.traces.size > COLOURS);
    this.names.replaceChildren(...this.labels.map((label) => label.row));
    for (const listener of this.listeners) listener(this.traces);
    if (!this.running && this.traces.size > 0) {
      this.running = true;
      requestAnimationFrame(this.draw);
    }
  }

  draw(now) {
    this.running = this.traces.size > 0 && this.canvas.isConnected;
    if (!this.running) return;
    this.paint(now);
    for (const { reading, trace } of this.labels) setText(reading, short(trace.signal.value));
    requestAnimationFrame(this.draw);
  }

  paint(now) {
    const height = this.names.offsetHeight;
    const width = this.canvas.clientWidth;
    const scale = window.devicePixelRatio || 1;
    if (this.canvas.width !== Math.round(width * scale) || this.canvas.height !== Math.round(height * scale)) {
      this.canvas.width = Math.round(width * scale);
      this.canvas.height = Math.round(height * scale);
      this.canvas.style.height = `${height}px`;
    }
    const style = getComputedStyle(this.canvas);
    const pen = this.canvas.getContext("2d");
    pen.setTransform(scale, 0, 0, scale, 0, 0);
    pen.clearRect(0, 0, width, height);
    pen.strokeStyle = style.getPropertyValue("--grid");
    pen.lineWidth = 1;
    pen.beginPath();
    const step = this.seconds / 10;
    for (let second = 0; second <= this.seconds; second += step) {
      const x = Math.round(width - ((now / 1000) % step + second) * width / this.seconds) + 0.5;
      pen.moveTo(x, 0);
      pen.lineTo(x, height);
    }
    pen.stroke();
    this.labels.forEach(({ row, trace }, lane) => {
      this.paintTrace(pen, trace, now, width, row.offsetTop, row.offsetHeight, style.getPropertyValue(`--trace-${lane % COLOURS}`), style.getPropertyValue("--grid"));
    });
  }

  paintTrace(pen, trace, now, width, top, height, colour, grid) {
    const [least, most] = trace.limits();
    const margin = 7;
    const y = (value) => top + height - margin - (value - least) / (most - least) * (height - 2 * margin);
    const x = (time) => width - (now - time) / 1000 * width / this.seconds;
    pen.strokeStyle = grid;
    pen.beginPath();
    pen.moveTo(0, top + height - 0.5);
    pen.lineTo(width, top + height - 0.5);
    pen.stroke();
    pen.strokeStyle = colour;
    pen.lineWidth = 1.5;
    pen.beginPath();
    let before = null;
    for (const bucket of trace.buckets) {
      const at = Math.max(x(bucket.time), -1);
      if (before === null) pen.moveTo(at, y(bucket.first));
      else pen.lineTo(at, y(before));
      for (const value of new Set([bucket.first, bucket.low, bucket.high, bucket.last])) pen.lineTo(at, y(value));
      before = bucket.last;
    }
    if (before !== null) pen.lineTo(width, y(before));
    pen.stroke();
    pen.lineWidth = 1;
  }
}
