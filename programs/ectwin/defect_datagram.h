/* SPDX-License-Identifier: MIT */
/** @file A datagram of a frame on its way through the first twin, for defects.c and defects_mail.c. */
#ifndef ECTWIN_DEFECT_DATAGRAM_H
#define ECTWIN_DEFECT_DATAGRAM_H

#include "defects.h"
#include "esc/route.h"
#include "wire/bytes.h"
#include "wire/registers.h"

/* A datagram of the received frame: `sent` as received, `now` as processed so far. */
typedef struct datagram {
    const uint8_t *sent;
    uint8_t *now;
    uint8_t command;
    uint16_t adp, ado, length;
    const uint8_t *chip; /* the first twin's registers and RAM */
    const ect_esc_config_t *config;
} datagram_t;

static inline uint8_t *data(const datagram_t *g)
{
    return g->now + ECT_DATAGRAM_DATA;
}

static inline uint16_t counter(const datagram_t *g)
{
    return ect_load_le16(g->now + ECT_DATAGRAM_DATA + g->length);
}

static inline uint16_t out_start(const datagram_t *g)
{
    return ect_load_le16(g->chip + ECT_REG_SM);
}

static inline uint16_t in_start(const datagram_t *g)
{
    return ect_load_le16(g->chip + ECT_REG_SM + ECT_SM_SIZE);
}

/* A whole mail to or from the slave. */
static inline bool is_mail(const datagram_t *g, bool to_slave)
{
    uint16_t start = to_slave ? out_start(g) : in_start(g);
    return g->command == (to_slave ? ECT_FPWR : ECT_FPRD) && start >= ECT_RAM && g->ado == start && g->length >= 16;
}

/* Defects of AoE and SoE: changes of a reply. */
void defect_ads_value_is_wrong(defect_t *d, datagram_t *g);
void defect_ads_refuses_nothing(defect_t *d, datagram_t *g);
void defect_idn_is_known(defect_t *d, datagram_t *g);
void defect_drive_is_known(defect_t *d, datagram_t *g);
void defect_long_value_is_taken(defect_t *d, datagram_t *g);
void defect_width_is_wrong(defect_t *d, datagram_t *g);
void defect_width_alone_is_wrong(defect_t *d, datagram_t *g);
void defect_pieces_are_not_counted(defect_t *d, datagram_t *g);

#endif
