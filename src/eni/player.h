/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Declarations that the files of the player share: play_wire.c (datagrams, cyclic frames), play_mail.c (SDO transfers),
 * play.c (transitions).
 */
#ifndef ECT_ENI_PLAYER_H
#define ECT_ENI_PLAYER_H

#include "eni/play.h"
#include "wire/assert.h"

ECT_C_BEGIN

/** A datagram to send. */
typedef struct eni_datagram {
    uint8_t command;
    uint16_t length;
    uint32_t address; /**< logical; or ADP, and ADO in the upper half */
    const uint8_t *data;
} eni_datagram_t;

/** A frame under construction. */
typedef struct eni_frame {
    uint8_t *bytes; /**< ::ECT_ENI_FRAME */
    size_t length;
    size_t last; /**< offset of the last datagram, 0: none */
} eni_frame_t;

static inline eni_datagram_t eni_datagram_of(const ect_eni_command_t *command)
{
    const uint32_t physical = command->adp | (uint32_t)command->ado << 16;
    return (eni_datagram_t){.command = command->command,
                            .length = (uint16_t)command->data.length,
                            .address = command->address != 0 ? command->address : physical,
                            .data = command->data.bytes};
}

/** Station address of slave `i`, from 0: that of the file, else one by its position. */
static inline uint16_t eni_station(const ect_eni_slave_t *slave, size_t i)
{
    enum { FIRST = 0x1001 };
    return slave->address != 0 ? slave->address : (uint16_t)(FIRST + i);
}

static inline uint32_t eni_bounded_timeout(uint32_t timeout_ms)
{
    return timeout_ms < ECT_ENI_MAX_TIMEOUT ? timeout_ms : ECT_ENI_MAX_TIMEOUT;
}

/** Reports a reply that differs from the expectation of line `line` of the file. */
__attribute__((format(printf, 3, 4))) void eni_report(ect_eni_player_t *p, int line, const char *format, ...);

void eni_frame_begin(eni_frame_t *f);
/** @return offset of the datagram's data */
size_t eni_frame_add(eni_frame_t *f, uint8_t index, const eni_datagram_t *datagram);
bool eni_frame_exchange(ect_eni_player_t *p, eni_frame_t *f);

/** Sends one datagram. @param[out] reply  data of the reply @return the working counter, -1: no reply */
int eni_exchange(ect_eni_player_t *p, const eni_datagram_t *datagram, const uint8_t **reply);

/** Waits a millisecond and sends the cyclic frames of the present state that are due. */
void eni_wait(ect_eni_player_t *p);

/** Plays a start-up command of CoE (play_mail.c). */
void eni_play_coe(ect_eni_player_t *p, size_t slave, const ect_eni_coe_t *command);

ECT_C_END

#endif
