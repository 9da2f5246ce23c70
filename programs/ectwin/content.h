/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Content of the folders of --store and --files at the power-on of the twins, as a record holds it (docs/REPLAY.md): a
 * run keeps it and logs it, a replay takes it and gives it to the twins. A replay opens neither folder; files for FoE
 * get a private folder, which ::content_free removes.
 */
#ifndef ECTWIN_CONTENT_H
#define ECTWIN_CONTENT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/capture/logged.h"
#include "bus/trace.h"

/** Room of a name, and of the folder of a replay. */
enum { CONTENT_NAME = 160, CONTENT_FOLDER = 256 };

/** Bank 0 or 1 of a twin's memory, or its EEPROM: a piece of the content. */
typedef struct content_piece {
    struct content_piece *next;
    char name[CONTENT_NAME];
    uint8_t *data;
    size_t size;
} content_piece_t;

/** All zero: empty. */
typedef struct content {
    content_piece_t *pieces;
    char folder[CONTENT_FOLDER]; /**< of a replay's files; "": none */
} content_t;

/** Names of pieces. @param slave  from 1 @param[out] name  CONTENT_NAME bytes */
void content_name_memory(char *name, size_t slave, unsigned int bank);
void content_name_eeprom(char *name, size_t slave);

/** Keeps a copy of a piece; zeros at its end are left out. @return false: out of memory */
bool content_keep(content_t *content, const char *name, const uint8_t *data, size_t size);

/** @return the piece of a name; NULL: there is none */
const content_piece_t *content_find(const content_t *content, const char *name);

/**
 * Logs all pieces, and the files of a folder that a master can read by FoE. The trace writes in this thread: call it
 * before ::ect_trace_start.
 * @param files  the folder; NULL: none
 * @return NULL, or why not: one line for the user, constant or in `room` bytes of `text`
 */
const char *content_log(const content_t *content, const char *files, ect_trace_t *trace, char *text, size_t room);

/** Makes the folder of a replay's files. @return NULL, or why not */
const char *content_make_folder(content_t *content);

/** Takes a block of a record. @param room  bytes at logged->text in the file. @return NULL, or why not */
const char *content_take(content_t *content, const ect_logged_t *logged, size_t room);

/**
 * Fills a piece up with zeros.
 * @param[out] data  the piece, `size` bytes, until ::content_free; unchanged if there is none, or a longer one
 * @return false: out of memory
 */
bool content_pad(content_t *content, const char *name, size_t size, const uint8_t **data);

/** Frees the pieces, and removes the folder with its files. */
void content_free(content_t *content);

#endif
