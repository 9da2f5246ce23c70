/* SPDX-License-Identifier: MIT */
#include "request.h"

#include <arpa/inet.h>
#include <stdio.h>
#include <string.h>

bool request_is_numeric(const char *address)
{
    struct in6_addr binary;
    return inet_pton(AF_INET, address, &binary) == 1 || inet_pton(AF_INET6, address, &binary) == 1;
}

bool request_is_loopback(const char *address)
{
    struct in_addr four;
    struct in6_addr six;
    if (inet_pton(AF_INET, address, &four) == 1)
        return ntohl(four.s_addr) >> 24 == 127;
    return inet_pton(AF_INET6, address, &six) == 1 && IN6_IS_ADDR_LOOPBACK(&six);
}

/* The name of a Host header, without port and brackets. @return the rest behind it; NULL: malformed */
static const char *split_name(const char *host, char name[REQUEST_HOST])
{
    bool brackets = host[0] == '[';
    size_t length = strcspn(host + brackets, brackets ? "]" : ":");
    if (length >= REQUEST_HOST || (brackets && host[1 + length] != ']'))
        return NULL;
    memcpy(name, host + brackets, length);
    name[length] = 0;
    bool colons = strchr(name, ':') != NULL; /* an address of IPv6 has them, and is in brackets */
    return colons == brackets ? host + length + 2 * brackets : NULL;
}

bool request_host_is_ours(const char *host, unsigned int port)
{
    char name[REQUEST_HOST];
    char expected[16];
    const char *rest = split_name(host, name);
    if (!rest || (strcmp(name, "localhost") != 0 && !request_is_numeric(name)))
        return false;
    snprintf(expected, sizeof expected, ":%u", port);
    return strcmp(rest, expected) == 0 || (port == 80 && *rest == 0);
}

bool request_origin_is_ours(const char *origin, const char *host)
{
    static const char scheme[] = "http://";
    return strncmp(origin, scheme, sizeof scheme - 1) == 0 && strcmp(origin + sizeof scheme - 1, host) == 0;
}

bool request_token_is_right(const char *given, const char *token)
{
    size_t length = strlen(token);
    unsigned int difference = strlen(given) != length || length == 0;
    if (difference != 0)
        return false;
    for (size_t i = 0; i < length; i++)
        difference |= (unsigned char)given[i] ^ (unsigned char)token[i];
    return difference == 0;
}

void request_write_token(const uint8_t bits[16], char token[REQUEST_TOKEN])
{
    for (size_t i = 0; i < 16; i++)
        snprintf(token + 2 * i, 3, "%02x", bits[i]);
}

const char *request_refused(const cJSON *request, bool view)
{
    const char *op = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(request, "op"));
    static const struct {
        const char *op;
        bool changes;
    } taken[] = {
        {"set", true},    {"fault", true},     {"write", true}, {"objects", false}, {"read", false},   {"pdos", false},
        {"wires", false}, {"counters", false}, {"wave", true},  {"waves", false},   {"capture", true},
    };
    for (size_t i = 0; op && i < sizeof taken / sizeof taken[0]; i++) {
        if (strcmp(op, taken[i].op) == 0)
            return taken[i].changes && view ? "this panel was started with --view: it changes nothing" : NULL;
    }
    return "the panel does not pass this request on";
}
