#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Builds tank.fmu from tank_fmu.c, for this machine, with the C compiler ($CC, default cc).

    tank_fmu.py [--fmi 2|3] FILE.fmu
"""
import os
import platform
import subprocess
import sys
import tempfile
import zipfile

SOURCE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "tank_fmu.c")
TOKEN = "{6f3b1c7e-2d0a-4c55-9b6e-7a1d3f9e0c21}"

FMI2 = f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="tank" guid="{TOKEN}">
  <CoSimulation modelIdentifier="tank" canHandleVariableCommunicationStepSize="true"/>
  <DefaultExperiment stepSize="0.001"/>
  <ModelVariables>
    <ScalarVariable name="valves" valueReference="0" causality="input" variability="discrete"><Integer start="0" min="0" max="3"/></ScalarVariable>
    <ScalarVariable name="level" valueReference="1" causality="output"><Real unit="mm"/></ScalarVariable>
    <ScalarVariable name="fill" valueReference="2" causality="parameter" variability="fixed"><Real start="100"/></ScalarVariable>
    <ScalarVariable name="drain" valueReference="3" causality="parameter" variability="tunable"><Real start="2"/></ScalarVariable>
    <ScalarVariable name="height" valueReference="4" causality="parameter" variability="fixed"><Real start="1000"/></ScalarVariable>
  </ModelVariables>
  <ModelStructure><Outputs><Unknown index="2"/></Outputs></ModelStructure>
</fmiModelDescription>
"""

FMI3 = f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="tank" instantiationToken="{TOKEN}">
  <CoSimulation modelIdentifier="tank" canHandleVariableCommunicationStepSize="true"/>
  <DefaultExperiment stepSize="0.001"/>
  <ModelVariables>
    <UInt8 name="valves" valueReference="0" causality="input" start="0" max="3"/>
    <Float64 name="level" valueReference="1" causality="output" unit="mm"/>
    <Float64 name="fill" valueReference="2" causality="parameter" variability="fixed" start="100"/>
    <Float64 name="drain" valueReference="3" causality="parameter" variability="tunable" start="2"/>
    <Float64 name="height" valueReference="4" causality="parameter" variability="fixed" start="1000"/>
  </ModelVariables>
  <ModelStructure><Output valueReference="1"/></ModelStructure>
</fmiModelDescription>
"""


def build(file, fmi=2):
    """Compiles the model and packs it into a file."""
    folder = "linux64" if fmi == 2 else f"{platform.machine()}-linux"
    with tempfile.TemporaryDirectory() as work:
        library = os.path.join(work, "tank.so")
        flags = ["-std=c11", "-O2", "-Wall", "-Wextra", "-fPIC", "-shared", "-fvisibility=hidden", f"-DFMI={fmi}"]
        subprocess.run([os.environ.get("CC", "cc"), *flags, SOURCE, "-o", library, "-lm"], check=True)
        with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr("modelDescription.xml", FMI2 if fmi == 2 else FMI3)
            archive.write(library, f"binaries/{folder}/tank.so")


if __name__ == "__main__":
    words = sys.argv[1:]
    version = 2
    if words[:1] == ["--fmi"]:
        version, words = int(words[1]), words[2:]
    if len(words) != 1 or version not in (2, 3):
        sys.exit(__doc__)
    build(words[0], version)
