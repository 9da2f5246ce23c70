// SPDX-License-Identifier: MIT
// The newest frames of the bus as a pcapng file: the twins keep them in memory while a capture runs.
import { make, setText } from "./dom.js";
import { atEnd } from "./bus.js";

const PARALLEL = 4; // requests of a download under way; the others of the page pass in between

/** Bytes of the hexadecimal digits of a line. */
function bytesOf(digits) {
  return Uint8Array.from({ length: digits.length / 2 }, (_, i) => Number.parseInt(digits.slice(2 * i, 2 * i + 2), 16));
}

/** Reads the whole capture. @param show  called with the share that is read @return the bytes, or the reason of a refusal */
async function download(context, show) {
  const first = await context.request({ op: "capture", offset: 0 });
  if (!first.ok) return first.message;
  const { size, serial } = first.lines[0];
  const piece = first.lines.reduce((sum, line) => sum + line.data.length / 2, 0);
  const bytes = new Uint8Array(size);
  let next = 0;
  let wrong = null;
  const take = (reply) => {
    const lines = reply.lines ?? [];
    if (!reply.ok || lines.length === 0 || lines[0].serial !== serial) wrong = reply.message ?? "another capture was begun";
    else for (const line of lines) bytes.set(bytesOf(line.data), line.offset);
  };
  const work = async () => {
    while (next < size && !wrong) {
      const offset = next;
      next += piece;
      take(await context.request({ op: "capture", offset }));
      show(Math.min(1, next / size));
    }
  };
  await Promise.all(Array.from({ length: PARALLEL }, work));
  return wrong ?? bytes;
}

/** A button that begins and ends a capture, and a link to its file. */
export function makeCapture(context) {
  const line = make("p", { class: "label", role: "status" }, "The newest frames, at most 4 MiB, as a file for Wireshark.");
  const button = make("button", { type: "button", class: "capture record", "aria-pressed": "false" }, "Capture frames");
  const link = make("a", { class: "download", download: "capture.pcapng", hidden: true }, "Download pcapng");
  let runs = false;
  let url = null;
  const setRuns = (now) => {
    runs = now;
    button.setAttribute("aria-pressed", String(now));
    setText(button, now ? "Stop the capture" : "Capture frames");
  };
  const begin = async () => {
    const reply = await context.request({ op: "capture", on: true, time: Date.now() / 1000 });
    setRuns(reply.ok);
    setText(line, reply.ok ? "Capturing …" : reply.message);
  };
  const end = async () => {
    setRuns(false);
    await context.request({ op: "capture", on: false });
    const bytes = await download(context, (part) => setText(line, `Reading, ${Math.round(100 * part)} %`));
    if (typeof bytes === "string") {
      setText(line, bytes);
      return;
    }
    if (url) URL.revokeObjectURL(url);
    url = URL.createObjectURL(new Blob([bytes], { type: "application/x-pcapng" }));
    link.href = url;
    link.hidden = false;
    setText(line, `${(bytes.length / 1000).toFixed(0)} kB`);
  };
  button.addEventListener("click", async () => {
    button.disabled = true;
    await (runs ? end() : begin());
    button.disabled = false;
  });
  atEnd(() => {
    if (runs) context.request({ op: "capture", on: false });
    if (url) URL.revokeObjectURL(url);
  });
  return make("div", { class: "recorder" }, make("div", { class: "tools" }, button, link), line);
}
