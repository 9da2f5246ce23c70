// SPDX-License-Identifier: MIT
// The list of events: AL states with their codes, and emergencies, the newest first.
import { make } from "./dom.js";

const MOST = 200;

function makeEvent(event) {
  const bad = event.event === "emergency" ? event.code !== 0 : event.code !== 0 || event.state === 0;
  const twin = event.twin ? `${event.slave} ${event.twin}` : String(event.slave);
  const text = event.event === "emergency" ? `${event.text}, register 0x${event.register.toString(16).padStart(2, "0")}, data ${event.data}` : event.text;
  return make("li", { class: bad ? "event bad" : "event", "data-event": event.number }, make("span", { class: "time" }, `${event.time.toFixed(3)} s`),
    make("span", { class: "twin" }, twin), make("span", { class: "text" }, text));
}

/** @return the element, and `add` for events in the order of their numbers */
export function makeEvents() {
  const none = make("p", { class: "label" }, "Changes of AL states and emergencies appear here.");
  const list = make("ol", { class: "events", tabindex: "0", "aria-label": "Events, the newest first" });
  return {
    element: make("div", {}, none, list),
    add(events) {
      none.hidden = true;
      list.prepend(...events.map(makeEvent).reverse());
      while (list.children.length > MOST) list.lastChild.remove();
    },
  };
}
