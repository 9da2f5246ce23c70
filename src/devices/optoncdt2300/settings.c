/* SPDX-License-Identifier: MIT */
/* SDO writes: user level, and the effect of settings. */
#include <string.h>

#include "devices/optoncdt2300/instance.h"
#include "wire/bytes.h"

enum { USER_LEVEL = 0x2001, STATISTIC = 0x2181, CHOICE = 0x21B0, RATE = 0x2250 };
enum { LOGIN = 2, LOGOUT = 3, DEFAULT_USER = 4, REPEAT = 7 };

/* --- selection of measurements ------------------------------------------------------------------------------------ */

/* The sub-indices of 6065h, in the order of 1A00h. */
static const uint8_t sources[OPTO_VALUES] = {0x01, 0x02, 0x03, 0x11, 0x04, 0x05, 0x06,
                                             0x07, 0x0C, 0x0D, 0x0E, 0x0F, 0x10};

void opto_choose(opto_t *u)
{
    u->mapped = 0;
    memset(u->mapping, 0, sizeof u->mapping);
    for (unsigned int n = 0; n < OPTO_VALUES; n++) {
        if (u->chosen[n])
            u->mapping[u->mapped++] = ECT_MAP(0x6065, sources[n], 32);
    }
    opto_keep_last(u);
}

/* Adds a measurement to each assigned PDO. */
static ect_reason_t check_choice(const opto_t *u, uint8_t subindex, bool wanted)
{
    enum { VALUE_BYTES = 4 };
    bool more = wanted && !u->chosen[subindex - OPTO_FIRST_CHOICE];
    unsigned int bytes = (u->mapped + (more ? 1u : 0u)) * VALUE_BYTES * u->assigned;
    return bytes <= OPTO_LONGEST ? ECT_OK : ECT_REASON_PDO_LENGTH;
}

/* --- user level --------------------------------------------------------------------------------------------------- */

static bool is_text(const char *text, const void *data, uint16_t size)
{
    return strlen(text) == size && memcmp(text, data, size) == 0;
}

static bool is_password(const char *text, uint16_t size)
{
    for (uint16_t i = 0; i < size; i++) {
        if ((text[i] < 'A' || text[i] > 'Z') && (text[i] < 'a' || text[i] > 'z'))
            return false;
    }
    return size > 0;
}

static ect_reason_t check_user(const opto_t *u, uint8_t subindex, const void *data, uint16_t size)
{
    bool right = true;
    if (subindex == LOGIN)
        right = is_text(u->plant.password, data, size);
    else if (subindex == REPEAT)
        right = strcmp(u->password_old, u->plant.password) == 0 && is_text(u->password_new, data, size) &&
                is_password(data, size);
    return right ? ECT_OK : ECT_REASON_STORE;
}

/* Each change needs the old and the new password. */
static void change_password(opto_t *u)
{
    memcpy(u->plant.password, u->password_new, sizeof u->plant.password);
    memset(u->password_old, 0, sizeof u->password_old);
    memset(u->password_new, 0, sizeof u->password_new);
    memset(u->password_repeat, 0, sizeof u->password_repeat);
}

static void user_written(opto_t *u, uint8_t subindex)
{
    if (subindex == LOGIN) {
        memset(u->login, 0, sizeof u->login);
        u->user = OPTO_EXPERT;
    } else if (subindex == LOGOUT) {
        u->user = u->logout ? OPTO_USER : u->user;
        u->logout = 0;
    } else if (subindex == REPEAT) {
        change_password(u);
    }
}

/* --- from the stack ----------------------------------------------------------------------------------------------- */

static bool needs_expert(uint16_t index, uint8_t subindex)
{
    return index > USER_LEVEL || (index == USER_LEVEL && subindex >= DEFAULT_USER);
}

ect_reason_t opto_sdo_write(void *instance, uint16_t index, uint8_t subindex, const void *data, uint16_t size)
{
    const opto_t *u = instance;
    if (needs_expert(index, subindex) && u->user != OPTO_EXPERT)
        return ECT_REASON_LOCAL_CONTROL;
    switch (index) {
    case USER_LEVEL:
        return check_user(u, subindex, data, size);
    case CHOICE:
        return check_choice(u, subindex, *(const uint8_t *)data != 0);
    case RATE:
        return opto_is_rate(ect_load_le32(data)) ? ECT_OK : ECT_REASON_RANGE;
    default:
        return ECT_OK;
    }
}

void opto_sdo_written(void *instance, uint16_t index, uint8_t subindex, uint64_t now_ns)
{
    opto_t *u = instance;
    opto_advance(u, now_ns);
    switch (index) {
    case USER_LEVEL:
        user_written(u, subindex);
        break;
    case STATISTIC:
        if (u->statistic_reset)
            opto_reset_statistic(u);
        u->statistic_reset = 0;
        break;
    case CHOICE:
        opto_choose(u);
        break;
    case RATE:
        opto_new_rate(u, now_ns);
        break;
    default:
        break;
    }
}
