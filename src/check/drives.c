/* SPDX-License-Identifier: MIT */
/* Checks of SoE: its place in the instance, the tables of IDNs, and the objects that process data map. */
#include "check/internal.h"
#include "seams/soe.h"
#include "seams/standard.h"

/* One IDN of a drive. */
typedef struct row {
    const report_t *r;
    const ect_soe_drive_t *drive;
    const ect_soe_idn_t *idn;
    unsigned int number; /* of the drive */
} row_t;

static bool wrong_idn(const row_t *row, const char *what)
{
    const uint16_t idn = row->idn->idn;
    return wrong(row->r, "protocols: SoE drive %u, %c-%u-%04u: %s", row->number, idn >> 15 != 0 ? 'P' : 'S',
                 idn >> 12 & 7u, idn & 0xFFFu, what);
}

static bool is_inside(const report_t *r, size_t offset, size_t size)
{
    const size_t whole = r->device->instance_size;
    return offset >= sizeof(ect_standard_t) && offset <= whole && size <= whole - offset;
}

static bool is_list(const ect_soe_idn_t *idn)
{
    return (idn->attribute & ECT_SOE_LIST) != 0;
}

static bool is_command(const ect_soe_idn_t *idn)
{
    return (idn->attribute & ECT_SOE_COMMAND) != 0;
}

static size_t capacity(const ect_soe_idn_t *idn)
{
    return idn->size != 0 ? idn->size : idn->used;
}

/* Bytes of an IDN in the instance, and their alignment. */
static size_t memory_of(const ect_soe_idn_t *idn, size_t *alignment)
{
    const size_t width = ect_soe_width(idn->attribute);
    *alignment = is_list(idn) || is_command(idn) ? sizeof(uint16_t) : width;
    if (is_command(idn))
        return sizeof(ect_soe_command_t);
    return is_list(idn) ? sizeof(uint16_t) + capacity(idn) : width;
}

static bool command_good(const row_t *row)
{
    const ect_soe_idn_t *idn = row->idn;
    if (is_list(idn) || ect_soe_width(idn->attribute) != 2 || idn->offset == 0)
        return wrong_idn(row, "a command has 16 bits and memory");
    return true;
}

static bool list_good(const row_t *row)
{
    const ect_soe_idn_t *idn = row->idn;
    const unsigned int width = ect_soe_width(idn->attribute);
    if ((idn->flags & (ECT_SOE_MINIMUM | ECT_SOE_MAXIMUM | ECT_SOE_DEFAULT)) != 0)
        return wrong_idn(row, "a list has no limits and no default on the wire");
    if (idn->used > capacity(idn) || capacity(idn) % width != 0 || idn->used % width != 0)
        return wrong_idn(row, "the lengths of a list are multiples of its elements, and 'used' is not above 'size'");
    if (idn->used > 0 && !idn->content)
        return wrong_idn(row, "the content of the list is missing");
    return true;
}

static bool value_good(const row_t *row)
{
    const ect_soe_idn_t *idn = row->idn;
    size_t alignment = 0;
    const size_t size = memory_of(idn, &alignment);
    if (is_command(idn) && !command_good(row))
        return false;
    if (is_list(idn) && !list_good(row))
        return false;
    if (ect_soe_is_made(idn) && (!is_list(idn) || ect_soe_width(idn->attribute) != 2))
        return wrong_idn(row, "it is a list of 16 bits");
    if (idn->offset != 0 && (!is_inside(row->r, idn->offset, size) || idn->offset % alignment != 0))
        return wrong_idn(row, "its memory is not inside the instance, or not aligned");
    return true;
}

/* An IDN of process data stands for an entry of its length. */
static bool mapping_good(const row_t *row)
{
    const ect_soe_idn_t *idn = row->idn;
    const bool in_mdt = (idn->flags & ECT_SOE_IN_MDT) != 0;
    const bool in_at = (idn->flags & ECT_SOE_IN_AT) != 0;
    if ((!in_mdt || row->drive->mdt == 0) && (!in_at || row->drive->at == 0))
        return true;
    const ect_entry_t *entry = ect_od_mapped(&row->r->od, idn->mapping);
    const uint16_t needed = (uint16_t)((in_mdt && row->drive->mdt != 0 ? ECT_ACCESS_RXPDO : 0) |
                                       (in_at && row->drive->at != 0 ? ECT_ACCESS_TXPDO : 0));
    if (!entry || (entry->access & needed) != needed || is_list(idn) ||
        (idn->mapping & 0xFF) != 8u * ect_soe_width(idn->attribute) || entry->bit_length != (idn->mapping & 0xFF))
        return wrong_idn(row, "its mapping is no entry of its length that can be mapped in this direction");
    return true;
}

static bool writable(const ect_object_t *object, unsigned int subindex)
{
    const ect_entry_t *entry = ect_od_entry(object, (uint8_t)subindex);
    return entry && entry->data && (entry->access & (ECT_ACCESS_SHARED | ECT_ACCESS_DESCRIPTION)) == 0;
}

/* Whether element `n` + 2 of a mapping object is by default the IDN that a list has at `n`. */
static bool default_good(const row_t *row, const ect_object_t *object, unsigned int n, unsigned int flag)
{
    const ect_soe_drive_t *drive = row->drive;
    const uint8_t *bytes = (const uint8_t *)row->idn->content + 2u * (size_t)n;
    for (unsigned int i = 0; i < drive->count; i++) {
        const ect_soe_idn_t *mapped = &drive->idns[i];
        if (mapped->idn == (bytes[0] | bytes[1] << 8))
            return (mapped->flags & flag) != 0 && ect_od_element(object, n + 2) == mapped->mapping;
    }
    return false;
}

static bool defaults_good(const row_t *row, const ect_object_t *object, unsigned int flag)
{
    const unsigned int count = row->idn->used / 2u;
    bool good = ect_od_element(object, 0) == count + 1;
    for (unsigned int n = 0; n < count; n++)
        good = good && default_good(row, object, n, flag);
    return good || wrong_idn(row, "the mapping object of its process data has another default");
}

/* The mapping object of a list has the list's IDNs as its default, behind one element, and room for all. */
static bool process_list_good(const row_t *row, uint16_t index, unsigned int flag)
{
    const ect_soe_idn_t *list = row->idn;
    const ect_object_t *object = ect_od_find(&row->r->od, index);
    const size_t most = capacity(list) / 2;
    if (!is_list(list) || ect_soe_width(list->attribute) != 2 || list->offset == 0)
        return wrong_idn(row, "it is a list of 16 bits with memory");
    if (index == 0)
        return true;
    if (!object || most + 1 > UINT8_MAX || !writable(object, 0))
        return wrong_idn(row, "the mapping object of its process data is missing, or constant");
    for (unsigned int n = 2; n < most + 2; n++) {
        if (!writable(object, n))
            return wrong_idn(row, "the mapping object of its process data has no memory for each IDN");
    }
    return defaults_good(row, object, flag);
}

static bool idn_good(const row_t *row)
{
    const ect_soe_drive_t *drive = row->drive;
    if (row->idn > drive->idns && row->idn[-1].idn >= row->idn->idn)
        return wrong_idn(row, "IDNs ascend");
    return value_good(row) && mapping_good(row);
}

static bool lists_good(const row_t *row)
{
    const ect_soe_drive_t *drive = row->drive;
    if (row->idn->idn == ECT_SOE_S(16))
        return process_list_good(row, drive->at, ECT_SOE_IN_AT);
    return row->idn->idn != ECT_SOE_S(24) || process_list_good(row, drive->mdt, ECT_SOE_IN_MDT);
}

static bool each_idn(const report_t *r, const ect_soe_t *soe, bool (*good)(const row_t *row))
{
    for (unsigned int n = 0; n < soe->drive_count; n++) {
        row_t row = {.r = r, .drive = &soe->drives[n], .number = n};
        for (unsigned int i = 0; i < row.drive->count; i++) {
            row.idn = &row.drive->idns[i];
            if (!good(&row))
                return false;
        }
    }
    return true;
}

static bool names_checks(const report_t *r)
{
    for (const ect_service_t *const *s = r->device->services; s && *s; s++) {
        if (*s == &ect_service_soe)
            return true;
    }
    return wrong(r, "services: SoE needs ect_service_soe, which checks the transitions");
}

static bool soe_good(const report_t *r, const ect_soe_t *soe)
{
    if (!ect_soe_fits(r->device))
        return wrong(r, "sm: with SoE both mailboxes have at least %d bytes", ECT_SOE_MAILBOX_LEAST);
    if (!is_inside(r, soe->offset, sizeof(ect_soe_state_t)) || soe->offset % _Alignof(ect_soe_state_t) != 0 ||
        !is_inside(r, soe->buffer, soe->buffer_size))
        return wrong(r, "protocols: the state or the buffer of SoE is not inside the instance, or not aligned");
    if (soe->drive_count == 0 || soe->drive_count > ECT_SOE_DRIVES || !soe->drives)
        return wrong(r, "protocols: SoE has 1 to %d drives", ECT_SOE_DRIVES);
    if (r->device->soe_channels != soe->drive_count && (r->device->soe_channels != 0 || soe->drive_count != 1))
        return wrong(r, "soe_channels: %u, but SoE has %u drives", r->device->soe_channels, soe->drive_count);
    if (!names_checks(r) || !each_idn(r, soe, idn_good) || !each_idn(r, soe, lists_good))
        return false;
    if (ect_soe_longest(soe) > soe->buffer_size)
        return wrong(r, "protocols: the buffer of SoE has %u bytes, the longest reply %u", soe->buffer_size,
                     ect_soe_longest(soe));
    return true;
}

/* A device may have its own SoE, with functions of its own. */
bool check_soe(const report_t *r)
{
    for (const ect_protocol_t *const *p = r->device->protocols; p && *p; p++) {
        if ((*p)->request == ect_soe_request && !soe_good(r, (const ect_soe_t *)(const void *)*p))
            return false;
    }
    return true;
}
