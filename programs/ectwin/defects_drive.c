/* SPDX-License-Identifier: MIT */
/* Defects of CiA 402 drives: in the process data of the first axis, as the SII maps them, and in its objects. */
#include <string.h>

#include "defects_internal.h"
#include "sii/sii.h"

enum {
    CONTROL = 0x6040,
    STATUS = 0x6041,
    DISPLAY = 0x6061,
    TARGET = 0x607A,
    TORQUE = 0x6071,
    SPEED = 0x60FF,
    DISABLE_OPTION = 0x605C
};
enum { READY = 0x21, SWITCHED_ON = 0x23, ENABLED = 0x27, STOPPING = 0x07, FAULT = 0x08, STATE = 0x6F };
enum { QUICK_STOP = 0x02, SHUTDOWN = 0x06, SWITCH_ON = 0x07, ENABLE = 0x0F };
enum { START = 0x10, RESET = 0x80, HALT = 0x100, REACHED = 0x400, ATTAINED = 0x1000 };
enum { PP = 1, PV = 3, TQ = 4, HM = 6, IP = 7, CSP = 8, CSV = 9, CST = 10 };
enum { LAST_MODE = 1, LAST_STATUS = 3 }; /* of defect_t.memory */

/* @return bytes from the start of the SyncManager's image to the entry; -1: none */
static int offset_of(const datagram_t *g, uint16_t category, uint8_t sm, uint16_t index)
{
    size_t length;
    unsigned int bits = 0;
    const uint8_t *pdo = ect_sii_category(g->config->sii, g->config->sii_size, category, &length);
    const uint8_t *end = pdo ? pdo + length : NULL;
    for (; pdo && end - pdo >= 8 && end - pdo >= 8 + 8 * pdo[2]; pdo += 8 + 8 * pdo[2]) {
        for (unsigned int i = 0; i < pdo[2] && pdo[3] == sm; i++) {
            const uint8_t *entry = pdo + 8 + 8 * (size_t)i;
            if (ect_load_le16(entry) == index)
                return (int)(bits / 8);
            bits += entry[5];
        }
    }
    return -1;
}

static bool is_process_data(const datagram_t *g)
{
    const uint16_t outputs = ect_load_le16(g->chip + SM_2 + ECT_SM_LENGTH);
    const uint16_t inputs = ect_load_le16(g->chip + SM_3 + ECT_SM_LENGTH);
    return g->command == ECT_LRW && outputs > 0 && g->length == outputs + inputs;
}

/* @return the outputs of an entry in an LRW of all process data; NULL: none */
static uint8_t *output(const datagram_t *g, uint16_t index)
{
    const int at = offset_of(g, ECT_SII_RXPDO, 2, index);
    return is_process_data(g) && at >= 0 ? data(g) + at : NULL;
}

static uint8_t *input(const datagram_t *g, uint16_t index)
{
    const uint16_t outputs = ect_load_le16(g->chip + SM_2 + ECT_SM_LENGTH);
    const int at = offset_of(g, ECT_SII_TXPDO, 3, index);
    return is_process_data(g) && at >= 0 ? data(g) + outputs + at : NULL;
}

static bool shows_mode(const datagram_t *g, uint8_t mode)
{
    const uint8_t *shown = input(g, DISPLAY);
    return shown && *shown == mode;
}

static void remember_status(defect_t *d, datagram_t *g)
{
    const uint8_t *status = input(g, STATUS);
    if (status)
        d->memory[LAST_STATUS] = ect_load_le16(status);
}

/* A command is another one in the state that the status word showed last. */
static void swap(defect_t *d, const datagram_t *g, uint16_t state, uint16_t command, uint16_t becomes)
{
    uint8_t *control = output(g, CONTROL);
    const uint16_t mask = state == FAULT ? 0x4F : STATE;
    if (control && (d->memory[LAST_STATUS] & mask) == state && ect_load_le16(control) == command)
        ect_store_le16(control, becomes);
}

static void ready_stays(defect_t *d, datagram_t *g)
{
    swap(d, g, READY, QUICK_STOP, SHUTDOWN);
}

/* pv is shown as pp, by process data and SDO. */
static void shows_another(defect_t *d, datagram_t *g)
{
    (void)d;
    uint8_t *shown = input(g, DISPLAY);
    uint8_t *mail = data(g);
    if (shown && *shown == PV)
        *shown = PP;
    if (is_mail(g, false) && counter(g) == 1 && (mail[5] & 0x0F) == 3 && mail[7] >> 4 == 3 &&
        ect_load_le16(mail + 9) == DISPLAY && mail[12] == PV)
        mail[12] = PP;
}

static void shutdown_is_ignored(defect_t *d, datagram_t *g)
{
    swap(d, g, SWITCHED_ON, SHUTDOWN, SWITCH_ON);
}

static void quick_stop_is_off(defect_t *d, datagram_t *g)
{
    swap(d, g, ENABLED, QUICK_STOP, 0);
    swap(d, g, STOPPING, QUICK_STOP, 0);
}

static void never_brakes(defect_t *d, datagram_t *g)
{
    (void)d;
    uint8_t *mail = data(g);
    if (is_mail(g, true) && (mail[5] & 0x0F) == 3 && mail[8] >> 5 == 1 && ect_load_le16(mail + 9) == DISABLE_OPTION &&
        mail[12] == 1)
        mail[12] = 0;
}

static void halt_is_ignored(defect_t *d, datagram_t *g)
{
    (void)d;
    uint8_t *control = output(g, CONTROL);
    if (control)
        ect_store_le16(control, ect_load_le16(control) & (uint16_t)~HALT);
}

static void shutdown_resets(defect_t *d, datagram_t *g)
{
    swap(d, g, FAULT, SHUTDOWN, RESET);
}

static uint16_t control_of(const datagram_t *g)
{
    const uint8_t *control = output(g, CONTROL);
    return control ? ect_load_le16(control) : 0;
}

static void set_status(const datagram_t *g, uint16_t clear, uint16_t set)
{
    uint8_t *status = input(g, STATUS);
    if (status)
        ect_store_le16(status, (uint16_t)((ect_load_le16(status) & ~clear) | set));
}

static void acknowledge_stays(defect_t *d, datagram_t *g)
{
    const uint8_t *status = input(g, STATUS);
    if (!status)
        return;
    if ((control_of(g) & ENABLE) != ENABLE)
        d->memory[0] = 0;
    else if ((control_of(g) & START) != 0 && (ect_load_le16(status) & ATTAINED) != 0)
        d->memory[0] = 1;
    if (d->memory[0] != 0)
        set_status(g, 0, ATTAINED);
}

static void speed_is_never_0(defect_t *d, datagram_t *g)
{
    (void)d;
    if (shows_mode(g, PV))
        set_status(g, ATTAINED, 0);
}

static void home_is_never_found(defect_t *d, datagram_t *g)
{
    (void)d;
    if (shows_mode(g, HM))
        set_status(g, ATTAINED, 0);
}

/* The first set position in Operation enabled stays in force. */
static void target_stays(defect_t *d, datagram_t *g)
{
    uint8_t *target = output(g, TARGET);
    if (!target)
        return;
    if ((d->memory[LAST_STATUS] & STATE) != ENABLED || d->memory[LAST_MODE] != CSP)
        d->memory[0] = ect_load_le32(target);
    ect_store_le32(target, d->memory[0]);
}

static void remember_mode(defect_t *d, datagram_t *g)
{
    const uint8_t *shown = input(g, DISPLAY);
    remember_status(d, g);
    if (shown)
        d->memory[LAST_MODE] = *shown;
}

static void interpolation_is_not_shown(defect_t *d, datagram_t *g)
{
    (void)d;
    if (shows_mode(g, IP))
        set_status(g, ATTAINED, 0);
}

static void speed_has_no_sign(defect_t *d, datagram_t *g)
{
    uint8_t *speed = output(g, SPEED);
    if (speed && d->memory[LAST_MODE] == CSV && (speed[3] & 0x80) != 0)
        ect_store_le32(speed, 0 - ect_load_le32(speed));
}

static void torque_is_always_reached(defect_t *d, datagram_t *g)
{
    (void)d;
    if (shows_mode(g, TQ))
        set_status(g, 0, REACHED);
}

static void torque_has_no_sign(defect_t *d, datagram_t *g)
{
    uint8_t *torque = output(g, TORQUE);
    if (torque && d->memory[LAST_MODE] == CST && (torque[1] & 0x80) != 0)
        ect_store_le16(torque, (uint16_t)(0 - ect_load_le16(torque)));
}

const defect_row_t defect_drive_rows[] = {
    {"CF-D01", "6041h by SDO shows Operation enabled in PREOP (needs a CiA 402 drive)", SDO(STATUS, 0, 12), .state = 2,
     .command = 0x4B, .change = ANY(2, ENABLED)},
    {"CF-D02", "Quick stop in Ready to switch on is ignored (needs a CiA 402 drive)", CUSTOM, .before = ready_stays,
     .after = remember_status},
    {"CF-D03", "6061h shows pp in pv (needs a CiA 402 drive)", CUSTOM, .after = shows_another},
    {"CF-D04", "a reserved option code is accepted (needs 605Ah)", SDO(0x605A, 0, 8), .command = 0x80,
     .change = ANY(1, 0x60)},
    {"CF-D05", "Shutdown in Switched on is ignored (needs --move of ectwin-conform)", CUSTOM,
     .before = shutdown_is_ignored, .after = remember_status},
    {"CF-D06", "Quick stop is Disable voltage (needs --move)", CUSTOM, .before = quick_stop_is_off,
     .after = remember_status},
    {"CF-D07", "1 in 605Ch is taken as 0 (needs --move)", CUSTOM, .before = never_brakes},
    {"CF-D08", "halt is ignored (needs --move)", CUSTOM, .before = halt_is_ignored},
    {"CF-D09", "Shutdown resets a fault (needs --move)", CUSTOM, .before = shutdown_resets, .after = remember_status},
    {"CF-D10", "bit 12 stays when bit 4 falls (needs --move)", CUSTOM, .after = acknowledge_stays},
    {"CF-D11", "speed is never 0 in pv (needs --move, 6061h in the inputs)", CUSTOM, .after = speed_is_never_0},
    {"CF-D12", "home is never found (needs --move, 6061h in the inputs)", CUSTOM, .after = home_is_never_found},
    {"CF-D13", "the set position of csp stays (needs --move, 6061h in the inputs)", CUSTOM, .before = target_stays,
     .after = remember_mode},
    {"CF-D14", "bit 12 is 0 in ip (needs --move, 6061h in the inputs, 60C1h:1 in the outputs)", CUSTOM,
     .after = interpolation_is_not_shown},
    {"CF-D15", "a negative speed in csv is a positive one (needs --move, 6061h in the inputs)", CUSTOM,
     .before = speed_has_no_sign, .after = remember_mode},
    {"CF-D16", "bit 10 is 1 in tq (needs --move, 6061h in the inputs)", CUSTOM, .after = torque_is_always_reached},
    {"CF-D17", "a negative torque in cst is a positive one (needs --move, 6061h in the inputs)", CUSTOM,
     .before = torque_has_no_sign, .after = remember_mode},
};
const size_t defect_drive_count = sizeof defect_drive_rows / sizeof defect_drive_rows[0];
