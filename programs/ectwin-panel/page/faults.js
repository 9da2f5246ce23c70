// SPDX-License-Identifier: MIT
// A form for faults that shows the line it stands for (docs/FAULTS.md), and the faults that are set.
import { make } from "./dom.js";

// Words of a fault: `place` is a slave or a wire; `when` a condition; `field` a value with its default.
const kinds = [
  { word: "drop", label: "lose frames", when: true, place: "wire" },
  { word: "delay", label: "delay replies", when: true, place: "wire", field: ["3000", "us"] },
  { word: "duplicate", label: "replies twice", when: true },
  { word: "reorder", label: "swap replies", when: true },
  { word: "corrupt", label: "invert a bit", when: true, place: "wire" },
  { word: "truncate", label: "cut requests", when: true, field: ["20", ""] },
  { word: "counter", label: "wrong working counter", when: true, field: ["-1", ""] },
  { word: "hang", label: "microcontroller stops", place: "slave" },
  { word: "resume", label: "microcontroller continues", place: "slave" },
  { word: "reset", label: "slave restarts", place: "slave" },
  { word: "identity", label: "another product", place: "slave" },
  { word: "to", label: "slave leaves its state", place: "slave", field: ["SAFEOP", ""] },
  { word: "al refuse", label: "refuse states", place: "slave", field: ["0x001D", ""] },
  { word: "al never", label: "states never come", place: "slave" },
  { word: "emergency", label: "CoE emergency", place: "slave", field: ["0x5530", ""] },
  { word: "abort", label: "SDO transfers end", place: "slave", field: ["0x1018 0x06040043", ""] },
  { word: "mail late", label: "late mails", place: "slave", field: ["50ms", ""] },
  { word: "mail lost", label: "lost mails", place: "slave" },
  { word: "eeprom busy", label: "EEPROM busy", place: "slave" },
  { word: "eeprom ok", label: "EEPROM as before", place: "slave" },
  { word: "clock", label: "clock jumps", place: "slave", field: ["5000ns", ""] },
  { word: "pdi-error", label: "PDI error", place: "slave" },
];

/** The line that the choices of the form stand for. */
export function composeLine({ kind, value, place, when, amount }) {
  const words = [kind.word];
  if (kind.field && value !== "") words.push(value + kind.field[1]);
  if (kind.when && when === "%") words.push(`${amount}%`);
  else if (kind.when && when !== "") words.push(when, String(amount));
  if (kind.place === "slave") words.push("slave", place || "1");
  else if (kind.place === "wire" && place) words.push("wire", place);
  return words.join(" ");
}

function labelled(text, control) {
  return make("label", {}, make("span", {}, text), control);
}

function makeForm(context, slaves) {
  const kind = make("select", { name: "kind" }, ...kinds.map((one, i) => make("option", { value: i }, `${one.word}: ${one.label}`)));
  const value = make("input", { name: "value", autocomplete: "off" });
  const when = make("select", { name: "when" }, ...[["%", "per cent"], ["every", "every nth"], ["frame", "frame number"], ["", "all"]]
    .map(([word, label]) => make("option", { value: word }, label)));
  const amount = make("input", { name: "amount", type: "number", min: 0, value: 5 });
  const place = make("select", { name: "place" });
  const line = make("input", { name: "line", class: "line", autocomplete: "off", spellcheck: "false", "aria-label": "Fault line" });
  const fields = { value: labelled("Value", value), when: labelled("Frames", when), amount: labelled("Amount", amount), place: labelled("Place", place) };
  const compose = () => {
    line.value = composeLine({ kind: kinds[kind.value], value: value.value.trim(), place: place.value, when: when.value, amount: amount.value });
    fields.amount.hidden = fields.when.hidden || when.value === "";
  };
  const chooseKind = () => {
    const one = kinds[kind.value];
    fields.value.hidden = !one.field;
    value.value = one.field?.[0] ?? "";
    fields.when.hidden = !one.when;
    fields.place.hidden = !one.place;
    place.replaceChildren(...(one.place === "wire" ? [make("option", { value: "" }, "at the master")] : []),
      ...slaves.map((slave) => make("option", { value: slave.number }, `${one.place === "wire" ? "wire of " : ""}${slave.number} ${slave.name}`)));
    compose();
  };
  kind.addEventListener("change", chooseKind);
  for (const control of [value, when, amount, place]) control.addEventListener("input", compose);
  chooseKind();
  const form = make("form", { class: "fault-form" }, labelled("Fault", kind), ...Object.values(fields),
    make("div", { class: "line-row" }, line, make("button", { type: "submit", class: "primary" }, "Set")));
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    context.fault(line.value.trim());
  });
  return form;
}

/** @return an element with `show(faults)` */
export function makeFaults(context) {
  const list = make("ul", { class: "fault-list", "aria-label": "Faults that are set" });
  const clear = make("button", { type: "button", on: { click: () => context.fault("off") } }, "Clear all");
  const part = make("div", { class: "faults" }, ...(context.view ? [] : [makeForm(context, context.signals.slaves())]), list, ...(context.view ? [] : [clear]));
  part.show = (faults) => {
    list.replaceChildren(...faults.map((text) => make("li", {}, make("code", {}, text))));
    if (faults.length === 0) list.append(make("li", { class: "none" }, "No fault is set."));
    clear.disabled = faults.length === 0;
  };
  part.show([]);
  return part;
}
