// SPDX-License-Identifier: MIT
// A strip chart: a lane for each chosen signal, the newest values at the right edge.
import { make, setText, short } from "./dom.js";

const LANES = 20;
const COLOURS = 8;
const BUCKETS = 1500; // of a lane: about one a pixel
const MARGIN = 7; // pixels above and below a line

/** Rounds limits outwards to a quarter of their distance as 1, 2 or 5 times a power of ten: they change seldom. */
export function roundLimits(least, most) {
  if (!(least < most)) return [least - 1, least + 1];
  const power = 10 ** Math.floor(Math.log10((most - least) / 4));
  const step = power * ([1, 2, 5].find((one) => one * power * 4 >= most - least) ?? 10);
  return [Math.floor(least / step) * step, Math.ceil(most / step) * step];
}

/** The changes of a signal. A bucket of time has its first, least, greatest and last value, so no pulse is lost. */
export class Trace {
  constructor(signal, seconds, tracer) {
    this.signal = signal;
    this.seconds = seconds;
    this.buckets = [];
    this.traced = false;
    [this.least, this.most] = [Infinity, -Infinity];
    this.fresh = -Infinity; // the chart does not show this trace from this time on
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
    this.least = Math.min(this.least, value);
    this.most = Math.max(this.most, value);
    if (last && time < last.time + span) {
      last.low = Math.min(last.low, value);
      last.high = Math.max(last.high, value);
      last.last = value;
      this.fresh = Math.min(this.fresh, last.time);
      return;
    }
    this.fresh = Math.min(this.fresh, time);
    this.buckets.push({ time, first: value, low: value, high: value, last: value });
    const old = time - (this.seconds + 1) * 1000;
    if (this.buckets.length > 1.1 * BUCKETS || this.buckets[0].time < old - 2000) this.forget(old);
  }

  /** Ends the buckets before a time, except for the last one of them. */
  forget(old) {
    let drop = 0;
    while (drop + 1 < this.buckets.length && this.buckets[drop + 1].time < old) drop++;
    this.buckets.splice(0, drop);
    this.least = Math.min(...this.buckets.map((bucket) => bucket.low));
    this.most = Math.max(...this.buckets.map((bucket) => bucket.high));
  }

  limits() {
    const { low, high } = this.signal.range;
    if (high - low <= 10) return [low, high];
    return this.least <= this.most ? roundLimits(this.least, this.most) : [-1, 1];
  }

  /** The index of the last bucket that begins before a time, or 0. */
  before(time) {
    let at = this.buckets.length - 1;
    while (at > 0 && this.buckets[at].time >= time) at--;
    return Math.max(at, 0);
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
    this.version = 0; // of the choice of signals
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
    this.version++;
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
    for (const { reading, trace } of this.labels) setText(reading, short(trace.signal.value));
    this.paint(now);
    requestAnimationFrame(this.draw);
  }

  /** Fits the canvas to the page. @return whether its picture has to be painted completely */
  fit() {
    const scale = window.devicePixelRatio || 1;
    const [width, height] = [Math.round(this.canvas.clientWidth * scale), Math.round(this.names.offsetHeight * scale)];
    const style = getComputedStyle(this.canvas);
    const colours = ["--grid", ...Array.from({ length: COLOURS }, (_, i) => `--trace-${i}`)].map((name) => style.getPropertyValue(name));
    const lanes = this.labels.map(({ row }) => [row.offsetTop * scale, row.offsetHeight * scale]);
    const key = [width, height, scale, ...colours, ...lanes, this.version].join();
    if (key === this.key) return false;
    Object.assign(this, { key, width, height, scale, colours, lanes });
    this.canvas.style.height = `${this.names.offsetHeight}px`;
    [this.canvas.width, this.canvas.height] = [width, height];
    return true;
  }

  /** Moves the picture to the left, and paints what has been added at the right: the work does not grow with the number of changes. */
  paint(now) {
    const refitted = this.fit();
    if (this.width === 0) return;
    const rate = this.width / (this.seconds * 1000); // pixels of the canvas a millisecond
    const at = Math.floor(now * rate);
    const moved = at - this.at;
    const whole = refitted || moved < 0 || moved >= this.width;
    const pen = this.canvas.getContext("2d");
    if (!whole && moved > 0) {
      pen.globalCompositeOperation = "copy"; // clears the rest
      pen.drawImage(this.canvas, -moved, 0);
      pen.globalCompositeOperation = "source-over";
    }
    this.at = at;
    const x = (time) => this.width - at + time * rate;
    this.labels.forEach((label, lane) => {
      const limits = label.trace.limits();
      const scaled = limits.join() !== label.limits;
      label.limits = limits.join();
      const from = whole || scaled ? 0 : Math.min(this.width - moved, Math.floor(x(label.trace.fresh)) - 2);
      label.trace.fresh = Infinity;
      if (from < this.width) this.paintLane(pen, label.trace, lane, limits, Math.max(0, from), x, rate);
    });
  }

  /** Paints a lane from the column `from` to the right edge. */
  paintLane(pen, trace, lane, limits, from, x, rate) {
    const [top, height] = this.lanes[lane];
    pen.save();
    pen.beginPath();
    pen.rect(from, top, this.width - from, height);
    pen.clip();
    pen.clearRect(from, top, this.width - from, height);
    this.paintGrid(pen, top, height, from, rate);
    this.paintTrace(pen, trace, lane, limits, from, x, rate);
    pen.restore();
  }

  paintGrid(pen, top, height, from, rate) {
    pen.fillStyle = this.colours[0];
    const step = this.seconds * 100;
    const left = this.width - this.at;
    for (let line = Math.ceil((from - 1 - left) / rate / step); ; line++) {
      const column = Math.floor(line * step * rate) + left;
      if (column >= this.width) break;
      pen.fillRect(column, top, 1, height);
    }
    pen.fillRect(from, top + height - 1, this.width - from, 1);
  }

  paintTrace(pen, trace, lane, [least, most], from, x, rate) {
    if (trace.buckets.length === 0) return;
    const [top, height] = this.lanes[lane];
    const margin = MARGIN * this.scale;
    const y = (value) => top + height - margin - (value - least) / (most - least) * (height - 2 * margin);
    const { buckets } = trace;
    const first = trace.before((from - 2 - this.width + this.at) / rate);
    pen.strokeStyle = this.colours[1 + lane % COLOURS];
    pen.lineWidth = 1.5 * this.scale;
    pen.beginPath();
    pen.moveTo(Math.max(x(buckets[first].time), from - 4), y(buckets[first].first));
    for (let i = first; i < buckets.length; i++) {
      const bucket = buckets[i];
      const column = Math.max(x(bucket.time), from - 4);
      if (i > first) pen.lineTo(column, y(buckets[i - 1].last));
      if (i > first && bucket.first !== buckets[i - 1].last) pen.lineTo(column, y(bucket.first));
      if (bucket.low < Math.min(bucket.first, bucket.last)) pen.lineTo(column, y(bucket.low));
      if (bucket.high > Math.max(bucket.first, bucket.last)) pen.lineTo(column, y(bucket.high));
      if (bucket.last !== bucket.first) pen.lineTo(column, y(bucket.last));
    }
    pen.lineTo(this.width + 2, y(buckets.at(-1).last));
    pen.stroke();
  }
}
