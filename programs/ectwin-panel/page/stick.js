// SPDX-License-Identifier: MIT
// A joystick of two axes: by mouse or finger, by arrow keys, by a gamepad. It returns to its centre when it is released,
// and when the connection to the page ends.
import { make, setText } from "./dom.js";
import { watchAll } from "./bus.js";
import { sender } from "./signals.js";

const FULL = 1000;
const BY_KEY = 500; // with Shift: FULL
const DEAD = 0.08; // of a gamepad's axis
const directions = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

function limited(value) {
  return Math.max(-FULL, Math.min(FULL, Math.round(value)));
}

/**
 * @param axes  signals to the right and up
 * @return the element; its `move(x, y)` deflects the stick
 */
export function makeStick(context, axes, label) {
  const senders = axes.map((axis) => sender(context, axis, 0));
  const thumb = make("span", { class: "thumb" });
  const pad = make("div", { class: "stick", role: "slider", tabindex: context.view ? null : "0", "aria-roledescription": "joystick", "aria-label": label,
    "aria-valuemin": -FULL, "aria-valuemax": FULL, "aria-readonly": String(context.view), "data-stick": axes[0].name }, make("span", { class: "cross" }), thumb);
  const reading = make("output", { class: "reading" });
  const sent = [0, 0];
  let held = false;

  function show([x, y]) {
    thumb.style.left = `${50 + 40 * x / FULL}%`;
    thumb.style.top = `${50 - 40 * y / FULL}%`;
    pad.setAttribute("aria-valuenow", String(x));
    pad.setAttribute("aria-valuetext", `${x} to the right, ${y} up`);
    setText(reading, `${x}, ${y}`);
  }
  function move(...to) {
    to.map(limited).forEach((value, i) => {
      if (value !== sent[i]) senders[i](value);
      sent[i] = value;
    });
    if (held) show(sent);
  }
  function release() {
    if (held) move(0, 0);
    held = false;
  }
  watchAll(axes, () => {
    if (held) return;
    axes.forEach((axis, i) => { sent[i] = axis.value; });
    show(sent);
  });
  if (!context.view) {
    listenToPointer(pad, (x, y) => { held = true; move(x, y); }, release);
    listenToKeys(pad, (x, y) => { held = true; move(x, y); }, release);
  }
  const element = make("div", { class: "stick-frame" }, pad, make("span", { class: "label" }, label), reading);
  element.move = move;
  return element;
}

function listenToPointer(pad, move, release) {
  let pointer = null;
  const follow = (event) => {
    const { left, top, width, height } = pad.getBoundingClientRect();
    move((event.clientX - left - width / 2) / (0.4 * width) * FULL, -(event.clientY - top - height / 2) / (0.4 * height) * FULL);
  };
  pad.addEventListener("pointerdown", (event) => {
    pointer = event.pointerId;
    pad.setPointerCapture(pointer);
    follow(event);
  });
  pad.addEventListener("pointermove", (event) => { if (event.pointerId === pointer) follow(event); });
  for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
    pad.addEventListener(end, () => {
      pointer = null;
      release();
    });
  }
}

function listenToKeys(pad, move, release) {
  const pressed = new Set();
  const follow = (reach) => {
    const sum = [...pressed].map((key) => directions[key]).reduce(([x, y], [dx, dy]) => [x + dx, y + dy], [0, 0]);
    if (pressed.size > 0) move(sum[0] * reach, sum[1] * reach);
    else release();
  };
  pad.addEventListener("keydown", (event) => {
    if (!directions[event.key]) return;
    event.preventDefault();
    pressed.add(event.key);
    follow(event.shiftKey ? FULL : BY_KEY);
  });
  pad.addEventListener("keyup", (event) => {
    if (pressed.delete(event.key)) follow(event.shiftKey ? FULL : BY_KEY);
  });
  pad.addEventListener("blur", () => {
    pressed.clear();
    release();
  });
}

/** A button that lets the first gamepad move two sticks: its left one the first, its right one the second. */
export function makeGamepadButton(sticks) {
  const button = make("button", { type: "button", class: "gamepad", "aria-pressed": "false" }, "Gamepad");
  let last = "";
  let running = false;
  const axis = (value) => (Math.abs(value ?? 0) < DEAD ? 0 : value * FULL);
  const follow = () => {
    if (!button.isConnected || !running) return;
    const pad = [...navigator.getGamepads()].find((one) => one?.connected);
    const values = pad ? [0, 1, 2, 3].map((i) => axis(pad.axes[i])) : [0, 0, 0, 0];
    if (values.join() !== last) { // an idle gamepad leaves the sticks to mouse and keys
      last = values.join();
      sticks.forEach((stick, i) => stick.move(values[2 * i], -values[2 * i + 1]));
    }
    setText(button, pad ? "Gamepad" : "Gamepad: press a button of it");
    requestAnimationFrame(follow);
  };
  button.addEventListener("click", () => {
    running = !running;
    button.setAttribute("aria-pressed", String(running));
    last = "0,0,0,0";
    if (running) follow();
    else sticks.forEach((stick) => stick.move(0, 0));
  });
  return button;
}
