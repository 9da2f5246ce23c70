/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A wire for the reader of a slave, in virtual time: a chain of twins, and between the chain and the reader a liar that
 * may replace mails, change registers, or lose frames.
 */
#ifndef TESTS_SUPPORT_LIAR_H
#define TESTS_SUPPORT_LIAR_H

#include "reader/reader.h"
#include "support/wire.h"

enum { LIAR_FRAME = 2100, FRAME_NS = 10000 };

/* Ways to treat a mail. */
typedef enum liar_mail {
    LIAR_PASSES,   /* the slave gets the request and replies */
    LIAR_SWALLOWS, /* neither gets anything */
    LIAR_REPLIES,  /* the reader gets liar_t::mail */
} liar_mail_t;

typedef struct liar liar_t;

/* A kind of lie; each function may be NULL. */
typedef struct liar_kind {
    const char *name;
    /* A request to the slave; `r` points to its mailbox header. */
    liar_mail_t (*request)(liar_t *l, const uint8_t *r);
    /* A mail of the slave on its way to the reader, to be changed. */
    void (*reply)(liar_t *l, uint8_t *mail);
    /* After the reader has fetched a mail of the liar. @return whether there is another, in liar_t::mail */
    bool (*next)(liar_t *l);
    /* A returned datagram: `ado`, its data and its working counter. @return false: the frame is lost */
    bool (*datagram)(liar_t *l, uint8_t *d, uint16_t ado, uint8_t *data, uint16_t length, uint8_t *wkc);
} liar_kind_t;

struct liar {
    wire_t w;
    const liar_kind_t *kind; /* NULL: no lies */
    ect_reader_link_t link;
    uint8_t reply[LIAR_FRAME];
    size_t reply_length; /* 0: no frame is on its way */
    uint16_t out_start, in_start, in_size;
    uint8_t mail[1600];
    uint16_t mail_length; /* mailbox header included */
    bool has_mail;
    uint8_t counter;
    unsigned int frames, mails, fetched; /* until now */
    uint64_t number;                     /* for the kind */
};

/* A twin of a device behind a liar. */
void liar_open(liar_t *l, const ect_device_t *device, const liar_kind_t *kind);
/* Chain that is there already in l->w. */
void liar_attach(liar_t *l, const liar_kind_t *kind);
void liar_close(liar_t *l);

/* Sets liar_t::mail: a mail of a type with the next counter. */
void liar_set_mail(liar_t *l, uint8_t type, const void *data, size_t length);
/* A CoE message: service and the bytes behind the CoE header. */
void liar_set_coe_mail(liar_t *l, uint8_t service, const void *data, size_t length);

#endif
