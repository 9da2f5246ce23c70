/* SPDX-License-Identifier: MIT */
/* Finds the slave, brings it to PREOP, and restores its previous state. */
#include <string.h>

#include "reader/internal.h"
#include "wire/assert.h"
#include "wire/bytes.h"
#include "wire/registers.h"
#include "wire/sii.h"

enum { INIT = 1, PREOP = 2, BOOT = 3, SAFEOP = 4, OP = 8, STATE_POLLS = 100000 };
enum { TO_SLAVE = 0x26, FROM_SLAVE = 0x22, SM1 = ECT_SM_SIZE };

static ect_reader_config_t with_defaults(const ect_reader_config_t *given)
{
    ect_reader_config_t c = given != NULL ? *given : (ect_reader_config_t){0};
    c.frame_ms = c.frame_ms != 0 ? c.frame_ms : 500;
    c.reply_ms = c.reply_ms != 0 ? c.reply_ms : 2000;
    c.state_ms = c.state_ms != 0 ? c.state_ms : 5000;
    c.limit_ms = c.limit_ms != 0 ? c.limit_ms : 600000;
    c.tries = c.tries != 0 ? c.tries : 3;
    return c;
}

static ect_reader_result_t count_slaves(ect_reader_t *r)
{
    uint8_t byte = 0;
    const bool came = reader_ask(r, BRD, ECT_REG_TYPE, &byte, 1, &r->count);
    if (came && r->config.position < r->count)
        return ECT_READER_OK;
    if (!came && reader_is_stopped(r))
        return r->result;
    return came ? reader_report(r, ECT_READER_LOST, "the segment has only %u slave%s", r->count,
                                r->count == 1 ? "" : "s")
                : reader_report(r, ECT_READER_LOST, "no frame returns: is a slave connected?");
}

static ect_reader_result_t al_status(ect_reader_t *r, uint16_t *status, uint16_t *code)
{
    uint8_t bytes[6];
    if (reader_get(r, ECT_REG_AL_STATUS, bytes, sizeof bytes) != ECT_READER_OK)
        return r->result;
    *status = ect_load_le16(bytes);
    *code = ect_load_le16(bytes + 4);
    return ECT_READER_OK;
}

ect_reader_result_t ect_reader_open(ect_reader_t *r, const ect_reader_link_t *link, const ect_reader_config_t *config)
{
    const uint8_t *header = r->header;
    uint16_t code;
    size_t read;
    memset(r, 0, sizeof *r);
    r->link = link;
    r->config = with_defaults(config);
    r->counter = r->config.counter;
    r->limit_ns = reader_now(r) + r->config.limit_ms * NS_PER_MS;
    if (count_slaves(r) != ECT_READER_OK || al_status(r, &r->found_status, &code) != ECT_READER_OK ||
        ect_reader_sii(r, r->header, sizeof r->header, &read) != ECT_READER_OK)
        return r->result;
    r->vendor = ect_load_le32(header + ECT_SII_AT_VENDOR);
    r->product = ect_load_le32(header + ECT_SII_AT_PRODUCT);
    r->revision = ect_load_le32(header + ECT_SII_AT_REVISION);
    r->protocols = ect_load_le16(header + ECT_SII_AT_PROTOCOLS);
    r->out_start = ect_load_le16(header + ECT_SII_AT_MAILBOX_OUT);
    r->out_size = ect_load_le16(header + ECT_SII_AT_MAILBOX_OUT + 2);
    r->in_start = ect_load_le16(header + ECT_SII_AT_MAILBOX_IN);
    r->in_size = ect_load_le16(header + ECT_SII_AT_MAILBOX_IN + 2);
    return ECT_READER_OK;
}

static void store_sm(uint8_t *sm, uint16_t start, uint16_t length, uint8_t control)
{
    memset(sm, 0, ECT_SM_SIZE);
    ect_store_le16(sm + ECT_SM_START, start);
    ect_store_le16(sm + ECT_SM_LENGTH, length);
    sm[ECT_SM_CONTROL] = control;
    sm[ECT_SM_ACTIVATE] = ECT_SM_ACTIVATE_ENABLE;
}

static bool is_usable(uint16_t start, uint16_t size)
{
    return start >= ECT_RAM && size >= MAIL_HEADER + COE_HEADER + 8 && size <= ECT_READER_MAIL &&
           start <= 0x10000 - size;
}

static ect_reader_result_t check_mailbox(ect_reader_t *r)
{
    if (is_usable(r->out_start, r->out_size) && is_usable(r->in_start, r->in_size))
        return ECT_READER_OK;
    (void)reader_report(r, ECT_READER_WRONG, "no usable mailbox: %u bytes at 0x%04X, %u bytes at 0x%04X", r->out_size,
                        r->out_start, r->in_size, r->in_start);
    return r->result;
}

static ect_reader_result_t change_state(ect_reader_t *r, uint8_t wanted)
{
    const uint64_t until = reader_now(r) + r->config.state_ms * NS_PER_MS;
    const uint8_t control[2] = {wanted | ECT_AL_ACKNOWLEDGE, 0};
    uint16_t status = 0, code = 0;
    if (reader_put(r, ECT_REG_AL_CONTROL, control, sizeof control) != ECT_READER_OK)
        return r->result;
    for (unsigned int polls = 0; polls < STATE_POLLS; polls++) {
        const bool late = reader_now(r) >= until;
        if (reader_is_over(r) || al_status(r, &status, &code) != ECT_READER_OK)
            return r->result;
        if ((status & (ECT_AL_STATE_MASK | ECT_AL_ERROR)) == wanted)
            return ECT_READER_OK;
        if ((status & ECT_AL_ERROR) != 0 && polls > 0) {
            r->code = code;
            return reader_report(r, ECT_READER_REFUSED, "the slave refuses %s with AL status code 0x%04X",
                                 wanted == INIT ? "INIT" : "PREOP", code);
        }
        if (late)
            break;
        reader_pause(r, polls);
    }
    return reader_report(r, ECT_READER_SILENT, "the slave does not reach %s within %u ms",
                         wanted == INIT ? "INIT" : "PREOP", r->config.state_ms);
}

/* A SyncManager takes a new configuration only while it is disabled. */
static ect_reader_result_t put_sms(ect_reader_t *r, const uint8_t sms[2 * ECT_SM_SIZE])
{
    static const uint8_t disabled;
    if (reader_put(r, ECT_REG_SM + ECT_SM_ACTIVATE, &disabled, 1) != ECT_READER_OK ||
        reader_put(r, ECT_REG_SM + SM1 + ECT_SM_ACTIVATE, &disabled, 1) != ECT_READER_OK)
        return r->result;
    return reader_put(r, ECT_REG_SM, sms, 2 * ECT_SM_SIZE);
}

/* The SyncManagers define the mailbox in use; the EEPROM may name another. */
static ect_reader_result_t adopt_mailbox(ect_reader_t *r)
{
    const uint8_t *sm = r->found_sms;
    r->out_start = ect_load_le16(sm + ECT_SM_START);
    r->out_size = (sm[ECT_SM_ACTIVATE] & ECT_SM_ACTIVATE_ENABLE) != 0 ? ect_load_le16(sm + ECT_SM_LENGTH) : 0;
    r->in_start = ect_load_le16(sm + SM1 + ECT_SM_START);
    r->in_size =
        (sm[SM1 + ECT_SM_ACTIVATE] & ECT_SM_ACTIVATE_ENABLE) != 0 ? ect_load_le16(sm + SM1 + ECT_SM_LENGTH) : 0;
    return check_mailbox(r);
}

static ect_reader_result_t bring_up(ect_reader_t *r)
{
    uint8_t sms[sizeof r->found_sms];
    if (check_mailbox(r) != ECT_READER_OK || change_state(r, INIT) != ECT_READER_OK)
        return r->result;
    store_sm(sms, r->out_start, r->out_size, TO_SLAVE);
    store_sm(sms + SM1, r->in_start, r->in_size, FROM_SLAVE);
    r->brought_up = true;
    if (put_sms(r, sms) != ECT_READER_OK)
        return r->result;
    return change_state(r, PREOP);
}

/* The part of AL status that decides on the mailbox: the state, and the error flag if it may be acknowledged. */
static unsigned int state_of(const ect_reader_t *r, uint16_t status)
{
    const bool acknowledges = r->config.changes == ECT_READER_CHANGES_ALL;
    return status & (ECT_AL_STATE_MASK | (acknowledges ? ECT_AL_ERROR : 0u));
}

static ect_reader_result_t check_changes(ect_reader_t *r, unsigned int state)
{
    if (r->config.changes == ECT_READER_CHANGES_ALL || (r->config.changes == ECT_READER_CHANGES_INIT && state == INIT))
        return ECT_READER_OK;
    return reader_report(r, ECT_READER_DECLINED, "the slave is in %s, without a mailbox",
                         state == INIT   ? "INIT"
                         : state == BOOT ? "BOOT"
                                         : "an unknown state");
}

ect_reader_result_t ect_reader_preop(ect_reader_t *r)
{
    uint16_t status = 0;
    uint16_t code = 0;
    if (r->out_size == 0 && r->found_sms[ECT_SM_ACTIVATE] == 0)
        return reader_report(r, ECT_READER_WRONG, "the slave has no mailbox");
    if (al_status(r, &status, &code) != ECT_READER_OK)
        return r->result;
    const unsigned int state = state_of(r, status);
    const bool has_mailbox = state == PREOP || state == SAFEOP || state == OP;
    if (r->brought_up && has_mailbox)
        return reader_good(r);
    if (!r->brought_up && reader_get(r, ECT_REG_SM, r->found_sms, sizeof r->found_sms) != ECT_READER_OK)
        return r->result;
    if (has_mailbox) {
        r->plain |= !r->sent && r->counter == 0;
        return adopt_mailbox(r);
    }
    return check_changes(r, state) == ECT_READER_OK ? bring_up(r) : r->result;
}

void ect_reader_close(ect_reader_t *r)
{
    static const uint8_t to_pdi = 0x01;
    char text[sizeof r->text];
    const ect_reader_result_t result = r->result;
    ECT_ASSERT(r->link != NULL);
    memcpy(text, r->text, sizeof text);
    r->limit_ns = reader_now(r) + 2 * r->config.state_ms * NS_PER_MS;
    r->config.stopped = NULL;
    if (r->brought_up) {
        (void)change_state(r, INIT);
        (void)put_sms(r, r->found_sms);
        r->brought_up = false;
    }
    if (r->sii_of_pdi)
        (void)reader_put(r, ECT_REG_SII_CONFIG, &to_pdi, 1);
    r->sii_of_pdi = false;
    r->result = result;
    memcpy(r->text, text, sizeof text);
}
