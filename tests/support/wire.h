/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A raw master for tests: datagrams into a chain of twins, in virtual time. No socket, no clock, no thread.
 *
 * After each frame the slaves are polled, unless `manual_poll` is set. Station addresses are 0x1001 + position.
 */
#ifndef TESTS_SUPPORT_WIRE_H
#define TESTS_SUPPORT_WIRE_H

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "bus/chain/chain.h"
#include "wire/bytes.h"
#include "wire/registers.h"

enum { NOP = 0, APRD, APWR, APRW, FPRD, FPWR, FPRW, BRD, BWR, BRW, LRD, LWR, LRW, ARMW, FRMW };
enum { WIRE_STATION = 0x1001, NO_REPLY = -1 };

#define MS 1000000ull

typedef struct wire {
    ect_chain_t *chain;
    uint64_t now_ns;
    bool manual_poll;
    uint8_t frame[2100]; /* the last frame, as it came back */
    size_t frame_length;
    uint8_t mail_counter;
    void (*poll)(struct wire *w); /* replaces the poll of the chain's own slaves; NULL: those are polled */
} wire_t;

/* A chain of twins, addresses assigned, clock at 1 s. */
void wire_open_twins(wire_t *w, const ect_twin_config_t *twins, size_t count);
/* The same again, after a power cycle. */
void wire_assign_stations(wire_t *w);
/* A chain of the given twins. */
void wire_open(wire_t *w, const ect_device_t *const *devices, size_t count);
void wire_open_one(wire_t *w, const ect_device_t *device);
void wire_close(wire_t *w);

/* Builds a frame of one datagram in w->frame. */
void wire_build(wire_t *w, uint8_t command, uint16_t adp, uint16_t ado, const void *data, uint16_t length);
/* Adds a datagram to the frame that was built. */
void wire_append(wire_t *w, uint8_t command, uint16_t adp, uint16_t ado, const void *data, uint16_t length);
/* Sends w->frame. @return whether it came back */
bool wire_transmit(wire_t *w);
/* Start of datagram n (from 0) of w->frame. */
uint8_t *wire_datagram(wire_t *w, unsigned int n);
uint16_t wire_wkc(wire_t *w, unsigned int n);

/* Sends one datagram and receives it; the slaves change `data`. @return working counter, or NO_REPLY */
int wire_send(wire_t *w, uint8_t command, uint16_t adp, uint16_t ado, void *data, uint16_t length);
int wire_logical(wire_t *w, uint8_t command, uint32_t address, void *data, uint16_t length);
/* To the slave at `position`. */
int wire_read(wire_t *w, size_t position, uint16_t ado, void *data, uint16_t length);
int wire_write(wire_t *w, size_t position, uint16_t ado, const void *data, uint16_t length);
int wire_write8(wire_t *w, size_t position, uint16_t ado, uint8_t value);
int wire_write16(wire_t *w, size_t position, uint16_t ado, uint16_t value);
uint8_t wire_read8(wire_t *w, size_t position, uint16_t ado);
uint16_t wire_read16(wire_t *w, size_t position, uint16_t ado);

void wire_poll(wire_t *w);
/* Lets time pass, polling at every deadline on the way. */
void wire_advance(wire_t *w, uint64_t ns);

/* Writes an SM's configuration registers and enables it (length 0: disables). */
void wire_set_sm(wire_t *w, size_t position, unsigned int sm, uint16_t start, uint16_t length, uint8_t control);
/* All SMs as described. */
void wire_configure_mailbox(wire_t *w, size_t position);
void wire_configure_process_data(wire_t *w, size_t position);
void wire_set_fmmu(wire_t *w, size_t position, unsigned int n, uint32_t logical, uint16_t length, uint8_t start_bit,
                   uint8_t stop_bit, uint16_t physical, uint8_t physical_bit, uint8_t type);

/* Writes AL control and returns AL status (low byte); *code, if not NULL, becomes the AL status code. */
uint8_t wire_al(wire_t *w, size_t position, uint16_t request, uint16_t *code);
/* Enters a state step by step, with outputs sent on the way to OP; asserts that it is reached. */
void wire_go(wire_t *w, size_t position, uint8_t state);

/* Writes all outputs of a device, each byte the same. @return 1: it took them all; also for a device without outputs */
int wire_outputs(wire_t *w, size_t position, uint8_t value);

/* Mailbox: `mail` is a whole mail with header, which contains the length of the service data. */
int wire_mail_send(wire_t *w, size_t position, const uint8_t *mail, uint16_t length);
/* Sends a request with the next counter; `data` starts behind the mailbox header. @return as wire_mail_send */
int wire_mail_request(wire_t *w, size_t position, uint8_t type, const uint8_t *data, uint16_t length);
/* @return service data length of the mail fetched (without the header), or -1 when the mailbox is empty */
int wire_mail_receive(wire_t *w, size_t position, uint8_t *mail, uint16_t room);
/* Sends a CoE request and receives the next mail. `payload` starts at the CoE header. @return as wire_mail_receive */
int wire_coe(wire_t *w, size_t position, const uint8_t *payload, uint16_t length, uint8_t *reply, uint16_t room);
/* A whole SDO transfer; @return 0 or the abort code. *size: room in, bytes out. */
uint32_t wire_sdo_upload(wire_t *w, size_t position, uint16_t index, uint8_t subindex, bool complete, void *data,
                         size_t *size);
uint32_t wire_sdo_download(wire_t *w, size_t position, uint16_t index, uint8_t subindex, bool complete,
                           const void *data, size_t size);

/* The description of the device at `position`. */
const ect_device_t *wire_device(wire_t *w, size_t position);

#endif
