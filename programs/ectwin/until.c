/* SPDX-License-Identifier: MIT */
#include "until.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "connection.h"
#include "text/number.h"

const char *until_read(until_t *until, const char *text)
{
    size_t length = strcspn(text, "=!<>");
    const char *value = text + length + 1;
    if (length == 0 || length >= sizeof until->name || text[length] == 0 || (text[length] == '!' && *value != '='))
        return "a condition is NAME=VALUE, NAME!=VALUE, NAME<VALUE or NAME>VALUE";
    snprintf(until->name, sizeof until->name, "%.*s", (int)length, text);
    if (strpbrk(until->name, "*?["))
        return "a condition is on one signal: its name has no '*', '?' or '['";
    until->relation = text[length];
    until->value = until->relation == '!' ? value + 1 : value;
    char *end;
    until->number = strtod(until->value, &end);
    until->has_number = end != until->value && *end == 0;
    if ((until->relation == '<' || until->relation == '>') && !until->has_number)
        return "'<' and '>' compare with a number";
    return NULL;
}

static bool compare_number(const until_t *until, double number)
{
    switch (until->relation) {
    case '<':
        return number < until->number;
    case '>':
        return number > until->number;
    case '!':
        return !(until->has_number && number == until->number);
    default:
        return until->has_number && number == until->number;
    }
}

/* @return whether a line is of the signal, "gripper.data1" or "data1" */
static bool is_of_signal(const until_t *until, const cJSON *line)
{
    char name[CONNECTION_NAME], room[32];
    connection_full_name(line, name);
    if (cJSON_GetObjectItemCaseSensitive(line, "twin") && strcmp(name, until->name) == 0)
        return true;
    if (strcmp(connection_text(line, "name", room), until->name) != 0)
        return false;
    uint64_t slave;
    const cJSON *number = cJSON_GetObjectItemCaseSensitive(line, "slave");
    if (ect_number(until->slave, 0, UINT16_MAX, &slave))
        return slave == 0 || (cJSON_IsNumber(number) && number->valuedouble == (double)slave);
    return strcmp(connection_text(line, "twin", room), until->slave) == 0;
}

bool until_met(void *ctx, const cJSON *line)
{
    until_t *until = ctx;
    char room[32];
    const cJSON *value = cJSON_GetObjectItemCaseSensitive(line, "value");
    if (!value || !is_of_signal(until, line))
        return false;
    const char *text = connection_text(line, "value", room);
    snprintf(until->current, sizeof until->current, "%s", text);
    if (cJSON_IsNumber(value))
        return compare_number(until, value->valuedouble);
    bool equal = strcmp(text, until->value) == 0;
    return until->relation == '=' ? equal : until->relation == '!' && !equal;
}
