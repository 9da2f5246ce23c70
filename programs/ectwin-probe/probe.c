/* SPDX-License-Identifier: MIT */
#include "probe.h"

#include <string.h>

enum { SII_SIZE_WORD = 0x3E, SII_CATEGORIES = 0x80 };
enum { MAILBOX_HEADER = 6, COE_HEADER = 2, INFO_HEADER = 4, INFO_DATA = MAILBOX_HEADER + COE_HEADER + INFO_HEADER };
enum { COE_TYPE = 3, SDO_INFORMATION = 8, INCOMPLETE = 0x80 };
enum { LIST_REQUEST = 1, LIST_RESPONSE, OBJECT_REQUEST, OBJECT_RESPONSE, ENTRY_REQUEST, ENTRY_RESPONSE, INFO_ERROR };
enum { INFO_UNIT = 0x08, INFO_DEFAULT = 0x10, INFO_MINIMUM = 0x20, INFO_MAXIMUM = 0x40, INFO_ALL = 0x7F };
enum { OBJECTS_MOST = 8192, VALUE_MOST = 256, TRIES = 5 };

static unsigned int load16(const uint8_t *bytes)
{
    return (unsigned int)(bytes[0] | bytes[1] << 8);
}

/* A frame that comes late may be taken for the answer to another: what two reads agree on is what is there. */
static uint32_t read_two_words(uint16_t slave, size_t word)
{
    uint32_t before = ec_readeeprom(slave, (uint16_t)word, EC_TIMEOUTEEP);
    for (int tries = 0; tries < TRIES; tries++) {
        uint32_t now = ec_readeeprom(slave, (uint16_t)word, EC_TIMEOUTEEP);
        if (now == before)
            break;
        before = now;
    }
    return before;
}

bool probe_sii(uint16_t slave, FILE *file)
{
    size_t size = SII_CATEGORIES;
    (void)ec_eeprom2master(slave);
    for (size_t byte = 0; byte < size; byte += 4) {
        uint32_t two = read_two_words(slave, byte / 2);
        if (byte == 2 * SII_SIZE_WORD)
            size = ((two & 0xFFFFu) + 1) * 128 <= 0x20000 ? ((two & 0xFFFFu) + 1) * 128 : SII_CATEGORIES;
        const uint8_t bytes[4] = {(uint8_t)two, (uint8_t)(two >> 8), (uint8_t)(two >> 16), (uint8_t)(two >> 24)};
        (void)fwrite(bytes, 1, sizeof bytes, file);
    }
    uint16_t al_status = 0;
    return ec_FPRD(ec_slave[slave].configadr, ECT_REG_ALSTAT, sizeof al_status, &al_status, EC_TIMEOUTRET3) > 0;
}

/* --- SDO information --------------------------------------------------------------------------------------------- */

/* An answer, or a part of one. */
typedef struct answer {
    ec_mbxbuft mail;
    const uint8_t *data;
    size_t length;
    bool more;
    bool full; /* to the end of the mailbox: a name at its end may be cut off */
} answer_t;

/* What became of a request. */
typedef enum outcome { ANSWERED, REFUSED, LOST } outcome_t;

/* SOEM keeps mailbox errors for itself: a slave without SDO information answers with one. */
static outcome_t not_received(void)
{
    ec_errort error;
    outcome_t outcome = LOST;
    while (ec_poperror(&error))
        outcome = error.Etype == EC_ERR_TYPE_MBX_ERROR ? REFUSED : outcome;
    return outcome;
}

static outcome_t receive(uint16_t slave, uint8_t opcode, answer_t *answer)
{
    ec_clearmbx(&answer->mail);
    if (ec_mbxreceive(slave, &answer->mail, EC_TIMEOUTRXM) <= 0)
        return not_received();
    const uint8_t *mail = answer->mail;
    size_t length = MAILBOX_HEADER + load16(mail);
    if (length < INFO_DATA || length > sizeof answer->mail || (mail[5] & 0x0F) != COE_TYPE ||
        mail[7] >> 4 != SDO_INFORMATION)
        return LOST;
    if ((mail[8] & 0x7F) == INFO_ERROR)
        return REFUSED;
    answer->data = mail + INFO_DATA;
    answer->length = length - INFO_DATA;
    answer->more = (mail[8] & INCOMPLETE) != 0;
    answer->full = length >= ec_slave[slave].mbx_rl;
    return (mail[8] & 0x7F) == opcode ? ANSWERED : LOST;
}

static outcome_t request_once(uint16_t slave, uint8_t opcode, const uint8_t *data, uint8_t length, answer_t *answer)
{
    ec_mbxbuft mail;
    ec_clearmbx(&mail);
    uint8_t count = ec_nextmbxcnt(ec_slave[slave].mbx_cnt);
    ec_slave[slave].mbx_cnt = count;
    uint8_t *bytes = mail;
    bytes[0] = (uint8_t)(COE_HEADER + INFO_HEADER + length);
    bytes[5] = (uint8_t)(COE_TYPE | count << 4);
    bytes[7] = SDO_INFORMATION << 4;
    bytes[8] = opcode;
    memcpy(bytes + INFO_DATA, data, length);
    answer_t old; /* what still lies there from before */
    (void)ec_mbxreceive(slave, &old.mail, 0);
    return ec_mbxsend(slave, &mail, EC_TIMEOUTTXM) > 0 ? receive(slave, (uint8_t)(opcode + 1), answer) : LOST;
}

/* An answer repeats the first `echo` bytes of its request; one that does not belongs to an earlier request. */
static outcome_t request(uint16_t slave, uint8_t opcode, const uint8_t *data, uint8_t length, uint8_t echo,
                         answer_t *answer)
{
    for (int tries = 0; tries < TRIES; tries++) {
        outcome_t outcome = request_once(slave, opcode, data, length, answer);
        if (outcome == REFUSED ||
            (outcome == ANSWERED && answer->length >= echo && memcmp(answer->data, data, echo) == 0))
            return outcome;
    }
    return LOST;
}

/* All objects; none when the slave has no SDO information. */
static outcome_t list_once(uint16_t slave, uint16_t *objects, size_t *count)
{
    const uint8_t all[2] = {1, 0};
    answer_t answer;
    size_t skip = 2; /* the first part repeats which list it is */
    *count = 0;
    outcome_t outcome = request(slave, LIST_REQUEST, all, sizeof all, sizeof all, &answer);
    while (outcome == ANSWERED) {
        for (size_t at = skip; at + 2 <= answer.length && *count < OBJECTS_MOST; at += 2)
            objects[(*count)++] = (uint16_t)load16(answer.data + at);
        skip = 0;
        if (!answer.more)
            break;
        outcome = receive(slave, LIST_RESPONSE, &answer);
    }
    return outcome;
}

static outcome_t list(uint16_t slave, uint16_t *objects, size_t *count)
{
    outcome_t outcome = LOST;
    for (int tries = 0; tries < TRIES && outcome == LOST; tries++)
        outcome = list_once(slave, objects, count);
    return outcome;
}

/* --- JSON -------------------------------------------------------------------------------------------------------- */

static void put_text(FILE *file, const char *name, const uint8_t *text, size_t length)
{
    fprintf(file, ", \"%s\": \"", name);
    for (size_t i = 0; i < length && text[i] != 0; i++) {
        if (text[i] < ' ' || text[i] > '~' || text[i] == '"' || text[i] == '\\')
            fprintf(file, "\\u%04x", text[i]); /* beyond ASCII it is taken for ISO 8859-1 */
        else
            fputc(text[i], file);
    }
    fputc('"', file);
}

static void put_bytes(FILE *file, const char *name, const uint8_t *bytes, size_t length)
{
    fprintf(file, ", \"%s\": \"", name);
    for (size_t i = 0; i < length; i++)
        fprintf(file, "%02x", bytes[i]);
    fputc('"', file);
}

/* --- objects ----------------------------------------------------------------------------------------------------- */

/* Those whose values say what the slave is. */
static bool is_read(unsigned int index)
{
    return index == 0x1000 || index == 0x1008 || index == 0x1018 || (index >= 0x1600 && index < 0x1C00) ||
           (index >= 0x1C10 && index < 0x1C30);
}

/* @return bytes, 0: it cannot be read */
static size_t read_value(uint16_t slave, unsigned int index, unsigned int subindex, uint8_t value[VALUE_MOST])
{
    ec_errort abort;
    for (int tries = 0; tries < TRIES; tries++) {
        int size = VALUE_MOST;
        while (ec_poperror(&abort))
            continue;
        if (ec_SDOread(slave, (uint16_t)index, (uint8_t)subindex, FALSE, &size, value, EC_TIMEOUTRXM) > 0)
            return size > 0 && size <= VALUE_MOST ? (size_t)size : 0;
        if (ec_iserror())
            break; /* refused */
    }
    return 0;
}

static void put_value(uint16_t slave, unsigned int index, unsigned int subindex, FILE *file)
{
    uint8_t value[VALUE_MOST];
    size_t length = is_read(index) ? read_value(slave, index, subindex, value) : 0;
    if (length > 0)
        put_bytes(file, "value", value, length);
}

/* The optional fields stand in the order of their bits, those with the entry's length among them. */
static size_t put_details(const answer_t *answer, size_t bytes, FILE *file)
{
    static const struct {
        uint8_t bit;
        const char *name;
    } fields[] = {{INFO_UNIT, "unit"}, {INFO_DEFAULT, "default"}, {INFO_MINIMUM, "minimum"}, {INFO_MAXIMUM, "maximum"}};
    size_t at = 10;
    for (size_t i = 0; i < sizeof fields / sizeof fields[0]; i++) {
        size_t size = fields[i].bit == INFO_UNIT ? 2 : bytes;
        if ((answer->data[3] & fields[i].bit) == 0 || at + size > answer->length)
            continue;
        put_bytes(file, fields[i].name, answer->data + at, size);
        at += size;
    }
    return at;
}

/* A sub-index of no type and no length is a gap. */
static bool put_entry(uint16_t slave, unsigned int index, unsigned int subindex, bool *first, FILE *file)
{
    const uint8_t wanted[4] = {(uint8_t)index, (uint8_t)(index >> 8), (uint8_t)subindex, INFO_ALL};
    answer_t answer;
    outcome_t outcome = request(slave, ENTRY_REQUEST, wanted, sizeof wanted, 3, &answer);
    if (outcome != ANSWERED || answer.length < 10)
        return outcome != LOST;
    unsigned int type = load16(answer.data + 4);
    unsigned int bits = load16(answer.data + 6);
    if (type == 0 && bits == 0)
        return true;
    fprintf(file, "%s\n    {\"subindex\": %u, \"type\": %u, \"bits\": %u, \"access\": %u", *first ? "" : ",", subindex,
            type, bits, load16(answer.data + 8));
    *first = false;
    size_t at = put_details(&answer, (bits + 7) / 8, file);
    if (!answer.full)
        put_text(file, "name", answer.data + at, answer.length - at);
    put_value(slave, index, subindex, file);
    fputc('}', file);
    return true;
}

static bool put_object(uint16_t slave, unsigned int index, const char *separator, FILE *file)
{
    const uint8_t wanted[2] = {(uint8_t)index, (uint8_t)(index >> 8)};
    answer_t answer;
    outcome_t outcome = request(slave, OBJECT_REQUEST, wanted, sizeof wanted, sizeof wanted, &answer);
    if (outcome != ANSWERED || answer.length < 6)
        return false;
    unsigned int most = answer.data[4];
    fprintf(file, "%s\n  {\"index\": %u, \"type\": %u, \"code\": %u", separator, index, load16(answer.data + 2),
            answer.data[5]);
    if (!answer.full)
        put_text(file, "name", answer.data + 6, answer.length - 6);
    fputs(", \"entries\": [", file);
    bool first = true;
    bool whole = true;
    for (unsigned int subindex = 0; subindex <= most && whole; subindex++)
        whole = put_entry(slave, index, subindex, &first, file);
    fputs("]}", file);
    return whole;
}

/* Without SDO information: an object that can be read, with its values alone. */
static bool put_undescribed(uint16_t slave, unsigned int index, const char *separator, FILE *file)
{
    uint8_t value[VALUE_MOST];
    size_t length = read_value(slave, index, 0, value);
    if (length == 0)
        return false;
    bool single = index == 0x1000 || index == 0x1008;
    fprintf(file, "%s\n  {\"index\": %u, \"entries\": [{\"subindex\": 0", separator, index);
    put_bytes(file, "value", value, length);
    fputc('}', file);
    for (unsigned int subindex = 1; !single && subindex <= value[0]; subindex++) {
        fprintf(file, ", {\"subindex\": %u", subindex);
        put_value(slave, index, subindex, file);
        fputc('}', file);
    }
    fputs("]}", file);
    return true;
}

static void put_all_undescribed(uint16_t slave, FILE *file)
{
    static const uint16_t fixed[] = {0x1000, 0x1008, 0x1018};
    const char *separator = "";
    for (size_t i = 0; i < sizeof fixed / sizeof fixed[0]; i++)
        separator = put_undescribed(slave, fixed[i], separator, file) ? "," : separator;
    for (unsigned int assignment = 0x1C12; assignment < 0x1C14; assignment++) {
        uint8_t count[VALUE_MOST] = {0};
        uint8_t pdo[VALUE_MOST];
        if (read_value(slave, assignment, 0, count) == 0)
            continue;
        separator = put_undescribed(slave, assignment, separator, file) ? "," : separator;
        for (unsigned int n = 1; n <= count[0]; n++) {
            if (read_value(slave, assignment, n, pdo) >= 2)
                separator = put_undescribed(slave, load16(pdo), separator, file) ? "," : separator;
        }
    }
}

bool probe_dictionary(uint16_t slave, FILE *file)
{
    static uint16_t objects[OBJECTS_MOST];
    bool coe = (ec_slave[slave].mbx_proto & ECT_PROBE_COE) != 0;
    size_t count = 0;
    const char *separator = "";
    bool whole = !coe || list(slave, objects, &count) != LOST;
    fprintf(file, "{\"slave\": %u, \"described\": %s, \"objects\": [", (unsigned int)slave,
            count > 0 ? "true" : "false");
    for (size_t i = 0; i < count && whole; i++) {
        whole = put_object(slave, objects[i], separator, file);
        separator = ",";
    }
    if (coe && whole && count == 0)
        put_all_undescribed(slave, file);
    fputs("\n]}\n", file);
    return whole;
}
