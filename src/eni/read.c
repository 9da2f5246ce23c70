/* SPDX-License-Identifier: MIT */
#include "eni/read.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "eni/internal.h"

struct ect_eni {
    ect_arena_t arena;
    const char *file;
    ect_eni_network_t network;
};

/* `<EtherCATConfig>`, the root or below it. */
static const xmlNode *config_of(const xmlNode *root)
{
    const xmlNode *top = ect_esi_is(root, "EtherCATConfig") ? root : ect_esi_child(root, "EtherCATConfig");
    return ect_esi_child(top, "Config");
}

static const ect_eni_frame_t *read_frames(ect_esi_xml_t *xml, const xmlNode *cyclic, size_t *count)
{
    ect_eni_frame_t *frames = NULL;
    ect_eni_frame_t *frame;
    ect_eni_command_t *command;
    ECT_ESI_EACH(node, cyclic, "Frame")
    {
        ect_eni_command_t *commands = NULL;
        size_t bytes = 0;
        ECT_APPEND(xml, frames, *count, frame);
        frame->line = ect_esi_line(node);
        ECT_ESI_EACH(child, node, "Cmd")
        {
            ECT_APPEND(xml, commands, frame->command_count, command);
            ect_eni_read_command(xml, child, command);
            bytes += command->data.length + 12;
        }
        frame->commands = commands;
        if (bytes > ECT_ENI_DATA + 12)
            ect_esi_fail(xml, node, "Frame has %zu bytes with the headers of its commands; a frame takes %d", bytes,
                         ECT_ENI_DATA + 12);
    }
    return frames;
}

static void read_cyclics(ect_esi_xml_t *xml, const xmlNode *config, ect_eni_network_t *network)
{
    ect_eni_cyclic_t *cyclics = NULL;
    ect_eni_cyclic_t *cyclic;
    ECT_ESI_EACH(node, config, "Cyclic")
    {
        ECT_APPEND(xml, cyclics, network->cyclic_count, cyclic);
        cyclic->cycle_us = (uint32_t)ect_esi_number(xml, node, "CycleTime", 0, UINT32_MAX, 0);
        cyclic->frames = read_frames(xml, node, &cyclic->frame_count);
    }
    network->cyclics = cyclics;
}

static void read_image(ect_esi_xml_t *xml, const xmlNode *node, ect_eni_image_t *image)
{
    ect_eni_variable_t *variables = NULL;
    ect_eni_variable_t *variable;
    image->given = node != NULL;
    image->bytes = (uint32_t)ect_esi_number(xml, node, "ByteSize", 0, UINT32_MAX, 0);
    ECT_ESI_EACH(child, node, "Variable")
    {
        ECT_APPEND(xml, variables, image->variable_count, variable);
        variable->name = ect_esi_name(xml, child, "Name");
        variable->bits = (uint32_t)ect_esi_number(xml, child, "BitSize", 0, UINT32_MAX, 0);
        variable->offset = (uint32_t)ect_esi_number(xml, child, "BitOffs", 0, UINT32_MAX, 0);
        variable->line = ect_esi_line(child);
    }
    image->variables = variables;
}

static void read_slaves(ect_esi_xml_t *xml, const xmlNode *config, ect_eni_network_t *network)
{
    ect_eni_slave_t *slaves = NULL;
    ect_eni_slave_t *slave;
    ECT_ESI_EACH(node, config, "Slave")
    {
        if (network->slave_count == ECT_ENI_SLAVES) {
            ect_esi_fail(xml, node, "more than %d slaves", (int)ECT_ENI_SLAVES);
            return;
        }
        ECT_APPEND(xml, slaves, network->slave_count, slave);
        ect_eni_read_slave(xml, node, slave);
    }
    network->slaves = slaves;
}

static void read_network(ect_esi_xml_t *xml, const xmlNode *root, ect_eni_network_t *network)
{
    const xmlNode *config = config_of(root), *master = ect_esi_child(config, "Master");
    const xmlNode *states = ect_esi_child(master, "MailboxStates"), *image = ect_esi_child(config, "ProcessImage");
    if (config == NULL) {
        ect_esi_fail(xml, root, "no ENI file: there is no EtherCATConfig with Config");
        return;
    }
    if (master == NULL) {
        ect_esi_fail(xml, config, "EtherCATConfig/Config has no Master");
        return;
    }
    network->name = ect_esi_name(xml, ect_esi_child(master, "Info"), "Name");
    network->commands = ect_eni_read_inits(xml, master, &network->command_count);
    network->status_start = ect_esi_optional(xml, states, "StartAddr");
    network->status_count = (uint32_t)ect_esi_number(xml, states, "Count", 0, UINT32_MAX, 0);
    read_slaves(xml, config, network);
    read_cyclics(xml, config, network);
    read_image(xml, ect_esi_child(image, "Inputs"), &network->inputs);
    read_image(xml, ect_esi_child(image, "Outputs"), &network->outputs);
    if (network->slave_count == 0)
        ect_esi_fail(xml, config, "there is no slave in it");
}

ect_eni_t *ect_eni_parse(const char *name, const void *data, size_t length, char *text, size_t room)
{
    xmlDocPtr document = ect_esi_document("ENI", name, data, length, text, room);
    if (document == NULL)
        return NULL;
    ect_eni_t *eni = calloc(1, sizeof *eni);
    if (eni == NULL) {
        (void)snprintf(text, room, "%s: no memory left", name);
        xmlFreeDoc(document);
        return NULL;
    }
    eni->file = ect_arena_copy(&eni->arena, name, strlen(name));
    ect_esi_xml_t xml = {.arena = &eni->arena, .file = eni->file, .text = text, .room = room};
    read_network(&xml, xmlDocGetRootElement(document), &eni->network);
    xmlFreeDoc(document);
    if (!xml.failed)
        return eni;
    ect_eni_close(eni);
    return NULL;
}

ect_eni_t *ect_eni_open(const char *path, char *text, size_t room)
{
    ect_esi_file_t file = ect_esi_load(path, text, room);
    ect_eni_t *eni = file.data != NULL ? ect_eni_parse(path, file.data, file.length, text, room) : NULL;
    free(file.data);
    return eni;
}

const char *ect_eni_file(const ect_eni_t *eni)
{
    return eni->file;
}

const ect_eni_network_t *ect_eni_network(const ect_eni_t *eni)
{
    return &eni->network;
}

void ect_eni_close(ect_eni_t *eni)
{
    if (eni == NULL)
        return;
    ect_arena_free(&eni->arena);
    free(eni);
}
