/* SPDX-License-Identifier: MIT */
#include "master.h"

#include <string.h>

#include "esc/route.h"
#include "wire/bytes.h"
#include "wire/registers.h"

enum { DATAGRAM = 16, PATIENCE = 2000 };

void master_build(master_t *m, uint8_t command, uint16_t adp, uint16_t ado, uint16_t length)
{
    uint8_t *d = m->frame + DATAGRAM;
    memset(m->frame, 0, sizeof m->frame);
    memset(m->frame, 0xFF, 6);
    m->frame[6] = 0x01;
    ect_store_be16(m->frame + 12, 0x88A4);
    ect_store_le16(m->frame + 14, (uint16_t)(0x1000 | (length + 12)));
    d[ECT_DATAGRAM_COMMAND] = command;
    ect_store_le16(d + ECT_DATAGRAM_ADP, adp);
    ect_store_le16(d + ECT_DATAGRAM_ADO, ado);
    ect_store_le16(d + ECT_DATAGRAM_LENGTH, length);
    m->length = (size_t)DATAGRAM + ECT_DATAGRAM_DATA + length + ECT_DATAGRAM_COUNTER;
    m->length = m->length < 60 ? 60 : m->length;
}

uint8_t *master_data(master_t *m)
{
    return m->frame + DATAGRAM + ECT_DATAGRAM_DATA;
}

unsigned int master_counter(const master_t *m)
{
    const uint8_t *d = m->frame + DATAGRAM;
    return ect_load_le16(d + ECT_DATAGRAM_DATA + ect_datagram_length(d));
}

int master_send(master_t *m, uint8_t command, uint16_t adp, uint16_t ado, void *data, uint16_t length)
{
    master_build(m, command, adp, ado, length);
    memcpy(master_data(m), data, length);
    if (!m->exchange(m))
        return -1;
    memcpy(data, master_data(m), length);
    return (int)master_counter(m);
}

static bool write_to(master_t *m, size_t position, uint16_t ado, const void *data, uint16_t length)
{
    uint8_t copy[MASTER_FRAME];
    memcpy(copy, data, length);
    return master_send(m, ECT_FPWR, (uint16_t)(MASTER_STATION + position), ado, copy, length) == 1;
}

static bool read_from(master_t *m, size_t position, uint16_t ado, void *data, uint16_t length)
{
    return master_send(m, ECT_FPRD, (uint16_t)(MASTER_STATION + position), ado, data, length) == 1;
}

bool master_address(master_t *m, size_t count)
{
    bool good = true;
    for (size_t i = 0; i < count && good; i++) {
        uint8_t station[2];
        ect_store_le16(station, (uint16_t)(MASTER_STATION + i));
        good = master_send(m, ECT_APWR, (uint16_t)(0 - i), ECT_REG_STATION_ADDRESS, station, 2) == 1;
    }
    return good;
}

/* Devices run after the reply has left: the next frame may precede them. */
static bool go(master_t *m, size_t position, uint8_t state)
{
    uint8_t request[2] = {(uint8_t)(state | ECT_AL_ACKNOWLEDGE), 0};
    uint8_t status[2] = {0};
    bool good = write_to(m, position, ECT_REG_AL_CONTROL, request, sizeof request);
    for (unsigned int i = 0; good && status[0] != state && i < PATIENCE; i++)
        good = read_from(m, position, ECT_REG_AL_STATUS, status, sizeof status);
    return status[0] == state;
}

static bool set_sms(master_t *m, const ect_device_t *device, size_t position, bool process)
{
    bool good = true;
    for (unsigned int n = 0; n < device->sm_count; n++) {
        uint8_t sm[ECT_SM_SIZE] = {0};
        uint16_t bytes = ect_device_sm_bytes(device, n);
        if (bytes == 0 || ect_device_sm_is_process(device, n) != process)
            continue;
        ect_store_le16(sm + ECT_SM_START, device->sm[n].start);
        ect_store_le16(sm + ECT_SM_LENGTH, bytes);
        sm[ECT_SM_CONTROL] = device->sm[n].control;
        sm[ECT_SM_ACTIVATE] = ECT_SM_ACTIVATE_ENABLE;
        good = good && write_to(m, position, (uint16_t)(ECT_REG_SM + ECT_SM_SIZE * n), sm, sizeof sm);
    }
    return good;
}

static bool set_fmmus(master_t *m, const ect_device_t *device, size_t position, uint32_t *logical,
                      unsigned int *expected)
{
    unsigned int used = 0;
    bool good = true;
    for (unsigned int n = 0; n < device->sm_count; n++) {
        uint8_t fmmu[ECT_FMMU_SIZE] = {0};
        uint16_t bytes = ect_device_sm_bytes(device, n);
        bool outputs = device->sm[n].type == ECT_SM_OUTPUTS;
        if (bytes == 0 || !ect_device_sm_is_process(device, n))
            continue;
        ect_store_le32(fmmu + ECT_FMMU_LOGICAL, *logical);
        ect_store_le16(fmmu + ECT_FMMU_LENGTH, bytes);
        fmmu[ECT_FMMU_STOP_BIT] = 7;
        ect_store_le16(fmmu + ECT_FMMU_PHYSICAL, device->sm[n].start);
        fmmu[ECT_FMMU_TYPE] = outputs ? ECT_PART_WRITE : ECT_PART_READ;
        fmmu[ECT_FMMU_ACTIVATE] = 1;
        good = good && write_to(m, position, (uint16_t)(ECT_REG_FMMU + ECT_FMMU_SIZE * used++), fmmu, sizeof fmmu);
        *logical += bytes;
        *expected += outputs ? 2 : 1;
    }
    return good;
}

static bool send_outputs(master_t *m, const ect_device_t *device, size_t position)
{
    const uint8_t zeros[MASTER_FRAME] = {0};
    bool good = true;
    for (unsigned int n = 0; n < device->sm_count; n++) {
        uint16_t bytes = ect_device_sm_bytes(device, n);
        if (device->sm[n].type == ECT_SM_OUTPUTS && bytes > 0)
            good = good && write_to(m, position, device->sm[n].start, zeros, bytes);
    }
    return good;
}

bool master_operate(master_t *m, const ect_device_t *device, size_t position, uint32_t *logical, unsigned int *expected)
{
    const uint8_t off[2] = {0};
    return go(m, position, ECT_STATE_INIT) && set_sms(m, device, position, false) && go(m, position, ECT_STATE_PREOP) &&
           set_sms(m, device, position, true) && set_fmmus(m, device, position, logical, expected) &&
           go(m, position, ECT_STATE_SAFEOP) && write_to(m, position, ECT_REG_WD_TIME_PD, off, sizeof off) &&
           send_outputs(m, device, position) && go(m, position, ECT_STATE_OP);
}

bool master_sdo(master_t *m, const ect_device_t *device, size_t position)
{
    static uint8_t counter;
    uint8_t mail[MASTER_FRAME] = {10, 0, 0, 0, 0, 0, 0, 0x20, 0x40, 0x18, 0x10, 1};
    uint8_t status = 0;
    counter = (uint8_t)(counter % 7 + 1);
    mail[5] = (uint8_t)(3 | counter << 4);
    bool good = write_to(m, position, device->sm[0].start, mail, device->sm[0].length);
    for (unsigned int i = 0; good && (status & ECT_SM_STATUS_FULL) == 0 && i < PATIENCE; i++)
        good = read_from(m, position, ECT_REG_SM + ECT_SM_SIZE + ECT_SM_STATUS, &status, 1);
    return good && read_from(m, position, device->sm[1].start, mail, device->sm[1].length) && mail[8] == 0x43;
}
