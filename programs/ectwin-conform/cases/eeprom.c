/* SPDX-License-Identifier: MIT */
/* F. The EEPROM: the interface, and the consistency of its content with itself and with the slave. */
#include <string.h>

#include "steps/esi.h"
#include "wire/crc.h"

enum { STRINGS = 10, GENERAL = 30, FMMU = 40, SYNCM = 41, TXPDO = 50, RXPDO = 51, DC = 60 };
enum {
    WORD_SIZE = 0x3E,
    WORD_ALIAS = 4,
    CHECK_OFF = 0x88A4,
    GENERAL_BYTES = 32,
    GENERAL_FLAGS = 11,
    SMALL_EEPROM = 2048
};
enum { BUSY = 0x8000, WRITE_REFUSED = 0x4000, NO_ACK = 0x2000, BAD_CHECK = 0x0800, WIDE = 0x0080, WRITE_ENABLE = 1 };
enum { COMMAND_READ = 0x0100, COMMAND_WRITE = 0x0200, COMMAND_RELOAD = 0x0400, COMMAND_NONE = 0x0300 };
enum { FINDINGS_SHOWN = 20 };
enum { ERROR_PROTOCOL = 2, FOE_READ = 1, EOE_GET_IP = 6 };

static uint16_t word(const cf_t *c, size_t n)
{
    return ect_load_le16(c->facts.sii + 2 * n);
}

static void checksum(cf_t *c)
{
    uint16_t stored = word(c, 7);
    if (stored == CHECK_OFF)
        cf_warn(c, "word 7 is 0x88A4: the check is disabled, which is for development only");
    else
        cf_expect(c, "checksum in word 7", ect_crc_sii(c->facts.sii), stored & 0xFF);
    cf_expect(c, "word 0 and PDI control (0x0140)", word(c, 0), c->facts.pdi);
    cf_expect_bits(c, "EEPROM status: checksum error", BAD_CHECK, 0, cf_get16(c, ECT_REG_SII_CONTROL));
}

/* --- the interface ------------------------------------------------------------------------------------------------ */

/* Writes control and address in one datagram. @return the status after the command */
static uint16_t command(cf_t *c, uint16_t control, uint16_t address)
{
    uint8_t order[6] = {0};
    ect_store_le16(order, control);
    ect_store_le16(order + 2, address);
    cf_put(c, ECT_REG_SII_CONTROL, order, sizeof order);
    return cf_sii_wait(c);
}

static void expect_word(cf_t *c, uint16_t address, uint16_t expected)
{
    uint8_t data[8];
    (void)cf_sii_read(c, address, data);
    cf_expect(c, "a word of the EEPROM", expected, ect_load_le16(data));
}

static void reading(cf_t *c)
{
    uint8_t data[8];
    unsigned int bytes = cf_sii_read(c, 8, data);
    cf_expect_bytes(c, "vendor id and more, at word 8", c->facts.sii + 16, data, bytes);
    cf_step(c, "word by word: each address counts words");
    for (uint16_t n = 8; n < 16; n++)
        expect_word(c, n, word(c, n));
    cf_step(c, "after the end of the EEPROM: the command ends with any result, and the next read is correct");
    (void)command(c, COMMAND_READ, (uint16_t)(c->facts.eeprom_bytes / 2 + 8));
    cf_put16(c, ECT_REG_SII_CONTROL, 0);
    expect_word(c, 8, word(c, 8));
    cf_step(c, "an unknown command");
    cf_expect_bits(c, "EEPROM status after an unknown command", NO_ACK, NO_ACK, command(c, COMMAND_NONE, 0));
    cf_put16(c, ECT_REG_SII_CONTROL, 0);
    cf_expect_bits(c, "EEPROM status, cleared", NO_ACK, 0, cf_get16(c, ECT_REG_SII_CONTROL));
    expect_word(c, 8, word(c, 8));
}

/* Writes the present value without the write enable bit, which must be refused, and is harmless if accepted. */
static void unenabled_write(cf_t *c)
{
    cf_step(c, "a write without the write enable bit");
    cf_put16(c, ECT_REG_SII_DATA, word(c, 8));
    cf_expect_bits(c, "EEPROM status after a write without enable", WRITE_REFUSED, WRITE_REFUSED,
                   command(c, COMMAND_WRITE, 8));
    cf_put16(c, ECT_REG_SII_CONTROL, 0);
    expect_word(c, 8, word(c, 8));
}

static void ownership(cf_t *c)
{
    uint8_t order[6] = {0, 1, 9, 0, 0, 0}, now[4];
    cf_step(c, "EEPROM assigned to the slave: commands of the master are ignored");
    cf_put8(c, ECT_REG_SII_CONFIG, 1);
    cf_get(c, ECT_REG_SII_ADDRESS, now, sizeof now);
    uint32_t before = ect_load_le32(now);
    (void)cf_write(c, ECT_REG_SII_CONTROL, order, sizeof order);
    cf_expect_that(c, cf_get32(c, ECT_REG_SII_ADDRESS) == before || before == 9,
                   "EEPROM address, written without ownership: expected 0x%08X as before, got 0x%08X", before,
                   cf_get32(c, ECT_REG_SII_ADDRESS));
    cf_put8(c, ECT_REG_SII_CONFIG, 2);
    cf_put8(c, ECT_REG_SII_CONFIG, 0);
    cf_step(c, "taken back");
    expect_word(c, 8, word(c, 8));
}

static void enabled_write(cf_t *c)
{
    const uint16_t spare = (uint16_t)(c->facts.sii_size / 2 + 1);
    uint8_t data[8];
    if (!c->destructive || 2u * spare + 8 > c->facts.eeprom_bytes) {
        cf_note(c, "without a write: %s", c->destructive ? "the EEPROM is full" : "only with --destructive");
        return;
    }
    cf_step(c, "a write after the categories");
    (void)cf_sii_read(c, spare, data);
    uint16_t other = (uint16_t)~ect_load_le16(data);
    cf_sii_write(c, spare, other);
    expect_word(c, spare, other);
}

static void writing(cf_t *c)
{
    unenabled_write(c);
    ownership(c);
    cf_step(c, "reload: the configuration is unchanged");
    uint16_t status = command(c, COMMAND_RELOAD, 0);
    cf_expect_bits(c, "EEPROM status after a reload", NO_ACK | BAD_CHECK, 0, status);
    cf_expect(c, "PDI control after a reload", c->facts.pdi, cf_get16(c, ECT_REG_PDI_CONTROL));
    enabled_write(c);
}

/* --- SII against the slave ---------------------------------------------------------------------------------------- */

/* The revision of the device may be newer than that of the file, but not older. */
static void identity_in_file(cf_t *c)
{
    const ect_esi_device_t *model = cf_esi_model(c);
    cf_esi_expect_sii(c, ECT_FACT_VENDOR, ECT_FACT_PRODUCT);
    if (model && c->facts.revision_no > model->revision)
        cf_warn(c, "revision: 0x%08X, newer than the 0x%08X of the ESI file", c->facts.revision_no, model->revision);
    cf_expect_that(c, !model || c->facts.revision_no >= model->revision,
                   "revision: expected 0x%08X as in the ESI file or newer, got 0x%08X", model ? model->revision : 0,
                   c->facts.revision_no);
}

static void identity(cf_t *c)
{
    static const char *const names[] = {"vendor id", "product code", "revision", "serial number"};
    const uint32_t sii[] = {c->facts.vendor, c->facts.product, c->facts.revision_no, c->facts.serial};
    cf_expect_that(c, c->facts.vendor != 0 && c->facts.product != 0,
                   "vendor id and product code of the SII: expected not 0, got 0x%08X and 0x%08X", c->facts.vendor,
                   c->facts.product);
    identity_in_file(c);
    if ((c->facts.has & CF_COE) == 0)
        return;
    cf_go(c, CF_PREOP);
    for (uint8_t sub = 1; sub <= 4; sub++) {
        uint64_t value = cf_upload_number(c, 0x1018, sub);
        cf_expect_that(c, value == sii[sub - 1], "%s: expected 0x%08X as in the SII, got 0x%08X in 1018h:%02X",
                       names[sub - 1], sii[sub - 1], (unsigned int)value, sub);
    }
}

typedef struct protocol {
    const char *name;
    uint8_t type, bit;
    uint16_t length;
    uint8_t request[12];
} protocol_t;

/* Requests without effect: reads of 1018h:00, of a missing file, of the IP address. */
static const protocol_t protocols[] = {
    {"AoE", CF_MBX_AOE, CF_PROTO_AOE, 4, {0}},
    {"EoE", CF_MBX_EOE, CF_PROTO_EOE, 4, {EOE_GET_IP, 0x01, 0, 0}},
    {"CoE", CF_MBX_COE, CF_PROTO_COE, 10, {0x00, 0x20, 0x40, 0x18, 0x10, 0x00}},
    {"FoE", CF_MBX_FOE, CF_PROTO_FOE, 8, {FOE_READ, 0, 0, 0, 0, 0, '?', '?'}},
    {"SoE", CF_MBX_SOE, CF_PROTO_SOE, 4, {0x01, 0, 1, 0}},
    {"VoE", CF_MBX_VOE, CF_PROTO_VOE, 6, {0}},
};

static void try_protocol(cf_t *c, const protocol_t *p)
{
    cf_mail_t mail;
    bool offered = (c->facts.protocols & p->bit) != 0;
    const char *named = offered ? "in the SII" : "not in the SII",
               *wanted = offered ? "a reply" : "mailbox error 0x0002";
    cf_step(c, "%s, %s", p->name, named);
    cf_send_mail(c, p->type, p->request, p->length);
    if (!cf_receive_mail(c, &mail, CF_MAIL_MS))
        cf_fail(c, "%s, %s: expected %s, got no mail within %d ms", p->name, named, wanted, (int)CF_MAIL_MS);
    bool error = mail.type == CF_MBX_ERROR && mail.length >= 4;
    uint16_t detail = error ? ect_load_le16(mail.data + 2) : 0;
    if (offered == (error && detail == ERROR_PROTOCOL) && error)
        cf_fail(c, "%s, %s: expected %s, got mailbox error 0x%04X", p->name, named, wanted, detail);
    cf_expect_that(c, offered || error, "%s, %s: expected %s, got a mail of type %u", p->name, named, wanted,
                   mail.type);
}

static void offered(cf_t *c)
{
    cf_go(c, CF_PREOP);
    for (size_t i = 0; i < sizeof protocols / sizeof protocols[0]; i++)
        try_protocol(c, &protocols[i]);
    cf_esi_expect_sii(c, ECT_FACT_PROTOCOLS, ECT_FACT_COE);
}

static void size(cf_t *c)
{
    const cf_facts_t *f = &c->facts;
    cf_expect(c, "version, word 0x3F", 1, word(c, WORD_SIZE + 1));
    cf_expect_that(c, f->sii_size <= f->eeprom_bytes,
                   "size by word 0x3E: expected at least the image of %zu bytes, got %u", f->sii_size, f->eeprom_bytes);
    bool ends = false;
    for (size_t at = 0x80; at + 2 <= f->sii_size && !ends;) {
        ends = ect_load_le16(f->sii + at) == 0xFFFF;
        at += ends || at + 4 > f->sii_size ? 2 : 4 + 2 * (size_t)ect_load_le16(f->sii + at + 2);
    }
    cf_expect_that(c, ends, "categories: expected an end mark within %u bytes, got none", f->eeprom_bytes);
    bool wide = (cf_get16(c, ECT_REG_SII_CONTROL) & WIDE) != 0;
    if (f->eeprom_bytes > SMALL_EEPROM && !wide)
        cf_warn(c, "word 0x3E gives %u bytes, but the chip addresses its EEPROM with one byte: up to 2048",
                f->eeprom_bytes);
    cf_esi_expect_sii(c, ECT_FACT_EEPROM_SIZE, ECT_FACT_CONFIG);
}

/* --- the SII alone ------------------------------------------------------------------------------------------------ */

static void check_sm(cf_t *c, unsigned int n, const uint8_t *entry)
{
    static const uint8_t controls[] = {0, 0x06, 0x02, 0x04, 0x00}; /* mode and direction by type */
    const uint32_t end = ECT_RAM + c->facts.ram_kb * 1024u, start = ect_load_le16(entry);
    const uint8_t type = entry[7];
    cf_expect_that(c, type <= ECT_SM_INPUTS, "SM%u: expected a type up to 4, got %u", n, type);
    if (type == 0)
        return;
    cf_expect_that(c, (entry[4] & 0x0F) == controls[type],
                   "SM%u of type %u: expected control 0x%02X in its low bits, got 0x%02X", n, type, controls[type],
                   entry[4]);
    cf_expect_that(c, start >= ECT_RAM || (start >= ECT_REG_DIGITAL_OUTPUT && start < ECT_RAM),
                   "SM%u: expected a start in the RAM, got 0x%04X", n, start);
    bool buffered = type >= ECT_SM_OUTPUTS;
    uint32_t used = buffered ? 3u * c->facts.sm[n].length : ect_load_le16(entry + 2);
    cf_expect_that(c, start + used <= end || c->facts.sm[n].length == 1,
                   "SM%u: expected within the RAM up to 0x%04X, got 0x%04X and %u bytes", n, end, start, used);
}

static bool overlap(uint32_t a, uint32_t a_size, uint32_t b, uint32_t b_size)
{
    return a_size != 0 && b_size != 0 && a < b + b_size && b < a + a_size;
}

static uint32_t span(const cf_t *c, unsigned int n)
{
    const cf_sm_t *sm = &c->facts.sm[n];
    if (sm->type == 0)
        return 0;
    return sm->type >= ECT_SM_OUTPUTS && sm->length > 1 ? 3u * sm->length : sm->length;
}

static void no_overlap(cf_t *c)
{
    for (unsigned int a = 0; a < c->facts.sm_count; a++) {
        for (unsigned int b = a + 1; b < c->facts.sm_count; b++)
            cf_expect_that(
                c, !overlap(c->facts.sm[a].start, span(c, a), c->facts.sm[b].start, span(c, b)),
                "SM%u and SM%u: expected not to overlap, three buffers included, got 0x%04X+%u and 0x%04X+%u", a, b,
                c->facts.sm[a].start, span(c, a), c->facts.sm[b].start, span(c, b));
    }
}

static void categories(cf_t *c)
{
    size_t length;
    const uint8_t *data = cf_sii_category(c, GENERAL, &length);
    cf_expect_that(c, data && length == GENERAL_BYTES, "General category: expected %d bytes, got %zu",
                   (int)GENERAL_BYTES, data ? length : 0);
    cf_expect_that(c, c->facts.fmmu_count <= c->facts.fmmus, "FMMU category: expected at most the chip's %u, got %u",
                   c->facts.fmmus, c->facts.fmmu_count);
    data = cf_sii_category(c, SYNCM, &length);
    cf_expect_that(c, data != NULL, "SyncManager category: expected, got none");
    cf_expect_that(c, length % 8 == 0 && length / 8 <= c->facts.sms,
                   "SyncManager category: expected 8 bytes for at most the chip's %u, got %zu bytes", c->facts.sms,
                   length);
    for (unsigned int n = 0; n < length / 8; n++)
        check_sm(c, n, data + (size_t)8 * n);
    no_overlap(c);
    cf_esi_expect_sii(c, ECT_FACT_PORTS, ECT_FACT_EBUS);
    cf_esi_expect_sii(c, ECT_FACT_MAILBOX_OUT, ECT_FACT_FMMU);
}

/* Compares a PDO of the SII with the object of the same index. */
static void compare_pdo(cf_t *c, const uint8_t *pdo)
{
    const uint16_t index = ect_load_le16(pdo);
    uint32_t code;
    if (!cf_object_exists(c, index, 0, &code))
        cf_fail(c, "%04Xh of the SII: expected as an object, got abort 0x%08X", index, code);
    uint64_t count = cf_upload_number(c, index, 0);
    cf_expect_that(c, count == pdo[2], "entries of %04Xh: expected %u as in the SII, got %u", index, pdo[2],
                   (unsigned int)count);
    for (uint8_t n = 0; n < pdo[2]; n++) {
        const uint8_t *e = pdo + 8 + (size_t)8 * n;
        uint32_t expected = (uint32_t)ect_load_le16(e) << 16 | (uint32_t)e[2] << 8 | e[5];
        uint32_t got = (uint32_t)cf_upload_number(c, index, (uint8_t)(n + 1));
        bool gap = ect_load_le16(e) == 0 && got >> 16 == 0;
        cf_expect_that(c, got == expected || (gap && (got & 0xFF) == e[5]),
                       "%04Xh:%02X: expected 0x%08X as in the SII, got 0x%08X", index, n + 1u, expected, got);
    }
}

static void compare_pdos(cf_t *c, uint16_t category)
{
    size_t length;
    const uint8_t *data;
    for (unsigned int nth = 0; (data = cf_sii_block(c, category, nth, &length)) != NULL; nth++) {
        for (size_t at = 0; at + 8 <= length; at += 8 + (size_t)8 * data[at + 2])
            compare_pdo(c, data + at);
    }
}

/* Counts the PDOs. A truncated PDO ends the case. */
static unsigned int count_pdos(cf_t *c, uint16_t category)
{
    unsigned int pdos = 0;
    size_t length;
    const uint8_t *data;
    for (unsigned int nth = 0; (data = cf_sii_block(c, category, nth, &length)) != NULL; nth++) {
        for (size_t at = 0; at + 8 <= length; at += 8 + (size_t)8 * data[at + 2], pdos++)
            cf_expect_that(c, at + 8 + (size_t)8 * data[at + 2] <= length, "a PDO of the SII is truncated");
    }
    return pdos;
}

static void mapping(cf_t *c)
{
    const bool coe = (c->facts.has & CF_COE) != 0, file = cf_esi_model(c) != NULL;
    unsigned int pdos = count_pdos(c, RXPDO) + count_pdos(c, TXPDO);
    if (pdos == 0 && !(file && coe))
        cf_skip(c, "the SII lists no PDOs%s", coe ? ": masters take them from CoE" : "");
    if (!file && !coe)
        cf_skip(c, "the slave has no CoE, and no ESI file was given (--esi FILE)");
    if (pdos > 0)
        cf_esi_expect_sii(c, ECT_FACT_PDO, ECT_FACT_PDO_ENTRY_TYPE);
    if (coe) {
        cf_go(c, CF_PREOP);
        compare_pdos(c, RXPDO);
        compare_pdos(c, TXPDO);
        cf_esi_expect_assigned(c);
    }
    cf_note(c, "%u PDOs", pdos);
}

static unsigned int string_count(const cf_t *c)
{
    size_t length;
    const uint8_t *table = cf_sii_category(c, STRINGS, &length);
    return table && length > 0 ? table[0] : 0;
}

static void expect_string(cf_t *c, const char *what, uint8_t index)
{
    cf_expect_that(c, index <= string_count(c), "%s: expected one of %u strings or 0, got %u", what, string_count(c),
                   index);
}

static void clocks(cf_t *c)
{
    size_t length;
    const uint8_t *data = cf_sii_category(c, DC, &length);
    const ect_esi_device_t *model = cf_esi_model(c);
    if (!data && model && model->dc_count > 0) {
        cf_warn(c, "the ESI file has %zu clock modes, the SII none: masters without the file do not know them",
                model->dc_count);
        return;
    }
    if (!data)
        cf_skip(c, "the SII has no clock modes");
    cf_expect_that(c, length % 24 == 0, "clock modes: expected 24 bytes each, got %zu in total", length);
    for (size_t at = 0; at + 24 <= length; at += 24) {
        uint16_t activate = ect_load_le16(data + at + 14);
        bool sync = (activate & 0x0700) != 0;
        cf_expect_that(c, !sync || (c->facts.has & CF_DC) != 0,
                       "mode %zu, AssignActivate 0x%04X: expected a chip with clocks, got feature word 0x%04X", at / 24,
                       activate, c->facts.features);
        cf_expect_that(c, !sync || (activate & 0x0100) != 0,
                       "mode %zu: expected the cyclic unit with SYNC0 or SYNC1, got AssignActivate 0x%04X", at / 24,
                       activate);
        expect_string(c, "name of a clock mode", data[at + 18]);
        expect_string(c, "description of a clock mode", data[at + 19]);
    }
    cf_esi_expect_sii(c, ECT_FACT_DC, ECT_FACT_DC_SYNC1);
}

/* --- the ESI file ------------------------------------------------------------------------------------------------- */

typedef struct findings {
    cf_t *c;
    size_t wrong, words;
    char first_wrong[300], first_word[300];
} findings_t;

static void find(void *ctx, bool wrong, const char *line)
{
    findings_t *f = ctx;
    size_t *count = wrong ? &f->wrong : &f->words;
    if (*count == 0)
        snprintf(wrong ? f->first_wrong : f->first_word, sizeof f->first_wrong, "%s", line);
    if (++*count <= FINDINGS_SHOWN)
        cf_remark(f->c, "%s", line);
}

/* Checks the file alone; other cases compare the slave with the file. */
static void file(cf_t *c)
{
    findings_t f = {.c = c};
    if (!c->esi->twin)
        cf_fail(c, "%.350s", c->esi->why);
    ect_esi_lint(c->esi->file, c->esi->device, find, &f);
    if (c->esi->schema)
        ect_esi_validate(c->esi->file, c->esi->schema, find, &f);
    if (f.wrong > 0)
        cf_fail(c, "%s%s", f.first_wrong, f.wrong > 1 ? ", and more" : "");
    if (f.words > 0)
        cf_warn(c, "%s%s", f.first_word, f.words > 1 ? ", and more" : "");
    cf_note(c, "%s",
            c->esi->schema ? "valid against the schema" : "not validated: name the schema of the ETG with --schema");
}

static void pdo_strings(cf_t *c, uint16_t category)
{
    size_t length;
    const uint8_t *data;
    for (unsigned int nth = 0; (data = cf_sii_block(c, category, nth, &length)) != NULL; nth++) {
        for (size_t at = 0; at + 8 <= length; at += 8 + (size_t)8 * data[at + 2]) {
            expect_string(c, "name of a PDO", data[at + 5]);
            for (size_t e = at + 8; e + 8 <= length && e < at + 8 + (size_t)8 * data[at + 2]; e += 8)
                expect_string(c, "name of a PDO's entry", data[e + 3]);
        }
    }
}

static void strings(cf_t *c)
{
    size_t length, at = 1;
    const uint8_t *table = cf_sii_category(c, STRINGS, &length);
    const uint8_t *general;
    if (table) {
        for (unsigned int n = 0; n < table[0]; n++) {
            cf_expect_that(c, at < length && at + 1 + table[at] <= length,
                           "string %u of %u: expected complete, got truncated", n + 1, table[0]);
            at += 1u + table[at];
        }
    }
    general = cf_sii_category(c, GENERAL, &length);
    for (size_t n = 0; general && n < 4 && n < length; n++)
        expect_string(c, "a string of the General category", general[n]);
    pdo_strings(c, RXPDO);
    pdo_strings(c, TXPDO);
    cf_esi_expect_sii(c, ECT_FACT_TYPE, ECT_FACT_GROUP_NAME);
}

static void alias(cf_t *c)
{
    size_t length;
    const uint8_t *general = cf_sii_category(c, GENERAL, &length);
    uint16_t shown = cf_get16(c, ECT_REG_STATION_ALIAS);
    cf_expect(c, "station alias (0x0012) and word 4", word(c, WORD_ALIAS), shown);
    (void)command(c, COMMAND_RELOAD, 0);
    cf_expect(c, "station alias after a reload, which does not change it", shown, cf_get16(c, ECT_REG_STATION_ALIAS));
    if (general && length > GENERAL_FLAGS)
        cf_expect_that(c, (general[GENERAL_FLAGS] & 0x18) != 0x18,
                       "identification: expected by AL status or by physical memory, got both in 0x%02X",
                       general[GENERAL_FLAGS]);
}

static void again(cf_t *c)
{
    uint8_t data[8];
    for (size_t at = 0; at < c->facts.sii_size;) {
        unsigned int bytes = cf_sii_read(c, (uint16_t)(at / 2), data);
        size_t left = c->facts.sii_size - at;
        cf_expect_bytes(c, "the image, read again", c->facts.sii + at, data, bytes < left ? bytes : left);
        at += bytes;
    }
}

static const cf_case_t cases[] = {
    {"CF-054", "The checksum of the first words is right, and PDI control equals that of the chip", 'S', CF_SII, 0,
     checksum},
    {"CF-055", "Reads return 4 or 8 bytes as announced by the chip; wrong commands and addresses have no effect", 'R',
     CF_SII, 0, reading},
    {"CF-056", "A write needs the write enable bit, commands need ownership; a reload changes nothing", 'R', CF_SII, 0,
     writing},
    {"CF-057", "Identity in the SII, in 1018h and in the ESI is the same", 'S', CF_SII, 0, identity},
    {"CF-058", "Each protocol in SII and ESI replies; any other protocol gets mailbox error 0x0002", 'S',
     CF_SII | CF_MAILBOX, 0, offered},
    {"CF-059", "The image ends within the EEPROM; size and first words equal those of the ESI", 'S', CF_SII, 0, size},
    {"CF-060", "General, FMMU and SyncManager categories match each other, the chip and the ESI", 'S', CF_SII, 0,
     categories},
    {"CF-061", "PDOs of the SII equal those of the dictionary and of the ESI, entry by entry", 'S', CF_SII, 60000,
     mapping},
    {"CF-062", "Clock modes match the chip and the ESI", 'S', CF_SII, 0, clocks},
    {"CF-063", "The ESI file follows the rules for files and describes a possible device", 'S', CF_ESI, 0, file},
    {"CF-064", "Every referenced string exists and is complete; names equal those of the ESI", 'S', CF_SII, 0, strings},
    {"CF-065", "Alias of EEPROM and register agree; identification is declared once", 'S', CF_SII, 0, alias},
    {"CF-066", "A second read of the image gives the same bytes", 'F', CF_SII, 60000, again},
};

CF_SECTION(cf_eeprom, 'F', "EEPROM and SII", cases);
