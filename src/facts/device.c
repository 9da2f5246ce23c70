/* SPDX-License-Identifier: MIT */
/* Facts of a description. */
#include <inttypes.h>
#include <string.h>

#include "esi/twin.h"
#include "facts/facts.h"
#include "sii/sii.h"
#include "wire/assert.h"
#include "wire/bytes.h"

static void add_text(ect_facts_t *facts, ect_fact_kind_t kind, unsigned int index, unsigned int element,
                     const char *text)
{
    ect_facts_add_text(facts, kind, index, element, text, text ? strlen(text) : 0);
}

/* Adds the ports as in an EEPROM: MII, EBUS, or unknown. */
static void add_ports(ect_facts_t *facts, const char *physics)
{
    char ports[4];
    size_t count = 0;
    for (; count < sizeof ports && physics[count] != '\0'; count++)
        ports[count] = strchr("YKH", physics[count]) != NULL ? physics[count] : ' ';
    ect_facts_add_text(facts, ECT_FACT_PORTS, 0, 0, ports, count);
}

static void add_identity(ect_facts_t *facts, const ect_device_t *device)
{
    (void)ect_facts_add(facts, ECT_FACT_VENDOR, 0, 0, "0x%08" PRIX32, device->identity.vendor_id);
    (void)ect_facts_add(facts, ECT_FACT_PRODUCT, 0, 0, "0x%08" PRIX32, device->identity.product_code);
    (void)ect_facts_add(facts, ECT_FACT_REVISION, 0, 0, "0x%08" PRIX32, device->identity.revision);
    add_text(facts, ECT_FACT_TYPE, 0, 0, device->type_name);
    add_text(facts, ECT_FACT_NAME, 0, 0, device->full_name ? device->full_name : device->type_name);
    add_text(facts, ECT_FACT_VENDOR_NAME, 0, 0, device->vendor_name);
    add_text(facts, ECT_FACT_GROUP, 0, 0, device->group_type);
    add_text(facts, ECT_FACT_GROUP_NAME, 0, 0, device->group_name);
    add_ports(facts, device->physics ? device->physics : "");
    (void)ect_facts_add(facts, ECT_FACT_EBUS, 0, 0, "%d mA", device->ebus_ma);
}

static void add_timeouts(ect_facts_t *facts, const ect_timeouts_t *t)
{
    const uint16_t values[] = {t->preop_ms,          t->safeop_op_ms,       t->back_to_init_ms,
                               t->back_to_safeop_ms, t->mailbox_request_ms, t->mailbox_response_ms};
    for (unsigned int i = 0; i < sizeof values / sizeof values[0]; i++) {
        if (values[i] != 0)
            (void)ect_facts_add(facts, ECT_FACT_TIMEOUT, i, 0, "%u ms", values[i]);
    }
}

/* Skips word 4, the alias, which depends on the installation. */
static void add_eeprom(ect_facts_t *facts, const ect_device_t *device)
{
    (void)ect_facts_add(facts, ECT_FACT_EEPROM_SIZE, 0, 0, "%u bytes", device->sii_size);
    for (unsigned int word = 0; word < sizeof device->esc_config / 2; word++) {
        if (word != 4)
            (void)ect_facts_add(facts, ECT_FACT_CONFIG, word, 0, "0x%04X",
                                ect_load_le16(device->esc_config + 2 * word));
    }
    (void)ect_facts_add(facts, ECT_FACT_CHECKSUM, 0, 0, "right");
}

static void add_layout(ect_facts_t *facts, const ect_device_t *device)
{
    const ect_sm_t *out = NULL;
    const ect_sm_t *in = NULL;
    for (unsigned int i = 0; i < device->sm_count; i++) {
        const ect_sm_t *sm = &device->sm[i];
        uint16_t bytes = ect_device_sm_bytes(device, i);
        out = sm->type == ECT_SM_MAILBOX_OUT ? sm : out;
        in = sm->type == ECT_SM_MAILBOX_IN ? sm : in;
        ect_facts_add_sm(facts, i, ect_sm_role(sm));
        (void)ect_facts_add(facts, ECT_FACT_SM_START, i, 0, "0x%04X", sm->start);
        (void)ect_facts_add(facts, ECT_FACT_SM_CONTROL, i, 0, "0x%02X", sm->control);
        if (ect_sm_role(sm) == ECT_SM_UNUSED)
            continue;
        (void)ect_facts_add(facts, ECT_FACT_SM_LENGTH, i, 0, "%u bytes", bytes);
        if (bytes > 0)
            (void)ect_facts_add(facts, ECT_FACT_SM_ENABLED, i, 0, "yes");
    }
    facts->complete[ECT_FACT_SM] = true;
    ect_facts_add_mailbox(facts, ECT_FACT_MAILBOX_OUT, out ? out->start : 0, out ? out->length : 0);
    ect_facts_add_mailbox(facts, ECT_FACT_MAILBOX_IN, in ? in->start : 0, in ? in->length : 0);
    ect_facts_add_mailbox(facts, ECT_FACT_BOOT_OUT, device->boot_out.start, device->boot_out.length);
    ect_facts_add_mailbox(facts, ECT_FACT_BOOT_IN, device->boot_in.start, device->boot_in.length);
    ect_facts_add_fmmus(facts, device->fmmu, device->fmmu_count);
    ect_facts_add_protocols(facts, device->mailbox_protocols, device->coe_details);
}

static void add_clocks(ect_facts_t *facts, const ect_device_t *device)
{
    for (unsigned int i = 0; i < device->dc_mode_count; i++) {
        const ect_dc_mode_t *mode = &device->dc_modes[i];
        (void)ect_facts_add(facts, ECT_FACT_DC, i, 0, "\"%s\"", mode->name);
        (void)ect_facts_add(facts, ECT_FACT_DC_ACTIVATE, i, 0, "0x%04X", mode->assign_activate);
        (void)ect_facts_add(facts, ECT_FACT_DC_SYNC0, i, 0, "%" PRIu32 " ns, factor %d, shift %" PRId32 " ns",
                            mode->cycle_sync0_ns, mode->factor_sync0, mode->shift_sync0_ns);
        (void)ect_facts_add(facts, ECT_FACT_DC_SYNC1, i, 0, "factor %d, shift %" PRId32 " ns", mode->factor_sync1,
                            mode->shift_sync1_ns);
    }
    facts->complete[ECT_FACT_DC] = true;
}

/* --- PDOs -------------------------------------------------------------------------------------------------------- */

static void add_pdo(ect_facts_t *facts, const ect_device_t *device, const ect_od_t *od, const ect_object_t *pdo)
{
    uint8_t sm = ect_sii_pdo_sm(device, pdo->index);
    const uint16_t number = ect_sii_pdo_number(device, pdo->index);
    (void)ect_facts_add(facts, ECT_FACT_PDO, number, 0, "%s", ect_od_is_rxpdo(pdo->index) ? "outputs" : "inputs");
    add_text(facts, ECT_FACT_PDO_NAME, number, 0, pdo->name);
    (void)(sm == 0xFF ? ect_facts_add(facts, ECT_FACT_PDO_SM, number, 0, "none")
                      : ect_facts_add(facts, ECT_FACT_PDO_SM, number, 0, "%u", sm));
    for (uint32_t n = 1; n <= ect_od_element(pdo, 0) && n <= 255; n++) {
        uint32_t mapping = ect_od_element(pdo, n);
        const uint32_t written = ect_sii_pdo_element(device, pdo, n);
        const ect_entry_t *entry = ect_od_mapped(od, mapping);
        ect_facts_add_mapping(facts, number, n, written >> 16, written >> 8 & 0xFF, written & 0xFF);
        if (entry == NULL)
            continue;
        add_text(facts, ECT_FACT_PDO_ENTRY_NAME, number, n, entry->name);
        (void)ect_facts_add(facts, ECT_FACT_PDO_ENTRY_TYPE, number, n, "0x%02X", entry->data_type & 0xFFu);
    }
}

/* --- dictionary -------------------------------------------------------------------------------------------------- */

static void load_default(const ect_entry_t *entry, const ect_detail_t *detail, uint8_t *wire, uint16_t size)
{
    if (detail && detail->initial)
        memcpy(wire, detail->initial, size);
    else
        ect_store_le32(wire, entry->value);
}

/* Adds the default of device type and name, constants with the value that a slave returns. */
static void add_identity_default(ect_facts_t *facts, const ect_od_t *od, uint16_t index, const ect_entry_t *entry)
{
    const bool constant = (entry->access & (ECT_ACCESS_SHARED | ECT_ACCESS_DESCRIPTION)) != 0;
    const uint16_t length = constant ? ect_od_upload_size(od, entry) : ect_od_bytes(entry);
    uint8_t wire[256] = {0};
    if (length > sizeof wire)
        return;
    if (constant && ect_od_data(od, entry) != NULL)
        ect_od_read(od, entry, 0, wire, length);
    else
        load_default(entry, ect_od_detail(od, index, (uint8_t)entry->subindex), wire, length);
    ect_facts_add_default(facts, index, entry->subindex, wire, length);
}

static void add_default(ect_facts_t *facts, const ect_od_t *od, uint16_t index, const ect_entry_t *entry)
{
    const bool constant = (entry->access & (ECT_ACCESS_SHARED | ECT_ACCESS_DESCRIPTION)) != 0;
    const uint16_t size = ect_od_bytes(entry);
    uint8_t wire[8] = {0};
    if (index == 0x1000 || index == 0x1008) {
        add_identity_default(facts, od, index, entry);
        return;
    }
    if (ect_facts_are_known_elsewhere(index) || constant || size == 0 || size > sizeof wire || ect_od_is_string(entry))
        return;
    load_default(entry, ect_od_detail(od, index, (uint8_t)entry->subindex), wire, size);
    ect_facts_add_default(facts, index, entry->subindex, wire, size);
}

static void add_entry(ect_facts_t *facts, const ect_od_t *od, uint16_t index, const ect_entry_t *entry)
{
    const ect_detail_t *detail = ect_od_detail(od, index, (uint8_t)entry->subindex);
    if (!ect_facts_are_of_pdos(index)) {
        (void)ect_facts_add(facts, ECT_FACT_ENTRY, index, entry->subindex, "%u bits", ect_od_bits(od, entry));
        add_default(facts, od, index, entry);
    }
    (void)ect_facts_add(facts, ECT_FACT_ENTRY_TYPE, index, entry->subindex, "0x%04X", entry->data_type);
    ect_facts_add_access(facts, index, entry->subindex, entry->access & ECT_ACCESS_WIRE);
    add_text(facts, ECT_FACT_ENTRY_NAME, index, entry->subindex, entry->name);
    if (detail && detail->minimum != detail->maximum)
        (void)ect_facts_add(facts, ECT_FACT_ENTRY_LIMITS, index, entry->subindex, "%" PRId64 " to %" PRId64,
                            detail->minimum, detail->maximum);
    if (detail && detail->unit != 0)
        (void)ect_facts_add(facts, ECT_FACT_ENTRY_UNIT, index, entry->subindex, "0x%04X", detail->unit);
}

static void add_dictionary(ect_facts_t *facts, const ect_device_t *device, const ect_od_t *od)
{
    const ect_object_t *objects = ect_esi_reported(device);
    for (uint16_t i = 0; i < device->object_count; i++) {
        const ect_object_t *object = &objects[i];
        (void)ect_facts_add(facts, ECT_FACT_OBJECT, object->index, 0, "code %u", object->object_code);
        if (!ect_facts_are_of_pdos(object->index))
            add_text(facts, ECT_FACT_OBJECT_NAME, object->index, 0, object->name);
        for (const ect_entry_t *e = object->entries; e; e = ect_od_next(object, e))
            add_entry(facts, od, object->index, e);
    }
    facts->complete[ECT_FACT_OBJECT] = true;
    facts->complete[ECT_FACT_ENTRY] = true;
}

void ect_facts_of_device(ect_facts_t *facts, const ect_device_t *device)
{
    ECT_ASSERT(device->sm_count <= ECT_SMS && device->fmmu_count <= ECT_FMMUS);
    ECT_ASSERT(device->objects != NULL || device->object_count == 0);
    ect_od_t od = ect_device_od(device, NULL);
    add_identity(facts, device);
    add_timeouts(facts, &device->timeouts);
    add_eeprom(facts, device);
    add_layout(facts, device);
    add_clocks(facts, device);
    for (uint16_t i = 0; i < device->object_count; i++) {
        const ect_object_t *object = &device->objects[i];
        if (ect_od_is_rxpdo(object->index) || ect_od_is_txpdo(object->index))
            add_pdo(facts, device, &od, object);
    }
    facts->complete[ECT_FACT_PDO] = true;
    facts->complete[ECT_FACT_PDO_ENTRY] = true;
    if ((device->mailbox_protocols & ECT_MAILBOX_COE) != 0)
        add_dictionary(facts, device, &od);
}
