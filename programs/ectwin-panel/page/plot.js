// SPDX-License-Identifier: MIT
// A strip chart: a lane for each chosen signal, the newest values at the right edge.
import { make, setText, short } from "./dom.js";

const LANES = 8;
const SAMPLES = 4096;

class Trace {
  constructor(signal, seconds) {
    this.signal = signal;
    this.seconds = seconds;
    this.times = [];
    this.values = [];
    this.watcher = (changed, now) => this.add(now, Number(changed.value));
    signal.watchers.push(this.watcher);
    this.add(performance.now(), Number(signal.value));
  }

  end() {
    this.signal.watchers = this.signal.watchers.filter((watcher) => watcher !== this.watcher);
  }

  add(time, value) {
    if (!Number.isFinite(value)) return;
    this.times.push(time);
    this.values.push(value);
    const old = time - (this.seconds + 1) * 1000;
    let drop = 0;
    while (drop + 1 < this.times.length && (this.times[drop + 1] < old || this.times.length - drop > SAMPLES)) drop++;
    if (drop > 0) {
      this.times.splice(0, drop);
      this.values.splice(0, drop);
    }
  }

  limits() {
    const { low, high } = this.signal.range;
    if (high - low <= 10) return [low, high];
    let [least, most] = [Math.min(...this.values), Math.max(...this.values)];
    if (least === most) [least, most] = [least - 1, most + 1];
    return [least, most];
  }
}

export class Plot {
  /** @param seconds  span of the chart */
  constructor(seconds = 20) {
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
      this.traces.set(signal, new Trace(signal, this.seconds));
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
      const row = make("div", { class: `lane lane-${lane}` }, make("span", { class: "name" }, `${trace.signal.twin ?? trace.signal.slave}: ${trace.signal.name}`), reading,
        make("span", { class: "unit" }, trace.signal.range.unit));
      return { row, reading, trace };
    });
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
      this.paintTrace(pen, trace, now, width, row.offsetTop, row.offsetHeight, style.getPropertyValue(`--trace-${lane}`), style.getPropertyValue("--grid"));
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
    trace.times.forEach((time, i) => {
      const at = Math.max(x(time), -1);
      if (i > 0) pen.lineTo(at, y(trace.values[i - 1]));
      if (i > 0) pen.lineTo(at, y(trace.values[i]));
      else pen.moveTo(at, y(trace.values[i]));
    });
    if (trace.values.length > 0) pen.lineTo(width, y(trace.values[trace.values.length - 1]));
    pen.stroke();
    pen.lineWidth = 1;
  }
}
