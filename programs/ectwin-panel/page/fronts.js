// SPDX-License-Identifier: MIT
// The fronts of a twin, by the signals that it has.
import { axesOf, makeDrive } from "./drive.js";
import { isCamera, makeCamera } from "./camera.js";
import { isBaseUnit, makeBaseUnit, makeRemotes } from "./remote.js";
import { isSensor, makeSensor } from "./sensor.js";
import { entriesOf, makeTerminal } from "./terminal.js";

/** @return title and `make` of each front of a twin */
export function frontsOf(context, slave) {
  const { signals } = context;
  const fronts = axesOf(signals, slave).map((axis) => ({ title: `Drive ${axis.replace(".", "")}`.trim(), make: () => makeDrive(signals, slave, axis) }));
  if (isBaseUnit(signals, slave)) {
    fronts.push({ title: "Base unit", make: () => makeBaseUnit(context, slave), wide: true }, { title: "Remote units", make: () => makeRemotes(context, slave), wide: true });
  }
  if (isCamera(signals, slave)) fronts.push({ title: "Vision sensor", make: () => makeCamera(context, slave), wide: true });
  if (isSensor(signals, slave)) fronts.push({ title: "Distance sensor", make: () => makeSensor(context, slave) });
  if (entriesOf(signals, slave).length > 0) fronts.push({ title: "Process data", make: () => makeTerminal(context, slave) });
  return fronts;
}
