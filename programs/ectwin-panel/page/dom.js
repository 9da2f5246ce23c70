// SPDX-License-Identifier: MIT
// Elements without markup from texts: names come from ESI files, and are set as text alone.

/** An element. Properties: `class`, `on` (events by name), attributes; `null` and `false` are left out. */
export function make(tag, properties = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name === "on") {
      for (const [event, listener] of Object.entries(value)) element.addEventListener(event, listener);
    } else if (value !== null && value !== false && value !== undefined) {
      element.setAttribute(name === "class" ? "class" : name, value === true ? "" : String(value));
    }
  }
  element.append(...children.filter((child) => child !== null));
  return element;
}

/** An element of a picture (SVG). */
export function draw(tag, attributes = {}, ...children) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, String(value));
  element.append(...children);
  return element;
}

/** Sets the text if it has changed, which keeps the layout. */
export function setText(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

/** The devices of a bus, descriptions without their folders. */
export function withoutFolders(devices) {
  return devices.replace(/\b(esi|sii|eni):[^,#]*\//g, "$1:");
}

const units = [[1e9, "G"], [1e6, "M"], [1e3, "k"]];

/** A number of at most seven digits. */
export function short(value) {
  if (typeof value !== "number") return String(value);
  if (Number.isInteger(value) && Math.abs(value) < 1e7) return String(value);
  for (const [scale, unit] of units) {
    if (Math.abs(value) >= 10 * scale) return (value / scale).toPrecision(4) + " " + unit;
  }
  return String(Number(value.toPrecision(6)));
}
