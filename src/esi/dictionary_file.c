/* SPDX-License-Identifier: MIT */
/*
 * A dictionary in a file of its own, EtherCATDict (ETG.2000, EtherCATDict.xsd), in the folder of the ESI file or below.
 */
#include <stdlib.h>
#include <string.h>

#include "esi/internal.h"

enum { REASON = 300 };

/* @return whether each part of a relative path is a name; '\\' separates as '/' does */
static bool is_below(const char *name)
{
    static const char separators[] = "/\\";
    bool below = *name != '\0';
    for (const char *part = name; below; part += strspn(part, separators)) {
        const size_t length = strcspn(part, separators);
        below = length > 0 && strncmp(part, "..", length > 2 ? length : 2) != 0 && memchr(part, ':', length) == NULL;
        part += length;
        if (*part == '\0')
            break;
    }
    return below;
}

static const char *path_of(const ect_esi_xml_t *xml, const char *name)
{
    char *path = ect_arena_print(xml->arena, "%s%s", xml->folder, name);
    for (char *at = path + strlen(xml->folder); *at != '\0'; at++)
        *at = (char)(*at == '\\' ? '/' : *at);
    return path;
}

static bool has_attribute(const xmlNode *dictionary)
{
    ECT_ESI_EACH(object, ect_esi_child(dictionary, "Objects"), "Object")
    {
        if (ect_esi_child(ect_esi_child(object, "Flags"), "Attribute") != NULL)
            return true;
    }
    return false;
}

/* @return the dictionary of CoE or of SoE; @param parent  of `<Dictionary>` */
static ect_esi_dictionary_t *dictionary_for(const xmlNode *parent, ect_esi_device_t *device)
{
    const ect_esi_mailbox_t *mailbox = &device->mailbox;
    const bool idns = mailbox->soe && (!mailbox->coe || has_attribute(ect_esi_child(parent, "Dictionary")));
    return idns ? &device->idns : &device->dictionary;
}

static xmlDocPtr open_document(const char *path, char *text, size_t room)
{
    ect_esi_file_t file = ect_esi_load(path, text, room);
    xmlDocPtr document =
        file.data != NULL ? ect_esi_document("dictionary", path, file.data, file.length, text, room) : NULL;
    free(file.data);
    return document;
}

/* @return the reason why it was not read; NULL: it was */
static const char *read_file(const ect_esi_xml_t *xml, ect_esi_device_t *device)
{
    char *text = ect_arena_alloc(xml->arena, REASON);
    const char *path = path_of(xml, device->dictionary_file);
    xmlDocPtr document = open_document(path, text, REASON);
    if (document == NULL)
        return text;
    ect_esi_xml_t own = {.arena = xml->arena, .file = path, .text = text, .room = REASON};
    ect_esi_dictionary_t dictionary = {0};
    const xmlNode *root = xmlDocGetRootElement(document);
    ect_esi_dictionary_t *place = dictionary_for(root, device);
    if (ect_esi_child(root, "Dictionary") == NULL)
        ect_esi_fail(&own, root, "no dictionary: the root is %s, not EtherCATDict with Dictionary",
                     (const char *)root->name);
    ect_esi_read_dictionary(&own, root, &dictionary);
    if (place->object_count > 0)
        ect_esi_fail(&own, root, "the device has another dictionary already");
    if (!own.failed)
        *place = dictionary;
    xmlFreeDoc(document);
    return own.failed ? text : NULL;
}

void ect_esi_read_profile(ect_esi_xml_t *xml, const xmlNode *profile, ect_esi_device_t *device)
{
    const xmlNode *file = ect_esi_child(profile, "DictionaryFile");
    ect_esi_read_dictionary(xml, profile, dictionary_for(profile, device));
    if (file == NULL)
        return;
    device->dictionary_file = ect_esi_text(xml, file);
    device->dictionary_unread = "";
    if (!is_below(device->dictionary_file))
        device->dictionary_unread = "its name is not that of a file in the folder of the ESI file, or below it";
    else if (xml->folder != NULL)
        device->dictionary_unread = read_file(xml, device);
}
