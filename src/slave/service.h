/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The interface of an object service, for the author of a service; devices only name services (seams/services.h).
 *
 * Any member may be NULL: the stack then does not call it. Context: mainline, except for `event`.
 */
#ifndef ECT_SLAVE_SERVICE_H
#define ECT_SLAVE_SERVICE_H

#include "slave/slave.h"

ECT_C_BEGIN

/** A value that a master writes. */
typedef struct ect_download {
    uint16_t index;
    uint8_t subindex;
    bool complete; /**< by Complete Access: one value of a whole object */
    const uint8_t *data;
    uint16_t size;
} ect_download_t;

struct ect_service {
    /** Called at power-on, after the initialisation of the device: adds the service's functions for the device to
     * s->host. */
    void (*start)(ect_slave_t *s);

    /**
     * Called before a value is stored. For a value that arrives in one mail there are two calls: one for its check,
     * and, after the check of the whole object, one before it is stored.
     * @return ECT_OK, or the reason to refuse the value
     */
    ect_reason_t (*write)(ect_slave_t *s, const ect_download_t *d);

    /**
     * Called after a value is stored. For Complete Access there is one call for the whole object, as sub-index 0.
     * @return ECT_OK, or the reason for which a consequence of the write failed
     */
    ect_reason_t (*written)(ect_slave_t *s, uint16_t index, uint8_t subindex, bool complete);

    /** Called when an upward transition has passed the other checks. @return 0, or the AL status code of a refusal */
    uint16_t (*check_up)(ect_slave_t *s, uint8_t target);

    /** Called for events in SAFEOP or OP, by the exchange, so possibly in an interrupt. */
    void (*event)(ect_slave_t *s, uint32_t event);
};

ECT_C_END

#endif
