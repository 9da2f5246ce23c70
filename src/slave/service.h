/* SPDX-License-Identifier: MIT */
/**
 * @file
 * An object service, as those see it who write one; devices only name them (seams/services.h).
 *
 * Every member may be NULL: there is nothing to do then. Context: mainline, but for `event`.
 */
#ifndef ECT_SLAVE_SERVICE_H
#define ECT_SLAVE_SERVICE_H

#include "slave/slave.h"

ECT_C_BEGIN

/** A value that a master writes. */
typedef struct ect_download {
    uint16_t index;
    uint8_t subindex;
    bool complete; /**< by Complete Access: one of the values of a whole object */
    const uint8_t *data;
    uint16_t size;
} ect_download_t;

struct ect_service {
    /** Power-on, after the device was initialised. What the service offers the device it puts into s->host. */
    void (*start)(ect_slave_t *s);

    /**
     * A value is about to be stored. One that came in one mail comes twice: to be checked, and once all of the object
     * is, to be stored.
     * @return ECT_OK, or the reason to refuse it
     */
    ect_reason_t (*write)(ect_slave_t *s, const ect_download_t *d);

    /**
     * It is stored; a whole object by Complete Access: once, as sub-index 0.
     * @return ECT_OK, or a reason that tells the master that what had to follow from it failed
     */
    ect_reason_t (*written)(ect_slave_t *s, uint16_t index, uint8_t subindex, bool complete);

    /** A transition upwards has passed the other checks. @return 0, or the AL status code that refuses it */
    uint16_t (*check_up)(ect_slave_t *s, uint8_t target);

    /** Events have come in SAFEOP or OP. Part of the exchange: perhaps in an interrupt. */
    void (*event)(ect_slave_t *s, uint32_t event);
};

ECT_C_END

#endif
