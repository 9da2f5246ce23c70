// SPDX-License-Identifier: MIT
// Recordings of the plotted signals, in the format of `ectwin watch --csv` and `ectwin set --csv` (docs/COMMAND.md).
import { make, setText } from "./dom.js";
import { atEnd } from "./bus.js";

const MOST = 200000; // changes of a recording

/** The name of a signal in a recording: with that of its twin, or with its number where there are several. */
export function nameIn(signals, signal) {
  if (signal.twin) return `${signal.twin}.${signal.name}`;
  return signals.slaves().length > 1 ? `${signal.slave}:${signal.name}` : signal.name;
}

/** A table of changes: a line for each time, an empty cell where a signal keeps its value. */
export function writeTable(names, changes) {
  const first = changes[0]?.time ?? 0;
  const lines = [["time", ...names].join(",")];
  for (const { time, column, value } of changes) {
    const cells = names.map((_, i) => (i === column ? String(value) : ""));
    lines.push([((time - first) / 1000).toFixed(6), ...cells].join(","));
  }
  return lines.join("\n") + "\n";
}

/** @return {names, rows} of a table, rows with time in ms and pairs of column and text; NULL: it is none */
export function readTable(text) {
  const lines = text.split(/\r?\n/).filter((line) => line !== "" && !line.startsWith("#"));
  const [head, ...names] = (lines.shift() ?? "").split(",").map((cell) => cell.trim());
  if (head !== "time" || names.length === 0) return null;
  const rows = lines.map((line) => {
    const [time, ...cells] = line.split(",").map((cell) => cell.trim());
    return { time: Number(time) * 1000, values: cells.map((cell, column) => [column, cell]).filter(([, cell]) => cell !== "") };
  });
  return rows.every((row) => Number.isFinite(row.time) && row.values.every(([column]) => column < names.length)) ? { names, rows } : null;
}

/** Records the signals that are plotted when it starts. */
class Recording {
  constructor(context, signals) {
    this.names = signals.map((signal) => nameIn(context.signals, signal));
    this.changes = [];
    const start = performance.now();
    signals.forEach((signal, column) => { if (signal.value !== null) this.changes.push({ time: start, column, value: signal.value }); });
    this.ends = signals.map((signal, column) => context.tracer.add(signal, (time, value) => {
      const last = this.changes.at(-1)?.time ?? start;
      if (time >= start && this.changes.length < MOST) this.changes.push({ time: Math.max(time, last), column, value });
    }));
  }

  end() {
    this.ends.forEach((end) => end());
  }
}

/** The settable signals of a table, by column, and the names of the others. */
function columnsOf(context, names) {
  const byName = new Map(context.signals.all.map((signal) => [nameIn(context.signals, signal), signal]));
  const columns = names.map((name) => byName.get(name) ?? null).map((signal) => (signal?.access === "rw" ? signal : null));
  return { columns, others: names.filter((_, i) => !columns[i]) };
}

/** Plays the rows of a table. @return a function that ends it */
function play(context, columns, rows, show) {
  const start = performance.now();
  let timer = 0;
  let next = 0;
  const step = () => {
    while (next < rows.length && performance.now() - start >= rows[next].time) {
      for (const [column, value] of rows[next].values) if (columns[column]) context.set(columns[column], value);
      next++;
    }
    show(next);
    if (next < rows.length) timer = setTimeout(step, Math.max(0, rows[next].time - (performance.now() - start)));
  };
  step();
  return () => clearTimeout(timer);
}

/** Buttons that record, download and play. */
export function makeRecorder(context, plot) {
  const state = { recording: null, url: null, stop: null };
  const line = make("p", { class: "label", role: "status" }, "Records every change of the plotted signals.");
  const record = make("button", { type: "button", class: "record", "aria-pressed": "false" }, "Record");
  const download = make("a", { class: "download", download: "recording.csv", hidden: true }, "Download CSV");
  const file = make("input", { type: "file", accept: ".csv,text/csv", "aria-label": "Recording to play" });
  const stop = make("button", { type: "button", hidden: true }, "Stop");

  function endRecording() {
    const { recording } = state;
    recording.end();
    state.recording = null;
    record.setAttribute("aria-pressed", "false");
    setText(record, "Record");
    setText(line, `${recording.changes.length} values of ${recording.names.join(", ")}`);
    if (state.url) URL.revokeObjectURL(state.url);
    state.url = URL.createObjectURL(new Blob([writeTable(recording.names, recording.changes)], { type: "text/csv" }));
    download.href = state.url;
    download.hidden = false;
  }
  record.addEventListener("click", () => {
    if (state.recording) {
      endRecording();
      return;
    }
    const signals = [...plot.traces.keys()];
    if (signals.length === 0) {
      setText(line, "Choose signals with the button at the end of their row first.");
      return;
    }
    state.recording = new Recording(context, signals);
    record.setAttribute("aria-pressed", "true");
    setText(record, "Stop recording");
    setText(line, "Recording …");
  });
  const endPlay = () => {
    state.stop?.();
    state.stop = null;
    stop.hidden = true;
  };
  stop.addEventListener("click", endPlay);
  file.addEventListener("change", async () => {
    const table = file.files[0] ? readTable(await file.files[0].text()) : null;
    file.value = "";
    endPlay();
    if (!table) {
      setText(line, "This is no recording: its first line is 'time' and the names of signals.");
      return;
    }
    const { columns, others } = columnsOf(context, table.names);
    const rest = others.length > 0 ? `; not set: ${others.join(", ")}` : "";
    stop.hidden = false;
    state.stop = play(context, columns, table.rows, (count) => {
      setText(line, `${count} of ${table.rows.length} lines played${rest}`);
      stop.hidden = count === table.rows.length;
    });
  });
  atEnd(() => {
    endPlay();
    state.recording?.end();
  });
  return make("div", { class: "recorder" }, make("div", { class: "tools" }, record, download,
    ...(context.view ? [] : [make("label", { class: "field" }, make("span", { class: "label" }, "Play"), file), stop])), line);
}
