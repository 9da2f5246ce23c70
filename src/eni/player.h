/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Declarations that the files of the player share: play_*.c and play.c (internal.h).
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

/** @return the station address of slave `i`, from 0: that of the file, else one by its position. */
static inline uint16_t eni_station(const ect_eni_slave_t *slave, size_t i)
{
    enum { FIRST = 0x1001 };
    return slave->address != 0 ? slave->address : (uint16_t)(FIRST + i);
}

static inline uint32_t eni_bounded_timeout(uint32_t timeout_ms)
{
    return timeout_ms < ECT_ENI_MAX_TIMEOUT ? timeout_ms : (uint32_t)ECT_ENI_MAX_TIMEOUT;
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

/** A start-up command of a mailbox under way. */
typedef struct eni_talk {
    ect_eni_player_t *p;
    const ect_eni_slave_t *slave;
    size_t number; /**< of the slave, from 1 */
    int line;      /**< of the command */
    uint32_t timeout_ms;
    uint8_t protocol; /**< type of the mail */
    char name[24];    /**< of the command in reports: "8000:1", "SoE drive 0, S-0-0032" */
    bool failed;
} eni_talk_t;

enum { ENI_MAIL_HEADER = 6 };

/**
 * Begins a command with mails of up to `bytes` bytes after the header. @return false: no suitable mailbox, which is
 * reported
 */
bool eni_talk_begin(eni_talk_t *t, ect_eni_player_t *p, size_t slave, size_t bytes);

/** Reports the failure of the command, once. */
void eni_talk_fail(eni_talk_t *t, const char *why);

/** Sends the mail in ect_eni_player_t::mail. @param length  after the header, which this function writes */
void eni_talk_send(eni_talk_t *t, size_t length);

/**
 * Receives the reply to a mail; other mails before it are skipped.
 * @param is_reply  whether a mail of the protocol is the reply
 * @return NULL: none, or a mailbox error, which is reported
 */
const uint8_t *eni_talk_receive(eni_talk_t *t, bool (*is_reply)(const eni_talk_t *t, const uint8_t *mail));

/** Plays a start-up command of AoE or EoE (play_mail.c). */
void eni_play_mail(ect_eni_player_t *p, size_t slave, const ect_eni_mail_t *mail);

/** Plays a start-up command of SoE (play_soe.c). */
void eni_play_soe(ect_eni_player_t *p, size_t slave, const ect_eni_mail_t *mail);

/** Plays a start-up command of CoE (play_coe.c). */
void eni_play_coe(ect_eni_player_t *p, size_t slave, const ect_eni_coe_t *command);

ECT_C_END

#endif
