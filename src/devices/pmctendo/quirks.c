/* SPDX-License-Identifier: MIT */
/* Differences of the manual from the standard, for masters written after the manual. */
#include "devices/pmctendo/instance.h"

enum { COE = 3, RESPONSE = 3, REQUEST = 2, COE_HEADER = 6, TELEGRAM = 16, HEADER_AND_LENGTH = 2 };

/* The reply of §4.10's example: the length counts from byte 2, and the service is the request's. */
void pmc_mail(void *instance, uint8_t *mail, uint16_t size)
{
    const pmctendo_t *u = instance;
    bool reply = (mail[5] & 0x0F) == COE && mail[COE_HEADER + 1] >> 4 == RESPONSE;
    if (!u->plant.quirk_reply || !reply || size < TELEGRAM)
        return;
    mail[0] = TELEGRAM - HEADER_AND_LENGTH;
    mail[1] = 0;
    mail[COE_HEADER + 1] = REQUEST << 4;
}

/* The manual lists three AL status codes; "other codes are not supported". */
uint16_t pmc_al_code(const pmctendo_t *u, uint16_t code)
{
    if (!u->plant.quirk_al_codes)
        return code;
    switch (code) {
    case ECT_AL_NO_ERROR:
        return ECT_AL_NO_ERROR;
    case ECT_AL_UNKNOWN_STATE:
    case ECT_AL_NO_BOOT:
    case ECT_AL_INVALID_CHANGE:
        return ECT_AL_INVALID_CHANGE;
    case ECT_AL_MAILBOX:
    case ECT_AL_OUTPUT_SM:
    case ECT_AL_INPUT_SM:
    case ECT_AL_OUTPUT_MAPPING:
    case ECT_AL_INPUT_MAPPING:
        return ECT_AL_SM;
    default:
        return ECT_AL_SYNC;
    }
}
