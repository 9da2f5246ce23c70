/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The bus that an ENI describes, as twins need it: the place of each slave in the tree, and the slave itself as the
 * model of a device, for where its ESI file is not at hand.
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

/** The port that the input of a slave is connected to. */
typedef struct ect_eni_place {
    size_t up;    /**< position of the slave towards the master; less than its own */
    uint8_t port; /**< of that slave: 1 to 3 for B to D; 0: port B of the slave before, or the master */
} ect_eni_place_t;

/**
 * Finds the neighbour of a slave towards the master: `PreviousPort`, without one the slave before.
 * @param i  less than `slave_count`
 * @param[out] text, room  the error, one line
 * @return false: `PhysAddr` is of no slave before it, or the port is A, which leads to the master
 */
bool ect_eni_place(const ect_eni_t *eni, size_t i, ect_eni_place_t *place, char *text, size_t room);

/** @return true: a command of no transition but those to and from BOOT, whose SyncManagers are others */
bool ect_eni_is_of_boot(const ect_eni_command_t *command);

/** @return the alias or device id by which the master identifies a slave; 0: none */
uint16_t ect_eni_alias(const ect_eni_slave_t *slave);

/**
 * Makes the model of a slave from what the ENI has of it: identity, SyncManagers and PDOs, mailbox and its protocols,
 * clocks, and the objects that its start-up commands write. SyncManagers that are not listed follow from the mailbox
 * and from the writes of the InitCmds to the registers at 0800h.
 * @param i  less than `slave_count`
 * @param[out] text, room  the error, one line
 * @return to be freed by ::ect_esi_close; NULL: no memory
 */
ect_esi_t *ect_eni_device(const ect_eni_t *eni, size_t i, char *text, size_t room);

ECT_C_END

#endif
