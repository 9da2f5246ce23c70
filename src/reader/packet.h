/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The connection of a reader over a network interface.
 */
#ifndef ECT_READER_PACKET_H
#define ECT_READER_PACKET_H

#include "bus/net/packet.h"
#include "reader/reader.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** @param port  open; must outlive the link, which uses it exclusively @return a connection over the port */
ect_reader_link_t ect_reader_packet_link(ect_packet_t *port);

ECT_C_END

#endif
