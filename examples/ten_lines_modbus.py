import time
from pymodbus.client import ModbusTcpClient
bu = ModbusTcpClient("127.0.0.1", port=1502); bu.connect()
for pco in range(1, 1000):
    bu.write_register(0, pco % 256)                      # PCO and CCO: the unit detects an active controller
    r = bu.read_input_registers(0, count=33).registers   # all input data
    joystick = r[19] - (r[19] >> 15 << 16)
    print(f"PCI {r[0] % 256}, BU state 0x{r[11] % 256:02X}, armed RU {r[14]}, joystick 1 at {joystick}")
    time.sleep(0.1)
