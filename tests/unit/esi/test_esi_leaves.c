/* SPDX-License-Identifier: MIT */
/* All values of a file as leaves (esi/leaves.h): their order, their paths, and which of them reach a twin. */
#define _POSIX_C_SOURCE 200809L
#include "esi/leaves.h"
#include "from_text.h"

/* Prints one line for each leaf: path, "=", value; with "*" in front of modelled leaves. */
static void print_leaf(void *out, bool modelled, const char *path, const char *value)
{
    (void)fprintf(out, "%s%s=%s\n", modelled ? "*" : "", path, value);
}

/* The leaves of a device of a file; to be freed. */
static char *leaves_of(const char *what, const char *text, const char *selector)
{
    char why[300] = "";
    char *lines = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&lines, &size);
    ect_esi_t *esi = ect_esi_parse("t.xml", text, strlen(text), why, sizeof why);
    const ect_esi_device_t *device = esi != NULL ? ect_esi_select(esi, selector, why, sizeof why) : NULL;
    assert_non_null(out);
    if (device == NULL)
        fail_msg("%s: expected a device, got: %s", what, why);
    ect_esi_leaves(device, print_leaf, out);
    ect_esi_close(esi);
    (void)fclose(out);
    return lines;
}

#define HEAD                                                                                                           \
    "<EtherCATInfo Version='1.14'><InfoReference>r</InfoReference><Vendor UniqueName='U'><Id>1</Id></Vendor>"          \
    "<Descriptions><Groups><Group SortOrder='3'><Type>G</Type></Group><Group><Type>H</Type></Group></Groups><Devices>"
#define TAIL "</Devices></Descriptions></EtherCATInfo>"
/* The leaves of every device below, in front of its own. */
#define HEAD_LEAVES "Vendor@UniqueName=U\n*Vendor/Id=1\nGroup@SortOrder=3\n*Group/Type=G\n"
#define DEVICE(body)                                                                                                   \
    HEAD "<Device><Type>D</Type><GroupType>G</GroupType>" body "</Device><Device><Type>E</Type></Device>" TAIL
#define DEVICE_LEAVES HEAD_LEAVES "*Device/Type=D\n*Device/GroupType=G\n"

static void paths(void **state)
{
    static const struct {
        const char *what, *text, *leaves;
    } table[] = {
        {"vendor, group and device", DEVICE(""), DEVICE_LEAVES},
        {"an attribute before the text", DEVICE("<Name LcId='1033'>N</Name>"),
         DEVICE_LEAVES "*Device/Name@LcId=1033\n*Device/Name=N\n"},
        {"several attributes in their order", DEVICE("<Sm StartAddress='1' Enable='1' Other='x'>Inputs</Sm>"),
         DEVICE_LEAVES "*Device/Sm@StartAddress=1\nDevice/Sm@Enable=1\nDevice/Sm@Other=x\n*Device/Sm=Inputs\n"},
        {"the second and third of a kind", DEVICE("<Fmmu>Outputs</Fmmu><Fmmu>Inputs</Fmmu><Fmmu/>"),
         DEVICE_LEAVES "*Device/Fmmu=Outputs\n*Device/Fmmu 2=Inputs\n*Device/Fmmu 3=\n"},
        {"another kind between begins the count again", DEVICE("<Fmmu>1</Fmmu><Sm/><Fmmu>2</Fmmu><Fmmu>3</Fmmu>"),
         DEVICE_LEAVES "*Device/Fmmu=1\n*Device/Sm=\n*Device/Fmmu=2\n*Device/Fmmu 2=3\n"},
        {"attributes of a second one", DEVICE("<Sm/><Sm ControlByte='4'/>"),
         DEVICE_LEAVES "*Device/Sm=\n*Device/Sm 2@ControlByte=4\n*Device/Sm 2=\n"},
        {"an element with children has no text of its own", DEVICE("<Info>a<Electrical><X>1</X></Electrical>b</Info>"),
         DEVICE_LEAVES "Device/Info/Electrical/X=1\n"},
        {"an element of blanks", DEVICE("<Info> \n </Info>"), DEVICE_LEAVES "Device/Info=\n"},
        {"blanks around a value", DEVICE("<Name> a b\n</Name>"), DEVICE_LEAVES "*Device/Name=a b\n"},
        {"CDATA", DEVICE("<Name><![CDATA[a<b]]></Name>"), DEVICE_LEAVES "*Device/Name=a<b\n"},
        {"a comment is none", DEVICE("<!-- c --><Name><!-- d -->N</Name>"), DEVICE_LEAVES "*Device/Name=N\n"},
        {"a PDO by its index", DEVICE("<TxPdo Fixed='1'><Index>#x1A00</Index><Name>P</Name></TxPdo>"),
         DEVICE_LEAVES
         "*Device/TxPdo #x1A00@Fixed=1\n*Device/TxPdo #x1A00/Index=#x1A00\n*Device/TxPdo #x1A00/Name=P\n"},
        {"outputs by their index", DEVICE("<RxPdo><Index>5632</Index></RxPdo><RxPdo><Index>#x1601</Index></RxPdo>"),
         DEVICE_LEAVES "*Device/RxPdo 5632/Index=5632\n*Device/RxPdo #x1601/Index=#x1601\n"},
        {"entries of a PDO by their number",
         DEVICE("<RxPdo><Index>1</Index><Entry><BitLen>1</BitLen><Index>2</Index></Entry><Entry><Index>3</Index>"
                "<BitLen>7</BitLen></Entry></RxPdo>"),
         DEVICE_LEAVES "*Device/RxPdo 1/Index=1\n*Device/RxPdo 1/Entry/BitLen=1\n*Device/RxPdo 1/Entry/Index=2\n"
                       "*Device/RxPdo 1/Entry 2/Index=3\n*Device/RxPdo 1/Entry 2/BitLen=7\n"},
        {"a type by its name, an object by its index",
         DEVICE("<Profile><Dictionary><DataTypes><DataType><Name>T</Name><BitSize>8</BitSize></DataType></DataTypes>"
                "<Objects><Object><Index>#x2000</Index><Name>O</Name></Object></Objects></Dictionary></Profile>"),
         DEVICE_LEAVES "*Device/Profile/Dictionary/DataTypes/DataType T/Name=T\n"
                       "*Device/Profile/Dictionary/DataTypes/DataType T/BitSize=8\n"
                       "*Device/Profile/Dictionary/Objects/Object #x2000/Index=#x2000\n"
                       "*Device/Profile/Dictionary/Objects/Object #x2000/Name=O\n"},
        {"a type without a name by no label",
         DEVICE("<Profile><Dictionary><DataTypes><DataType/><DataType><BitSize>1"
                "</BitSize></DataType></DataTypes></Dictionary></Profile>"),
         DEVICE_LEAVES "Device/Profile/Dictionary/DataTypes/DataType=\n"
                       "*Device/Profile/Dictionary/DataTypes/DataType 2/BitSize=1\n"},
        {"values that the model has from other elements are not modelled here",
         DEVICE("<Mailbox><Name>N</Name></Mailbox><Dc><Name>N</Name></Dc>"),
         DEVICE_LEAVES "Device/Mailbox/Name=N\nDevice/Dc/Name=N\n"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        char *lines = leaves_of(table[i].what, table[i].text, "D");
        if (strcmp(lines, table[i].leaves) != 0)
            fail_msg("%s: expected\n%sgot\n%s", table[i].what, table[i].leaves, lines);
        free(lines);
    }
}

/* Modules are of the file, for all its devices with slots. */
static void modules(void **state)
{
#define RACK(slots)                                                                                                    \
    HEAD "<Device><Type>D</Type>" slots "</Device></Devices><Modules><Module><Type ModuleIdent='7'/><Name>M</Name>"    \
         "</Module><Module><Name>N</Name></Module></Modules></Descriptions></EtherCATInfo>"
    static const struct {
        const char *what, *text, *leaves;
    } table[] = {
        {"slots", RACK("<Slots><Slot><Name>S</Name></Slot></Slots>"),
         "Vendor@UniqueName=U\n*Vendor/Id=1\n*Device/Type=D\nDevice/Slots/Slot S/Name=S\n"
         "Modules/Module M/Type@ModuleIdent=7\nModules/Module M/Type=\nModules/Module M/Name=M\n"
         "Modules/Module N/Name=N\n"},
        {"no slot", RACK("<Slots/>"), "Vendor@UniqueName=U\n*Vendor/Id=1\n*Device/Type=D\nDevice/Slots=\n"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        char *lines = leaves_of(table[i].what, table[i].text, "D");
        if (strcmp(lines, table[i].leaves) != 0)
            fail_msg("%s: expected\n%sgot\n%s", table[i].what, table[i].leaves, lines);
        free(lines);
    }
}

static void one_device_of_several(void **state)
{
    (void)state;
    char *lines = leaves_of("the second device", DEVICE(""), "E");
    assert_string_equal(lines, "Vendor@UniqueName=U\n*Vendor/Id=1\n*Device/Type=E\n");
    free(lines);
}

/* --- long paths --------------------------------------------------------------------------------------------------- */

enum { LONGEST_PATH = 399, BEFORE = sizeof "Device/" - 1 };

/* A device with an element of `length` characters around `inner`. */
static char *with_name(size_t length, const char *inner)
{
    char *text = NULL, *name = calloc(1, length + 1);
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    assert_true(out != NULL && name != NULL);
    memset(name, 'n', length);
    (void)fprintf(out, HEAD "<Device><Type>D</Type><%s>%s</%s><Name>N</Name></Device>" TAIL, name, inner, name);
    (void)fclose(out);
    free(name);
    return text;
}

static void long_paths(void **state)
{
    static const struct {
        const char *what, *inner;
        size_t behind;    /* characters of the longest path behind the element's name */
        const char *leaf; /* end of the line of that path */
    } table[] = {
        {"an element", "v", 0, "n=v\n"},
        {"a child", "<C>v</C>", 2, "/C=v\n"},
        {"a second child", "<C/><C>v</C>", 4, "/C 2=v\n"},
        {"an attribute of a child", "<C At='v'><D/></C>", 5, "/C@At=v\n"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        for (size_t over = 0; over < 2; over++) {
            char *text = with_name(LONGEST_PATH - BEFORE - table[i].behind + over, table[i].inner);
            char *lines = leaves_of(table[i].what, text, "D");
            if ((strstr(lines, table[i].leaf) != NULL) != (over == 0))
                fail_msg("%s: expected a path of %zu characters %s, got %s", table[i].what, LONGEST_PATH + over,
                         over ? "to be left out" : "to be there", lines);
            if (strstr(lines, "\n*Device/Name=N\n") == NULL)
                fail_msg("%s: expected the element behind to be there, got %s", table[i].what, lines);
            free(lines);
            free(text);
        }
    }
}

/* --- which of them reach a twin ----------------------------------------------------------------------------------- */

static bool is_modelled(const char *text, const char *path)
{
    char *lines = leaves_of(path, text, "D");
    char wanted[200];
    (void)snprintf(wanted, sizeof wanted, "\n*%s=", path);
    bool found = strstr(lines, wanted) != NULL;
    free(lines);
    return found;
}

/* A path is the elements down to the value: a value of that name elsewhere is another one. */
static void modelled(void **state)
{
    static const struct {
        const char *path, *body;
        bool modelled;
    } table[] = {
        {"Device/Dc/OpMode/AssignActivate", "<Dc><OpMode><AssignActivate>1</AssignActivate></OpMode></Dc>", true},
        {"Device/Dc/OpMode/CycleTimeSync0@Factor",
         "<Dc><OpMode><CycleTimeSync0 Factor='1'>0</CycleTimeSync0></OpMode></Dc>", true},
        {"Device/Dc/OpMode/CycleTimeSync1", "<Dc><OpMode><CycleTimeSync1>1</CycleTimeSync1></OpMode></Dc>", false},
        {"Device/Dc/OpMode/CycleTimeSync1@Factor",
         "<Dc><OpMode><CycleTimeSync1 Factor='1'>0</CycleTimeSync1></OpMode></Dc>", true},
        {"Device/Dc/OpMode/Desc", "<Dc><OpMode><Desc>1</Desc></OpMode></Dc>", false},
        {"Device/Eeprom/ByteSize", "<Eeprom><ByteSize>1024</ByteSize></Eeprom>", true},
        {"Device/Eeprom/Category/CatNo", "<Eeprom><Category><CatNo>2048</CatNo></Category></Eeprom>", false},
        {"Device/Info/Electrical/EBusCurrent", "<Info><Electrical><EBusCurrent>1</EBusCurrent></Electrical></Info>",
         true},
        {"Device/Mailbox@DataLinkLayer", "<Mailbox DataLinkLayer='1'/>", false},
        {"Device/Mailbox/CoE@PdoUpload", "<Mailbox><CoE PdoUpload='1'/></Mailbox>", true},
        {"Device/Mailbox/CoE@SegmentedSdo", "<Mailbox><CoE SegmentedSdo='1'/></Mailbox>", false},
        {"Device/Mailbox/VoE", "<Mailbox><VoE/></Mailbox>", true},
        {"Device/Mailbox/CoE/InitCmd/Data", "<Mailbox><CoE><InitCmd><Data>00</Data></InitCmd></CoE></Mailbox>", false},
        {"Device@Physics", "", false}, /* it has none here */
        {"Device/Sm@MinSize", "<Sm MinSize='1'/>", true},
        {"Device/Sm@Virtual", "<Sm Virtual='1'/>", false},
        {"Device/TxPdo 1@Mandatory", "<TxPdo Mandatory='1'><Index>1</Index></TxPdo>", true},
        {"Device/TxPdo 1@OSFac", "<TxPdo OSFac='2'><Index>1</Index></TxPdo>", false},
        {"Device/RxPdo 1/Exclude", "<RxPdo><Index>1</Index><Exclude>2</Exclude></RxPdo>", true},
        {"Device/Name", "<Name>N</Name>", true},
        {"Device/URL", "<URL>u</URL>", false},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        char text[1000];
        (void)snprintf(text, sizeof text, DEVICE("%s"), table[i].body);
        if (is_modelled(text, table[i].path) != table[i].modelled)
            fail_msg("%s: expected modelled %d", table[i].path, table[i].modelled);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"CF-066 leaves are in the order of the file, with index, name or number of elements that repeat", paths, NULL,
         NULL, NULL},
        {"CF-066 modules are leaves of devices with slots", modules, NULL, NULL, NULL},
        {"CF-066 a device has no leaves of other devices and of other groups", one_device_of_several, NULL, NULL, NULL},
        {"a path of 399 characters is kept, a longer one is omitted with all below it", long_paths, NULL, NULL, NULL},
        {"CF-066 a leaf is modelled by its whole path", modelled, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
