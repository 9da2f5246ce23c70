/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Declarations that the files of the writer share: write_slave.c (a slave) and write.c (the network around it).
 */
#ifndef ECT_ENI_WRITE_SLAVE_H
#define ECT_ENI_WRITE_SLAVE_H

#include "eni/part.h"
#include "esi/xml_writer.h"

ECT_C_BEGIN

enum {
    ENI_LOGICAL_OUTPUTS = 0x00010000,
    ENI_LOGICAL_INPUTS = 0x01000000,
    ENI_LOGICAL_STATES = 0x09000000, /* as of other tools: a bit each mailbox */
    ENI_FIRST_STATION = 1001,
};

/** The part of a slave in the process image and in the network. */
typedef struct eni_share {
    uint32_t offsets[2]; /**< bytes of the outputs and the inputs of the slaves before */
    int state_bit;       /**< of its mailbox in the logical memory, -1: none */
    uint32_t cycle_us;
    bool reference; /**< its clock is the reference clock */
} eni_share_t;

/** An InitCmd with a physical address. */
typedef struct eni_init {
    const char *transition, *comment;
    uint8_t command;
    uint16_t adp, ado;
    const uint8_t *data; /**< NULL: `length` bytes to read */
    size_t length;
    size_t counter;
    bool uncounted; /**< no `Cnt` */
    bool before_slave;
    const uint8_t *expected; /**< `length` bytes, NULL: no Validate */
    const uint8_t *mask;     /**< `length` bytes, NULL: all bits */
    uint32_t timeout_ms;     /**< of the Validate */
} eni_init_t;

void eni_write_init(ect_xml_writer_t *xml, const eni_init_t *init);

/** @return bytes of process data in one direction */
uint32_t eni_bytes(const ect_device_t *device, bool inputs);

/** @return whether an FMMU of the slave is free for the state of its mailbox */
bool eni_has_state(const ect_device_t *device);

/** Writes `<Slave>`. */
void eni_write_slave(ect_xml_writer_t *xml, const ect_eni_part_t *parts, size_t i, const eni_share_t *share);

/** Writes a `<Variable>` for each entry of the assigned PDOs. @param offset  of the slave's data in the image, bytes */
void eni_write_variables(ect_xml_writer_t *xml, const ect_device_t *device, size_t i, bool inputs, uint32_t offset);

ECT_C_END

#endif
