/* SPDX-License-Identifier: MIT */
/* Modules of a device whose file is not an ESI, in the order of the schema. */
#include <inttypes.h>

#include "esi/internal.h"

static bool is_of(const ect_esi_module_t *module, uint16_t index)
{
    for (size_t i = 0; i < module->dictionary.object_count; i++) {
        if (module->dictionary.objects[i].index == index)
            return true;
    }
    return false;
}

/* Writes the objects of the module, without those that each device has. */
static void write_objects(ect_xml_writer_t *xml, const ect_esi_module_t *module, const ect_device_t *device)
{
    ect_device_t own = *device;
    ect_object_t *objects = ect_arena_alloc(xml->arena, (device->object_count + 1u) * sizeof *objects);
    own.objects = objects;
    own.object_count = 0;
    for (uint16_t i = 0; i < device->object_count; i++) {
        if (is_of(module, device->objects[i].index))
            objects[own.object_count++] = device->objects[i];
    }
    ect_xml_dictionary(xml, &own, NULL);
}

static void write_profile(ect_xml_writer_t *xml, const ect_esi_module_t *module, const ect_device_t *device)
{
    if (module->profile == 0 && module->dictionary.object_count == 0)
        return;
    ect_xml_open(xml, "Profile");
    if (module->profile != 0) {
        ect_xml_number(xml, "ProfileNo", module->profile & 0xFFFF);
        ect_xml_number(xml, "AddInfo", module->profile >> 16);
    }
    if (module->dictionary.object_count > 0)
        write_objects(xml, module, device);
    ect_xml_close(xml);
}

/* Makes the description of a device that has only the parts of the module. */
static bool write_module(ect_xml_writer_t *xml, const ect_esi_device_t *model, const ect_esi_module_t *module)
{
    char text[200];
    ect_esi_device_t alone = *model;
    alone.slots = NULL;
    alone.modules = NULL;
    alone.slot_count = alone.module_count = 0;
    alone.download_idents = alone.download_addresses = false;
    alone.pdos = module->pdos;
    alone.pdo_count = module->pdo_count;
    alone.dictionary = module->dictionary;
    alone.fields = NULL;
    ect_esi_twin_t *twin = ect_esi_twin_assemble(model->esi, &alone, NULL, 0, NULL, text, sizeof text);
    if (twin == NULL)
        return false;
    ect_xml_open(xml, "Module");
    ect_xml_open(xml, "Type");
    ect_xml_attribute(xml, "ModuleIdent", "#x%08" PRIX32, module->ident);
    ect_xml_content(xml, module->type);
    ect_xml_close(xml);
    ect_xml_text(xml, "Name", module->name);
    ect_xml_pdos(xml, &twin->device, true);
    ect_xml_pdos(xml, &twin->device, false);
    write_profile(xml, module, &twin->device);
    ect_xml_close(xml);
    ect_esi_twin_drop(twin);
    return true;
}

bool ect_xml_modules(ect_xml_writer_t *xml, const ect_esi_device_t *model)
{
    bool written = true;
    xml->plant = NULL;
    xml->by_slot = true;
    for (size_t i = 0; i < model->module_count && written; i++)
        written = write_module(xml, model, &model->modules[i]);
    xml->by_slot = false;
    return written;
}
