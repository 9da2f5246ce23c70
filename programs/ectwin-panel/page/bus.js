// SPDX-License-Identifier: MIT
// The connection to the panel's server, and the bus that is shown.

/** The range of a signal as the twin describes it. */
export function parseRange(text) {
  const match = /^(-?[0-9.]+)\.\.(-?[0-9.]+)(?: (.*))?$/.exec(text ?? "");
  return match ? { low: Number(match[1]), high: Number(match[2]), unit: match[3] ?? "" } : null;
}

/** Names of the values of a signal: those of its field, "2001h:8: 0 Initial, 1 Stopped". */
export function parseNames(field) {
  const names = /: (-?\d+ .*)$/.exec(field ?? "");
  if (!names) return null;
  const found = names[1].split(", ").map((part) => /^(-?\d+) (.+)$/.exec(part));
  return found.every((part) => part) ? found.map((part) => ({ value: Number(part[1]), name: part[2] })) : null;
}

export class Connection {
  /** @param handlers  functions by event: those of the server, and `state` (text, is good) */
  constructor(token, handlers) {
    this.token = token;
    this.handlers = handlers;
    this.waiting = new Map();
    this.queue = [];
    this.number = 0;
    this.failures = 0;
    this.connect();
  }

  connect() {
    this.handlers.state("connecting", false);
    this.socket = new WebSocket(`ws://${location.host}/`, "ectwin-panel");
    this.socket.addEventListener("open", () => this.send({ token: this.token }));
    this.socket.addEventListener("message", (event) => this.take(JSON.parse(event.data)));
    this.socket.addEventListener("close", () => this.closed());
  }

  send(message) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }

  take(message) {
    if (message.event === "hello") {
      this.failures = 0;
      this.handlers.state(message.view ? "view only" : "connected", true);
    }
    if (message.event === "reply") {
      const done = this.waiting.get(message.id);
      this.waiting.delete(message.id);
      done?.(message.reply);
      this.next();
      return;
    }
    this.handlers[message.event]?.(message);
  }

  closed() {
    for (const done of this.waiting.values()) done({ ok: false, message: "the connection has ended" });
    for (const { resolve } of this.queue) resolve({ ok: false, message: "the connection has ended" });
    this.waiting.clear();
    this.queue = [];
    this.failures++;
    const gone = this.failures > 3;
    this.handlers.state(gone ? "the panel has ended: start 'ectwin panel' again and open its new URL" : "no connection", false);
    this.handlers.lost();
    setTimeout(() => this.connect(), gone ? 5000 : 500);
  }

  /**
   * A request of the control protocol; eight are under way at a time.
   * @param rest  the value to which the server sets the signal when the connection ends; undefined: none
   * @return a promise of the reply
   */
  request(bus, request, rest) {
    if (this.socket.readyState !== WebSocket.OPEN) return Promise.resolve({ ok: false, message: "the connection has ended" });
    return new Promise((resolve) => {
      this.queue.push({ bus, request, rest, resolve });
      this.next();
    });
  }

  next() {
    while (this.queue.length > 0 && this.waiting.size < 8) {
      const { bus, request, rest, resolve } = this.queue.shift();
      const id = ++this.number;
      this.waiting.set(id, resolve);
      this.send({ id, bus, request, rest });
    }
  }
}

/** The signals of the bus that is shown. */
export class Signals {
  constructor() {
    this.clear();
  }

  clear() {
    this.all = [];
    this.complete = false;
    this.byKey = new Map();
    this.listeners = new Set();
  }

  describe(message) {
    if (message.from === 0) this.clear();
    for (const line of message.signals) {
      const signal = { ...line, value: null, index: this.all.length, range: parseRange(line.range), text: line.range ?? "", watchers: [] };
      this.all.push(signal);
      this.byKey.set(`${signal.slave}/${signal.name}`, signal);
    }
    this.complete = this.all.length === message.of;
    return this.complete;
  }

  change(message) {
    const now = performance.now();
    for (const [index, value] of message.values) {
      const signal = this.all[index];
      if (!signal) continue;
      signal.value = value;
      for (const watcher of signal.watchers) watcher(signal, now);
    }
  }

  find(slave, name) {
    return this.byKey.get(`${slave}/${name}`);
  }

  /** Slaves by number, with their names. */
  slaves() {
    const found = new Map();
    for (const signal of this.all) {
      if (!found.has(signal.slave)) found.set(signal.slave, { number: signal.slave, name: signal.twin ?? "" });
    }
    return [...found.values()];
  }
}

/** Every change of the signals that plots show, with the time of the twin. */
export class Tracer {
  /** @param send  sends a message to the server */
  constructor(send) {
    this.send = send;
    this.listeners = new Map();
    this.restart();
  }

  /** The signals are others. */
  restart() {
    this.listeners.clear();
    this.offset = null;
    this.announced = "";
  }

  /** Calls `listener` with the time, in ms of this page, and the value of each change. @return a function that ends it */
  add(signal, listener) {
    const entry = { signal, listener };
    if (!this.listeners.has(signal.index)) this.listeners.set(signal.index, new Set());
    this.listeners.get(signal.index).add(entry);
    this.announce();
    return () => {
      const entries = this.listeners.get(signal.index);
      if (!entries?.delete(entry)) return;
      if (entries.size === 0) this.listeners.delete(signal.index);
      this.announce();
    };
  }

  announce() {
    queueMicrotask(() => {
      const wanted = [...this.listeners.keys()].sort((a, b) => a - b);
      if (wanted.join() === this.announced) return;
      this.announced = wanted.join();
      this.send({ trace: wanted });
    });
  }

  /** The clocks differ by the shortest way of a change so far; a clock that runs at another rate begins again. */
  timeOf(seconds, now) {
    const offset = now - seconds * 1000;
    if (this.offset === null || offset < this.offset || offset > this.offset + 2000) this.offset = offset;
    return seconds * 1000 + this.offset;
  }

  take(message) {
    const now = performance.now();
    const last = message.changes.at(-1);
    if (last) this.timeOf(last[1], now);
    for (const [index, seconds, value] of message.changes) {
      for (const { listener } of this.listeners.get(index) ?? []) listener(seconds * 1000 + this.offset, value);
    }
  }
}

let collected = null;

/** Runs `build`. @return a function that ends the watches that `build` has begun */
export function collect(build) {
  const begun = [];
  collected = begun;
  try {
    build();
  } finally {
    collected = null;
  }
  return () => begun.forEach((end) => end());
}

/** Calls `end` at the end of the watches that are being collected. */
export function atEnd(end) {
  collected?.push(end);
}

/** Calls `watcher` for each value of a signal from now on, and for its present one. Watches that it begins end with it. */
export function watch(signal, watcher) {
  if (!signal) return;
  const scope = collected;
  const call = (...change) => {
    const outer = collected;
    collected = scope;
    try {
      watcher(...change);
    } finally {
      collected = outer;
    }
  };
  signal.watchers.push(call);
  atEnd(() => { signal.watchers = signal.watchers.filter((other) => other !== call); });
  if (signal.value !== null) call(signal, performance.now());
}

/** Calls `update` for each change of one of these signals, once all of them have a value. */
export function watchAll(signals, update) {
  for (const signal of signals) {
    watch(signal, () => { if (signals.every((one) => one.value !== null)) update(); });
  }
}
