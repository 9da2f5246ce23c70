/* SPDX-License-Identifier: MIT */
#include "steps/coe_walk.h"

#include <stdio.h>

enum {
    DESCRIBE_OBJECT = 3,
    DESCRIBE_ENTRY = 5,
    OBJECT_BYTES = 6,
    ENTRY_BYTES = 10,
    HEADERS = 12,
    ACCESS_INFO = 7,
    COE_REPLY = 512
};

/* A name at the end of a full mailbox may be truncated. */
static bool is_full(const cf_t *c, int bytes)
{
    return bytes + HEADERS >= c->mailbox.in_size;
}

static bool describe(cf_t *c, uint16_t index, coe_object_t *object)
{
    uint8_t request[2], reply[COE_REPLY];
    uint32_t code;
    ect_store_le16(request, index);
    int bytes = cf_info(c, DESCRIBE_OBJECT, request, sizeof request, reply, sizeof reply, &code);
    if (bytes < 0)
        cf_fail(c, "%04Xh of the list of objects: expected a description, got info error 0x%08X", index, code);
    cf_expect_that(c, bytes >= OBJECT_BYTES, "description of %04Xh: expected at least 6 bytes, got %d", index, bytes);
    cf_expect(c, "index of an object description", index, ect_load_le16(reply));
    *object = (coe_object_t){.index = index, .type = ect_load_le16(reply + 2), .most = reply[4], .code = reply[5]};
    if (!is_full(c, bytes))
        snprintf(object->name, sizeof object->name, "%.*s", bytes - OBJECT_BYTES, (const char *)reply + OBJECT_BYTES);
    return true;
}

/* @return false: the slave has no such entry */
static bool describe_entry(cf_t *c, uint16_t index, uint8_t sub, uint8_t *reply)
{
    uint8_t request[4] = {0};
    uint32_t code;
    ect_store_le16(request, index);
    request[2] = sub;
    request[3] = ACCESS_INFO;
    int bytes = cf_info(c, DESCRIBE_ENTRY, request, sizeof request, reply, COE_REPLY, &code);
    if (bytes < 0)
        return false;
    cf_expect_that(c, bytes >= ENTRY_BYTES, "description of %04Xh:%02X: expected at least 10 bytes, got %d", index, sub,
                   bytes);
    cf_expect(c, "index of an entry description", index, ect_load_le16(reply));
    cf_expect(c, "sub-index of an entry description", sub, reply[2]);
    return true;
}

bool coe_entry(cf_t *c, const coe_object_t *object, uint8_t sub, coe_entry_t *entry)
{
    uint8_t reply[COE_REPLY];
    if ((c->facts.has & CF_SDO_INFO) == 0 || !describe_entry(c, object->index, sub, reply))
        return false;
    *entry = (coe_entry_t){
        .type = ect_load_le16(reply + 4), .bits = ect_load_le16(reply + 6), .access = ect_load_le16(reply + 8)};
    return true;
}

/* Without the information service: visits the objects of every slave with CoE. */
static unsigned int walk_usual(cf_t *c, void (*visit)(cf_t *c, const coe_object_t *object))
{
    static const coe_object_t usual[] = {{.index = 0x1000, .type = 7, .code = COE_VAR},
                                         {.index = 0x1018, .type = 0x23, .most = 4, .code = COE_RECORD}};
    for (size_t i = 0; i < sizeof usual / sizeof usual[0]; i++)
        visit(c, &usual[i]);
    return sizeof usual / sizeof usual[0];
}

unsigned int coe_walk(cf_t *c, void (*visit)(cf_t *c, const coe_object_t *object))
{
    static uint16_t indices[COE_OBJECTS_MOST];
    if ((c->facts.has & CF_SDO_INFO) == 0)
        return walk_usual(c, visit);
    size_t count = cf_object_list(c, 1, indices, COE_OBJECTS_MOST);
    for (size_t i = 0; i < count; i++) {
        coe_object_t object;
        if (describe(c, indices[i], &object))
            visit(c, &object);
    }
    return (unsigned int)count;
}
