// SPDX-License-Identifier: MIT
// Requests that a part of the page repeats while it is seen.
import { atEnd } from "./bus.js";

/** All lines of a list that is read in pieces. @param follow  the request after a line @return NULL: refused */
export async function readAll(context, first, follow) {
  const lines = [];
  let request = first;
  while (request) {
    const reply = await context.request(request);
    if (!reply.ok) return null;
    if (!reply.lines) break;
    lines.push(...reply.lines);
    request = follow(reply.lines.at(-1));
  }
  return lines;
}

/** Calls `task` again and again, `pause` ms after its end, while the page is visible and `wanted`. Ends with the watches that are being collected. */
export function repeat(task, pause, wanted = () => true) {
  let ended = false;
  const step = async () => {
    if (ended) return;
    if (!document.hidden && wanted()) await task();
    if (!ended) setTimeout(step, pause);
  };
  atEnd(() => { ended = true; });
  step();
}
