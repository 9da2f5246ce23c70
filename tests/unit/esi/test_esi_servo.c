/* SPDX-License-Identifier: MIT */
/* Twins of SoE drives of tests/esi/soe.xml on a wire: parameters by mail, telegrams with the file's lengths. */
#include "check/check.h"
#include "esi/write.h"
#include "from_text.h"
#include "servo_of_file.h"
#include "sii/sii.h"
#include "wire/sii.h"

static void expect_list(unsigned int drive, uint16_t idn, const uint16_t *expected, size_t count)
{
    uint8_t reply[4 * ROOM] = {0};
    const int length = request(drive, READ, VALUE, idn, NULL, 0, reply);
    if (length != (int)(4 + 2 * count) || ect_load_le16(reply) != 2 * count)
        fail_msg("drive %u, IDN %u: expected %zu elements, got %d bytes", drive, idn, count, length);
    for (size_t i = 0; i < count; i++)
        assert_int_equal(ect_load_le16(reply + 4 + 2 * i), expected[i]);
}

#define LIST(...) (const uint16_t[]){__VA_ARGS__}, sizeof((const uint16_t[]){__VA_ARGS__}) / sizeof(uint16_t)

/* --- parameters --------------------------------------------------------------------------------------------------- */

static void parameters_of_a_dictionary(void **state)
{
    uint8_t reply[4 * ROOM] = {0};
    (void)state;
    open_servo("SPEED", ECT_BEHAVIOUR_NONE);
    assert_int_equal(number_of(0, 1, VALUE), 2000);
    assert_int_equal(number_of(0, 1, 0x10), 250);
    assert_int_equal(number_of(0, 1, 0x20), 8000);
    assert_int_equal(number_of(0, 1, 0x80), 2000);
    assert_int_equal(number_of(0, 1, ATTRIBUTE), 0x60110001);
    assert_int_equal(number_of(0, 32, VALUE), 2);
    assert_int_equal(request(0, READ, VALUE, 95, NULL, 0, reply), 4 + 5);
    assert_memory_equal(reply, "\x05\x00\x14\x00Ready", 9);
    assert_int_equal(request(0, READ, VALUE, 0x800A, NULL, 0, reply), 4 + 4);
    assert_memory_equal(reply, "\x04\x00\x10\x00\x01\x00\x02\x00", 8);
    assert_int_equal(request(0, READ, 0x02, 32, NULL, 0, reply), 4 + 14);
    assert_memory_equal(reply + 4, "Operation mode", 14);
    assert_int_equal(write_value(0, 1, "\xF9\x00", 2), -1 - ECT_SOE_TOO_LOW);
    assert_int_equal(write_value(0, 1, "\xFA\x00", 2), 0);
    assert_int_equal(number_of(0, 1, VALUE), 250);
}

static void made_parameters(void **state)
{
    uint8_t reply[4 * ROOM];
    (void)state;
    open_servo("SPEED", ECT_BEHAVIOUR_NONE);
    assert_int_equal(number_of(0, 15, VALUE), 7);
    expect_list(0, 24, LIST(36));
    expect_list(0, 16, LIST(40));
    expect_list(0, 187, LIST(40, 51));
    expect_list(0, 188, LIST(36));
    expect_list(0, 17, LIST(1, 11, 15, 16, 17, 21, 22, 24, 32, 36, 40, 51, 95, 99, 134, 135, 187, 188, 0x800A));
    assert_int_equal(request(1, READ, VALUE, 24, NULL, 0, reply), -1 - ECT_SOE_NO_DRIVE);
    assert_int_equal(request(0, READ, VALUE, 0, NULL, 0, reply), -1 - ECT_SOE_NO_IDN);
}

static void start_up(void **state)
{
    const ect_esi_mailbox_t *mailbox;
    (void)state;
    open_servo("TWO", ECT_BEHAVIOUR_NONE);
    mailbox = &ect_esi_twin_model(twin)->mailbox;
    assert_int_equal(mailbox->mail_count, 5);
    for (size_t i = 0; i < mailbox->mail_count; i++) {
        const ect_esi_mail_t *init = &mailbox->mails[i];
        if (write_value(init->drive, init->idn, init->data.bytes, (uint16_t)init->data.length) != 0)
            fail_msg("expected that drive %u takes %zu bytes of IDN %u", init->drive, init->data.length, init->idn);
    }
    wire_go(&wire, 0, SAFEOP);
    wire_go(&wire, 0, OP);
}

/* A command of the manufacturer in two drives, which no axis executes. */
static void other_command(void **state)
{
#define UINT_AT(index, flags)                                                                                          \
    "<Object><Index>#x" index "</Index><Name>N</Name><Type>UINT</Type><BitSize>16</BitSize>" flags "</Object>"
#define TWO_DRIVES                                                                                                     \
    ESI_DEVICE(                                                                                                        \
        "<Profile><Dictionary><DataTypes><DataType><Name>UINT</Name><BitSize>16</BitSize></DataType>"                  \
        "</DataTypes><Objects>" UINT_AT("0086", "") UINT_AT("0087", "") UINT_AT(                                       \
            "8001", "<Flags><Attribute>#x00090001</Attribute></Flags>") "</Objects></Dictionary></"                    \
                                                                        "Profile>" ESI_MAILBOX_SMS ESI_PROCESS_SMS     \
                                                                        "<Mailbox><SoE "                               \
                                                                        "ChannelCount='2'/></Mailbox>" ESI_EEPROM)
    enum { COMMAND = 0x8001, STATE_ELEMENT = ECT_SOE_ELEMENT_STATE };
    static const uint8_t start[] = {3, 0}, clear[] = {0, 0};
    char why[200] = "";
    (void)state;
    made_t m = make_text("P-0-0001", TWO_DRIVES);
    assert_true(ect_esi_twin_behave(m.twin, ECT_BEHAVIOUR_BY_FILE, why, sizeof why));
    assert_non_null(note_of(&m, "S-0-0134, S-0-0135: axis 1"));
    twin = m.twin;
    open_twin();
    for (unsigned int drive = 0; drive < 2; drive++) {
        assert_int_equal(number_of(drive, COMMAND, STATE_ELEMENT), ECT_SOE_COMMAND_CLEARED);
        assert_int_equal(write_value(drive, COMMAND, start, sizeof start), 0);
        assert_int_equal(number_of(drive, COMMAND, STATE_ELEMENT), ECT_SOE_COMMAND_DONE);
        assert_int_equal(number_of(1 - drive, COMMAND, STATE_ELEMENT), ECT_SOE_COMMAND_CLEARED);
        assert_int_equal(write_value(drive, COMMAND, clear, sizeof clear), 0);
        assert_int_equal(number_of(drive, COMMAND, STATE_ELEMENT), ECT_SOE_COMMAND_CLEARED);
    }
    (void)close_drive(state);
    ect_esi_close(m.esi);
}

/* --- telegrams ---------------------------------------------------------------------------------------------------- */

static void lengths(void **state)
{
    (void)state;
    open_servo("TWO", ECT_BEHAVIOUR_NONE);
    assert_int_equal(size_of(2), 12);
    assert_int_equal(size_of(3), 20);
    for (unsigned int drive = 0; drive < 2; drive++) {
        expect_list(drive, 24, LIST(47));
        expect_list(drive, 16, LIST(51, 40));
        expect_list(drive, 187, LIST(40, 51, 84));
    }
    wire_go(&wire, 0, SAFEOP);
    wire_go(&wire, 0, OP);
}

/* Each drive has its own values. */
static void places(void **state)
{
    (void)state;
    open_servo("TWO", ECT_BEHAVIOUR_NONE);
    wire_go(&wire, 0, SAFEOP);
    set("at_1.position_feedback_1_value", "-2");
    set("at_2.position_feedback_1_value", "77");
    wire_go(&wire, 0, OP);
    ect_store_le32(out + 2, 1000);
    ect_store_le32(out + 8, 2000);
    cycles(2);
    assert_int_equal((int32_t)ect_load_le32(in + 2), -2);
    assert_int_equal(ect_load_le32(in + 12), 77);
    assert_int_equal((int)signal_of("mdt_1.position_command_value"), 1000);
    assert_int_equal((int)signal_of("mdt_2.position_command_value"), 2000);
    assert_int_equal(number_of(1, 47, VALUE), 2000);
    assert_int_equal(number_of(0, 51, VALUE), 0xFFFFFFFE);
}

static void other_lists(void **state)
{
    static const uint8_t at[] = {4, 0, 4, 0, 84, 0, 51, 0};
    static const uint8_t unknown[] = {2, 0, 2, 0, 1, 0};
    (void)state;
    open_servo("TWO", ECT_BEHAVIOUR_NONE);
    assert_int_equal(write_value(1, 16, unknown, sizeof unknown), -1 - ECT_SOE_INVALID);
    assert_int_equal(write_value(1, 16, at, sizeof at), 0);
    expect_list(1, 16, LIST(84, 51));
    expect_list(0, 16, LIST(51, 40));
}

/* --- EEPROM, file ------------------------------------------------------------------------------------------------- */

static void numbers_in_the_eeprom(void **state)
{
    static uint8_t image[2048];
    static const uint16_t mdts[] = {0x0018, 0x1018}, ats[] = {0x0010, 0x1010};
    size_t length = 0;
    (void)state;
    open_servo("TWO", ECT_BEHAVIOUR_NONE);
    assert_int_equal(ect_sii_write(device(), NULL, 0, image, sizeof image), 2048);
    assert_int_equal(ect_load_le16(image + ECT_SII_AT_PROTOCOLS), ECT_MAILBOX_SOE);
    assert_int_equal(ect_sii_category(image, sizeof image, ECT_SII_GENERAL, &length)[8], 2);
    const uint8_t *pdo = ect_sii_category(image, sizeof image, ECT_SII_RXPDO, &length);
    for (size_t i = 0; i < 2; i++, pdo += 8 + 8 * 2) {
        assert_int_equal(ect_load_le16(pdo), mdts[i]);
        assert_int_equal(ect_load_le16(pdo + 8), 134);
        assert_int_equal(ect_load_le16(pdo + 16), 47);
        assert_int_equal(pdo[16 + 2], 0);
        assert_int_equal(pdo[16 + 5], 32);
    }
    pdo = ect_sii_category(image, sizeof image, ECT_SII_TXPDO, &length);
    for (size_t i = 0; i < 2; i++, pdo += 8 + 8 * 3) {
        assert_int_equal(ect_load_le16(pdo), ats[i]);
        assert_int_equal(ect_load_le16(pdo + 8), 135);
        assert_int_equal(ect_load_le16(pdo + 24), 40);
    }
}

/* Gaps of a telegram keep their lengths. */
static void gaps_in_the_eeprom(void **state)
{
#define PART(index, bits) "<Entry><Index>" index "</Index><BitLen>" bits "</BitLen><Name>V</Name></Entry>"
#define GAPS                                                                                                           \
    ESI_DEVICE(ESI_MAILBOX_SMS ESI_PROCESS_SMS                                                                         \
               "<RxPdo Sm='2'><Index>#x0018</Index><Name>MDT</Name>" PART("#x86", "16") PART("0", "1") PART("0", "7")  \
                   PART("#x8001", "16") PART("0", "256") PART("0", "255")                                              \
                       PART("#x8002", "32") "</RxPdo><Mailbox><SoE/></Mailbox>" ESI_EEPROM)
    static const uint32_t expected[] = {134u << 16 | 16, 1, 7, 0x8001u << 16 | 16, 255, 1, 255, 0x8002u << 16 | 32};
    (void)state;
    made_t m = make_text("gaps", GAPS);
    const ect_od_t od = od_of(&m);
    const ect_object_t *pdo = ect_od_find(&od, 0x1600);
    assert_non_null(pdo);
    assert_int_equal(pdo->entries[0].value, COUNT(expected));
    assert_int_equal(ect_sii_pdo_number(device_of(&m), 0x1600), 0x0018);
    for (uint32_t n = 1; n <= COUNT(expected); n++)
        assert_int_equal(ect_sii_pdo_element(device_of(&m), pdo, n), expected[n - 1]);
    free_made(&m);
}

/* The written file is a drive with the same parameters, but for those of the file that it names. */
static void written_file(void **state)
{
    char why[300] = "";
    size_t length;
    ect_arena_t arena = {0};
    (void)state;
    open_servo("SPEED", ECT_BEHAVIOUR_NONE);
    const ect_esi_part_t part = {.device = device(), .twin = twin};
    const char *text = ect_esi_write(&arena, &part, 1, &length, why, sizeof why);
    assert_non_null(text);
    ect_esi_t *again = ect_esi_parse("w.xml", text, length, why, sizeof why);
    assert_non_null(again);
    const ect_esi_device_t *model = ect_esi_select(again, "", why, sizeof why);
    assert_non_null(model);
    assert_int_equal(model->pdos[0].index, 0x0018);
    assert_int_equal(model->pdos[0].entries[1].index, 36);
    assert_int_equal(model->pdos[1].index, 0x0010);
    assert_int_equal(model->idns.object_count, 8);
    assert_int_equal(model->mailbox.soe_channels, 1);
    ect_esi_close(again);
    ect_arena_free(&arena);
}

int main(void)
{
    static const struct CMUnitTest tests[] = {
        {"SOE-045 SOE-011: values, limits, texts and lists of the file's dictionary", parameters_of_a_dictionary, NULL,
         close_drive, NULL},
        {"SOE-033 SOE-034 SOE-035 SOE-044: parameters that the dictionary lacks", made_parameters, NULL, close_drive,
         NULL},
        {"SOE-046: each start-up command of the file is accepted, and OP follows", start_up, NULL, close_drive, NULL},
        {"SOE-030: a command that the axis does not execute ends at once, without an error", other_command, NULL,
         close_drive, NULL},
        {"SOE-036 SOE-037: telegrams of two drives have the file's lengths", lengths, NULL, close_drive, NULL},
        {"SOE-037: each drive has its place in the telegrams", places, NULL, close_drive, NULL},
        {"SOE-036 SOE-034: other values in a telegram", other_lists, NULL, close_drive, NULL},
        {"SOE-039: the EEPROM has the file's numbers of PDOs and IDNs", numbers_in_the_eeprom, NULL, close_drive, NULL},
        {"SOE-039: the EEPROM has the gaps of a telegram", gaps_in_the_eeprom, NULL, NULL, NULL},
        {"SOE-039 SOE-045: a written file has the numbers and the dictionary", written_file, NULL, close_drive, NULL},
    };
    return cmocka_run_group_tests_name("twins of SoE drives", tests, NULL, NULL);
}
