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
    this.waiting.clear();
    this.queue = [];
    this.failures++;
    const gone = this.failures > 3;
    this.handlers.state(gone ? "the panel has ended: start 'ectwin panel' again and open its new URL" : "no connection", false);
    this.handlers.lost();
    setTimeout(() => this.connect(), gone ? 5000 : 500);
  }

  /** A request of the control protocol. @return a promise of the reply; eight are under way at a time */
  request(bus, request) {
    return new Promise((resolve) => {
      this.queue.push({ bus, request, resolve });
      this.next();
    });
  }

  next() {
    while (this.queue.length > 0 && this.waiting.size < 8) {
      const { bus, request, resolve } = this.queue.shift();
      const id = ++this.number;
      this.waiting.set(id, resolve);
      this.send({ id, bus, request });
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
