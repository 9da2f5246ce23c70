/* SPDX-License-Identifier: MIT */
#include "support/wire.h"

#include <string.h>

#include "support/every.h"

enum { ETHERNET = 14, ECAT_HEADER = 2, DATAGRAM_HEADER = 10, WKC = 2, MAIL_HEADER = 6 };

void wire_open_twins(wire_t *w, const ect_twin_config_t *twins, size_t count)
{
    memset(w, 0, sizeof *w);
    w->now_ns = 1000 * MS;
    w->chain = ect_chain_new(twins, count, w->now_ns);
    assert_non_null(w->chain);
    wire_assign_stations(w);
}

void wire_assign_stations(wire_t *w)
{
    for (size_t i = 0; i < ect_chain_count(w->chain); i++) {
        uint8_t address[2];
        ect_store_le16(address, (uint16_t)(WIRE_STATION + i));
        assert_int_equal(wire_send(w, APWR, (uint16_t)(0 - i), ECT_REG_STATION_ADDRESS, address, 2), 1);
    }
}

void wire_open(wire_t *w, const ect_device_t *const *devices, size_t count)
{
    ect_twin_config_t twins[64];
    assert_true(count <= sizeof twins / sizeof twins[0]);
    for (size_t i = 0; i < count; i++)
        twins[i] = ect_twin_default(devices[i], plant_of(devices[i]));
    wire_open_twins(w, twins, count);
}

void wire_open_one(wire_t *w, const ect_device_t *device)
{
    wire_open(w, &device, 1);
}

void wire_close(wire_t *w)
{
    ect_chain_free(w->chain);
}

static void put_datagram(uint8_t *d, uint8_t command, uint16_t adp, uint16_t ado, const void *data, uint16_t length)
{
    memset(d, 0, DATAGRAM_HEADER);
    d[0] = command;
    ect_store_le16(d + 2, adp);
    ect_store_le16(d + 4, ado);
    ect_store_le16(d + 6, length);
    if (length > 0)
        memcpy(d + DATAGRAM_HEADER, data, length);
    ect_store_le16(d + DATAGRAM_HEADER + length, 0);
}

void wire_build(wire_t *w, uint8_t command, uint16_t adp, uint16_t ado, const void *data, uint16_t length)
{
    static const uint8_t header[ETHERNET] = {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x01,
                                             0x01, 0x01, 0x01, 0x01, 0x01, 0x88, 0xA4};
    memcpy(w->frame, header, sizeof header);
    put_datagram(w->frame + ETHERNET + ECAT_HEADER, command, adp, ado, data, length);
    uint16_t size = (uint16_t)(DATAGRAM_HEADER + length + WKC);
    ect_store_le16(w->frame + ETHERNET, (uint16_t)(size | 0x1000));
    w->frame_length = (size_t)ETHERNET + ECAT_HEADER + size;
}

void wire_append(wire_t *w, uint8_t command, uint16_t adp, uint16_t ado, const void *data, uint16_t length)
{
    unsigned int last = 0;
    while ((wire_datagram(w, last)[7] & 0x80) != 0)
        last++;
    wire_datagram(w, last)[7] |= 0x80;
    put_datagram(w->frame + w->frame_length, command, adp, ado, data, length);
    w->frame_length += (size_t)DATAGRAM_HEADER + length + WKC;
    uint16_t size = (uint16_t)(w->frame_length - ETHERNET - ECAT_HEADER);
    ect_store_le16(w->frame + ETHERNET, (uint16_t)(size | 0x1000));
}

bool wire_transmit(wire_t *w)
{
    bool came_back = ect_chain_process(w->chain, w->frame, w->frame_length, w->now_ns);
    if (!w->manual_poll)
        wire_poll(w);
    return came_back;
}

uint8_t *wire_datagram(wire_t *w, unsigned int n)
{
    uint8_t *d = w->frame + ETHERNET + ECAT_HEADER;
    for (; n > 0; n--)
        d += DATAGRAM_HEADER + (ect_load_le16(d + 6) & 0x7FF) + WKC;
    return d;
}

uint16_t wire_wkc(wire_t *w, unsigned int n)
{
    const uint8_t *d = wire_datagram(w, n);
    return ect_load_le16(d + DATAGRAM_HEADER + (ect_load_le16(d + 6) & 0x7FF));
}

int wire_send(wire_t *w, uint8_t command, uint16_t adp, uint16_t ado, void *data, uint16_t length)
{
    wire_build(w, command, adp, ado, data, length);
    if (!wire_transmit(w))
        return NO_REPLY;
    if (length > 0)
        memcpy(data, wire_datagram(w, 0) + DATAGRAM_HEADER, length);
    return wire_wkc(w, 0);
}

int wire_logical(wire_t *w, uint8_t command, uint32_t address, void *data, uint16_t length)
{
    return wire_send(w, command, (uint16_t)address, (uint16_t)(address >> 16), data, length);
}

int wire_read(wire_t *w, size_t position, uint16_t ado, void *data, uint16_t length)
{
    return wire_send(w, FPRD, (uint16_t)(WIRE_STATION + position), ado, data, length);
}

int wire_write(wire_t *w, size_t position, uint16_t ado, const void *data, uint16_t length)
{
    uint8_t copy[1500];
    memcpy(copy, data, length);
    return wire_send(w, FPWR, (uint16_t)(WIRE_STATION + position), ado, copy, length);
}

int wire_write8(wire_t *w, size_t position, uint16_t ado, uint8_t value)
{
    return wire_write(w, position, ado, &value, 1);
}

int wire_write16(wire_t *w, size_t position, uint16_t ado, uint16_t value)
{
    uint8_t bytes[2];
    ect_store_le16(bytes, value);
    return wire_write(w, position, ado, bytes, 2);
}

uint8_t wire_read8(wire_t *w, size_t position, uint16_t ado)
{
    uint8_t value = 0;
    assert_int_equal(wire_read(w, position, ado, &value, 1), 1);
    return value;
}

uint16_t wire_read16(wire_t *w, size_t position, uint16_t ado)
{
    uint8_t bytes[2] = {0};
    assert_int_equal(wire_read(w, position, ado, bytes, 2), 1);
    return ect_load_le16(bytes);
}

void wire_poll(wire_t *w)
{
    if (w->poll)
        w->poll(w);
    else
        (void)ect_chain_poll(w->chain, w->now_ns);
}

void wire_advance(wire_t *w, uint64_t ns)
{
    uint64_t end = w->now_ns + ns;
    for (;;) {
        uint64_t next = ect_chain_poll(w->chain, w->now_ns);
        if (next >= end)
            break;
        w->now_ns = next;
    }
    w->now_ns = end;
    wire_poll(w);
}

const ect_device_t *wire_device(wire_t *w, size_t position)
{
    return ect_chain_slave(w->chain, position)->config.device;
}

void wire_set_sm(wire_t *w, size_t position, unsigned int sm, uint16_t start, uint16_t length, uint8_t control)
{
    uint8_t registers[8] = {0};
    uint16_t address = (uint16_t)(ECT_REG_SM + 8 * sm);
    wire_write(w, position, (uint16_t)(address + ECT_SM_ACTIVATE), registers, 1);
    ect_store_le16(registers, start);
    ect_store_le16(registers + 2, length);
    registers[4] = control;
    registers[6] = length > 0 ? 1 : 0;
    assert_int_equal(wire_write(w, position, address, registers, 8), 1);
}

static void configure(wire_t *w, size_t position, bool process_data)
{
    const ect_device_t *device = wire_device(w, position);
    for (unsigned int n = 0; n < device->sm_count; n++) {
        const ect_sm_t *sm = &device->sm[n];
        if (sm->type == ECT_SM_UNUSED || ect_device_sm_is_process(device, n) != process_data)
            continue;
        wire_set_sm(w, position, n, sm->start, ect_device_sm_bytes(device, n), sm->control);
    }
}

void wire_configure_mailbox(wire_t *w, size_t position)
{
    configure(w, position, false);
}

void wire_configure_process_data(wire_t *w, size_t position)
{
    configure(w, position, true);
}

void wire_set_fmmu(wire_t *w, size_t position, unsigned int n, uint32_t logical, uint16_t length, uint8_t start_bit,
                   uint8_t stop_bit, uint16_t physical, uint8_t physical_bit, uint8_t type)
{
    uint8_t registers[16] = {0};
    ect_store_le32(registers, logical);
    ect_store_le16(registers + 4, length);
    registers[6] = start_bit;
    registers[7] = stop_bit;
    ect_store_le16(registers + 8, physical);
    registers[10] = physical_bit;
    registers[11] = type;
    registers[12] = 1;
    assert_int_equal(wire_write(w, position, (uint16_t)(ECT_REG_FMMU + 16 * n), registers, 16), 1);
}

uint8_t wire_al(wire_t *w, size_t position, uint16_t request, uint16_t *code)
{
    uint8_t status[6] = {0};
    wire_write16(w, position, ECT_REG_AL_CONTROL, request);
    assert_int_equal(wire_read(w, position, ECT_REG_AL_STATUS, status, 6), 1);
    if (code)
        *code = ect_load_le16(status + 4);
    return status[0];
}

static void expect_state(wire_t *w, size_t position, uint8_t state)
{
    uint16_t code = 0;
    uint8_t status = wire_al(w, position, state | ECT_AL_ACKNOWLEDGE, &code);
    if (status != state)
        fail_msg("slave %zu asked for state %u shows AL status 0x%02X, code 0x%04X", position, state, status, code);
}

void wire_go(wire_t *w, size_t position, uint8_t state)
{
    expect_state(w, position, ECT_STATE_INIT);
    if (state == ECT_STATE_INIT)
        return;
    w->mail_counter = 0;
    wire_configure_mailbox(w, position);
    expect_state(w, position, ECT_STATE_PREOP);
    if (state == ECT_STATE_PREOP)
        return;
    wire_configure_process_data(w, position);
    expect_state(w, position, ECT_STATE_SAFEOP);
    if (state == ECT_STATE_SAFEOP)
        return;
    assert_int_equal(wire_outputs(w, position, 0), 1);
    expect_state(w, position, ECT_STATE_OP);
}

int wire_outputs(wire_t *w, size_t position, uint8_t value)
{
    const ect_device_t *device = wire_device(w, position);
    int wkc = 1;
    for (unsigned int n = 0; n < device->sm_count; n++) {
        uint8_t image[1486];
        uint16_t bytes = ect_device_sm_bytes(device, n);
        memset(image, value, sizeof image);
        if (device->sm[n].type == ECT_SM_OUTPUTS && bytes > 0)
            wkc &= wire_write(w, position, device->sm[n].start, image, bytes);
    }
    return wkc;
}

int wire_mail_send(wire_t *w, size_t position, const uint8_t *mail, uint16_t length)
{
    const ect_sm_t *sm = &wire_device(w, position)->sm[0];
    uint8_t whole[1486] = {0};
    assert_true(length <= sm->length);
    memcpy(whole, mail, length);
    return wire_write(w, position, sm->start, whole, sm->length);
}

int wire_mail_receive(wire_t *w, size_t position, uint8_t *mail, uint16_t room)
{
    const ect_sm_t *sm = &wire_device(w, position)->sm[1];
    uint8_t whole[1486];
    if ((wire_read8(w, position, ECT_REG_SM + 8 + ECT_SM_STATUS) & ECT_SM_STATUS_FULL) == 0)
        return -1;
    assert_int_equal(wire_read(w, position, sm->start, whole, sm->length), 1);
    memcpy(mail, whole, room < sm->length ? room : sm->length);
    return ect_load_le16(whole);
}

int wire_mail_request(wire_t *w, size_t position, uint8_t type, const uint8_t *data, uint16_t length)
{
    uint8_t mail[1486] = {0};
    w->mail_counter = (uint8_t)(w->mail_counter % 7 + 1);
    ect_store_le16(mail, length);
    mail[5] = (uint8_t)(type | (w->mail_counter << 4));
    memcpy(mail + MAIL_HEADER, data, length);
    return wire_mail_send(w, position, mail, (uint16_t)(MAIL_HEADER + length));
}

int wire_coe(wire_t *w, size_t position, const uint8_t *payload, uint16_t length, uint8_t *reply, uint16_t room)
{
    if (wire_mail_request(w, position, ECT_MAILBOX_TYPE_COE, payload, length) != 1)
        return -1;
    uint8_t answer[1486] = {0};
    int size = wire_mail_receive(w, position, answer, sizeof answer);
    if (size >= 0)
        memcpy(reply, answer + MAIL_HEADER, (size_t)(size < room ? size : room));
    return size;
}

static void sdo_header(uint8_t *request, uint8_t command, uint16_t index, uint8_t subindex)
{
    memset(request, 0, 10);
    request[1] = 0x20;
    request[2] = command;
    ect_store_le16(request + 3, index);
    request[5] = subindex;
}

uint32_t wire_sdo_upload(wire_t *w, size_t position, uint16_t index, uint8_t subindex, bool complete, void *data,
                         size_t *size)
{
    uint8_t request[10];
    uint8_t r[1486] = {0};
    uint8_t *to = data;
    sdo_header(request, complete ? 0x50 : 0x40, index, subindex);
    int length = wire_coe(w, position, request, sizeof request, r, sizeof r);
    assert_true(length >= 10);
    if (r[2] == 0x80)
        return ect_load_le32(r + 6);
    assert_int_equal(ect_load_le16(r + 3), index);
    assert_int_equal(r[5], subindex);
    if ((r[2] & 0x02) != 0) {
        *size = 4u - ((r[2] >> 2) & 3u);
        memcpy(to, r + 6, *size);
        return 0;
    }
    size_t total = ect_load_le32(r + 6);
    size_t got = (size_t)length - 10;
    assert_true(total <= *size);
    memcpy(to, r + 10, got);
    uint8_t toggle = 0;
    while (got < total) {
        sdo_header(request, (uint8_t)(0x60 | toggle), 0, 0);
        length = wire_coe(w, position, request, sizeof request, r, sizeof r);
        if (r[2] == 0x80)
            return ect_load_le32(r + 6);
        size_t piece = length == 10 ? 7u - ((r[2] >> 1) & 7u) : (size_t)length - 3;
        memcpy(to + got, r + 3, piece);
        got += piece;
        assert_int_equal((r[2] & 1) != 0, got >= total);
        assert_int_equal(r[2] & 0x10, toggle);
        toggle ^= 0x10;
    }
    *size = total;
    return 0;
}

uint32_t wire_sdo_download(wire_t *w, size_t position, uint16_t index, uint8_t subindex, bool complete,
                           const void *data, size_t size)
{
    uint8_t request[1486];
    uint8_t r[64] = {0};
    const uint8_t *from = data;
    uint8_t ca = complete ? 0x10 : 0;
    size_t room = wire_device(w, position)->sm[0].length - 16u;
    size_t sent = size;
    if (size > 0 && size <= 4) {
        sdo_header(request, (uint8_t)(0x23 | ca | ((4 - size) << 2)), index, subindex);
        memcpy(request + 6, data, size);
        wire_coe(w, position, request, 10, r, sizeof r);
    } else {
        sent = size < room ? size : room;
        sdo_header(request, 0x21 | ca, index, subindex);
        ect_store_le32(request + 6, (uint32_t)size);
        memcpy(request + 10, data, sent);
        wire_coe(w, position, request, (uint16_t)(10 + sent), r, sizeof r);
    }
    if (r[2] == 0x80)
        return ect_load_le32(r + 6);
    assert_int_equal(r[2], 0x60 | ca);
    uint8_t toggle = 0;
    while (sent < size) {
        size_t piece = size - sent < room + 7 ? size - sent : room + 7;
        memset(request, 0, 16);
        request[1] = 0x20;
        request[2] = (uint8_t)(toggle | (sent + piece == size ? 1 : 0) | (piece < 7 ? (7 - piece) << 1 : 0));
        memcpy(request + 3, from + sent, piece);
        wire_coe(w, position, request, (uint16_t)(3 + (piece < 7 ? 7 : piece)), r, sizeof r);
        if (r[2] == 0x80)
            return ect_load_le32(r + 6);
        assert_int_equal(r[2], 0x20 | toggle);
        toggle ^= 0x10;
        sent += piece;
    }
    return 0;
}
