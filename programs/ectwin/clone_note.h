/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The comment at the head of a cloned slave's file: time and AL state of the reading, failed requests, and
 * disagreements of EEPROM and dictionary.
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
    struct cJSON *entries; /* entries of the last object */
} clone_note_t;

/** Begins a comment, to be freed with ::clone_note_free even after a failure. @return false: no memory, printed */
bool clone_note_begin(const char *who, clone_note_t *note);

/** Adds a request without a value. */
void clone_note_gap(clone_note_t *note, const ect_reader_gap_t *gap);

/** Add an object, and an entry; an entry that cannot be read in PREOP gets a line with its access rights. */
void clone_note_object(clone_note_t *note, const ect_reader_object_t *object);
void clone_note_entry(clone_note_t *note, const ect_reader_object_t *object, const ect_reader_entry_t *entry);

/**
 * Compares identity, PDOs and mailbox of the EEPROM with those of the dictionary and of SyncManagers 0 and 1.
 * @param image  the image as read from the slave
 * @param prefix  of each line on standard error, where the disagreements are printed too
 */
void clone_note_compare(clone_note_t *note, const uint8_t *image, size_t size, const ect_reader_t *reader,
                        const char *prefix);

/** Writes the time of the reading in UTC: $SOURCE_DATE_EPOCH, or else the present time. */
void clone_note_time(char text[32]);

/**
 * Inserts the comment after the first line of an ESI file.
 * @param head  first lines of the comment
 * @param[out] length  of the result
 * @return the file, to be freed with free(); NULL: out of memory, which is printed
 */
char *clone_note_join(const char *who, clone_note_t *note, const char *head, const char *file, size_t size,
                      size_t *length);

void clone_note_free(clone_note_t *note);

#endif
