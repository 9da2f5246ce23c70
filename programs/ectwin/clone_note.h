/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The comment at the head of a cloned slave's file: when and in which state the slave was read, what it has not given,
 * and where its EEPROM and its dictionary disagree.
 */
#ifndef ECTWIN_CLONE_NOTE_H
#define ECTWIN_CLONE_NOTE_H

#include <stdbool.h>

#include "output.h"
#include "reader/reader.h"

struct cJSON;

typedef struct clone_note {
    output_text_t lines;
    struct cJSON *objects; /* values of identity and PDOs, for the comparison */
    struct cJSON *entries; /* of the last one of them */
} clone_note_t;

/** @return false: no memory, which is printed. ::clone_note_free is due in each case */
bool clone_note_begin(const char *who, clone_note_t *note);

/** A request that brought nothing. */
void clone_note_gap(clone_note_t *note, const ect_reader_gap_t *gap);

/** An object, and an entry: its rights when it cannot be read in PREOP. */
void clone_note_object(clone_note_t *note, const ect_reader_object_t *object);
void clone_note_entry(clone_note_t *note, const ect_reader_object_t *object, const ect_reader_entry_t *entry);

/**
 * Compares identity, PDOs and mailbox of the EEPROM with those of the dictionary and of SyncManagers 0 and 1.
 * @param image  as it was read
 * @param prefix  of the lines that are printed to standard error, besides
 */
void clone_note_compare(clone_note_t *note, const uint8_t *image, size_t size, const ect_reader_t *reader,
                        const char *prefix);

/** The time of reading, UTC: that of the machine, or SOURCE_DATE_EPOCH of the environment. */
void clone_note_time(char text[32]);

/**
 * The ESI file with the comment behind its first line.
 * @param head  first lines of the comment
 * @param[out] length  of the result
 * @return for free(); NULL: no memory, which is printed
 */
char *clone_note_join(const char *who, clone_note_t *note, const char *head, const char *file, size_t size,
                      size_t *length);

void clone_note_free(clone_note_t *note);

#endif
