/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "plant.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

enum { LINE_ROOM = 1024, WORD_ROOM = 64 };

/* A descriptor, not a stream: with the twins in this process read(2) lets them serve the request. */
static int connection(void)
{
    static int twin = -1;
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    const char *path = getenv("ECTWIN_SOCKET");
    if (twin >= 0)
        return twin;
    if (!path || strlen(path) >= sizeof address.sun_path)
        fail_msg("no ECTWIN_SOCKET: run this test under 'ectwin with'");
    memcpy(address.sun_path, path, strlen(path) + 1);
    twin = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (twin < 0 || connect(twin, (const struct sockaddr *)&address, sizeof address) != 0)
        fail_msg("no twin answers at %s", path);
    return twin;
}

static cJSON *answer(void)
{
    static char kept[LINE_ROOM];
    static size_t length;
    char *end;
    while (!(end = memchr(kept, '\n', length))) {
        ssize_t got = read(connection(), kept + length, sizeof kept - length);
        if (got <= 0)
            fail_msg("the twin has ended");
        length += (size_t)got;
    }
    cJSON *line = cJSON_ParseWithLength(kept, (size_t)(end - kept));
    length -= (size_t)(end + 1 - kept);
    memmove(kept, end + 1, length);
    return line;
}

static void ask(const char *op, const char *key, const char *name, const char *value)
{
    dprintf(connection(), "{\"op\":\"%s\",\"%s\":\"%s\",\"value\":\"%s\"}\n", op, key, name, value);
}

/* Numbers come as numbers. */
static const char *text_of(const cJSON *object, const char *key)
{
    static char number[WORD_ROOM];
    const cJSON *value = cJSON_GetObjectItemCaseSensitive(object, key);
    const char *text = cJSON_GetStringValue(value);
    snprintf(number, sizeof number, "%.15g", cJSON_IsNumber(value) ? value->valuedouble : 0);
    return text ? text : cJSON_IsNumber(value) ? number : "";
}

/* @return whether it was taken; else `message` has the reason */
static int set(const char *name, const char *value, char message[LINE_ROOM])
{
    ask("set", "name", name, value);
    cJSON *verdict = answer();
    int taken = cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(verdict, "ok"));
    snprintf(message, LINE_ROOM, "%s", text_of(verdict, "message"));
    cJSON_Delete(verdict);
    return taken;
}

void plant_set(const char *name, const char *value)
{
    char message[LINE_ROOM];
    if (!set(name, value, message))
        fail_msg("%s=%s: %s", name, value, message);
}

void plant_set_of(unsigned int slave, const char *name, const char *value)
{
    dprintf(connection(), "{\"op\":\"set\",\"slave\":%u,\"name\":\"%s\",\"value\":\"%s\"}\n", slave, name, value);
    cJSON *verdict = answer();
    if (!cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(verdict, "ok")))
        fail_msg("slave %u, %s=%s: %s", slave, name, value, text_of(verdict, "message"));
    cJSON_Delete(verdict);
}

void plant_set_all(const char *settings)
{
    char name[WORD_ROOM], value[WORD_ROOM];
    int used = 0;
    while (sscanf(settings, " %63[^=]=%63s%n", name, value, &used) == 2) {
        plant_set(name, value);
        settings += used;
    }
}

void plant_refuses(const char *name, const char *value, const char *why)
{
    char message[LINE_ROOM];
    if (set(name, value, message))
        fail_msg("%s=%s was taken; expected a refusal: %s", name, value, why);
    if (!strstr(message, why))
        fail_msg("%s=%s: expected a refusal with '%s', got '%s'", name, value, why, message);
}

const char *plant_get(const char *name)
{
    static char value[LINE_ROOM];
    ask("get", "pattern", name, "");
    cJSON *line = answer();
    if (!cJSON_HasObjectItem(line, "value"))
        fail_msg("no signal %s", name);
    snprintf(value, sizeof value, "%s", text_of(line, "value"));
    cJSON_Delete(line);
    cJSON_Delete(answer()); /* "ok" */
    return value;
}

long long plant_number(const char *name)
{
    return strtoll(plant_get(name), NULL, 10);
}
