/* SPDX-License-Identifier: MIT */
/* Slaves on the segment, and the features of the slave under test. */
#include "probe.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "sii/sii.h"
#include "steps/engine.h"
#include "steps/reader.h"

enum { NO_LRW = 0x0200, NO_RW = 0x0400, HAS_DC = 0x0004 };
enum {
    WORD_ALIAS = 4,
    WORD_VENDOR = 8,
    WORD_BOOT = 0x14,
    WORD_MAILBOX = 0x18,
    WORD_PROTOCOLS = 0x1C,
    WORD_SIZE = 0x3E
};
enum { GENERAL_COE = 5, COE_INFO = 0x02, COE_COMPLETE = 0x20, ASSIGNMENTS = 0x1C10, SCAN_MS = 500 };

/* Ends the states set by another master. The second request is for device emulation, which copies the acknowledge bit
 * to the error flag; a slave's software has had no time to read the first request, and reads only the second. */
static void all_to_init(cf_t *c)
{
    static const uint8_t requests[] = {CF_INIT | ECT_AL_ACKNOWLEDGE, CF_INIT};
    for (size_t i = 0; i < sizeof requests; i++) {
        uint8_t request[2] = {requests[i], 0};
        cf_datagram_t d = {.command = CF_BWR, .address = CF_AT(0, ECT_REG_AL_CONTROL), .length = 2, .data = request};
        (void)cf_port_exchange(c->engine->port, &d, 1, SCAN_MS);
    }
}

uint16_t cf_scan(cf_t *c)
{
    uint8_t byte[2] = {0};
    all_to_init(c);
    cf_datagram_t scan = {.command = CF_BRD, .address = CF_AT(0, ECT_REG_TYPE), .length = 1, .data = byte};
    if (!cf_port_exchange(c->engine->port, &scan, 1, SCAN_MS))
        return 0;
    for (uint16_t n = 0; n < scan.wkc; n++) {
        ect_store_le16(byte, (uint16_t)(CF_STATION + n));
        cf_datagram_t name = {
            .command = CF_APWR, .address = CF_AT((uint16_t)-n, ECT_REG_STATION_ADDRESS), .length = 2, .data = byte};
        (void)cf_port_exchange(c->engine->port, &name, 1, SCAN_MS);
    }
    return scan.wkc;
}

static void read_chip(cf_t *c)
{
    cf_facts_t *f = &c->facts;
    uint8_t id[10], pdi[2], time[4];
    cf_get(c, ECT_REG_TYPE, id, sizeof id);
    cf_get(c, ECT_REG_PDI_CONTROL, pdi, sizeof pdi);
    f->type = id[0];
    f->revision = id[1];
    f->build = ect_load_le16(id + 2);
    f->fmmus = id[4] < CF_MAX_FMMUS ? id[4] : CF_MAX_FMMUS;
    f->sms = id[5] < CF_MAX_SMS ? id[5] : CF_MAX_SMS;
    f->ram_kb = id[6];
    f->ports = id[7];
    f->features = ect_load_le16(id + 8);
    f->pdi = ect_load_le16(pdi);
    f->has |= (pdi[1] & 1) != 0 ? CF_EMULATION : CF_APPLICATION;
    f->has |= (f->features & NO_LRW) == 0 ? CF_LRW_OK : 0;
    f->has |= (f->features & NO_RW) == 0 ? CF_RW : 0;
    f->has |= (f->features & HAS_DC) != 0 && cf_read(c, ECT_REG_DC_SYSTEM_TIME, time, sizeof time) == 1 ? CF_DC : 0;
    f->has |= f->slaves > 1 ? CF_CHAIN : 0;
}

/* --- SII ---------------------------------------------------------------------------------------------------------- */

static uint16_t word(const cf_facts_t *f, unsigned int n)
{
    return f->sii_size >= 2 * (size_t)n + 2 ? ect_load_le16(f->sii + 2 * (size_t)n) : 0;
}

/* Reads only up to the end mark: the rest of a large EEPROM contains no data. */
static void read_image(cf_t *c)
{
    cf_facts_t *f = &c->facts;
    uint8_t *image = calloc(1, ECT_READER_SII);
    if (!image)
        cf_fail(c, "out of memory");
    f->sii = image;
    ect_reader_t *reader = cf_reader_open(c);
    cf_reader_close(c, ect_reader_sii_content(reader, image, &f->sii_size));
    f->eeprom_bytes = (word(f, WORD_SIZE) + 1u) * 128u;
    f->has |= CF_SII;
}

static void take_protocols(cf_t *c)
{
    cf_facts_t *f = &c->facts;
    const cf_mailbox_t *m = &c->mailbox;
    bool fits = m->out_size > 0 && m->in_size > 0 && m->out_size <= CF_MAX_MAIL && m->in_size <= CF_MAX_MAIL;
    if (f->protocols == 0 || !fits)
        return;
    f->has |= CF_MAILBOX;
    f->has |= (f->protocols & CF_PROTO_COE) != 0 ? CF_COE : 0;
    f->has |= (f->protocols & CF_PROTO_FOE) != 0 ? CF_FOE : 0;
    f->has |= (f->protocols & CF_PROTO_EOE) != 0 ? CF_EOE : 0;
    if (f->boot.out_size > 0 && f->boot.in_size > 0 && (f->has & CF_FOE) != 0)
        f->has |= CF_BOOTSTRAP; /* sizes alone do not prove BOOT: many images have them; BOOT needs FoE */
}

static void take_head(cf_t *c)
{
    cf_facts_t *f = &c->facts;
    f->alias = word(f, WORD_ALIAS);
    f->vendor = ect_load_le32(f->sii + 2 * WORD_VENDOR);
    f->product = ect_load_le32(f->sii + 2 * WORD_VENDOR + 4);
    f->revision_no = ect_load_le32(f->sii + 2 * WORD_VENDOR + 8);
    f->serial = ect_load_le32(f->sii + 2 * WORD_VENDOR + 12);
    f->protocols = word(f, WORD_PROTOCOLS);
    f->boot =
        (cf_mailbox_t){word(f, WORD_BOOT), word(f, WORD_BOOT + 1), word(f, WORD_BOOT + 2), word(f, WORD_BOOT + 3)};
    c->mailbox = (cf_mailbox_t){word(f, WORD_MAILBOX), word(f, WORD_MAILBOX + 1), word(f, WORD_MAILBOX + 2),
                                word(f, WORD_MAILBOX + 3)};
    take_protocols(c);
}

static void take_sm(cf_facts_t *f, unsigned int n, const uint8_t *entry)
{
    f->sm[n] = (cf_sm_t){.start = ect_load_le16(entry),
                         .length = ect_load_le16(entry + 2),
                         .control = entry[4],
                         .enable = entry[6],
                         .type = entry[7]};
    if (f->sm[n].type == 0 &&
        f->sm[n].start != 0) { /* older images are without a type: it follows from the control byte */
        bool mailbox = (entry[4] & ECT_SM_CONTROL_MODE) == ECT_SM_CONTROL_MAILBOX;
        bool writes = (entry[4] & ECT_SM_CONTROL_DIRECTION) == ECT_SM_CONTROL_ECAT_WRITES;
        f->sm[n].type = (uint8_t)((mailbox ? ECT_SM_MAILBOX_OUT : ECT_SM_OUTPUTS) + (writes ? 0 : 1));
    }
}

static void take_fmmus(cf_t *c)
{
    cf_facts_t *f = &c->facts;
    size_t length;
    const uint8_t *data = cf_sii_category(c, ECT_SII_FMMU, &length);
    for (unsigned int n = 0; data && n < CF_MAX_FMMUS && n < length && data[n] != 0xFF; n++) {
        f->fmmu_use[n] = data[n];
        f->fmmu_count = (uint8_t)(n + 1);
    }
}

static void take_general(cf_t *c)
{
    cf_facts_t *f = &c->facts;
    size_t length;
    uint8_t size;
    const uint8_t *data = cf_sii_category(c, ECT_SII_GENERAL, &length);
    if (!data || length <= GENERAL_COE)
        return;
    const char *name = ect_sii_string(f->sii, f->sii_size, data[3], &size);
    f->coe_details = data[GENERAL_COE];
    if (name)
        snprintf(f->name, sizeof f->name, "%.*s", (int)size, name);
}

static void take_categories(cf_t *c)
{
    cf_facts_t *f = &c->facts;
    size_t length;
    const uint8_t *data = cf_sii_category(c, ECT_SII_SYNCM, &length);
    for (unsigned int n = 0; data && n < CF_MAX_SMS && 8 * (size_t)n + 8 <= length; n++) {
        take_sm(f, n, data + 8 * (size_t)n);
        f->sm_count = (uint8_t)(n + 1);
    }
    take_fmmus(c);
    take_general(c);
    if ((f->has & CF_MAILBOX) != 0 && f->sm_count < 2) { /* an image without the category: the usual control bytes */
        f->sm[0].control = ECT_SM_CONTROL_MAILBOX | ECT_SM_CONTROL_ECAT_WRITES | ECT_SM_CONTROL_AL_EVENT;
        f->sm[1].control = ECT_SM_CONTROL_MAILBOX | ECT_SM_CONTROL_AL_EVENT;
    }
}

/* @return bits of a SyncManager in one category of PDOs */
static size_t block_bits(const uint8_t *data, size_t length, unsigned int sm)
{
    size_t at = 0, bits = 0;
    while (at + 8 <= length) {
        size_t entries = data[at + 2];
        for (size_t i = 0; i < entries && at + 16 + 8 * i <= length && data[at + 3] == sm; i++)
            bits += data[at + 8 + 8 * i + 5];
        at += 8 + 8 * entries;
    }
    return bits;
}

/* @return bits of a SyncManager in all categories of PDOs */
static size_t sii_bits(const cf_t *c, uint16_t category, unsigned int sm)
{
    size_t length, bits = 0;
    const uint8_t *data;
    for (unsigned int nth = 0; (data = cf_sii_block(c, category, nth, &length)) != NULL; nth++)
        bits += block_bits(data, length, sm);
    return bits;
}

/* --- CoE ---------------------------------------------------------------------------------------------------------- */

/* Sum over the PDOs of an assignment. */
typedef struct mapped {
    size_t bits;
    unsigned int named, found;
    bool assigned; /* the slave has the assignment */
    bool whole;    /* no value is missing */
} mapped_t;

static void count_object(void *ctx, const ect_reader_object_t *object)
{
    mapped_t *m = ctx;
    m->assigned = m->assigned || object->index >= ASSIGNMENTS;
    m->found += object->index < ASSIGNMENTS;
}

static void add_entry(void *ctx, const ect_reader_object_t *object, const ect_reader_entry_t *entry)
{
    mapped_t *m = ctx;
    m->whole = m->whole && entry->value.data != NULL;
    if (entry->subindex == 0 || !m->whole)
        return;
    if (object->index < ASSIGNMENTS)
        m->bits += entry->value.data[0];
    else
        m->named++;
}

/* Adds up the bits of a SyncManager's assignment. @return false: unreadable */
static bool coe_bits(cf_t *c, unsigned int sm, size_t *bits)
{
    mapped_t m = {.whole = true};
    const ect_reader_sink_t sink = {.ctx = &m, .object = count_object, .entry = add_entry};
    ect_reader_t *reader = cf_reader_open(c);
    cf_reader_close(c, ect_reader_assigned(reader, UINT32_C(1) << sm, &sink));
    *bits = m.bits;
    return m.assigned && m.whole && m.found == m.named;
}

static void take_lengths(cf_t *c, bool coe)
{
    cf_facts_t *f = &c->facts;
    for (unsigned int n = 0; n < f->sm_count; n++) {
        cf_sm_t *sm = &f->sm[n];
        bool outputs = sm->type == ECT_SM_OUTPUTS;
        if (!outputs && sm->type != ECT_SM_INPUTS)
            continue;
        size_t bits = sii_bits(c, outputs ? ECT_SII_RXPDO : ECT_SII_TXPDO, n);
        size_t mapped;
        if (coe && coe_bits(c, n, &mapped))
            bits = mapped;
        else if (bits == 0 && (sm->enable & 1) != 0)
            bits = 8 * (size_t)sm->length;
        sm->length = (uint16_t)((bits + 7) / 8);
        if (outputs)
            f->output_bytes = (uint16_t)(f->output_bytes + sm->length);
        else
            f->input_bytes = (uint16_t)(f->input_bytes + sm->length);
    }
    f->has |= (f->output_bytes > 0 ? CF_OUTPUTS : 0) | (f->input_bytes > 0 ? CF_INPUTS : 0);
}

/* A service that replies counts as offered, whatever the SII contains; CF-058 compares the two. */
static void try_services(cf_t *c)
{
    cf_facts_t *f = &c->facts;
    uint8_t data[64];
    size_t size = sizeof data;
    cf_mail_t mail;
    const uint8_t list[2] = {0, 0}, request[6] = {1, 0, 0, 0, list[0], list[1]};
    if ((f->coe_details & COE_COMPLETE) != 0 || cf_upload(c, 0x1018, 0, true, data, &size) == 0)
        f->has |= CF_COMPLETE;
    cf_send_coe(c, CF_COE_INFO, request, sizeof request);
    bool replied = cf_receive_mail(c, &mail, CF_MAIL_MS) && mail.type == CF_MBX_COE && mail.length >= 6 &&
                   (mail.data[2] & 0x7F) == 2;
    if ((f->coe_details & COE_INFO) != 0 || replied)
        f->has |= CF_SDO_INFO;
    size = sizeof data - 1;
    if (f->name[0] == 0 && cf_upload(c, 0x1008, 0, false, data, &size) == 0)
        snprintf(f->name, sizeof f->name, "%.*s", (int)size, (const char *)data);
}

/* The first axis may be missing: a device of modules has those that are fitted. */
static void find_axes(cf_t *c)
{
    enum { STATUS = 0x6041, CONTROL = 0x6040, AXIS = 0x800, AXES = 8 };
    uint32_t code;
    for (unsigned int axis = 0; axis < AXES && (c->facts.has & CF_DRIVE) == 0; axis++) {
        if (cf_object_exists(c, (uint16_t)(STATUS + AXIS * axis), 0, &code) &&
            cf_object_exists(c, (uint16_t)(CONTROL + AXIS * axis), 0, &code))
            c->facts.has |= CF_DRIVE;
    }
}

void cf_probe(cf_t *c)
{
    read_chip(c);
    cf_known_state(c);
    read_image(c);
    take_head(c);
    take_categories(c);
    bool coe = (c->facts.has & CF_COE) != 0;
    if (coe)
        cf_go(c, CF_PREOP);
    take_lengths(c, coe);
    if (coe) {
        try_services(c);
        find_axes(c);
    }
    cf_known_state(c);
}
