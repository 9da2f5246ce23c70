/* SPDX-License-Identifier: MIT */
/* Differences between the manual and the standard, for masters that follow the manual. */
#include "devices/pmctendo/instance.h"

enum { COE = 3, RESPONSE = 3, REQUEST = 2, COE_HEADER = 6, TELEGRAM = 16, HEADER_AND_LENGTH = 2 };

/* Makes the reply of the example in §4.10: the length counts from byte 2, and the service is that of the request. */
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
