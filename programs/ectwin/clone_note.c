/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "clone_note.h"

#include <cjson/cJSON.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "facts/facts.h"
#include "od/od.h"
#include "od/pdo.h"
#include "text/number.h"
#include "wire/bytes.h"
#include "wire/registers.h"
#include "wire/sii.h"

enum { IDENTITY = 0x1018, ASSIGNMENTS = 32, HEX = 16 };
#define LAST_SECOND UINT64_C(253402300799) /* the last second of the year 9999 */

bool clone_note_begin(const char *who, clone_note_t *note)
{
    *note = (clone_note_t){.objects = cJSON_CreateArray()};
    return output_open(who, &note->lines) != NULL;
}

void clone_note_free(clone_note_t *note)
{
    if (note->lines.file)
        (void)fclose(note->lines.file);
    free(note->lines.text);
    cJSON_Delete(note->objects);
    *note = (clone_note_t){0};
}

/* --- requests without a value ------------------------------------------------------------------------------------- */

static void print_reason(FILE *file, const ect_reader_gap_t *gap)
{
    static const char *const reasons[] = {
        [ECT_READER_SILENT] = "no reply",           [ECT_READER_WRONG] = "a wrong reply",
        [ECT_READER_TOO_LONG] = "too long",         [ECT_READER_LOST] = "no frame came back",
        [ECT_READER_STOPPED] = "not read any more", [ECT_READER_DECLINED] = "not read"};
    if (gap->result == ECT_READER_ABORTED && gap->code == 0)
        fprintf(file, "refused without an abort code\n");
    else if (gap->result == ECT_READER_ABORTED)
        fprintf(file, "abort code 0x%08X\n", (unsigned int)gap->code);
    else if (gap->result == ECT_READER_REFUSED)
        fprintf(file, "mailbox error 0x%04X\n", (unsigned int)gap->code);
    else
        fprintf(file, "%s\n", reasons[gap->result] ? reasons[gap->result] : "not read");
}

void clone_note_gap(clone_note_t *note, const ect_reader_gap_t *gap)
{
    FILE *file = note->lines.file;
    if (gap->whole)
        fprintf(file, "%04X: no description: ", gap->index);
    else
        fprintf(file, "%04X:%02X: no %s: ", gap->index, gap->subindex, gap->value ? "value" : "description");
    print_reason(file, gap);
}

/* --- values for the comparison ------------------------------------------------------------------------------------ */

static bool is_compared(uint16_t index)
{
    return index == IDENTITY || ect_od_is_rxpdo(index) || ect_od_is_txpdo(index) ||
           (index >= ECT_OD_ASSIGNMENT && index < ECT_OD_ASSIGNMENT + ASSIGNMENTS);
}

void clone_note_object(clone_note_t *note, const ect_reader_object_t *object)
{
    note->entries = NULL;
    if (!is_compared(object->index))
        return;
    cJSON *one = cJSON_CreateObject();
    (void)cJSON_AddNumberToObject(one, "index", object->index);
    note->entries = cJSON_AddArrayToObject(one, "entries");
    (void)cJSON_AddItemToArray(note->objects, one);
}

static void keep_value(const clone_note_t *note, const ect_reader_entry_t *entry)
{
    char hex[HEX + 1] = "";
    cJSON *one = cJSON_CreateObject();
    for (size_t i = 0; i < entry->value.length && i < HEX / 2; i++)
        snprintf(hex + 2 * i, 3, "%02x", entry->value.data[i]);
    (void)cJSON_AddNumberToObject(one, "subindex", entry->subindex);
    (void)cJSON_AddStringToObject(one, "value", hex);
    (void)cJSON_AddItemToArray(note->entries, one);
}

void clone_note_entry(clone_note_t *note, const ect_reader_object_t *object, const ect_reader_entry_t *entry)
{
    if (note->entries && entry->value.data)
        keep_value(note, entry);
    if (object->described && (entry->access & ECT_ACCESS_R_PREOP) == 0)
        fprintf(note->lines.file, "%04X:%02X: no value: access 0x%04X, %s\n", object->index, entry->subindex,
                entry->access, (entry->access & ECT_ACCESS_RO) == 0 ? "not readable" : "not readable in PREOP");
}

/* --- disagreements ------------------------------------------------------------------------------------------------ */

static void add_dictionary(ect_facts_t *facts, const clone_note_t *note)
{
    cJSON *dictionary = cJSON_CreateObject();
    (void)cJSON_AddItemReferenceToObject(dictionary, "objects", note->objects);
    (void)ect_facts_of_objects(facts, dictionary);
    cJSON_Delete(dictionary);
}

/* Adds the mailbox only if a master has set it: in a slave started by the reader they come from the EEPROM. */
static void add_mailbox(ect_facts_t *facts, const ect_reader_t *r)
{
    const uint8_t *in = r->found_sms + ECT_SM_SIZE;
    if (r->brought_up || (r->found_sms[ECT_SM_ACTIVATE] & ECT_SM_ACTIVATE_ENABLE) == 0 ||
        (in[ECT_SM_ACTIVATE] & ECT_SM_ACTIVATE_ENABLE) == 0)
        return;
    ect_facts_add_mailbox(facts, ECT_FACT_MAILBOX_OUT, ect_load_le16(r->found_sms + ECT_SM_START),
                          ect_load_le16(r->found_sms + ECT_SM_LENGTH));
    ect_facts_add_mailbox(facts, ECT_FACT_MAILBOX_IN, ect_load_le16(in + ECT_SM_START),
                          ect_load_le16(in + ECT_SM_LENGTH));
}

static void print_lines(clone_note_t *note, const char *prefix, char *lines)
{
    char *rest = lines;
    for (const char *line; (line = strsep(&rest, "\n")) != NULL && *line != '\0';) {
        fprintf(note->lines.file, "%s\n", line);
        fprintf(stderr, "%s%s\n", prefix, line);
    }
}

static void print_found_mail(clone_note_t *note, const ect_reader_t *reader)
{
    if (reader->found_size == 0)
        return;
    fprintf(note->lines.file, "SyncManager 1 had a mail of another master:");
    for (unsigned int i = 0; i < reader->found_size; i++)
        fprintf(note->lines.file, " %02X", reader->found_mail[i]);
    fprintf(note->lines.file, "\n");
}

void clone_note_compare(clone_note_t *note, const uint8_t *image, size_t size, const ect_reader_t *reader,
                        const char *prefix)
{
    output_text_t found = {0};
    ect_facts_t eeprom = {.source = "EEPROM"}, known = {.source = "EEPROM"}, dictionary = {.source = "dictionary"};
    ect_facts_t sms = {.source = "SyncManagers"};
    if (!output_open(prefix, &found))
        return;
    print_found_mail(note, reader);
    ect_facts_of_sii(&eeprom, image, size);
    ect_facts_take(&known, &eeprom, ECT_FACT_VENDOR, ECT_FACT_REVISION);
    ect_facts_take(&known, &eeprom, ECT_FACT_MAILBOX_OUT, ECT_FACT_MAILBOX_IN);
    ect_facts_take(&known, &eeprom, ECT_FACT_PDO, ECT_FACT_PDO_ENTRY);
    add_dictionary(&dictionary, note);
    add_mailbox(&sms, reader);
    (void)ect_facts_compare(&known, &dictionary, found.file);
    (void)ect_facts_compare(&known, &sms, found.file);
    if (fclose(found.file) == 0)
        print_lines(note, prefix, found.text);
    free(found.text);
    ect_facts_free(&known);
    ect_facts_free(&eeprom);
    ect_facts_free(&dictionary);
    ect_facts_free(&sms);
}

/* --- the comment -------------------------------------------------------------------------------------------------- */

void clone_note_time(char text[32])
{
    const char *epoch = getenv("SOURCE_DATE_EPOCH"); /* reproducible files */
    uint64_t seconds = 0;
    struct tm parts;
    if (!epoch || !ect_number(epoch, 0, LAST_SECOND, &seconds))
        seconds = (uint64_t)time(NULL);
    const time_t at = (time_t)seconds;
    if (!gmtime_r(&at, &parts) || strftime(text, 32, "%Y-%m-%d %H:%M:%S UTC", &parts) == 0)
        text[0] = '\0';
}

/* An XML comment must not contain "--", and XML no control characters. */
static void put_text(FILE *file, const char *text)
{
    for (char last = '\n'; *text; last = *text++) {
        if (last == '-' && *text == '-')
            fputc(' ', file);
        if (last == '\n')
            fputs("  ", file);
        fputc(*text == '\n' || (*text >= ' ' && *text <= '~') ? *text : '?', file);
    }
}

char *clone_note_join(const char *who, clone_note_t *note, const char *head, const char *file, size_t size,
                      size_t *length)
{
    output_text_t whole = {0};
    const char *end = memchr(file, '\n', size);
    const size_t first = end ? (size_t)(end - file) + 1 : 0;
    if (fflush(note->lines.file) != 0 || !output_open(who, &whole))
        return NULL;
    (void)fwrite(file, first, 1, whole.file);
    fputs("<!--\n", whole.file);
    put_text(whole.file, head);
    put_text(whole.file, note->lines.text);
    fputs("-->\n", whole.file);
    (void)fwrite(file + first, size - first, 1, whole.file);
    if (fclose(whole.file) != 0) {
        free(whole.text);
        return NULL;
    }
    *length = whole.size;
    return whole.text;
}
