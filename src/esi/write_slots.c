/* SPDX-License-Identifier: MIT */
/* Slots of a device whose file is not an ESI, in the order of the schema. */
#include <inttypes.h>

#include "esi/internal.h"

static void write_slot(ect_xml_writer_t *xml, const ect_esi_slot_t *slot)
{
    ect_xml_open(xml, "Slot");
    ect_xml_attribute(xml, "MinInstances", "%u", slot->instances_min);
    ect_xml_attribute(xml, "MaxInstances", "%u", slot->instances_max);
    ect_xml_text(xml, "Name", slot->name);
    for (size_t i = 0; i < slot->ident_count; i++) {
        ect_xml_open(xml, "ModuleIdent");
        if (slot->idents[i] == slot->preset)
            ect_xml_attribute(xml, "Default", "1"); /* a number in the schema */
        ect_xml_content(xml, ect_arena_print(xml->arena, "#x%08" PRIX32, slot->idents[i]));
        ect_xml_close(xml);
    }
    ect_xml_close(xml);
}

void ect_xml_slots(ect_xml_writer_t *xml, const ect_esi_device_t *model)
{
    ect_xml_open(xml, "Slots");
    ect_xml_flag(xml, "DownloadModuleIdentList", model->download_idents);
    ect_xml_attribute(xml, "MaxSlotCount", "%" PRIu32, model->slots_max);
    ect_xml_attribute(xml, "SlotPdoIncrement", "%" PRIu32, model->slot_pdo_increment);
    ect_xml_attribute(xml, "SlotIndexIncrement", "%" PRIu32, model->slot_index_increment);
    for (size_t i = 0; i < model->slot_count; i++)
        write_slot(xml, &model->slots[i]);
    ect_xml_close(xml);
}
