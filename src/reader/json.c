/* SPDX-License-Identifier: MIT */
#include "reader/internal.h"

typedef struct json {
    FILE *file;
    unsigned int slave;
    bool object, entry; /* an element precedes: a comma or a bracket is due */
} json_t;

static void put_name(FILE *file, ect_reader_bytes_t name)
{
    if (name.data == NULL)
        return;
    fputs(", \"name\": \"", file);
    for (size_t i = 0; i < name.length && name.data[i] != 0; i++) {
        const uint8_t letter = name.data[i];
        if (letter < ' ' || letter > '~' || letter == '"' || letter == '\\')
            fprintf(file, "\\u%04x", letter); /* decoded as ISO 8859-1 */
        else
            fputc(letter, file);
    }
    fputc('"', file);
}

static void put_bytes(FILE *file, const char *name, ect_reader_bytes_t bytes)
{
    if (bytes.data == NULL)
        return;
    fprintf(file, ", \"%s\": \"", name);
    for (size_t i = 0; i < bytes.length; i++)
        fprintf(file, "%02x", bytes.data[i]);
    fputc('"', file);
}

static void begin(void *ctx, bool described)
{
    json_t *j = ctx;
    fprintf(j->file, "{\"slave\": %u, \"described\": %s, \"objects\": [", j->slave, described ? "true" : "false");
}

static void put_object(void *ctx, const ect_reader_object_t *object)
{
    json_t *j = ctx;
    fprintf(j->file, "%s\n  {\"index\": %u", j->object ? "]}," : "", object->index);
    if (object->described)
        fprintf(j->file, ", \"type\": %u, \"code\": %u", object->type, object->code);
    put_name(j->file, object->name);
    fputs(", \"entries\": [", j->file);
    j->object = true;
    j->entry = false;
}

static void put_entry(void *ctx, const ect_reader_object_t *object, const ect_reader_entry_t *entry)
{
    json_t *j = ctx;
    fprintf(j->file, "%s\n    {\"subindex\": %u", j->entry ? "," : "", entry->subindex);
    if (object->described)
        fprintf(j->file, ", \"type\": %u, \"bits\": %u, \"access\": %u", entry->type, entry->bits, entry->access);
    put_bytes(j->file, "unit", entry->unit);
    put_bytes(j->file, "default", entry->preset);
    put_bytes(j->file, "minimum", entry->minimum);
    put_bytes(j->file, "maximum", entry->maximum);
    put_name(j->file, entry->name);
    put_bytes(j->file, "value", entry->value);
    fputc('}', j->file);
    j->entry = true;
}

static ect_reader_sink_t sink_of(json_t *j)
{
    return (ect_reader_sink_t){.ctx = j, .begin = begin, .object = put_object, .entry = put_entry};
}

static ect_reader_result_t end(const json_t *j, ect_reader_result_t result)
{
    fprintf(j->file, "%s\n], \"complete\": %s}\n", j->object ? "]}" : "", result == ECT_READER_OK ? "true" : "false");
    return result;
}

ect_reader_result_t ect_reader_json(ect_reader_t *r, ect_reader_values_t values, FILE *file)
{
    json_t j = {.file = file, .slave = r->config.position + 1u};
    const ect_reader_sink_t sink = sink_of(&j);
    return end(&j, ect_reader_dictionary(r, values, &sink));
}

ect_reader_result_t ect_reader_json_assigned(ect_reader_t *r, uint32_t sms, FILE *file)
{
    json_t j = {.file = file, .slave = r->config.position + 1u};
    const ect_reader_sink_t sink = sink_of(&j);
    return end(&j, ect_reader_assigned(r, sms, &sink));
}
