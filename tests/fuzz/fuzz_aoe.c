/* SPDX-License-Identifier: MIT */
/*
 * AoE of one twin beside CoE. The input is a sequence of steps: an operation and its bytes. Each ADS request gets one
 * reply in one mail, whose AMS header repeats the fields of the request; every other mail is well-formed.
 */
#include "fuzz/mail.h"
#include "seams/aoe.h"
#include "support/testdev.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { AMS = 32, AOE = 1, COE = 3 };
enum { COMMAND = 16, FLAGS = 18, LENGTH = 20, ERROR = 24, INVOKE = 28, NOTIFICATION = 8, MOST_STEPS = 400 };

typedef struct adsdev {
    testdev_t base;
    ect_aoe_state_t aoe;
} adsdev_t;

static const ect_device_t *adsdev(void)
{
    static const ect_aoe_t entry = {.protocol = ECT_AOE_PROTOCOL, .offset = offsetof(adsdev_t, aoe)};
    static const ect_protocol_t *protocols[TESTDEV_PROTOCOLS];
    static ect_device_t device;
    device = testdev_with(&entry.protocol, protocols, ECT_MAILBOX_AOE, sizeof(adsdev_t));
    device.sm[1].minimum = device.sm[1].maximum = 0;
    device.boot_out = device.boot_in = (ect_boot_mailbox_t){0};
    return &device;
}

static void expect_reply(const fuzz_master_t *s, const uint8_t *request)
{
    uint8_t mail[FUZZ_MAILBOX];
    const uint8_t *ams = mail + FUZZ_MAIL_HEADER;
    const bool silent = (request[FLAGS] & 1) != 0 || ect_load_le16(request + COMMAND) == NOTIFICATION;
    assert(fuzz_read_mail(s, mail) == !silent);
    if (silent)
        return;
    const uint16_t length = ect_load_le16(mail);
    assert((mail[5] & 0x0F) == AOE && length >= AMS);
    assert(memcmp(ams, request + 8, 8) == 0 && memcmp(ams + 8, request, 8) == 0);
    assert(memcmp(ams + COMMAND, request + COMMAND, 2) == 0 && memcmp(ams + INVOKE, request + INVOKE, 4) == 0);
    assert(ect_load_le16(ams + FLAGS) == 5 && ect_load_le32(ams + LENGTH) == (uint32_t)length - AMS);
    assert((ect_load_le32(ams + ERROR) != 0) == (length == AMS));
}

/* A request with a valid header: command, target, then its parameters. */
static void request(fuzz_master_t *s)
{
    static const uint32_t groups[] = {ECT_AOE_GROUP_COE, ECT_AOE_GROUP_COE, ECT_AOE_GROUP_COE, ECT_AOE_GROUP_SETUP};
    uint8_t data[FUZZ_MAIL_ROOM] = {0}, mail[FUZZ_MAILBOX];
    const uint8_t command = fuzz_next(s), choice = fuzz_next(s), length = fuzz_next(s) % (FUZZ_MAIL_ROOM - AMS + 1);
    while (fuzz_read_mail(s, mail))
        ;
    data[5] = choice >> 6;
    data[COMMAND] = command % 12;
    data[COMMAND + 1] = command > 250;
    data[FLAGS] = (choice & 0x20) != 0 ? 5 : 4;
    ect_store_le32(data + LENGTH, length);
    data[INVOKE] = choice;
    for (unsigned int i = AMS; i < AMS + (unsigned int)length; i++)
        data[i] = fuzz_next(s);
    if ((choice & 0x10) == 0 && length >= 4)
        ect_store_le32(data + AMS, groups[choice & 3]);
    fuzz_write_mail(s, AOE, data, (uint16_t)(AMS + length));
    expect_reply(s, data);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const ect_device_t *device = adsdev();
    const ect_twin_config_t twin = ect_twin_default(device, NULL);
    fuzz_master_t s = {.device = device, .data = data, .size = size};
    s.chain = ect_chain_new(&twin, 1, 1);
    if (!s.chain)
        return 0;
    fuzz_set_sms(&s, 0, FUZZ_MAILBOX, FUZZ_MAILBOX);
    fuzz_request_state(&s, ECT_STATE_PREOP);
    for (unsigned int n = 0; s.size > 0 && n < MOST_STEPS; n++) {
        const uint8_t step = fuzz_next(&s);
        if (step % 4 == 3)
            fuzz_any_mail(&s, step >= 128 ? AOE : COE);
        else
            request(&s);
    }
    assert(ect_chain_slave(s.chain, 0)->state == ECT_STATE_PREOP);
    ect_chain_free(s.chain);
    return 0;
}
