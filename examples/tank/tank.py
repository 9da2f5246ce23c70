#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The water of a tank: flows through two valves change the level, which the sensor measures.

    tank.py [--wait] [TWINS]        with running twins of tank.yaml (name or socket; default: tank), until they end

--wait stops their virtual clock during each step, so that runs are repeatable.
"""
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "python"))
import ectwin  # noqa: E402

PERIOD = 0.001  # s
HEIGHT = 1000.0  # mm
INLET, OUTLET = 1, 2  # bits of the valves
FILL, DRAIN = 100.0, 2.0  # mm/s with an open inlet; mm/s for each root of a mm of water with an open outlet


class Tank:
    """A tank with vertical walls; water flows out by Torricelli's law."""

    def __init__(self, level=0.0):
        self.level = level

    def step(self, now, values):
        valves = values["valves.outputs.valves"]
        flow_in = FILL if valves & INLET else 0.0
        flow_out = DRAIN * self.level**0.5 if valves & OUTLET else 0.0
        self.level = min(max(self.level + (flow_in - flow_out) * PERIOD, 0.0), HEIGHT)
        return {"sensor.inputs.level": round(self.level)}

    def plant(self):
        return ectwin.Plant(self.step, reads=["valves.outputs.valves"], writes=["sensor.inputs.level"], period=PERIOD, name="tank")


if __name__ == "__main__":
    words = [word for word in sys.argv[1:] if word != "--wait"]
    try:
        Tank().plant().run(words[0] if words else "tank", wait="--wait" in sys.argv)
    except ectwin.Error as error:
        sys.exit(f"tank.py: {error}")
    except KeyboardInterrupt:
        pass
