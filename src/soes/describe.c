/* SPDX-License-Identifier: MIT */
/* Compiled with the application's headers: those of this folder, or SOES's own (ports/soes_hal). */
#include <esc.h>
#include <options.h>

#include "soes/describe.h"

#include <string.h>

_Static_assert(sizeof(_objd) == sizeof(ect_entry_t) && offsetof(_objd, data) == offsetof(ect_entry_t, data),
               "an entry of SOES has the layout of an ect_entry_t");
_Static_assert(sizeof(_objectlist) == sizeof(ect_object_t) &&
                   offsetof(_objectlist, objdesc) == offsetof(ect_object_t, entries),
               "an object of SOES has the layout of an ect_object_t");

static const ect_dc_mode_t dc_modes[] = {
    {.name = "FreeRun", .description = "Free run or SyncManager"},
    {.name = "DcSync0", .description = "SYNC0", .assign_activate = 0x0300, .factor_sync0 = 1},
};

static uint16_t count_objects(void)
{
    uint16_t count = 0;
    while (SDOobjects[count].index != 0xFFFF)
        count++;
    return count;
}

/* @return the value in the list, because the memory has no defaults yet */
static uint32_t number(const ect_device_t *device, uint16_t index, uint8_t subindex)
{
    ect_od_t od = ect_device_od(device, NULL);
    return ect_od_element(ect_od_find(&od, index), subindex);
}

static const char *text(const ect_device_t *device, uint16_t index, const char *otherwise)
{
    ect_od_t od = ect_device_od(device, NULL);
    const ect_object_t *object = ect_od_find(&od, index);
    const ect_entry_t *entry = object ? ect_od_entry(object, 0) : NULL;
    return entry && ect_od_is_string(entry) && entry->data ? entry->data : otherwise;
}

void ect_soes_describe(ect_device_t *device)
{
    *device = (ect_device_t){
        .name = "soes",
        .summary = "A SOES application",
        .vendor_name = "",
        .group_type = "SOES",
        .group_name = "SOES applications",
        .esc = "et1100",
        .esc_config = {0x05, 0x0E, 0x03, 0x6E}, /* SPI; DC on; SYNC0 is also an AL event */
        .sii_size = 4096,
        .sm = {{.start = MBX0_sma, .length = MBX0_sml, .control = MBX0_smc, .type = ECT_SM_MAILBOX_OUT},
               {.start = MBX1_sma, .length = MBX1_sml, .control = MBX1_smc, .type = ECT_SM_MAILBOX_IN},
               {.start = SM2_sma, .control = SM2_smc, .type = ECT_SM_OUTPUTS},
               {.start = SM3_sma, .control = SM3_smc, .type = ECT_SM_INPUTS}},
        .sm_count = 4,
        .fmmu = {ECT_FMMU_OUTPUTS, ECT_FMMU_INPUTS, ECT_FMMU_MAILBOX_STATE},
        .fmmu_count = 3,
        .boot_out = {MBX0_sma_b, MBX0_sml_b},
        .boot_in = {MBX1_sma_b, MBX1_sml_b},
        .mailbox_protocols = ECT_MAILBOX_COE | (USE_FOE ? ECT_MAILBOX_FOE : 0) | (USE_EOE ? ECT_MAILBOX_EOE : 0),
        .coe_details = ECT_COE_SDO | ECT_COE_SDO_INFO | ECT_COE_COMPLETE_ACCESS,
        .physics = "YY",
        .dc_modes = dc_modes,
        .dc_mode_count = ESCvar.esc_check_dc_handler ? sizeof dc_modes / sizeof dc_modes[0] : 0,
        .objects = (const ect_object_t *)(const void *)SDOobjects,
        .object_count = count_objects(),
        .addresses = true,
    };
    device->type_name = text(device, 0x1008, "SOES");
    device->device_type = number(device, 0x1000, 0);
    device->identity = (ect_identity_t){.vendor_id = number(device, 0x1018, 1),
                                        .product_code = number(device, 0x1018, 2),
                                        .revision = number(device, 0x1018, 3),
                                        .serial = number(device, 0x1018, 4)};
}
