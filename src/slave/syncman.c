/* SPDX-License-Identifier: MIT */
/* SyncManagers from the slave's side: the configuration by the master compared with the description, and deactivation.
 */
#include "slave/internal.h"

/* Bits of the control register that must be as described: mode, direction, event to the PDI. The master's own
 * interrupt bit and the watchdog trigger are its choice. */
enum { CONTROL_COMPARED = ECT_SM_CONTROL_MODE | ECT_SM_CONTROL_DIRECTION | ECT_SM_CONTROL_AL_EVENT };

uint16_t ect_sm_room(const ect_device_t *device, unsigned int sm)
{
    return device->sm[sm].maximum != 0 ? device->sm[sm].maximum : ect_device_sm_bytes(device, sm);
}

bool ect_sm_read(ect_slave_t *s, uint8_t block[ECT_SM_BLOCK])
{
    unsigned int count = s->config.device->sm_count;
    uint16_t size = (uint16_t)((count > 0 ? count : 1) * ECT_SM_SIZE); /* without any, read one */
    ECT_ASSERT(size <= ECT_SM_BLOCK);
    if (!ect_slave_read(s, ECT_REG_SM, block, size))
        return false;
    s->due &= ~(uint32_t)ECT_EVENT_SM_CHANGED;
    return true;
}

/* --- comparison with the description ---------------------------------------------------------------------------- */

static bool is_as_described(const uint8_t *registers, const ect_sm_t *sm, uint16_t start, uint16_t shortest,
                            uint16_t longest)
{
    uint16_t length = ect_load_le16(registers + ECT_SM_LENGTH);
    return (registers[ECT_SM_ACTIVATE] & ECT_SM_ACTIVATE_ENABLE) != 0 &&
           ect_load_le16(registers + ECT_SM_START) == start && length >= shortest && length <= longest &&
           ((registers[ECT_SM_CONTROL] ^ sm->control) & CONTROL_COMPARED) == 0;
}

bool ect_sm_mailbox_good(const ect_device_t *device, const uint8_t *block, bool boot)
{
    ECT_ASSERT(device->sm_count >= 2);
    for (unsigned int n = 0; n < 2; n++) {
        const ect_sm_t *sm = &device->sm[n];
        const ect_boot_mailbox_t *mailbox = n == 0 ? &device->boot_out : &device->boot_in;
        uint16_t start = boot ? mailbox->start : sm->start;
        uint16_t shortest = boot ? mailbox->length : ect_sm_shortest_mailbox(sm);
        uint16_t longest = boot ? mailbox->length : ect_sm_longest_mailbox(device, n);
        if (!is_as_described(block + n * ECT_SM_SIZE, sm, start, shortest, longest))
            return false;
    }
    return true;
}

/* Process data: exactly the mapped bytes, or disabled when nothing is mapped. */
static bool process_good(const ect_slave_t *s, const uint8_t *registers, unsigned int n)
{
    const ect_sm_t *sm = &s->config.device->sm[n];
    uint16_t bytes = s->image[n].bytes;
    ECT_ASSERT(ect_device_sm_is_process(s->config.device, n));
    if (bytes == 0)
        return (registers[ECT_SM_ACTIVATE] & ECT_SM_ACTIVATE_ENABLE) == 0 ||
               ect_load_le16(registers + ECT_SM_LENGTH) == 0;
    return is_as_described(registers, sm, sm->start, bytes, bytes);
}

uint16_t ect_sm_check_process(const ect_slave_t *s, const uint8_t *block)
{
    const ect_device_t *device = s->config.device;
    for (unsigned int n = 0; n < device->sm_count; n++) {
        if (ect_device_sm_is_process(device, n) && !process_good(s, block + (size_t)n * ECT_SM_SIZE, n))
            return device->sm[n].type == ECT_SM_OUTPUTS ? ECT_AL_OUTPUT_SM : ECT_AL_INPUT_SM;
    }
    return ECT_AL_NO_ERROR;
}

unsigned int ect_sm_process(const ect_device_t *device)
{
    unsigned int sms = 0;
    for (unsigned int n = 0; n < device->sm_count; n++)
        sms |= (unsigned int)ect_device_sm_is_process(device, n) << n;
    return sms;
}

/* --- on and off ------------------------------------------------------------------------------------------------- */

void ect_sm_disable(ect_slave_t *s, unsigned int sms)
{
    ECT_ASSERT(sms >> s->config.device->sm_count == 0);
    s->sm_off = (uint8_t)(s->sm_off | sms);
    s->sm_due = (uint8_t)(s->sm_due | sms);
}

void ect_sm_enable(ect_slave_t *s, unsigned int sms)
{
    ECT_ASSERT(sms >> s->config.device->sm_count == 0);
    s->sm_off = (uint8_t)(s->sm_off & ~sms);
    s->sm_due = (uint8_t)(s->sm_due | sms);
}

void ect_sm_acknowledge_repeat(ect_slave_t *s, bool toggle)
{
    s->sm_repeat_ack = toggle;
    s->sm_due |= 1u << 1;
}

bool ect_sm_flush(ect_slave_t *s)
{
    ECT_ASSERT(s->sm_due >> s->config.device->sm_count == 0);
    for (unsigned int n = 0; s->sm_due != 0; n++) {
        if ((s->sm_due & (1u << n)) == 0)
            continue;
        bool off = (s->sm_off & (1u << n)) != 0;
        bool acknowledged = n == 1 && s->sm_repeat_ack;
        uint8_t value = (uint8_t)((off ? ECT_SM_PDI_DISABLE : 0) | (acknowledged ? ECT_SM_PDI_REPEAT_ACK : 0));
        if (!ect_slave_write(s, (uint16_t)(ECT_REG_SM + n * ECT_SM_SIZE + ECT_SM_PDI_CONTROL), &value, 1))
            return false;
        s->sm_due &= (uint8_t)~(1u << n);
    }
    return true;
}
