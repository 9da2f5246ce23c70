/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Content of the folders of --store and --files at the power-on of the twins (docs/REPLAY.md): a run writes it to the
 * record; a replay reads it from the record and opens neither folder. Files for FoE are then in a private folder, which
 * ::content_free removes.
 */
#ifndef ECTWIN_CONTENT_H
#define ECTWIN_CONTENT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/capture/logged.h"
#include "bus/trace.h"

/** Sizes of the name of a piece and of the path of a replay's folder, with terminator. */
enum { CONTENT_NAME = 160, CONTENT_FOLDER = 256 };

/** A piece of the content: bank 0 or 1 of a twin's memory, or its EEPROM. */
typedef struct content_piece {
    struct content_piece *next;
    char name[CONTENT_NAME];
    uint8_t *data;
    size_t size;
} content_piece_t;

/** The content. Zeroed: empty. */
typedef struct content {
    content_piece_t *pieces;
    char folder[CONTENT_FOLDER]; /**< private folder for the files of a replay; "": none */
} content_t;

/** Writes the name of a piece. @param slave  from 1 @param[out] name  CONTENT_NAME bytes */
void content_name_memory(char *name, size_t slave, unsigned int bank);
void content_name_eeprom(char *name, size_t slave);

/** Adds a copy of a piece without the zeros at its end. @return false: out of memory */
bool content_keep(content_t *content, const char *name, const uint8_t *data, size_t size);

/** @return the piece with a name; NULL: none */
const content_piece_t *content_find(const content_t *content, const char *name);

/**
 * Writes all pieces, and the files that a master can read by FoE, to a record. Called before ::ect_trace_start, because
 * the trace writes in this thread.
 * @param files  the folder of --files; NULL: none
 * @return NULL, or the reason of a failure: one line for the user, constant or in `room` bytes of `text`
 */
const char *content_log(const content_t *content, const char *files, ect_trace_t *trace, char *text, size_t room);

/** Creates the private folder for the files of a replay. @return NULL, or the reason of a failure */
const char *content_make_folder(content_t *content);

/** Adds a block of a record. @param room  bytes at logged->text in the file @return NULL, or the reason of a failure */
const char *content_take(content_t *content, const ect_logged_t *logged, size_t room);

/**
 * Pads a piece with zeros to `size` bytes.
 * @param[out] data  the piece, valid until ::content_free; unchanged if there is no such piece or it is longer
 * @return false: out of memory
 */
bool content_pad(content_t *content, const char *name, size_t size, const uint8_t **data);

/** Frees the pieces, and removes the folder with its files. */
void content_free(content_t *content);

#endif
