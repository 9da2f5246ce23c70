/* SPDX-License-Identifier: MIT */
/*
 * Each member of a description in the file that is written from it (esi/write.h): one member is changed, and a part of
 * the file follows. Lines and indentation of the file are omitted.
 */
#include "esi/write.h"
#include "from_text.h"
#include "support/confdev.h"
#include "support/copy.h"
#include "support/testdev.h"

/* The file without the ends of lines and the blanks behind them; exists as long as the arena. */
static char *flat_file(ect_arena_t *arena, const ect_esi_part_t *parts, size_t count)
{
    char why[300];
    size_t length;
    const char *text = ect_esi_write(arena, parts, count, &length, why, sizeof why);
    if (text == NULL)
        fail_msg("expected a file, got: %s", why);
    char *flat = ect_arena_alloc(arena, length + 1);
    for (char *to = flat; *text != '\0';) {
        if (*text == '\n')
            text += strspn(text, "\n ");
        else
            *to++ = *text++;
    }
    return flat;
}

/* A device, a change of its copy, a part of its file, and a part that the file must not have. */
typedef struct row {
    const char *name;
    const ect_device_t *device;
    void (*change)(copy_t *c);
    const char *want, *unwanted;
} row_t;

#define D                 c->device
#define ENTRY(index, sub) copy_entry(c, index, sub)
#define OBJECT(index)     copy_object(c, index)
#define AS_IS             (void)c

/* X(name, device, the change, a part of the file, a part that is not in the file) */
#define IDENTITY(X)                                                                                                    \
    X(head, testdev, AS_IS,                                                                                            \
      "<EtherCATInfo xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" "                                         \
      "xsi:noNamespaceSchemaLocation=\"EtherCATInfo.xsd\" Version=\"1.14\"><Vendor><Id>#x00000E57</Id><Name>",         \
      NULL)                                                                                                            \
    X(groups, testdev, AS_IS,                                                                                          \
      "<Descriptions><Groups><Group><Type>TEST</Type><Name>Test devices</Name></Group></Groups><Devices><Device ",     \
      "<Modules>")                                                                                                     \
    X(numbers, testdev, AS_IS,                                                                                         \
      "<Type ProductCode=\"#x00007E57\" RevisionNo=\"#x00010002\" SerialNo=\"#x0000002A\">ectwin test device</Type>",  \
      "UseLrdLwr")                                                                                                     \
    X(no_serial, testdev, D.identity.serial = 0, "RevisionNo=\"#x00010002\">", "SerialNo")                             \
    X(no_lrw, testdev, D.general_flags = ECT_GENERAL_GIVEN | ECT_GENERAL_NO_LRW, " UseLrdLwr=\"true\">", NULL)         \
    X(ports, testdev, D.physics = "YK H", "<Device Physics=\"YK H\">", NULL)                                           \
    X(no_ports, testdev, D.physics = NULL, "<Device Physics=\"\">", NULL)                                              \
    X(no_name, testdev, D.full_name = NULL, "</Type><Name>ectwin test device</Name><Info>", NULL)                      \
    X(name, testdev, D.full_name = "A & B", "</Type><Name><![CDATA[A & B]]></Name><Info>", NULL)                       \
    X(name_of_cdata, testdev, D.full_name = "a]]>b", "<Name>a]]&gt;b</Name>", NULL)                                    \
    X(no_current, testdev, D.ebus_ma = 0, "<Info><StateMachine>", "Electrical")                                        \
    X(current, testdev, D.ebus_ma = 90, "<Info><Electrical><EBusCurrent>90</EBusCurrent></Electrical><StateM", NULL)   \
    X(fed_current, testdev, D.ebus_ma = -2000, "<EBusCurrent>-2000</EBusCurrent>", NULL)                               \
    X(timeouts, testdev, AS_IS,                                                                                        \
      "<StateMachine><Timeout><PreopTimeout>3000</PreopTimeout><SafeopOpTimeout>5000</SafeopOpTimeout>"                \
      "<BackToInitTimeout>1000</BackToInitTimeout><BackToSafeopTimeout>200</BackToSafeopTimeout></Timeout>"            \
      "</StateMachine>",                                                                                               \
      "RequestTimeout")                                                                                                \
    X(timeouts_of_the_standard, testdev, D.timeouts = (ect_timeouts_t){0},                                             \
      "<PreopTimeout>3000</PreopTimeout><SafeopOpTimeout>10000</SafeopOpTimeout><BackToInitTimeout>5000"               \
      "</BackToInitTimeout><BackToSafeopTimeout>200</BackToSafeopTimeout>",                                            \
      "RequestTimeout")                                                                                                \
    X(request_timeout, testdev, D.timeouts.mailbox_request_ms = 1,                                                     \
      "</StateMachine><Mailbox><Timeout><RequestTimeout>1</RequestTimeout><ResponseTimeout>2000</ResponseTimeout>"     \
      "</Timeout></Mailbox>",                                                                                          \
      NULL)                                                                                                            \
    X(response_timeout, testdev, D.timeouts.mailbox_response_ms = 65535,                                               \
      "<RequestTimeout>100</RequestTimeout><ResponseTimeout>65535</ResponseTimeout>", NULL)                            \
    X(identification, testdev, D.general_flags = ECT_GENERAL_GIVEN | ECT_GENERAL_ID_AL_STATUS,                         \
      "</StateMachine><IdentificationReg134>true</IdentificationReg134></Info>", "IdentificationAdo")                  \
    X(identification_in_memory, testdev,                                                                               \
      (D.general_flags = ECT_GENERAL_GIVEN | ECT_GENERAL_ID_MEMORY, D.id_address = 0x12),                              \
      "</StateMachine><IdentificationAdo>#x0012</IdentificationAdo></Info>", "IdentificationReg134")                   \
    X(no_profile, testdev, AS_IS, "<Profile><Dictionary>", "ProfileNo")                                                \
    X(profile, testdev, D.device_type = 0x00020192,                                                                    \
      "<Profile><ProfileNo>402</ProfileNo><AddInfo>2</AddInfo><Dictionary>", NULL)

#define LAYOUT(X)                                                                                                      \
    X(fmmus, testdev, AS_IS, "<Fmmu>Outputs</Fmmu><Fmmu>Inputs</Fmmu><Fmmu>MBoxState</Fmmu><Sm ", NULL)                \
    X(fmmu_unused, testdev, D.fmmu[1] = ECT_FMMU_UNUSED, "<Fmmu>Outputs</Fmmu><Fmmu></Fmmu><Fmmu>M", NULL)             \
    X(fmmu_unknown, testdev, D.fmmu[2] = 4, "<Fmmu>Inputs</Fmmu><Fmmu></Fmmu><Sm ", NULL)                              \
    X(mailbox_out, testdev, AS_IS,                                                                                     \
      "<Sm MinSize=\"128\" MaxSize=\"128\" DefaultSize=\"128\" StartAddress=\"#x1000\" ControlByte=\"#x26\" "          \
      "Enable=\"1\">MBoxOut</Sm>",                                                                                     \
      NULL)                                                                                                            \
    X(mailbox_in, testdev, AS_IS,                                                                                      \
      "<Sm MinSize=\"34\" MaxSize=\"256\" DefaultSize=\"128\" StartAddress=\"#x1080\" ControlByte=\"#x22\" "           \
      "Enable=\"1\">MBoxIn</Sm>",                                                                                      \
      NULL)                                                                                                            \
    X(outputs, testdev, AS_IS,                                                                                         \
      "<Sm DefaultSize=\"3\" StartAddress=\"#x1200\" ControlByte=\"#x64\" Enable=\"1\">Outputs</Sm>", NULL)            \
    X(most_as_default, testdev, D.sm[2].maximum = 3, "<Sm DefaultSize=\"3\" StartAddress=\"#x1200\"", "MaxSize=\"3\"") \
    X(most, testdev, D.sm[2].maximum = 4, "<Sm MaxSize=\"4\" DefaultSize=\"3\" StartAddress=\"#x1200\"", NULL)         \
    X(unused, testdev, (D.sm_count = 5, D.sm[4].start = 0x80),                                                         \
      "<Sm DefaultSize=\"0\" StartAddress=\"#x0080\" ControlByte=\"#x00\" Enable=\"0\"></Sm>", NULL)                   \
    X(one_byte, testdev, (ENTRY(0x1600, 0)->value = 2, ENTRY(0x1600, 2)->value = ECT_MAP(0, 0, 7)),                    \
      "<Sm DefaultSize=\"1\" StartAddress=\"#x1200\" ControlByte=\"#x64\" Enable=\"1\">Outputs</Sm>", NULL)            \
    X(no_byte, testdev, ENTRY(0x1600, 0)->value = 0,                                                                   \
      "<Sm DefaultSize=\"0\" StartAddress=\"#x1200\" ControlByte=\"#x64\" Enable=\"0\">Outputs</Sm>", NULL)            \
    X(fixed_sm, testdev, D.sm[2].flags = ECT_SM_FLAG_FIXED, "Enable=\"3\">Outputs</Sm>", NULL)                         \
    X(op_only, testdev, D.sm[2].flags = ECT_SM_FLAG_OP_ONLY, "Enable=\"1\" OpOnly=\"true\">Outputs</Sm>", NULL)        \
    X(virtual_sm, testdev,                                                                                             \
      (D.sm_count = 5, D.sm[4] = (ect_sm_t){.flags = ECT_SM_FLAG_VIRTUAL, .role = ECT_SM_INPUTS}),                     \
      " Virtual=\"true\">Inputs</Sm>", NULL)

#define PDOS(X)                                                                                                        \
    X(pdo, testdev, AS_IS,                                                                                             \
      "Sm=\"2\"><Index>#x1600</Index><Name>Outputs</Name><Entry><Index>#x7000</Index><SubIndex>1</SubIndex><BitLen>1"  \
      "</BitLen><Name>Output bit</Name><DataType>BOOL</DataType></Entry><Entry><Index>#x0</Index><BitLen>7</BitLen>"   \
      "</Entry><Entry><Index>#x7000</Index><SubIndex>2</SubIndex><BitLen>16</BitLen><Name>Output word</Name>"          \
      "<DataType>UINT</DataType></Entry></RxPdo><TxPdo ",                                                              \
      "<Exclude>")                                                                                                     \
    X(part_of_an_entry, testdev, ENTRY(0x1600, 3)->value = ECT_MAP(0x7000, 2, 12),                                     \
      "<BitLen>12</BitLen><Name>Output word</Name></Entry></RxPdo>", NULL)                                             \
    X(byte_of_an_entry, testdev, ENTRY(0x1600, 3)->value = ECT_MAP(0x7000, 2, 8),                                      \
      "<BitLen>8</BitLen><Name>Output word</Name><DataType>BIT8</DataType></Entry></RxPdo>", NULL)                     \
    X(entry_without_a_name, testdev, ENTRY(0x7000, 2)->name = NULL,                                                    \
      "<BitLen>16</BitLen><Name></Name><DataType>UINT</DataType></Entry></RxPdo>", NULL)                               \
    X(pdo_without_a_name, testdev, OBJECT(0x1600)->name = NULL, "<Index>#x1600</Index><Name></Name><Entry>", NULL)     \
    X(excluding, testdev, copy_pdo(c, 0x1A00, 0, 0x1600),                                                              \
      "<TxPdo Sm=\"3\"><Index>#x1A00</Index><Name>Inputs</Name><Exclude>#x1600</Exclude><Entry>", NULL)                \
    X(fixed, testdev, copy_pdo(c, 0x1A00, ECT_PDO_FIXED, 0), "<TxPdo Fixed=\"true\" Sm=\"3\">", NULL)                  \
    X(mandatory, testdev, copy_pdo(c, 0x1A00, ECT_PDO_MANDATORY, 0), "<TxPdo Mandatory=\"true\" Sm=\"3\">", NULL)      \
    X(free_pdo, confdev, AS_IS, "<RxPdo><Index>#x1601</Index><Name>RxPDO 2</Name></RxPdo><TxPdo Sm=\"3\">", NULL)      \
    X(order_of_the_assignment, confdev,                                                                                \
      (ENTRY(0x1C12, 0)->value = 2, ENTRY(0x1C12, 1)->value = 0x1601, ENTRY(0x1C12, 2)->value = 0x1600),               \
      "<RxPdo Sm=\"2\"><Index>#x1601</Index><Name>RxPDO 2</Name></RxPdo><RxPdo Sm=\"2\"><Index>#x1600</Index>", NULL)  \
    X(assigned_and_missing, confdev, ENTRY(0x1C12, 1)->value = 0x1602,                                                 \
      "</Sm><RxPdo><Index>#x1600</Index><Name>RxPDO 1</Name>", "#x1602")

#define OFFERS(X)                                                                                                      \
    X(no_mailbox, testdev, D.mailbox_protocols = 0, "</TxPdo><Eeprom>", "<Dictionary>")                                \
    X(foe, testdev, D.mailbox_protocols = ECT_MAILBOX_FOE, "<FoE/></Mailbox><Eeprom>", "<Profile>")                    \
    X(all_protocols, testdev, (D.mailbox_protocols = 0x3F, D.soe_channels = 3),                                        \
      "<AoE/><EoE/><CoE SdoInfo=\"true\" PdoUpload=\"true\" CompleteAccess=\"true\" SegmentedSdo=\"true\"/>"           \
      "<FoE/><SoE ChannelCount=\"3\"/><VoE/></Mailbox>",                                                               \
      NULL)                                                                                                            \
    X(no_channels, testdev, D.mailbox_protocols = ECT_MAILBOX_SOE, "<SoE/></Mailbox>", NULL)                           \
    X(repeated_mails, testdev, D.general_flags = ECT_GENERAL_GIVEN | ECT_GENERAL_MAIL_REPEAT,                          \
      "<Mailbox DataLinkLayer=\"true\"><CoE ", NULL)                                                                   \
    X(no_repeated_mails, testdev, D.general_flags = ECT_GENERAL_GIVEN, "<Mailbox><CoE ", "DataLinkLayer")              \
    X(configuration_and_history, confdev, AS_IS,                                                                       \
      "<CoE SdoInfo=\"true\" PdoAssign=\"true\" PdoConfig=\"true\" CompleteAccess=\"true\" SegmentedSdo=\"true\" "     \
      "DiagHistory=\"true\"/>",                                                                                        \
      "PdoUpload")                                                                                                     \
    X(no_history, testdev, AS_IS, "<CoE ", "DiagHistory")                                                              \
    X(command, testdev, command(c, "PS"),                                                                              \
      "<InitCmd CompleteAccess=\"true\"><Transition>PS</Transition><Index>#x2000</Index><SubIndex>17</SubIndex>"       \
      "<Data AdaptAutomatically=\"true\">0AFF00</Data><Comment>Why</Comment></InitCmd></CoE>",                         \
      NULL)                                                                                                            \
    X(plain_command, testdev, (command(c, "PS"), command_plain()),                                                     \
      "<InitCmd><Transition>PS</Transition><Index>#x2000</Index><SubIndex>17</SubIndex><Data>0AFF00</Data></InitCmd>", \
      "<Comment>")                                                                                                     \
    X(disabled_command, testdev, (command(c, "PS"), the_command.disabled = true), "<CoE ", "<InitCmd")                 \
    X(upload, testdev, (command(c, "PS"), the_command.upload = true), "<CoE ", "<InitCmd")                             \
    X(transitions, testdev, command(c, "IP PS OS"),                                                                    \
      "<Transition>IP</Transition><Transition>PS</Transition><Transition>OS</Transition><Index>", NULL)                \
    X(mails_of_EoE, testdev, mails(c, ECT_MAILBOX_EOE),                                                                \
      "<EoE><InitCmd><Transition>IP</Transition><Transition>PS</Transition><Type>2</Type><Data>010203</Data>"          \
      "<Comment>Why</Comment></InitCmd></EoE><CoE ",                                                                   \
      "<IDN>")                                                                                                         \
    X(mails_of_AoE, testdev, mails(c, ECT_MAILBOX_AOE),                                                                \
      "<AoE><InitCmd><Transition>PS</Transition><Data>010203</Data></InitCmd><InitCmd><Transition>SO</Transition>"     \
      "</InitCmd></AoE><CoE ",                                                                                         \
      "<Type>0</Type>")                                                                                                \
    X(mails_of_SoE, testdev, mails(c, ECT_MAILBOX_SOE),                                                                \
      "<SoE><InitCmd><Transition>PS</Transition><IDN>32</IDN><Data>010203</Data></InitCmd><InitCmd Chn=\"1\">"         \
      "<Transition>PS</Transition><IDN>33026</IDN><Data>01</Data></InitCmd></SoE>",                                    \
      "<IDN>17</IDN>")                                                                                                 \
    X(no_clocks, testdev, AS_IS, "</Mailbox><Eeprom>", "<Dc>")                                                         \
    X(clocks, confdev, AS_IS,                                                                                          \
      "</Mailbox><Dc><OpMode><Name>DC</Name><Desc>DC SYNC0</Desc><AssignActivate>#x0300</AssignActivate></OpMode>"     \
      "</Dc><Eeprom>",                                                                                                 \
      NULL)                                                                                                            \
    X(no_description, confdev, c->dc_modes[0].description = NULL, "<Name>DC</Name><AssignActivate>", "<Desc>")         \
    X(empty_description, confdev, c->dc_modes[0].description = "", "<Name>DC</Name><AssignActivate>", "<Desc>")        \
    X(free_run, confdev, c->dc_modes[0].assign_activate = 0, "<AssignActivate>#x0000</AssignActivate>", NULL)          \
    X(cycle, confdev, c->dc_modes[0].cycle_sync0_ns = 4000000000u,                                                     \
      "<CycleTimeSync0>4000000000</CycleTimeSync0></OpMode>", NULL)                                                    \
    X(cycle_of_the_bus, confdev, c->dc_modes[0].factor_sync0 = -2,                                                     \
      "<CycleTimeSync0 Factor=\"-2\">0</CycleTimeSync0></OpMode>", NULL)                                               \
    X(sync1, confdev, (c->dc_modes[0].factor_sync1 = 4, c->dc_modes[0].shift_sync1_ns = -7),                           \
      "<CycleTimeSync1 Factor=\"4\">0</CycleTimeSync1><ShiftTimeSync1>-7</ShiftTimeSync1></OpMode>", "Sync0")          \
    X(shift, confdev, c->dc_modes[0].shift_sync0_ns = 5, "<ShiftTimeSync0>5</ShiftTimeSync0></OpMode>", "Factor")      \
    X(eeprom, testdev, AS_IS,                                                                                          \
      "<Eeprom><ByteSize>2048</ByteSize><ConfigData>0800000000000000000000000000</ConfigData></Eeprom>", "BootStrap")  \
    X(boot, testdev, (D.boot_out = (ect_boot_mailbox_t){0x1234, 128}, D.boot_in = (ect_boot_mailbox_t){0x1480, 256}),  \
      "</ConfigData><BootStrap>3412800080140001</BootStrap></Eeprom>", NULL)                                           \
    X(categories, testdev, (D.categories = own, D.category_count = 2),                                                 \
      "</ConfigData><Category><CatNo>2048</CatNo><Data>010203</Data></Category><Category><CatNo>2049</CatNo><Data/>"   \
      "</Category></Eeprom>",                                                                                          \
      NULL)                                                                                                            \
    X(image, testdev, D.sii = image, "<Eeprom><Data>08000000", "<ByteSize>")

static const uint8_t bytes[] = {1, 2, 3};
static const ect_category_t own[] = {{.number = 2048, .length = 3, .data = bytes}, {.number = 2049}};
static const uint8_t image[2048] = {8};

static ect_init_command_t the_command;

static void command(copy_t *c, const char *transitions)
{
    static const uint8_t data[] = {0x0A, 0xFF, 0x00};
    the_command = (ect_init_command_t){.transitions = transitions,
                                       .index = 0x2000,
                                       .subindex = 17,
                                       .complete = true,
                                       .adapts = true,
                                       .size = sizeof data,
                                       .data = data,
                                       .comment = "Why"};
    c->device.init_commands = &the_command;
    c->device.init_command_count = 1;
}

/* Commands of three protocols, of which the device offers one more; some do not occur in an ESI file. */
static void mails(copy_t *c, uint8_t protocol)
{
    static const ect_init_mail_t all[] = {
        {"PS", NULL, ECT_MAILBOX_TYPE_AOE, 0, 0, 0, 0, false, sizeof bytes, bytes},
        {"IP PS", "Why", ECT_MAILBOX_TYPE_EOE, 2, 0, 0, 0, false, sizeof bytes, bytes},
        {"PS", NULL, ECT_MAILBOX_TYPE_EOE, 4, 0, 0, 0, true, sizeof bytes, bytes},
        {"PS", NULL, ECT_MAILBOX_TYPE_SOE, ECT_INIT_WRITES, 0, 0x40, 32, false, sizeof bytes, bytes},
        {"PS", NULL, ECT_MAILBOX_TYPE_SOE, ECT_INIT_WRITES, 1, 0x40, 0x8102, false, 1, bytes},
        {"SO", NULL, ECT_MAILBOX_TYPE_AOE, 0, 0, 0, 0, false, 0, NULL},
        {"PS", NULL, ECT_MAILBOX_TYPE_SOE, ECT_INIT_READS, 0, 0x40, 17, false, 0, NULL},
    };
    c->device.mailbox_protocols |= protocol;
    c->device.init_mails = all;
    c->device.init_mail_count = sizeof all / sizeof all[0];
}

static void command_plain(void)
{
    the_command.complete = the_command.adapts = false;
    the_command.comment = NULL;
}

/* --- dictionary --------------------------------------------------------------------------------------------------- */

#define OBJECT_HEAD(name, type, bits) "<Name>" name "</Name><Type>" type "</Type><BitSize>" bits "</BitSize>"
#define DICTIONARY(X)                                                                                                  \
    X(value, testdev, AS_IS,                                                                                           \
      "<Object><Index>#x2000</Index>" OBJECT_HEAD(                                                                     \
          "U32", "UDINT",                                                                                              \
          "32") "<Info><DefaultData>44332211</DefaultData>"                                                            \
                "</Info><Flags><Access>rw</Access><Category>o</Category><Backup>1</Backup></Flags></Object>",          \
      NULL)                                                                                                            \
    X(name_of_value, testdev, ENTRY(0x2000, 0)->name = "Entry",                                                        \
      "<Info><DefaultData>44332211</DefaultData><DisplayName>Entry</DisplayName></Info>", NULL)                        \
    X(no_object_name, testdev, OBJECT(0x2000)->name = NULL, "<Index>#x2000</Index><Name></Name><Type>UDINT", NULL)     \
    X(write_only, testdev, AS_IS,                                                                                      \
      OBJECT_HEAD("Write only", "UINT", "16") "<Info><DefaultData>0000</DefaultData></Info><Flags><Access>wo</Access>" \
                                              "<Category>o</Category></Flags>",                                        \
      NULL)                                                                                                            \
    X(setting, testdev, AS_IS,                                                                                         \
      "<Flags><Access WriteRestrictions=\"PreOP\">rw</Access><Category>o</Category><Setting>1</Setting></Flags>",      \
      NULL)                                                                                                            \
    X(read_in_op, testdev, ENTRY(0x2004, 0)->access = ECT_ACCESS_R_OP,                                                 \
      "<Flags><Access ReadRestrictions=\"OP\">ro</Access><Category>o</Category></Flags>", NULL)                        \
    X(both_restricted, testdev, ENTRY(0x2004, 0)->access = ECT_ACCESS_R_PREOP | ECT_ACCESS_W_SAFEOP | ECT_ACCESS_W_OP, \
      "<Access ReadRestrictions=\"PreOP\" WriteRestrictions=\"SafeOP_OP\">rw</Access>", NULL)                          \
    X(no_rights, testdev, ENTRY(0x2004, 0)->access = 0,                                                                \
      OBJECT_HEAD("PREOP only", "UINT", "16") "<Info><DefaultData>0700</DefaultData></Info><Flags><Category>o", NULL)  \
    X(to_outputs, testdev, ENTRY(0x2004, 0)->access = ECT_ACCESS_RW | ECT_ACCESS_RXPDO,                                \
      "<Access>rw</Access><Category>o</Category><PdoMapping>R</PdoMapping></Flags>", NULL)                             \
    X(to_inputs, testdev, ENTRY(0x2004, 0)->access = ECT_ACCESS_RO | ECT_ACCESS_TXPDO,                                 \
      "<Access>ro</Access><Category>o</Category><PdoMapping>T</PdoMapping></Flags>", NULL)                             \
    X(to_both, testdev, ENTRY(0x2004, 0)->access = ECT_ACCESS_RO | ECT_ACCESS_TXPDO | ECT_ACCESS_RXPDO,                \
      "<Access>ro</Access><Category>o</Category><PdoMapping>TR</PdoMapping></Flags>", NULL)                            \
    X(mandatory_1000, testdev, AS_IS,                                                                                  \
      "<Info><DefaultData>78563412</DefaultData></Info><Flags><Access>ro</Access>"                                     \
      "<Category>m</Category></Flags>",                                                                                \
      NULL)                                                                                                            \
    X(mandatory_1018, testdev, AS_IS, "<Index>#x1018</Index><Name>Identity</Name><Type>DT1018</Type>", NULL)           \
    X(limits, testdev, AS_IS,                                                                                          \
      "<Info><MinValue>-100</MinValue><MaxValue>200</MaxValue><DefaultValue>5</DefaultValue><Unit>#x002D0000</Unit>"   \
      "</Info>",                                                                                                       \
      NULL)                                                                                                            \
    X(negative_default, testdev, ENTRY(0x2005, 0)->value = 0xFFFB, "<DefaultValue>-5</DefaultValue>", NULL)            \
    X(unsigned_default, testdev,                                                                                       \
      (ENTRY(0x2005, 0)->data_type = ECT_TYPE_UNSIGNED16, ENTRY(0x2005, 0)->value = 0xFFFB),                           \
      "<DefaultValue>65531</DefaultValue>", NULL)                                                                      \
    X(bits_default, testdev, (ENTRY(0x2005, 0)->data_type = ECT_TYPE_BITARR16, ENTRY(0x2005, 0)->value = 0x8000),      \
      "<DefaultValue>32768</DefaultValue>", NULL)                                                                      \
    X(long_negative_default, testdev,                                                                                  \
      (copy_detail(c, 0x2009, 0), c->details[1].minimum = -2, c->details[1].initial = all_ones,                        \
       ENTRY(0x2009, 0)->data_type = ECT_TYPE_INTEGER64),                                                              \
      "<MinValue>-2</MinValue><MaxValue>0</MaxValue><DefaultValue>-1</DefaultValue>", NULL)                            \
    X(unit_alone, testdev, (c->details[0].minimum = c->details[0].maximum = 0, c->details[0].per = 3),                 \
      "<Info><DefaultData>0500</DefaultData><Unit>#x002D0300</Unit></Info>", "MinValue")                               \
    X(no_unit, testdev, c->details[0].unit = 0, "<DefaultValue>5</DefaultValue></Info>", "<Unit>")                     \
    X(text, testdev, text(c, "abc"), "<Info><DefaultString>abc</DefaultString></Info>", NULL)                          \
    X(text_of_xml, testdev, text(c, "a<b"), "<DefaultString><![CDATA[a<b]]></DefaultString>", NULL)                    \
    X(blank_in_front, testdev, text(c, " ab"), "<Info><DefaultData>206162</DefaultData></Info>", NULL)                 \
    X(blank_behind, testdev, text(c, "ab "), "<Info><DefaultData>616220</DefaultData></Info>", NULL)                   \
    X(blank_within, testdev, text(c, "a b"), "<DefaultString>a b</DefaultString>", NULL)                               \
    X(blank_alone, testdev, text(c, " "), "<Info><DefaultData>20</DefaultData></Info>", NULL)                          \
    X(no_text, testdev, AS_IS, OBJECT_HEAD("Text", "STRING(20)", "160") "<Info/><Flags>", NULL)                        \
    X(bytes_of_one, testdev, ENTRY(0x2002, 0)->bit_length = 8,                                                         \
      OBJECT_HEAD("Octets", "ARRAY [0..0] OF BYTE", "8") "<Info><DefaultData>00</DefaultData></Info>", NULL)           \
    X(bits_of_a_record, testdev, AS_IS,                                                                                \
      "<DataType><Name>DT2006</Name><BitSize>88</BitSize><SubItem><SubIdx>0</SubIdx><Name>SubIndex 000</Name>"         \
      "<DisplayName>Number of entries</DisplayName><Type>USINT</Type><BitSize>8</BitSize><BitOffs>0</BitOffs><Flags>"  \
      "<Access>ro</Access><Category>o</Category></Flags></SubItem><SubItem><SubIdx>1</SubIdx><Name>Bool</Name><Type>"  \
      "BOOL</Type><BitSize>1</BitSize><BitOffs>16</BitOffs>",                                                          \
      NULL)                                                                                                            \
    X(bits_follow_bits, testdev, AS_IS,                                                                                \
      "<SubIdx>3</SubIdx><Name>Five bits</Name><Type>BIT5</Type><BitSize>5</BitSize><BitOffs>20</BitOffs>", NULL)      \
    X(bytes_follow_bits, testdev, AS_IS,                                                                               \
      "<SubIdx>4</SubIdx><Name>U16</Name><Type>UINT</Type><BitSize>16</BitSize><BitOffs>32</BitOffs>", NULL)           \
    X(array, testdev, AS_IS,                                                                                           \
      "<DataType><Name>DT2007ARR</Name><BaseType>UINT</BaseType><BitSize>64</BitSize><ArrayInfo><LBound>1</LBound>"    \
      "<Elements>4</Elements></ArrayInfo></DataType><DataType><Name>DT2007</Name><BitSize>80</BitSize>",               \
      NULL)                                                                                                            \
    X(elements, testdev, AS_IS,                                                                                        \
      "<SubItem><Name>Elements</Name><Type>DT2007ARR</Type><BitSize>64</BitSize><BitOffs>16</BitOffs><Flags><Access>"  \
      "rw</Access><Category>o</Category></Flags></SubItem></DataType>",                                                \
      NULL)                                                                                                            \
    X(names_of_elements, testdev, AS_IS,                                                                               \
      "<SubItem><Name>SubIndex 004</Name><Info><DefaultData>0000</DefaultData><DisplayName>Element</DisplayName>"      \
      "</Info></SubItem></Info><Flags><Access>rw</Access><Category>o</Category></Flags></Object>",                     \
      NULL)                                                                                                            \
    X(sparse, testdev, AS_IS, "<SubIdx>5</SubIdx><Name>Five</Name>", "<Name>DT2008ARR</Name>")                         \
    X(one_name_twice, testdev, ENTRY(0x2008, 5)->name = "Three",                                                       \
      "<SubIdx>5</SubIdx><Name>SubIndex 005</Name><DisplayName>Three</DisplayName>", NULL)                             \
    X(bytes_are_a_type, testdev, AS_IS,                                                                                \
      "<DataType><Name>BYTE</Name><BitSize>8</BitSize></DataType><DataType><Name>ARRAY [0..999] OF BYTE</Name>"        \
      "<BaseType>BYTE</BaseType><BitSize>8000</BitSize><ArrayInfo><LBound>0</LBound><Elements>1000</Elements>"         \
      "</ArrayInfo></DataType>",                                                                                       \
      NULL)                                                                                                            \
    X(first_type, testdev, AS_IS, "<DataTypes><DataType><Name>UDINT</Name><BitSize>32</BitSize></DataType>", NULL)

static const uint8_t all_ones[] = {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF};

/* A default of 2001h. */
static void text(copy_t *c, const char *value)
{
    static char initial[20];
    memset(initial, 0, sizeof initial);
    (void)strcpy(initial, value);
    c->details[1] = c->details[0];
    c->details[0] = (ect_detail_t){.index = 0x2001, .initial = initial};
    c->device.detail_count = 2;
}

#define FUNCTION(name, of, statement, want, unwanted)                                                                  \
    static void change_##name(copy_t *c)                                                                               \
    {                                                                                                                  \
        (void)c;                                                                                                       \
        (void)(statement);                                                                                             \
    }
#define ROW(name, of, statement, want, unwanted) {#name, &(of), change_##name, want, unwanted},
#define ALL(X)                                   IDENTITY(X) LAYOUT(X) PDOS(X) OFFERS(X) DICTIONARY(X)

ALL(FUNCTION)
static const row_t rows[] = {ALL(ROW)};

static void each_member(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_arena_t arena = {0};
        copy_t *c = copy_device(rows[i].device);
        rows[i].change(c);
        const char *text = flat_file(&arena, &(ect_esi_part_t){.device = &c->device}, 1);
        if (strstr(text, rows[i].want) == NULL)
            fail_msg("%s: expected %s in %s", rows[i].name, rows[i].want, text);
        if (rows[i].unwanted != NULL && strstr(text, rows[i].unwanted) != NULL)
            fail_msg("%s: expected no %s in %s", rows[i].name, rows[i].unwanted, text);
        copy_free(c);
        ect_arena_free(&arena);
    }
}

/* --- names of values and bits ------------------------------------------------------------------------------------- */

static void fields(void **state)
{
    static const ect_value_name_t on_off[] = {{0, "Off"}, {1, "On"}, {0, NULL}};
    static const ect_value_name_t other[] = {{-1, "None"}, {0, NULL}};
    static const struct {
        const char *what;
        ect_field_t fields[4];
        const char *want, *unwanted;
    } table[] = {
        {"values of an entry",
         {ECT_FIELD_VALUES(0x2003, 0, on_off, NULL)},
         "<DataType><Name>DT2003EN00</Name><BaseType>UINT</BaseType><BitSize>16</BitSize><EnumInfo><Text>Off</Text>"
         "<Enum>0</Enum></EnumInfo><EnumInfo><Text>On</Text><Enum>1</Enum></EnumInfo></DataType>",
         "<Comment>"},
        {"the entry has the type", {ECT_FIELD_VALUES(0x2003, 0, on_off, NULL)}, "<Type>DT2003EN00</Type>", NULL},
        {"a negative value", {ECT_FIELD_VALUES(0x2005, 0, other, NULL)}, "<Enum>-1</Enum>", NULL},
        {"a sub-item",
         {ECT_FIELD_VALUES(0x2006, 4, on_off, NULL)},
         "<SubIdx>4</SubIdx><Name>U16</Name><Type>DT2006EN04</Type>",
         NULL},
        {"the same values of the same length are one type",
         {ECT_FIELD_VALUES(0x2003, 0, on_off, NULL), ECT_FIELD_VALUES(0x2006, 4, on_off, NULL)},
         "<SubIdx>4</SubIdx><Name>U16</Name><Type>DT2003EN00</Type>",
         "DT2006EN04"},
        {"the same values of another length are another type",
         {ECT_FIELD_VALUES(0x2003, 0, on_off, NULL), ECT_FIELD_VALUES(0x2006, 6, on_off, NULL)},
         "<Name>DT2006EN06</Name><BaseType>UDINT</BaseType><BitSize>32</BitSize>",
         NULL},
        {"other values are another type",
         {ECT_FIELD_VALUES(0x2003, 0, on_off, NULL), ECT_FIELD_VALUES(0x2006, 4, other, NULL)},
         "<Name>DT2006EN04</Name>",
         NULL},
        {"values beside numbers are none",
         {{.index = 0x2003, .open = true, .values = on_off}},
         "<Name>Write only</Name><Type>UINT</Type>",
         "EnumInfo"},
        {"values of some bits are none",
         {{.index = 0x2003, .bit = 2, .width = 2, .name = "Mode", .values = on_off}},
         "<Name>Write only</Name><Type>UINT</Type>",
         "EnumInfo"},
        {"an entry without values", {{.index = 0x2003}}, "<Name>Write only</Name><Type>UINT</Type>", "EnumInfo"},
        {"an entry that the device has not", {ECT_FIELD_VALUES(0x2003, 9, on_off, NULL)}, "<Type>UINT</Type>", "Enum"},
        {"an object that the device has not", {ECT_FIELD_VALUES(0x3000, 0, on_off, NULL)}, "<Type>UINT</Type>", "Enum"},
        {"a type of the second although the device has not the first",
         {ECT_FIELD_VALUES(0x3000, 0, on_off, NULL), ECT_FIELD_VALUES(0x2003, 0, on_off, NULL)},
         "<Name>DT2003EN00</Name>",
         "DT3000"},
        {"a bit", {ECT_FIELD_BIT(0x7000, 2, 3, "GO", NULL, NULL)}, "</Name><Comment>bit 3 GO</Comment><DataTy", NULL},
        {"a bit with its meaning",
         {ECT_FIELD_BIT(0x7000, 2, 3, "GO", "it moves", NULL)},
         "<Name>Output word</Name><Comment>bit 3 GO: it moves</Comment><DataType>",
         NULL},
        {"bits in the order of the table",
         {{.index = 0x7000, .subindex = 2, .bit = 4, .width = 12, .name = "N"},
          ECT_FIELD_BIT(0x7000, 2, 0, "A", NULL, NULL)},
         "<Comment>bits 4 to 15 N; bit 0 A</Comment>",
         NULL},
        {"bits of another sub-index",
         {ECT_FIELD_BIT(0x7000, 1, 0, "A", NULL, NULL)},
         "<Name>Output bit</Name><Comment>bit 0 A</Comment><DataType>",
         NULL},
        {"bits of what no PDO maps", {ECT_FIELD_BIT(0x2003, 0, 0, "A", NULL, NULL)}, "<RxPdo", "<Comment>"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        ect_arena_t arena = {0};
        const ect_plant_t plant = {.fields = table[i].fields};
        const char *text = flat_file(&arena, &(ect_esi_part_t){.device = &testdev, .plant = &plant}, 1);
        if (strstr(text, table[i].want) == NULL)
            fail_msg("%s: expected %s in %s", table[i].what, table[i].want, text);
        if (table[i].unwanted != NULL && strstr(text, table[i].unwanted) != NULL)
            fail_msg("%s: expected no %s in %s", table[i].what, table[i].unwanted, text);
        ect_arena_free(&arena);
    }
}

/* --- devices of several files ------------------------------------------------------------------------------------- */

#define RACK(product, ident)                                                                                           \
    ESI_HEAD "<Device Physics='YY'><Type ProductCode='" product "' RevisionNo='2'>R</Type><Name>R</Name>"              \
             "<Slots><Slot><Name>S</Name><ModuleIdent>" ident "</ModuleIdent></Slot></Slots></Device></Devices>"       \
             "<Modules><Module><Type ModuleIdent='" ident                                                              \
             "'>M</Type></Module></Modules></Descriptions></EtherCATInfo>"

static size_t occurrences(const char *text, const char *part)
{
    size_t count = 0;
    for (const char *at = strstr(text, part); at != NULL; at = strstr(at + 1, part))
        count++;
    return count;
}

static void modules_of_two_files(void **state)
{
    ect_arena_t arena = {0};
    (void)state;
    made_t one = make_text("one", RACK("1", "11")), other = make_text("other", RACK("3", "33"));
    const ect_identity_t second = {.vendor_id = 0xE57, .product_code = 2};
    const ect_esi_part_t parts[] = {{.device = device_of(&one), .twin = one.twin},
                                    {.device = device_of(&one), .twin = one.twin, .identity = &second},
                                    {.device = device_of(&other), .twin = other.twin}};
    const char *text = flat_file(&arena, parts, 3);
    assert_int_equal(occurrences(text, "<Modules>"), 1);
    assert_int_equal(occurrences(text, "<Slots>"), 3);
    assert_non_null(strstr(text, "</Devices><Modules><Module><Type ModuleIdent=\"11\">M</Type></Module><Module>"
                                 "<Type ModuleIdent=\"33\">M</Type></Module></Modules></Descriptions></EtherCATInfo>"));
    free_made(&one);
    free_made(&other);
    ect_arena_free(&arena);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"CF-057 CF-060 CF-061 CF-062 CF-077 each member of a description has its element or attribute", each_member,
         NULL, NULL, NULL},
        {"CF-077 values with names are an enumeration, bits with names are a comment", fields, NULL, NULL, NULL},
        {"modules of two files are written once each, in one element", modules_of_two_files, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
