/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Declarations that the files of eni/ share. No other room includes this header.
 *
 * From the lowest to the highest; each file uses only files above it in this list (tests/check/order.py):
 *
 *   read_command.c  datagrams and mails
 *   read_slave.c    a slave
 *   read.c          a file
 *   bus.c           the tree
 *   device.c        the device model of a slave
 *   check.c         contradictions
 *   play_wire.c     datagrams, cyclic frames
 *   play_mail.c     mails of AoE and EoE
 *   play_coe.c      SDO transfers
 *   play_soe.c      IDNs of drives
 *   play.c          transitions
 *   write_slave.c   a slave
 *   write.c         a file
 */
#ifndef ECT_ENI_INTERNAL_H
#define ECT_ENI_INTERNAL_H

#include <libxml/tree.h>

#include "eni/read.h"
#include "esi/xml.h"
#include "wire/assert.h"

/** Reads the `<Transition>`s of a command. */
unsigned int ect_eni_transitions(ect_esi_xml_t *xml, const xmlNode *node);

/** Reads one InitCmd of master or slave, or a cyclic command. */
void ect_eni_read_command(ect_esi_xml_t *xml, const xmlNode *node, ect_eni_command_t *command);

/** Reads each `<InitCmd>` of `<InitCmds>` below an element. @param[out] count  number of commands */
const ect_eni_command_t *ect_eni_read_inits(ect_esi_xml_t *xml, const xmlNode *parent, size_t *count);

/** Reads one InitCmd of CoE. */
void ect_eni_read_coe(ect_esi_xml_t *xml, const xmlNode *node, ect_eni_coe_t *command);

/** Reads one InitCmd of AoE, EoE, FoE or SoE; `mail` has its protocol. @return false: without a mail of the protocol */
bool ect_eni_read_mail(ect_esi_xml_t *xml, const xmlNode *node, ect_eni_mail_t *mail);

/** Reads a `<Slave>`. */
void ect_eni_read_slave(ect_esi_xml_t *xml, const xmlNode *node, ect_eni_slave_t *slave);

#endif
