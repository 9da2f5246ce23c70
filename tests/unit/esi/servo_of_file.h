/* SPDX-License-Identifier: MIT */
/* A SoE drive of tests/esi/soe.xml on a wire, and requests of SoE. Cycles of 1 ms. */
#ifndef TESTS_UNIT_ESI_SERVO_OF_FILE_H
#define TESTS_UNIT_ESI_SERVO_OF_FILE_H

#include "drive_of_file.h"
#include "seams/soe.h"

enum { ROOM = 512, MAIL = 6, HEAD = 4, READ = 1, WRITE = 3, ATTRIBUTE = 0x04, VALUE = 0x40 };

static inline void open_servo(const char *type, ect_behaviour_t behaviour)
{
    char path[300];
    char text[300] = "";
    (void)snprintf(path, sizeof path, "%s/soe.xml", ESI_FILES);
    twin = ect_esi_twin_make(path, type, NULL, 0, text, sizeof text);
    if (twin == NULL || !ect_esi_twin_behave(twin, behaviour, text, sizeof text))
        fail_msg("%s: expected a twin, got: %s", type, text);
    ect_twin_config_t config = ect_twin_default(device(), ect_esi_twin_product(twin)->plant);
    memset(&wire, 0, sizeof wire);
    memset(out, 0, sizeof out);
    wire_open_twins(&wire, &config, 1);
    wire_go(&wire, 0, PREOP);
}

/* One request. @return bytes of the reply behind its header of four; below 0: an error, its code is -1 - result */
static inline int request(unsigned int drive, unsigned int operation, unsigned int element, uint16_t idn,
                          const uint8_t *data, uint16_t length, uint8_t *reply)
{
    uint8_t mail[ROOM] = {(uint8_t)(operation | drive << 5), (uint8_t)element};
    ect_store_le16(mail + 2, idn);
    if (length > 0)
        memcpy(mail + HEAD, data, length);
    assert_int_equal(wire_mail_request(&wire, 0, ECT_MAILBOX_TYPE_SOE, mail, (uint16_t)(HEAD + length)), 1);
    int got = 0;
    for (bool more = true; more;) {
        const int bytes = wire_mail_receive(&wire, 0, mail, sizeof mail) - HEAD;
        assert_true(bytes >= 0);
        assert_int_equal(mail[5] & 0x0F, ECT_MAILBOX_TYPE_SOE);
        more = (mail[MAIL] & 0x08) != 0;
        if ((mail[MAIL] & 0x10) != 0)
            return -1 - ect_load_le16(mail + MAIL + HEAD);
        memcpy(reply + got, mail + MAIL + HEAD, (size_t)bytes);
        got += bytes;
    }
    return got;
}

static inline uint32_t number_of(unsigned int drive, uint16_t idn, unsigned int element)
{
    uint8_t reply[4 * ROOM] = {0};
    const int length = request(drive, READ, element, idn, NULL, 0, reply);
    if (length != 1 && length != 2 && length != 4)
        fail_msg("drive %u, IDN %u: expected a number, got %d bytes", drive, idn, length);
    return ect_load_le32(reply);
}

static inline int write_value(unsigned int drive, uint16_t idn, const void *data, uint16_t length)
{
    uint8_t reply[4 * ROOM];
    return request(drive, WRITE, VALUE, idn, data, length, reply);
}

#endif
