import struct, sys, time, pysoem
master = pysoem.Master(); master.open(sys.argv[1]); master.config_init()
sensor = master.slaves[0]
sensor.sdo_write(0x2001, 2, b"000")                   # log in: settings require the user level expert
sensor.sdo_write(0x21B0, 5, b"\x01")                  # the value counter too, in front of the distances
master.config_map(); master.state_check(pysoem.SAFEOP_STATE, 500000)
master.state = pysoem.OP_STATE; master.write_state()
while True:
    master.send_processdata(); master.receive_processdata(2000); time.sleep(0.01)
    counter, distance = struct.unpack("<Ii", sensor.input[:8])
    print(counter, "no distance: %08X" % distance if distance >= 0x7FFFFFF5 else "%.6f mm" % (distance / 1e6))
