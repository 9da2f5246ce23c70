/* SPDX-License-Identifier: MIT */
/* Mails through SyncManagers 0 and 1 (ETG.1000.4 clause 6.7, ETG.1000.6 clause 5.6.1). */
#include <string.h>

#include "reader/internal.h"
#include "wire/assert.h"
#include "wire/bytes.h"
#include "wire/registers.h"

enum { COUNTERS = 7, ATTEMPTS_MOST = 100000 };
enum { STATUS_OF_SM1 = ECT_REG_SM + ECT_SM_SIZE + ECT_SM_STATUS };

/* The read of the last byte empties the mailbox: where the reply to this read is lost, a repetition finds no mail, and
 * the request is repeated. */
static ect_reader_result_t fetch(ect_reader_t *r, bool *came)
{
    uint8_t status;
    uint16_t wkc = 0;
    *came = false;
    if (reader_get(r, STATUS_OF_SM1, &status, 1) != ECT_READER_OK)
        return r->result;
    if ((status & ECT_SM_STATUS_FULL) == 0)
        return ECT_READER_OK;
    memset(r->mail, 0, sizeof r->mail);
    *came = reader_ask(r, APRD, r->in_start, r->mail, r->in_size, &wkc) && wkc == 1;
    return ECT_READER_OK;
}

/* Keeps a mail that was in the mailbox before the first request, as evidence: another master has configured the
 * mailbox. */
static void keep_found(ect_reader_t *r)
{
    const size_t length = MAIL_HEADER + (size_t)ect_load_le16(r->mail);
    if (!r->plain || r->found_size != 0)
        return;
    r->found_size = (uint16_t)(length < sizeof r->found_mail ? length : sizeof r->found_mail);
    memcpy(r->found_mail, r->mail, r->found_size);
}

/* Removes replies to abandoned requests. */
static ect_reader_result_t drain(ect_reader_t *r)
{
    bool came = true;
    for (unsigned int mails = 0; came && mails < SKIPS; mails++) {
        if (fetch(r, &came) != ECT_READER_OK)
            return r->result;
        r->skipped += came;
        if (came)
            keep_found(r);
    }
    return ECT_READER_OK;
}

ect_reader_result_t reader_send_mail(ect_reader_t *r, uint8_t type, const uint8_t *data, uint16_t length)
{
    uint8_t mail[ECT_READER_MAIL] = {0};
    uint16_t wkc = 0;
    const uint64_t until = reader_now(r) + r->config.reply_ms * NS_PER_MS;
    ECT_ASSERT(r->out_size <= sizeof mail);
    if ((size_t)length + MAIL_HEADER > r->out_size)
        return reader_report(r, ECT_READER_WRONG, "its mailbox of %u bytes is too small for a request of %u bytes",
                             r->out_size, length + MAIL_HEADER);
    if (drain(r) != ECT_READER_OK)
        return r->result;
    if (!r->plain)
        r->counter = (uint8_t)(r->counter % COUNTERS + 1);
    r->plain = false;
    r->sent = true;
    ect_store_le16(mail, length);
    mail[5] = (uint8_t)(type | r->counter << 4);
    memcpy(mail + MAIL_HEADER, data, length);
    for (unsigned int polls = 0; polls < ATTEMPTS_MOST && reader_now(r) < until; polls++) {
        if (reader_is_over(r))
            return ECT_READER_STOPPED;
        if (reader_ask(r, APWR, r->out_start, mail, r->out_size, &wkc) && wkc == 1)
            return reader_good(r);
        reader_pause(r, polls);
    }
    return reader_report(r, ECT_READER_SILENT, "the slave does not empty its mailbox within %u ms", r->config.reply_ms);
}

/* FNV-1a. */
static uint32_t sum_of_mail(const ect_reader_t *r)
{
    uint32_t sum = 2166136261u;
    for (size_t i = 0; i < r->in_size; i++)
        sum = (sum ^ r->mail[i]) * 16777619u;
    return sum;
}

/* A slave that has missed the read of its mail sends the mail again: the same bytes with the same counter. The bytes
 * are compared as well, because some slaves do not count. */
static bool is_repeated(ect_reader_t *r)
{
    const uint8_t counter = r->mail[5] >> 4 & 7;
    const uint32_t sum = sum_of_mail(r);
    const bool repeated = counter != 0 && sum == r->last_sum;
    r->last_sum = sum;
    r->skipped += repeated;
    return repeated;
}

ect_reader_result_t reader_receive_mail(ect_reader_t *r, uint64_t until_ns)
{
    for (unsigned int polls = 0; polls < ATTEMPTS_MOST; polls++) {
        const bool late = reader_now(r) >= until_ns; /* a delayed process polls once more */
        bool came;
        if (reader_is_over(r) || fetch(r, &came) != ECT_READER_OK)
            return r->result;
        if (came && !is_repeated(r)) {
            const uint16_t length = ect_load_le16(r->mail);
            if (length + MAIL_HEADER > r->in_size)
                return reader_report(r, ECT_READER_WRONG, "a mail of %u bytes in a mailbox of %u", length, r->in_size);
            return reader_good(r);
        }
        if (late)
            break;
        reader_pause(r, polls);
    }
    return reader_report(r, ECT_READER_SILENT, "no reply within %u ms", r->config.reply_ms);
}
