/* SPDX-License-Identifier: MIT */
/* Checks of default assignments, mappings and their lengths. */
#include "check/internal.h"
#include "wire/assert.h"

static bool elements_good(const report_t *r, const ect_object_t *o, uint16_t type)
{
    for (const ect_entry_t *e = ect_od_next(o, o->entries); e; e = ect_od_next(o, e)) {
        if (e->data_type != type)
            return wrong(r, "%04Xh:%u: its data type is %04Xh, not %04Xh", o->index, e->subindex, type, e->data_type);
    }
    for (uint32_t n = 1; n <= ect_od_element(o, 0); n++) {
        if (!ect_od_entry(o, (uint8_t)n))
            return wrong(r, "%04Xh: it has no element %u", o->index, n);
    }
    return true;
}

static bool mapping_good(const report_t *r, const ect_object_t *pdo, uint32_t n)
{
    ECT_ASSERT(n >= 1 && n <= ect_od_element(pdo, 0));
    uint32_t mapping = ect_od_element(pdo, n);
    uint16_t direction = ect_od_is_rxpdo(pdo->index) ? ECT_ACCESS_RXPDO : ECT_ACCESS_TXPDO;
    unsigned int bits = mapping & 0xFF;
    const ect_entry_t *entry = ect_od_mapped(&r->od, mapping);
    if (bits == 0)
        return wrong(r, "%04Xh:%u: it maps nothing", pdo->index, n);
    if (mapping >> 16 == 0)
        return true;
    if (!entry)
        return wrong(r, "%04Xh:%u: there is no %04Xh:%u to map", pdo->index, n, mapping >> 16, mapping >> 8 & 0xFF);
    if ((entry->access & direction) == 0)
        return wrong(r, "%04Xh:%u: %04Xh:%u must not be mapped in that direction", pdo->index, n, mapping >> 16,
                     mapping >> 8 & 0xFF);
    if (entry->bit_length < bits)
        return wrong(r, "%04Xh:%u: %04Xh:%u has %u bits, not %u", pdo->index, n, mapping >> 16, mapping >> 8 & 0xFF,
                     entry->bit_length, bits);
    return true;
}

static bool pdo_good(const report_t *r, const ect_object_t *pdo)
{
    if (pdo->object_code == ECT_OBJECT_VAR)
        return wrong(r, "%04Xh: a PDO is a record", pdo->index);
    if (!elements_good(r, pdo, ECT_TYPE_UNSIGNED32))
        return false;
    for (uint32_t n = 1; n <= ect_od_element(pdo, 0); n++) {
        if (!mapping_good(r, pdo, n))
            return false;
    }
    return true;
}

static bool assigned_good(const report_t *r, const ect_object_t *assignment, uint32_t n, uint8_t type)
{
    uint32_t pdo = ect_od_element(assignment, n);
    bool right = type == ECT_SM_OUTPUTS ? ect_od_is_rxpdo((uint16_t)pdo) : ect_od_is_txpdo((uint16_t)pdo);
    if (!right)
        return wrong(r, "%04Xh:%u: %04Xh is no PDO of that direction", assignment->index, n, pdo);
    if (!ect_od_find(&r->od, (uint16_t)pdo))
        return wrong(r, "%04Xh:%u: there is no PDO %04Xh", assignment->index, n, pdo);
    for (uint32_t k = 1; k < n; k++) {
        if (ect_od_element(assignment, k) == pdo)
            return wrong(r, "%04Xh:%u: %04Xh is assigned twice", assignment->index, n, pdo);
    }
    return true;
}

static bool assignment_good(const report_t *r, const ect_object_t *assignment, unsigned int sm)
{
    ECT_ASSERT(sm < r->device->sm_count);
    const ect_sm_t *of = &r->device->sm[sm];
    if (assignment->object_code == ECT_OBJECT_VAR)
        return wrong(r, "%04Xh: an assignment is an array", assignment->index);
    if (!elements_good(r, assignment, ECT_TYPE_UNSIGNED16))
        return false;
    for (uint32_t n = 1; n <= ect_od_element(assignment, 0); n++) {
        if (!assigned_good(r, assignment, n, of->type))
            return false;
    }
    uint32_t bytes = (ect_od_sm_bits(&r->od, sm) + 7) / 8;
    if (of->maximum != 0 && bytes > of->maximum)
        return wrong(r, "SM%u: its PDOs come to %u bytes, more than its maximum %u", sm, bytes, of->maximum);
    return true;
}

static bool all_assignments_good(const report_t *r)
{
    const ect_device_t *d = r->device;
    for (unsigned int sm = 0; sm < 32; sm++) {
        const ect_object_t *assignment = ect_od_find(&r->od, (uint16_t)(ECT_OD_ASSIGNMENT + sm));
        bool process = ect_device_sm_is_process(d, sm);
        if (process && !assignment)
            return wrong(r, "SM%u: it has process data, but there is no %04Xh that assigns them", sm,
                         ECT_OD_ASSIGNMENT + sm);
        if (!process && assignment && ect_od_element(assignment, 0) > 0)
            return wrong(r, "%04Xh: SM%u has no process data", assignment->index, sm);
        if (process && !assignment_good(r, assignment, sm))
            return false;
    }
    return true;
}

static bool is_pdo(uint16_t index)
{
    return ect_od_is_rxpdo(index) || ect_od_is_txpdo(index);
}

static bool property_good(const report_t *r, const ect_pdo_t *p)
{
    const unsigned int unknown = p->flags & ~(unsigned int)(ECT_PDO_MANDATORY | ECT_PDO_FIXED | ECT_PDO_VIRTUAL);
    if (!is_pdo(p->index) || !ect_od_find(&r->od, p->index))
        return wrong(r, "pdos: there is no PDO %04Xh", p->index);
    if (unknown != 0)
        return wrong(r, "pdos: %04Xh has the unknown property %04Xh", p->index, unknown);
    for (const uint16_t *other = p->excludes; other && *other != 0; other++) {
        if (!is_pdo(*other) || !ect_od_find(&r->od, *other) || *other == p->index)
            return wrong(r, "pdos: %04Xh excludes %04Xh, which is no other PDO", p->index, *other);
    }
    return true;
}

static bool properties_good(const report_t *r)
{
    if (r->device->pdo_count > 0 && !r->device->pdos)
        return wrong(r, "pdos: they are missing");
    for (unsigned int i = 0; i < r->device->pdo_count; i++) {
        if (!property_good(r, &r->device->pdos[i]))
            return false;
    }
    return true;
}

bool check_pdos(const report_t *r)
{
    const ect_device_t *d = r->device;
    for (unsigned int i = 0; i < d->object_count; i++) {
        const ect_object_t *o = &d->objects[i];
        if (is_pdo(o->index) && !pdo_good(r, o))
            return false;
    }
    return all_assignments_good(r) && properties_good(r);
}
