/* SPDX-License-Identifier: MIT */
/**
 * @file
 * YAML documents written by users, as trees with line numbers. JSON is a part of YAML.
 *
 * Anchors, aliases, tags, a second document and deep lists are refused, so that no content of a file grows beyond its
 * own size. Each mistake is one line `FILE:LINE: ERROR` (text/mistake.h).
 *
 * Host only. Context: mainline. Cost: linear in the bytes of the file.
 */
#ifndef ECT_YAML_DOCUMENT_H
#define ECT_YAML_DOCUMENT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <yaml.h>

#include "text/mistake.h"
#include "wire/linkage.h"

enum { ECT_YAML_DEPTH = 8 /**< lists within lists */ };

/** An open document. */
typedef struct ect_yaml {
    ect_mistake_t *mistake;
    const char *kind; /**< name of such a file in errors: "bus file" */
    yaml_document_t document;
} ect_yaml_t;

ECT_C_BEGIN

/**
 * Reads a regular file.
 * @param most  longest permitted file, bytes
 * @param[out] length  of the file, bytes
 * @param[out] text, room  the error, one line
 * @return the bytes, to be freed; NULL: no file of at most `most` bytes, or not readable
 */
char *ect_yaml_load(const char *path, size_t most, size_t *length, char *text, size_t room);

/**
 * Opens a document.
 * @param data, length  need not outlive the call
 * @return true: to be closed by ::ect_yaml_close; false: a mistake is reported, and nothing is open
 */
bool ect_yaml_open(ect_yaml_t *yaml, const char *kind, ect_mistake_t *mistake, const void *data, size_t length);

/** Closes an open document; its nodes and their texts become invalid. */
void ect_yaml_close(ect_yaml_t *yaml);

/** @return the outermost node; NULL: the document is empty */
const yaml_node_t *ect_yaml_root(ect_yaml_t *yaml);

/** @return the node of a number in a list or mapping of the document */
const yaml_node_t *ect_yaml_node(ect_yaml_t *yaml, int number);

/** @return the line of a node, from 1; 1 for NULL */
size_t ect_yaml_line(const yaml_node_t *node);

/** Reports a mistake at a node; at NULL: at line 1. */
__attribute__((format(printf, 3, 4))) void ect_yaml_fail(ect_yaml_t *yaml, const yaml_node_t *node, const char *format,
                                                         ...);

/** @return the text of a scalar; for another node "", after a mistake that names `key` is reported */
const char *ect_yaml_scalar(ect_yaml_t *yaml, const yaml_node_t *node, const char *key);

/** @return the first value of a key in a mapping; NULL: no such key */
const yaml_node_t *ect_yaml_find(ect_yaml_t *yaml, const yaml_node_t *map, const char *key);

/** Receives a pair of a mapping. */
typedef void (*ect_yaml_take_t)(void *ctx, const char *key, const yaml_node_t *name, const yaml_node_t *value);

/**
 * Calls `take` for each pair of a mapping in the order of the file, until the first mistake.
 * @param what    name of the mapping, for the error about a node that is no mapping: "a twin"
 * @param unique  whether a repeated key is a mistake; `take` refuses unknown keys, which bounds the cost
 */
void ect_yaml_each(ect_yaml_t *yaml, const yaml_node_t *map, const char *what, bool unique, ect_yaml_take_t take,
                   void *ctx);

ECT_C_END

#endif
