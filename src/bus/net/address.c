/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/net/address.h"

#include <errno.h>
#include <netdb.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "text/number.h"

bool ect_address_parse(ect_address_t *address, const char *text)
{
    const struct addrinfo hints = {.ai_socktype = SOCK_STREAM,
                                   .ai_flags = AI_PASSIVE | AI_NUMERICHOST | AI_NUMERICSERV};
    struct addrinfo *found = NULL;
    char host[64] = "127.0.0.1";
    const char *colon = strrchr(text, ':');
    const char *port = colon ? colon + 1 : text;
    bool brackets = colon && text[0] == '[' && colon[-1] == ']';
    if (colon)
        snprintf(host, sizeof host, "%.*s", (int)(colon - text) - (brackets ? 2 : 0), text + (brackets ? 1 : 0));
    uint64_t number;
    if (!ect_number(port, 0, UINT16_MAX, &number) || (!brackets && strchr(host, ':')))
        return false;
    if (getaddrinfo(host, port, &hints, &found) != 0)
        return false;
    address->size = found->ai_addrlen;
    memcpy(&address->at, found->ai_addr, found->ai_addrlen);
    freeaddrinfo(found);
    return true;
}

const char *ect_address_why(int error)
{
    switch (error) {
    case EADDRINUSE:
        return "the port is in use: choose another port, or 0 for any free port";
    case EACCES:
        return "a port below 1024 needs CAP_NET_BIND_SERVICE: choose a higher port, or run it with sudo";
    case EADDRNOTAVAIL:
        return "this machine does not have the address; 'ip -br address' lists its addresses";
    default:
        return strerror(error);
    }
}

void ect_address_print(int fd, char text[ECT_ADDRESS_TEXT])
{
    ect_address_t address = {.size = sizeof address.at};
    char host[64] = "", port[8] = "";
    text[0] = '\0';
    if (getsockname(fd, (struct sockaddr *)&address.at, &address.size) == 0 &&
        getnameinfo((struct sockaddr *)&address.at, address.size, host, sizeof host, port, sizeof port,
                    NI_NUMERICHOST | NI_NUMERICSERV) == 0)
        snprintf(text, ECT_ADDRESS_TEXT, strchr(host, ':') ? "[%s]:%s" : "%s:%s", host, port);
}
