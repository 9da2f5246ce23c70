/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Reads network files (ENI), as TwinCAT, EC-Engineer and other configurators export them for a master.
 *
 * Elements that the model lacks are skipped. Only the file itself is opened, see esi/xml.h. An error is one line
 * `FILE:LINE: ERROR`. Context: mainline, host only.
 */
#ifndef ECT_ENI_READ_H
#define ECT_ENI_READ_H

#include "eni/model.h"
#include "wire/linkage.h"

/** Limits. */
enum {
    ECT_ENI_SLAVES = 65535, /**< of a network */
    ECT_ENI_DATA = 1486,    /**< bytes of a datagram */
};

ECT_C_BEGIN

/** An open file; owns all memory of its model. */
typedef struct ect_eni ect_eni_t;

/**
 * Opens a file.
 * @param path  a regular file of at most 64 MiB
 * @param[out] text, room  the error, one line
 * @return the file, or NULL: missing, too large, no XML, a document type definition, no ENI, without a slave, or with
 *         an invalid element
 */
ect_eni_t *ect_eni_open(const char *path, char *text, size_t room);

/**
 * Reads a file from memory, as ::ect_eni_open from a path.
 * @param name  prefix of messages
 * @param data, length  need not outlive the call
 */
ect_eni_t *ect_eni_parse(const char *name, const void *data, size_t length, char *text, size_t room);

/** @return the prefix of messages: the path, or `name` of ::ect_eni_parse */
const char *ect_eni_file(const ect_eni_t *eni);

/** @return the network, with at least one slave */
const ect_eni_network_t *ect_eni_network(const ect_eni_t *eni);

/** Frees the file and its model. NULL: no effect */
void ect_eni_close(ect_eni_t *eni);

ECT_C_END

#endif
