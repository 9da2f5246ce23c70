/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The bus of a network file (ENI) for twins: the position of each slave in the tree, and a model of the slave for use
 * without its ESI file.
 *
 * Host only. Context: mainline.
 */
#ifndef ECT_ENI_BUS_H
#define ECT_ENI_BUS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "eni/read.h"
#include "esi/read.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** The port to which the input of a slave is connected. */
typedef struct ect_eni_place {
    size_t up;    /**< position of the neighbour towards the master; less than that of the slave */
    uint8_t port; /**< of the neighbour: 1 to 3 for B to D; 0: port B of the previous slave, or the master */
} ect_eni_place_t;

/**
 * Finds the neighbour of a slave towards the master: that of `PreviousPort`, or without this element the previous
 * slave.
 * @param i  less than `slave_count`
 * @param[out] text, room  the error, one line
 * @return false: no preceding slave has `PhysAddr`, or the port is A, which leads to the master
 */
bool ect_eni_place(const ect_eni_t *eni, size_t i, ect_eni_place_t *place, char *text, size_t room);

/** @return true: all transitions of the command lead to or from BOOT, which has its own SyncManagers */
bool ect_eni_is_of_boot(const ect_eni_command_t *command);

/** @return the alias or device id by which the master identifies a slave; 0: none */
uint16_t ect_eni_alias(const ect_eni_slave_t *slave);

/**
 * Makes the model of a slave from the ENI: identity, SyncManagers and PDOs, mailbox and its protocols, clocks, and the
 * objects that start-up commands write. SyncManagers that the ENI does not list follow from the mailbox and from
 * InitCmds that write the registers from 0800h on.
 * @param i  less than `slave_count`
 * @param[out] text, room  the error, one line
 * @return to be freed by ::ect_esi_close; NULL: no memory
 */
ect_esi_t *ect_eni_device(const ect_eni_t *eni, size_t i, char *text, size_t room);

ECT_C_END

#endif
