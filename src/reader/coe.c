/* SPDX-License-Identifier: MIT */
/* CoE requests, and the recognition of their replies. */
#include <string.h>

#include "reader/internal.h"
#include "wire/assert.h"
#include "wire/bytes.h"

ect_reader_result_t reader_send_coe(ect_reader_t *r, uint8_t service, const uint8_t *data, uint16_t length)
{
    uint8_t message[COE_HEADER + 16] = {0};
    ECT_ASSERT(length <= sizeof message - COE_HEADER);
    ect_store_le16(message, (uint16_t)(service << 12));
    memcpy(message + COE_HEADER, data, length);
    return reader_send_mail(r, MAILBOX_COE, message, (uint16_t)(length + COE_HEADER));
}

/* A mailbox error: type 1 and the detail (ETG.1000.4 table 30). */
static ect_reader_result_t refused(ect_reader_t *r, size_t length)
{
    r->code = length >= 4 ? ect_load_le16(r->mail + MAIL_HEADER + 2) : 0;
    return reader_report(r, ECT_READER_REFUSED, "the slave refuses the mail with mailbox error 0x%04X",
                         (unsigned int)r->code);
}

ect_reader_result_t reader_receive_coe(ect_reader_t *r, reader_match_t match, const void *wanted, const uint8_t **data,
                                       size_t *length)
{
    const uint64_t until = reader_now(r) + r->config.reply_ms * NS_PER_MS;
    for (unsigned int mails = 0; mails < SKIPS; mails++) {
        const unsigned int skipped = r->skipped;
        if (reader_receive_mail(r, until) != ECT_READER_OK) {
            if (r->result == ECT_READER_SILENT && (mails > 0 || r->skipped > skipped))
                break;
            return r->result;
        }
        const uint8_t *message = r->mail + MAIL_HEADER;
        const size_t bytes = ect_load_le16(r->mail);
        const unsigned int type = r->mail[5] & 0x0F;
        if (type == MAILBOX_ERROR)
            return refused(r, bytes);
        *data = message + COE_HEADER;
        *length = bytes >= COE_HEADER ? bytes - COE_HEADER : 0;
        if (type == MAILBOX_COE && bytes >= COE_HEADER && match(message[1] >> 4, *data, *length, wanted))
            return reader_good(r);
        r->skipped++;
    }
    return reader_report(r, ECT_READER_WRONG, "no mail within %u ms is the reply to the request", r->config.reply_ms);
}

ect_reader_result_t reader_repeat(ect_reader_t *r, reader_request_t request, void *what)
{
    ect_reader_result_t result = ECT_READER_SILENT;
    for (unsigned int tries = 0; tries < r->config.tries; tries++) {
        result = request(r, what);
        if (result != ECT_READER_SILENT && result != ECT_READER_WRONG)
            break;
    }
    const bool failed = result == ECT_READER_SILENT || result == ECT_READER_WRONG;
    r->failures = failed ? r->failures + 1 : 0;
    return result;
}
