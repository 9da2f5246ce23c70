/* SPDX-License-Identifier: MIT */
/* SoE of a twin: the tables of its drives, and their memory in the instance. */
#include "esi/internal.h"

enum { MOST_MEBIBYTES = 16 /* of the parameters of all drives */ };

const ect_protocol_t *ect_esi_servo(ect_build_t *build, const ect_device_t *device)
{
    ECT_ASSERT(device->sm_count >= 2);
    if (build->soe == NULL || !ect_soe_fits(device))
        return NULL;
    build->soe->servo.protocol = (ect_protocol_t)ECT_SOE_PROTOCOL;
    build->soe->served = true;
    return &build->soe->servo.protocol;
}

/* @return bytes of a value's own memory; 0: none */
static size_t memory_of(const ect_build_idn_t *idn)
{
    if (idn->entry != 0 || ect_soe_is_made(&idn->row))
        return 0;
    if ((idn->row.attribute & ECT_SOE_COMMAND) != 0)
        return sizeof(ect_soe_command_t);
    if ((idn->row.attribute & ECT_SOE_LIST) == 0)
        return ect_soe_width(idn->row.attribute);
    return sizeof(uint16_t) + idn->row.size;
}

static size_t place(const ect_build_t *build, ect_build_idn_t *idn, size_t at)
{
    const size_t bytes = memory_of(idn);
    if (idn->entry != 0)
        idn->row.offset = ect_build_entry(ect_build_find(build, idn->entry), 0)->offset;
    else if (bytes > 0)
        idn->row.offset = at;
    return bytes > 0 ? ect_esi_aligned(at + bytes) : at;
}

/* @return the mapping object of a telegram that the lists change; 0: none */
static uint16_t mapping_of(const ect_build_t *build, uint8_t drive, bool tx)
{
    const ect_esi_pdo_t *model = build->soe->telegrams[drive][tx];
    for (size_t i = 0; model != NULL && i < build->pdo_count; i++) {
        if (build->pdos[i].model == model && build->pdos[i].usable)
            return build->pdos[i].index;
    }
    return 0;
}

static const ect_soe_drive_t *make_drives(const ect_build_t *build)
{
    const ect_build_soe_t *soe = build->soe;
    ect_soe_drive_t *drives = ect_arena_alloc(build->arena, soe->drives * sizeof *drives);
    ect_soe_idn_t *rows = ect_arena_alloc(build->arena, soe->count * sizeof *rows);
    for (size_t i = 0; i < soe->count; i++) {
        ect_soe_drive_t *drive = &drives[soe->idns[i].drive];
        rows[i] = soe->idns[i].row;
        if (drive->count++ == 0)
            drive->idns = &rows[i];
    }
    for (uint8_t drive = 0; drive < soe->drives; drive++) {
        drives[drive].mdt = mapping_of(build, drive, false);
        drives[drive].at = mapping_of(build, drive, true);
    }
    return drives;
}

size_t ect_esi_servo_place(ect_build_t *build, size_t at)
{
    ect_build_soe_t *soe = build->soe;
    if (soe == NULL || !soe->served)
        return at;
    at = ect_esi_aligned(at);
    soe->servo.offset = at;
    at = ect_esi_aligned(at + sizeof(ect_soe_state_t));
    for (size_t i = 0; i < soe->count; i++)
        at = place(build, &soe->idns[i], at);
    if (at > MOST_MEBIBYTES * 1024 * 1024)
        ect_build_fail(build, "its parameters of SoE need more than %d MiB", MOST_MEBIBYTES);
    soe->servo.drives = make_drives(build);
    soe->servo.drive_count = soe->drives;
    soe->servo.buffer = at;
    const uint32_t longest = ect_soe_longest(&soe->servo);
    if (longest > UINT16_MAX)
        ect_build_fail(build, "a parameter of SoE has %u bytes; the twin sends %u", (unsigned int)longest,
                       (unsigned int)UINT16_MAX);
    soe->servo.buffer_size = (uint16_t)longest;
    return at + soe->servo.buffer_size;
}

void ect_esi_servo_init(void *instance, const ect_host_t *host, uint64_t now_ns)
{
    const ect_standard_t *standard = instance;
    const ect_build_t *build = &((const ect_esi_twin_t *)standard->device->context)->build;
    (void)host;
    (void)now_ns;
    ect_soe_set_defaults(&build->soe->servo, instance);
}
