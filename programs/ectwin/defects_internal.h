/* SPDX-License-Identifier: MIT */
/** @file A row of the tables of defects. */
#ifndef ECTWIN_DEFECTS_INTERNAL_H
#define ECTWIN_DEFECTS_INTERNAL_H

#include "defect_datagram.h"

enum {
    SM_0 = ECT_REG_SM,
    SM_1 = ECT_REG_SM + ECT_SM_SIZE,
    SM_2 = SM_1 + ECT_SM_SIZE,
    SM_3 = SM_2 + ECT_SM_SIZE,
    SMS = 16
};

typedef enum kind {
    ANSWER,   /* changes data of the reply */
    REQUEST,  /* changes data of the request */
    COUNT,    /* changes the working counter */
    SWALLOW,  /* the datagram does not reach the chip, but its working counter is incremented */
    MAIL,     /* changes a mail of the slave */
    SII_WORD, /* changes a word read from the EEPROM */
    CATEGORY, /* changes a byte of a category of the EEPROM */
    CUSTOM,
} kind_t;

/* A change of the bits of `mask` in a value. */
typedef struct change {
    enum { IF_EXPECTED, ALWAYS, INVERTED } how; /* IF_EXPECTED: only if the bits are `was` */
    uint8_t width;
    uint32_t mask, was, becomes;
} change_t;

struct defect_row {
    const char *id, *what;
    kind_t kind;
    uint8_t command;  /* of the datagram; MAIL: SDO command, 0: any */
    uint16_t address; /* within the datagram; MAIL: index; SII_WORD: word; CATEGORY: type */
    uint16_t length;  /* of the datagram; MAIL: sub-index; CATEGORY: offset */
    uint8_t state;    /* AL status of the slave, error flag included; 0: any */
    uint8_t at;       /* MAIL: offset of the value in the mail */
    change_t change;
    void (*before)(defect_t *d, datagram_t *g);
    void (*after)(defect_t *d, datagram_t *g);
};

#define ALL(w)        (0xFFFFFFFFu >> (32 - 8 * (w)))
#define ANY(w, b)     {.how = ALWAYS, .width = (w), .mask = ALL(w), .becomes = (b)}
#define FROM(w, a, b) {.how = IF_EXPECTED, .width = (w), .mask = ALL(w), .was = (a), .becomes = (b)}
#define BITS(m, a, b) {.how = IF_EXPECTED, .width = 1, .mask = (m), .was = (a), .becomes = (b)}
#define CLEARED(m)    {.how = ALWAYS, .width = 1, .mask = (m), .becomes = 0}
#define FLIPPED(m)    {.how = INVERTED, .width = 1, .mask = (m)}

#define AL_CODE(a, b)                                                                                                  \
    .kind = ANSWER, .command = ECT_FPRD, .address = ECT_REG_AL_STATUS_CODE, .length = 6, .change = FROM(2, a, b)
#define SDO(i, s, o) .kind = MAIL, .address = (i), .length = (s), .at = (o)

/* Defects of CiA 402 drives (defects_drive.c). */
extern const defect_row_t defect_drive_rows[];
extern const size_t defect_drive_count;

#endif
