/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "yaml/document.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* --- files -------------------------------------------------------------------------------------------------------- */

char *ect_yaml_load(const char *path, size_t most, size_t *length, char *text, size_t room)
{
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK); /* an open() of a pipe must not block */
    struct stat status;
    char *data = NULL;
    ssize_t got = -1;
    if (fd < 0 || fstat(fd, &status) != 0) {
        (void)snprintf(text, room, "%s: %s", path, strerror(errno));
    } else if (!S_ISREG(status.st_mode) || status.st_size > (off_t)most) {
        (void)snprintf(text, room, "%s: not a file of at most %zu bytes", path, most);
    } else {
        data = malloc(most);
        got = data ? read(fd, data, most) : -1;
        if (got < 0)
            (void)snprintf(text, room, "%s: %s", path, strerror(errno));
    }
    if (fd >= 0)
        (void)close(fd);
    if (got >= 0) {
        *length = (size_t)got;
        return data;
    }
    free(data);
    return NULL;
}

/* --- mistakes ----------------------------------------------------------------------------------------------------- */

size_t ect_yaml_line(const yaml_node_t *node)
{
    return node ? node->start_mark.line + 1 : 1;
}

void ect_yaml_fail(ect_yaml_t *yaml, const yaml_node_t *node, const char *format, ...)
{
    va_list values;
    va_start(values, format);
    ect_mistake_of(yaml->mistake, ect_yaml_line(node), format, values);
    va_end(values);
}

static void fail_parser(ect_mistake_t *mistake, const yaml_parser_t *parser)
{
    ect_mistake(mistake, parser->problem_mark.line + 1, "no YAML: %s",
                parser->problem ? parser->problem : "no memory left");
}

/* --- the document ------------------------------------------------------------------------------------------------- */

/* Events by which a small file could expand to a large document. */
static const char *refused(const yaml_event_t *event)
{
    switch (event->type) {
    case YAML_ALIAS_EVENT:
        return "an alias";
    case YAML_SCALAR_EVENT:
        return event->data.scalar.anchor ? "an anchor" : event->data.scalar.tag ? "a tag" : NULL;
    case YAML_SEQUENCE_START_EVENT:
        return event->data.sequence_start.anchor ? "an anchor" : event->data.sequence_start.tag ? "a tag" : NULL;
    case YAML_MAPPING_START_EVENT:
        return event->data.mapping_start.anchor ? "an anchor" : event->data.mapping_start.tag ? "a tag" : NULL;
    default:
        return NULL;
    }
}

/* Checks the events of the entire file. */
static void check_events(ect_yaml_t *yaml, const void *data, size_t length)
{
    yaml_parser_t parser;
    yaml_event_t event;
    unsigned int documents = 0, depth = 0;
    bool ended = false;
    if (yaml_parser_initialize(&parser) == 0) {
        ect_yaml_fail(yaml, NULL, "no memory left");
        return;
    }
    yaml_parser_set_input_string(&parser, data, length);
    while (!ended && !yaml->mistake->failed) {
        if (yaml_parser_parse(&parser, &event) == 0) {
            fail_parser(yaml->mistake, &parser);
            break;
        }
        const char *what = refused(&event);
        const yaml_node_t at = {.start_mark = event.start_mark};
        if (what)
            ect_yaml_fail(yaml, &at, "%s of YAML: %ss have none", what, yaml->kind);
        documents += event.type == YAML_DOCUMENT_START_EVENT;
        depth += event.type == YAML_SEQUENCE_START_EVENT || event.type == YAML_MAPPING_START_EVENT;
        depth -= event.type == YAML_SEQUENCE_END_EVENT || event.type == YAML_MAPPING_END_EVENT;
        if (documents > 1)
            ect_yaml_fail(yaml, &at, "a second document: a %s has one", yaml->kind);
        if (depth > ECT_YAML_DEPTH)
            ect_yaml_fail(yaml, &at, "lists within lists: a %s has no such depth", yaml->kind);
        ended = event.type == YAML_STREAM_END_EVENT;
        yaml_event_delete(&event);
    }
    yaml_parser_delete(&parser);
}

bool ect_yaml_open(ect_yaml_t *yaml, const char *kind, ect_mistake_t *mistake, const void *data, size_t length)
{
    yaml_parser_t parser;
    yaml->kind = kind;
    yaml->mistake = mistake;
    check_events(yaml, data, length);
    if (mistake->failed)
        return false;
    if (yaml_parser_initialize(&parser) == 0) {
        ect_yaml_fail(yaml, NULL, "no memory left");
        return false;
    }
    yaml_parser_set_input_string(&parser, data, length);
    if (yaml_parser_load(&parser, &yaml->document) == 0)
        fail_parser(mistake, &parser);
    yaml_parser_delete(&parser);
    return !mistake->failed;
}

void ect_yaml_close(ect_yaml_t *yaml)
{
    yaml_document_delete(&yaml->document);
}

const yaml_node_t *ect_yaml_root(ect_yaml_t *yaml)
{
    return yaml_document_get_root_node(&yaml->document);
}

const yaml_node_t *ect_yaml_node(ect_yaml_t *yaml, int number)
{
    return yaml_document_get_node(&yaml->document, number);
}

/* --- nodes -------------------------------------------------------------------------------------------------------- */

const char *ect_yaml_scalar(ect_yaml_t *yaml, const yaml_node_t *node, const char *key)
{
    if (node->type != YAML_SCALAR_NODE) {
        ect_yaml_fail(yaml, node, "'%.60s' takes one value", key);
        return "";
    }
    const char *text = (const char *)node->data.scalar.value;
    if (strlen(text) != node->data.scalar.length)
        ect_yaml_fail(yaml, node, "'%.60s' has a character 0", key);
    return text;
}

const yaml_node_t *ect_yaml_find(ect_yaml_t *yaml, const yaml_node_t *map, const char *key)
{
    for (const yaml_node_pair_t *p = map->data.mapping.pairs.start; p < map->data.mapping.pairs.top; p++) {
        const yaml_node_t *name = ect_yaml_node(yaml, p->key);
        if (name->type == YAML_SCALAR_NODE && strcmp((const char *)name->data.scalar.value, key) == 0)
            return ect_yaml_node(yaml, p->value);
    }
    return NULL;
}

void ect_yaml_each(ect_yaml_t *yaml, const yaml_node_t *map, const char *what, bool unique, ect_yaml_take_t take,
                   void *ctx)
{
    if (map->type != YAML_MAPPING_NODE) {
        ect_yaml_fail(yaml, map, "%s: 'key: value' lines are missing", what);
        return;
    }
    for (const yaml_node_pair_t *p = map->data.mapping.pairs.start; p < map->data.mapping.pairs.top; p++) {
        const yaml_node_t *name = ect_yaml_node(yaml, p->key);
        const yaml_node_t *value = ect_yaml_node(yaml, p->value);
        const char *key = ect_yaml_scalar(yaml, name, what);
        if (unique && ect_yaml_find(yaml, map, key) != value)
            ect_yaml_fail(yaml, name, "'%.60s' occurs twice", key);
        if (!yaml->mistake->failed)
            take(ctx, key, name, value);
    }
}
