/* SPDX-License-Identifier: MIT */
/* Iteration over all values of a file. */
#include "esi/leaves.h"

#include <stdlib.h>
#include <string.h>

#include "esi/internal.h"

enum { PATH = 400 };

/* Paths of values that affect the twin, ascending: a change affects the description, the dictionary or the EEPROM,
 * unless another part of the file overrides it. */
static const char *const modelled[] = {
    "Device/Dc/OpMode/AssignActivate",
    "Device/Dc/OpMode/CycleTimeSync0",
    "Device/Dc/OpMode/CycleTimeSync0@Factor",
    "Device/Dc/OpMode/CycleTimeSync1@Factor",
    "Device/Dc/OpMode/Name",
    "Device/Dc/OpMode/ShiftTimeSync0",
    "Device/Dc/OpMode/ShiftTimeSync1",
    "Device/Eeprom/BootStrap",
    "Device/Eeprom/ByteSize",
    "Device/Eeprom/ConfigData",
    "Device/Eeprom/Data",
    "Device/Fmmu",
    "Device/GroupType",
    "Device/Info/Electrical/EBusCurrent",
    "Device/Info/Mailbox/Timeout/RequestTimeout",
    "Device/Info/Mailbox/Timeout/ResponseTimeout",
    "Device/Info/StateMachine/Timeout/BackToInitTimeout",
    "Device/Info/StateMachine/Timeout/BackToSafeopTimeout",
    "Device/Info/StateMachine/Timeout/PreopTimeout",
    "Device/Info/StateMachine/Timeout/SafeopOpTimeout",
    "Device/Mailbox/AoE",
    "Device/Mailbox/CoE",
    "Device/Mailbox/CoE@CompleteAccess",
    "Device/Mailbox/CoE@PdoAssign",
    "Device/Mailbox/CoE@PdoConfig",
    "Device/Mailbox/CoE@PdoUpload",
    "Device/Mailbox/CoE@SdoInfo",
    "Device/Mailbox/EoE",
    "Device/Mailbox/FoE",
    "Device/Mailbox/SoE",
    "Device/Mailbox/VoE",
    "Device/Name",
    "Device/Name@LcId",
    "Device/Profile/Dictionary/DataTypes/DataType/ArrayInfo/Elements",
    "Device/Profile/Dictionary/DataTypes/DataType/ArrayInfo/LBound",
    "Device/Profile/Dictionary/DataTypes/DataType/BaseType",
    "Device/Profile/Dictionary/DataTypes/DataType/BitSize",
    "Device/Profile/Dictionary/DataTypes/DataType/Name",
    "Device/Profile/Dictionary/DataTypes/DataType/SubItem/BitOffs",
    "Device/Profile/Dictionary/DataTypes/DataType/SubItem/BitSize",
    "Device/Profile/Dictionary/DataTypes/DataType/SubItem/Flags/Access",
    "Device/Profile/Dictionary/DataTypes/DataType/SubItem/Flags/Access@ReadRestrictions",
    "Device/Profile/Dictionary/DataTypes/DataType/SubItem/Flags/Access@WriteRestrictions",
    "Device/Profile/Dictionary/DataTypes/DataType/SubItem/Flags/Backup",
    "Device/Profile/Dictionary/DataTypes/DataType/SubItem/Flags/PdoMapping",
    "Device/Profile/Dictionary/DataTypes/DataType/SubItem/Flags/Setting",
    "Device/Profile/Dictionary/DataTypes/DataType/SubItem/Name",
    "Device/Profile/Dictionary/DataTypes/DataType/SubItem/SubIdx",
    "Device/Profile/Dictionary/DataTypes/DataType/SubItem/Type",
    "Device/Profile/Dictionary/Objects/Object/BitSize",
    "Device/Profile/Dictionary/Objects/Object/Flags/Access",
    "Device/Profile/Dictionary/Objects/Object/Flags/Access@ReadRestrictions",
    "Device/Profile/Dictionary/Objects/Object/Flags/Access@WriteRestrictions",
    "Device/Profile/Dictionary/Objects/Object/Flags/Backup",
    "Device/Profile/Dictionary/Objects/Object/Flags/PdoMapping",
    "Device/Profile/Dictionary/Objects/Object/Flags/Setting",
    "Device/Profile/Dictionary/Objects/Object/Index",
    "Device/Profile/Dictionary/Objects/Object/Info/DefaultData",
    "Device/Profile/Dictionary/Objects/Object/Info/DefaultString",
    "Device/Profile/Dictionary/Objects/Object/Info/DefaultValue",
    "Device/Profile/Dictionary/Objects/Object/Info/MaxValue",
    "Device/Profile/Dictionary/Objects/Object/Info/MinValue",
    "Device/Profile/Dictionary/Objects/Object/Info/SubItem/Info/DefaultData",
    "Device/Profile/Dictionary/Objects/Object/Info/SubItem/Info/DefaultValue",
    "Device/Profile/Dictionary/Objects/Object/Info/SubItem/Info/MaxData",
    "Device/Profile/Dictionary/Objects/Object/Info/SubItem/Info/MaxValue",
    "Device/Profile/Dictionary/Objects/Object/Info/SubItem/Info/MinData",
    "Device/Profile/Dictionary/Objects/Object/Info/SubItem/Info/MinValue",
    "Device/Profile/Dictionary/Objects/Object/Info/SubItem/Name",
    "Device/Profile/Dictionary/Objects/Object/Info/Unit",
    "Device/Profile/Dictionary/Objects/Object/Name",
    "Device/Profile/Dictionary/Objects/Object/Name@LcId",
    "Device/Profile/Dictionary/Objects/Object/Type",
    "Device/RxPdo/Entry/BitLen",
    "Device/RxPdo/Entry/DataType",
    "Device/RxPdo/Entry/Index",
    "Device/RxPdo/Entry/Name",
    "Device/RxPdo/Entry/Name@LcId",
    "Device/RxPdo/Entry/SubIndex",
    "Device/RxPdo/Exclude",
    "Device/RxPdo/Index",
    "Device/RxPdo/Name",
    "Device/RxPdo/Name@LcId",
    "Device/RxPdo@Fixed",
    "Device/RxPdo@Mandatory",
    "Device/RxPdo@Sm",
    "Device/Sm",
    "Device/Sm@ControlByte",
    "Device/Sm@DefaultSize",
    "Device/Sm@MaxSize",
    "Device/Sm@MinSize",
    "Device/Sm@StartAddress",
    "Device/TxPdo/Entry/BitLen",
    "Device/TxPdo/Entry/DataType",
    "Device/TxPdo/Entry/Index",
    "Device/TxPdo/Entry/Name",
    "Device/TxPdo/Entry/Name@LcId",
    "Device/TxPdo/Entry/SubIndex",
    "Device/TxPdo/Exclude",
    "Device/TxPdo/Index",
    "Device/TxPdo/Name",
    "Device/TxPdo/Name@LcId",
    "Device/TxPdo@Fixed",
    "Device/TxPdo@Mandatory",
    "Device/TxPdo@Sm",
    "Device/Type",
    "Device/Type@ProductCode",
    "Device/Type@RevisionNo",
    "Device@Physics",
    "Group/Name",
    "Group/Name@LcId",
    "Group/Type",
    "Vendor/Id",
    "Vendor/Name",
    "Vendor/Name@LcId",
};

typedef struct walk {
    ect_esi_xml_t xml;
    ect_esi_leaf_t leaf;
    void *ctx;
    char path[PATH];  /* with numbers and names of repeated elements */
    char plain[PATH]; /* without */
} walk_t;

static int by_text(const void *a, const void *b)
{
    return strcmp(*(const char *const *)a, *(const char *const *)b);
}

static bool is_modelled(const char *plain)
{
    return bsearch(&plain, modelled, sizeof modelled / sizeof modelled[0], sizeof modelled[0], by_text) != NULL;
}

static void take(walk_t *w, const char *value)
{
    w->leaf(w->ctx, is_modelled(w->plain), w->path, value);
}

/* Appends a name. A path that is too long, impossible in a valid file, is skipped with all below. @return its length */
static size_t append(char path[PATH], size_t length, const char *between, const char *name)
{
    const size_t more = strlen(between) + strlen(name);
    if (length + more >= PATH)
        return 0;
    (void)memcpy(path + length, between, strlen(between));
    (void)memcpy(path + length + strlen(between), name, strlen(name) + 1);
    return length + more;
}

/* @return the label of an element, index or name; other elements are numbered */
static const char *label_of(walk_t *w, const xmlNode *node, unsigned int number)
{
    static const char *const named[] = {"DataType", "Object", "RxPdo", "TxPdo", "Module", "Slot"};
    const xmlNode *label = NULL;
    for (size_t i = 0; i < sizeof named / sizeof named[0] && label == NULL; i++) {
        if (ect_esi_is(node, named[i]))
            label = ect_esi_child(node, ect_esi_child(node, "Index") != NULL ? "Index" : "Name");
    }
    if (label != NULL)
        return ect_esi_text(&w->xml, label);
    return number > 0 ? ect_arena_print(w->xml.arena, "%u", number + 1) : "";
}

static void walk_attributes(walk_t *w, const xmlNode *node, size_t path, size_t plain)
{
    for (const xmlAttr *a = node->properties; a != NULL; a = a->next) {
        const char *name = (const char *)a->name;
        if (append(w->path, path, "@", name) == 0)
            continue;
        (void)append(w->plain, plain, "@", name);
        take(w, ect_esi_attribute(&w->xml, node, name));
    }
    w->path[path] = '\0';
    w->plain[plain] = '\0';
}

static bool has_elements(const xmlNode *node)
{
    const xmlNode *child = node->children;
    while (child != NULL && child->type != XML_ELEMENT_NODE)
        child = child->next;
    return child != NULL;
}

static void walk_node(walk_t *w, const xmlNode *node, size_t path, size_t plain, unsigned int number)
{
    const char *name = (const char *)node->name;
    const char *label = label_of(w, node, number);
    path = append(w->path, path, path > 0 ? "/" : "", name);
    if (path > 0 && *label != '\0')
        path = append(w->path, path, " ", label);
    if (path == 0)
        return;
    plain = append(w->plain, plain, plain > 0 ? "/" : "", name);
    ECT_ASSERT(plain > 0 && plain <= path);
    walk_attributes(w, node, path, plain);
    if (!has_elements(node)) {
        take(w, ect_esi_text(&w->xml, node));
        return;
    }
    const xmlNode *before = NULL;
    unsigned int count = 0;
    for (const xmlNode *child = node->children; child != NULL; child = child->next) {
        if (child->type != XML_ELEMENT_NODE)
            continue;
        count = before != NULL && xmlStrEqual(before->name, child->name) ? count + 1 : 0;
        before = child;
        walk_node(w, child, path, plain, count);
        w->path[path] = '\0';
        w->plain[plain] = '\0';
    }
}

static void walk_root(walk_t *w, const xmlNode *node)
{
    if (node != NULL)
        walk_node(w, node, 0, 0, 0);
}

void ect_esi_leaves(const ect_esi_device_t *device, ect_esi_leaf_t leaf, void *ctx)
{
    ect_arena_t arena = {0};
    walk_t w = {
        .xml = {.arena = &arena, .file = device->esi->file}, .leaf = leaf, .ctx = ctx}; /* mistakes are ignored */
    const xmlNode *descriptions = ect_esi_child(device->esi->root, "Descriptions");
    walk_root(&w, ect_esi_child(device->esi->root, "Vendor"));
    ECT_ESI_EACH(group, ect_esi_child(descriptions, "Groups"), "Group")
    {
        if (strcmp(ect_esi_text(&w.xml, ect_esi_child(group, "Type")), device->group_type) == 0)
            walk_root(&w, group);
    }
    walk_root(&w, device->esi->nodes[device->place]);
    if (device->slot_count > 0)
        walk_root(&w, ect_esi_child(descriptions, "Modules"));
    ect_arena_free(&arena);
}
