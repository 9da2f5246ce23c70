/* SPDX-License-Identifier: MIT */
/* ADS over EtherCAT (mailbox type 1): one command in a mail, one reply in a mail; the dictionary as an index group. */
#include "seams/aoe.h"

#include <string.h>

#include "slave/internal.h"

/* Offsets in the AMS header, and in the following parameters. */
enum { TARGET = 0, SOURCE = 8, COMMAND = 16, FLAGS = 18, LENGTH = 20, ERROR = 24, INVOKE = 28, HEADER = 32 };
enum { ADDRESS = 8, IS_RESPONSE = 0x0001, IS_ADS = 0x0004 };
enum { GROUP = 0, OFFSET = 4, SIZE = 8, WRITE_SIZE = 12 };

enum {
    READ_DEVICE_INFO = 1,
    READ = 2,
    WRITE = 3,
    READ_STATE = 4,
    WRITE_CONTROL = 5,
    ADD_NOTIFICATION = 6,
    DELETE_NOTIFICATION = 7,
    NOTIFICATION = 8,
    READ_WRITE = 9,
    COMMANDS = 10
};

/* Replies: a result, then the length and the data of a value. */
enum { RESULT = 4, VALUE = 8, STATES = 8, DEVICE_INFO = 24, NAME = 16 };
enum { ADS_RUN = 5, ADS_STOP = 6 };

/* A request and the parameters of its reply. */
typedef struct call {
    const ect_aoe_t *aoe;
    ect_slave_t *s;
    const uint8_t *from;
    uint32_t length; /* of `from` */
    uint8_t *to;
    uint32_t room;
    uint32_t size; /* of the reply */
} call_t;

static ect_aoe_state_t *state_of(const ect_aoe_t *aoe, const ect_slave_t *s)
{
    return (ect_aoe_state_t *)(void *)((uint8_t *)s->config.instance + aoe->offset);
}

/* --- the dictionary ----------------------------------------------------------------------------------------------- */

/* The result for an SDO abort code: that of the first row that is not below it. */
static const struct {
    uint32_t last;
    uint16_t result;
} results[] = {
    {0x05040004, ECT_ADS_GENERAL},   {0x05040005, ECT_ADS_MEMORY},  {0x06010004, ECT_ADS_ACCESS},
    {0x06010005, ECT_ADS_SIZE},      {0x06010006, ECT_ADS_ACCESS},  {0x06020000, ECT_ADS_NO_OFFSET},
    {0x06040047, ECT_ADS_VALUE},     {0x06060000, ECT_ADS_GENERAL}, {0x06070013, ECT_ADS_SIZE},
    {0x06090011, ECT_ADS_NO_OFFSET}, {0x06090036, ECT_ADS_VALUE},   {0x060A0023, ECT_ADS_MEMORY},
    {0x08000020, ECT_ADS_GENERAL},   {0x08000022, ECT_ADS_STATE},   {UINT32_MAX, ECT_ADS_GENERAL},
};

static uint32_t result_of(ect_reason_t reason)
{
    const uint32_t code = ect_abort_code(reason);
    unsigned int row = 0;
    if (reason == ECT_OK)
        return ECT_ADS_OK;
    while (code > results[row].last)
        row++;
    return results[row].result;
}

static uint32_t read_object(const call_t *c, uint32_t offset, uint8_t *data, uint32_t *length)
{
    const ect_sdo_t *sdo = &c->s->sdo;
    if (sdo->state == ECT_SDO_UPLOADING && sdo->instead.data)
        return ECT_ADS_BUSY; /* the device may use the same memory for this read */
    const uint32_t room = *length;
    ect_reason_t reason = ect_sdo_read_all(c->s, offset, data, length);
    if (reason == ECT_OK && *length > room) {
        memset(data, 0, room); /* the rest of the mail after a refusal is 0 */
        reason = ECT_REASON_MAILBOX_SIZE;
    }
    return result_of(reason);
}

static uint32_t write_object(const call_t *c, uint32_t offset, const uint8_t *data, uint32_t length)
{
    if (c->s->sdo.state == ECT_SDO_DOWNLOADING)
        return ECT_ADS_BUSY; /* a write collects a value */
    return result_of(ect_sdo_write_all(c->s, offset, data, (uint16_t)length));
}

/* --- index groups ------------------------------------------------------------------------------------------------- */

static bool is_dictionary(const call_t *c, uint32_t group)
{
    return group == ECT_AOE_GROUP_COE && (c->s->config.device->mailbox_protocols & ECT_MAILBOX_COE) != 0;
}

static bool sets_net_id(uint16_t command, const uint8_t *from)
{
    return command == WRITE && ect_load_le32(from + GROUP) == ECT_AOE_GROUP_SETUP &&
           ect_load_le32(from + OFFSET) == ECT_AOE_OFFSET_NET_ID;
}

static uint32_t set_net_id(const call_t *c, const uint8_t *data, uint32_t length)
{
    if (length != ECT_AOE_NET_ID)
        return ECT_ADS_SIZE;
    memcpy(state_of(c->aoe, c->s)->net_id, data, ECT_AOE_NET_ID);
    return ECT_ADS_OK;
}

static uint32_t read_group(call_t *c)
{
    const uint32_t group = ect_load_le32(c->from + GROUP);
    const uint32_t offset = ect_load_le32(c->from + OFFSET);
    const uint32_t wanted = ect_load_le32(c->from + SIZE);
    uint32_t length = c->room - VALUE;
    uint32_t result = ECT_ADS_NO_GROUP;
    length = wanted < length ? wanted : length;
    const uint32_t most = length;
    if (is_dictionary(c, group))
        result = read_object(c, offset, c->to + VALUE, &length);
    else if (c->aoe->read)
        result = c->aoe->read(c->aoe, c->s->config.instance, group, offset, c->to + VALUE, &length);
    if (result != ECT_ADS_OK)
        return result;
    ECT_ASSERT(length <= most);
    ect_store_le32(c->to + RESULT, length);
    c->size = VALUE + length;
    return ECT_ADS_OK;
}

static uint32_t write_group(call_t *c, const uint8_t *data, uint32_t length)
{
    const uint32_t group = ect_load_le32(c->from + GROUP);
    const uint32_t offset = ect_load_le32(c->from + OFFSET);
    if (group == ECT_AOE_GROUP_SETUP && offset == ECT_AOE_OFFSET_NET_ID)
        return set_net_id(c, data, length);
    if (is_dictionary(c, group))
        return write_object(c, offset, data, length);
    if (!c->aoe->write)
        return ECT_ADS_NO_GROUP;
    return c->aoe->write(c->aoe, c->s->config.instance, group, offset, data, length);
}

/* --- commands ----------------------------------------------------------------------------------------------------- */

static uint32_t read_device_info(call_t *c)
{
    const char *name = c->s->config.device->type_name;
    c->to[4] = c->aoe->version;
    c->to[5] = c->aoe->revision;
    ect_store_le16(c->to + 6, c->aoe->build);
    for (unsigned int i = 0; i < NAME && name[i] != '\0'; i++)
        c->to[8 + i] = (uint8_t)name[i];
    return ECT_ADS_OK;
}

static uint32_t read_state(call_t *c)
{
    ect_store_le16(c->to + 4, c->s->state == ECT_STATE_OP ? ADS_RUN : ADS_STOP);
    ect_store_le16(c->to + 6, c->s->state);
    return ECT_ADS_OK;
}

/* Checks that the announced length equals that of the data. */
static uint32_t write_value(call_t *c)
{
    const uint32_t length = ect_load_le32(c->from + SIZE);
    if (length != c->length - WRITE_SIZE)
        return ECT_ADS_SIZE;
    return write_group(c, c->from + WRITE_SIZE, length);
}

static uint32_t read_write(call_t *c)
{
    const uint32_t length = ect_load_le32(c->from + WRITE_SIZE);
    const uint8_t *data = c->from + WRITE_SIZE + 4;
    if (length != c->length - WRITE_SIZE - 4)
        return ECT_ADS_SIZE;
    const uint32_t result = write_group(c, data, length);
    return result == ECT_ADS_OK ? read_group(c) : result;
}

static uint32_t refuse(call_t *c)
{
    (void)c;
    return ECT_ADS_NO_SERVICE;
}

static const struct {
    uint8_t parameters; /* least number of bytes */
    uint8_t reply;
    uint32_t (*serve)(call_t *c);
} commands[COMMANDS] = {
    [READ_DEVICE_INFO] = {0, DEVICE_INFO, read_device_info},
    [READ] = {12, VALUE, read_group},
    [WRITE] = {12, RESULT, write_value},
    [READ_STATE] = {0, STATES, read_state},
    [WRITE_CONTROL] = {0, RESULT, refuse},
    [ADD_NOTIFICATION] = {0, RESULT + 4, refuse},
    [DELETE_NOTIFICATION] = {0, RESULT, refuse},
    [READ_WRITE] = {16, VALUE, read_write},
};

static bool is_for_another(const call_t *c, uint16_t command, const uint8_t *target)
{
    static const uint8_t none[ECT_AOE_NET_ID];
    const uint8_t *own = state_of(c->aoe, c->s)->net_id;
    if (memcmp(own, none, sizeof none) == 0 || memcmp(target, none, sizeof none) == 0)
        return false;
    return memcmp(own, target, sizeof none) != 0 && !sets_net_id(command, c->from);
}

/* @return the error code of the AMS header; 0: `size` bytes of reply follow it */
static uint32_t serve(call_t *c, const uint8_t *mail)
{
    const uint16_t command = ect_load_le16(mail + COMMAND);
    if ((mail[FLAGS] & IS_ADS) == 0 || command >= COMMANDS || !commands[command].serve)
        return ECT_AMS_UNKNOWN_COMMAND;
    if (c->length < commands[command].parameters)
        return ECT_AMS_LENGTH;
    if (is_for_another(c, command, mail + TARGET))
        return ECT_AMS_NO_TARGET;
    c->size = commands[command].reply;
    ect_store_le32(c->to, commands[command].serve(c));
    return 0;
}

uint16_t ect_aoe_request(const ect_protocol_t *self, ect_slave_t *s, const uint8_t *data, uint16_t length)
{
    if (length < HEADER)
        return ECT_MAILBOX_ERROR_TOO_SHORT;
    const uint32_t parameters = ect_load_le32(data + LENGTH);
    if (parameters > length - (uint32_t)HEADER)
        return ECT_MAILBOX_ERROR_SIZE;
    if ((data[FLAGS] & IS_RESPONSE) != 0 || ect_load_le16(data + COMMAND) == NOTIFICATION)
        return ECT_MAILBOX_OK;
    const uint16_t room = ect_mailbox_room(s);
    ECT_ASSERT(room >= HEADER + DEVICE_INFO);
    uint8_t *mail = ect_mailbox_build(s);
    call_t call = {.aoe = (const ect_aoe_t *)(const void *)self,
                   .s = s,
                   .from = data + HEADER,
                   .length = parameters,
                   .to = mail + HEADER,
                   .room = (uint32_t)room - HEADER};
    const uint32_t error = serve(&call, data);
    memcpy(mail + TARGET, data + SOURCE, ADDRESS);
    memcpy(mail + SOURCE, data + TARGET, ADDRESS);
    memcpy(mail + COMMAND, data + COMMAND, 2);
    ect_store_le16(mail + FLAGS, IS_RESPONSE | IS_ADS);
    ect_store_le32(mail + LENGTH, call.size);
    ect_store_le32(mail + ERROR, error);
    memcpy(mail + INVOKE, data + INVOKE, 4);
    ect_mailbox_send(s, ECT_MAILBOX_TYPE_AOE, (uint16_t)(HEADER + call.size));
    return ECT_MAILBOX_OK;
}
