/* SPDX-License-Identifier: MIT */
/* The device with a network address: EoE with replies to ARP, ping and UDP echo. */
#include "profiles/ip/echo.h"

#include "firmware.h"

enum { PROTOCOLS = 8 };

/* Returns the same device at each call; called once for the firmware and once for the EEPROM. */
const ect_device_t *firmware_device(void)
{
    static ect_device_t device;
    static ect_eoe_t network;
    static const ect_protocol_t *protocols[PROTOCOLS + 1];
    const size_t aligned = sizeof(max_align_t);
    size_t count = 0;
    device = *firmware_described();
    network = (ect_eoe_t)ECT_IP_ECHO((device.instance_size + aligned - 1) / aligned * aligned);
    for (const ect_protocol_t *const *p = device.protocols; p && *p; p++) {
        if (count == PROTOCOLS - 1)
            firmware_stop();
        protocols[count++] = *p;
    }
    if (!ect_eoe_fits(&device))
        firmware_stop();
    protocols[count] = &network.protocol; /* the last: its frames must not delay the mails of the others */
    device.protocols = protocols;
    device.mailbox_protocols |= ECT_MAILBOX_EOE;
    device.instance_size = network.offset + sizeof(ect_ip_echo_t);
    return &device;
}
