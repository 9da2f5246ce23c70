/* SPDX-License-Identifier: MIT */
/* The bus of a network file: places in the tree, and twins from the file's data of each slave. */
#include "from_text.h"

#include "eni/bus.h"
#include "esi/twin.h"

enum { ROOM = 400 };

/* --- places ------------------------------------------------------------------------------------------------------- */

#define AT(address)         "<PhysAddr>" #address "</PhysAddr>"
#define PORT(port, address) "<PreviousPort><Port>" port "</Port><PhysAddr>" #address "</PhysAddr></PreviousPort>"
#define THREE(place)                                                                                                   \
    ENI_HEAD ENI_SLAVE(AT(1001), "") ENI_SLAVE(AT(1002), PORT("B", 1001)) "\n" ENI_SLAVE(AT(1003), place) ENI_TAIL

static void ENI_010_the_previous_port_is_the_place_in_the_tree(void **state)
{
    static const struct {
        const char *title, *text;
        size_t up;
        uint8_t port;
    } rows[] = {
        {"without one it is behind the slave before", THREE(""), 0, 0},
        {"port C of the first", THREE(PORT("C", 1001)), 0, 2},
        {"port D of the first", THREE(PORT("D", 1001)), 0, 3},
        {"port B of the second", THREE(PORT("B", 1002)), 1, 1},
        {"without an address it is a port of the slave before", THREE("<PreviousPort><Port>C</Port></PreviousPort>"), 1,
         2},
        {"the selected one of several",
         THREE(PORT("B", 1002) "<PreviousPort Selected='1'><Port>D</Port><PhysAddr>1001</PhysAddr></PreviousPort>"), 0,
         3},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char why[ROOM] = "";
        ect_eni_place_t place;
        ect_eni_t *eni = eni_of(rows[i].title, rows[i].text);
        if (!ect_eni_place(eni, 2, &place, why, sizeof why) || place.port != rows[i].port || place.up != rows[i].up)
            fail_msg("%s: expected %zu.%u, got %zu.%u %s", rows[i].title, rows[i].up, rows[i].port, place.up,
                     place.port, why);
        ect_eni_close(eni);
    }
}

static void ENI_010_an_impossible_place_is_refused_with_its_line(void **state)
{
    static const struct {
        const char *text, *why;
    } rows[] = {
        {THREE(PORT("B", 1003)), "t.xml:2: PreviousPort has the PhysAddr 1003, which no previous slave has"},
        {THREE(PORT("C", 7)), "t.xml:2: PreviousPort has the PhysAddr 7, which no previous slave has"},
        {THREE(PORT("A", 1001)), "t.xml:2: PreviousPort has Port A, which leads to the master"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char why[ROOM] = "";
        ect_eni_place_t place;
        ect_eni_t *eni = eni_of(rows[i].why, rows[i].text);
        assert_false(ect_eni_place(eni, 2, &place, why, sizeof why));
        assert_string_equal(why, rows[i].why);
        ect_eni_close(eni);
    }
}

static void the_first_slave_is_at_the_master_whatever_its_previous_port(void **state)
{
    char why[ROOM] = "";
    ect_eni_place_t place;
    (void)state;
    ect_eni_t *eni = eni_of("first", ENI_ONE("", PORT("D", 99)));
    assert_true(ect_eni_place(eni, 0, &place, why, sizeof why));
    assert_int_equal(place.port, 0);
    ect_eni_close(eni);
}

static void ENI_021_the_identification_is_the_alias(void **state)
{
    (void)state;
    ect_eni_t *eni = eni_of("alias", ENI_HEAD ENI_SLAVE("<Identification Value='17'><Ado>18</Ado></Identification>", "")
                                         ENI_SLAVE("", "") ENI_TAIL);
    assert_int_equal(ect_eni_alias(slave_of(eni, 0)), 17);
    assert_int_equal(ect_eni_alias(slave_of(eni, 1)), 0);
    ect_eni_close(eni);
}

/* --- twins -------------------------------------------------------------------------------------------------------- */

/* The ENI is closed before the twin is used: nothing of the model points into it. */
static ect_esi_twin_t *twin_of(const char *what, ect_eni_t *eni, size_t i)
{
    char why[ROOM] = "";
    ect_esi_t *esi = ect_eni_device(eni, i, why, sizeof why);
    ect_eni_close(eni);
    ect_esi_twin_t *twin = ect_esi_twin_take(esi, "", NULL, 0, why, sizeof why);
    if (twin == NULL)
        fail_msg("%s: expected a twin, got: %s", what, why);
    return twin;
}

static const ect_device_t *device_of(const ect_esi_twin_t *twin)
{
    return ect_esi_twin_product(twin)->device;
}

static ect_eni_t *machine(void)
{
    char why[ROOM] = "";
    ect_eni_t *eni = ect_eni_open(ENI_FILES "/machine.xml", why, sizeof why);
    if (eni == NULL)
        fail_msg("%s", why);
    return eni;
}

static void ENI_009_a_slave_alone_makes_a_twin_with_its_identity_and_layout(void **state)
{
    static const unsigned int roles[] = {ECT_SM_MAILBOX_OUT, ECT_SM_MAILBOX_IN, ECT_SM_OUTPUTS, ECT_SM_INPUTS};
    static const uint16_t starts[] = {0x1000, 0x1080, 0x1100, 0x1200};
    (void)state;
    ect_esi_twin_t *twin = twin_of("drive", machine(), 1);
    const ect_device_t *device = device_of(twin);
    assert_int_equal(device->identity.vendor_id, 0xE57);
    assert_int_equal(device->identity.product_code, 0x2A1);
    assert_int_equal(device->identity.revision, 3);
    assert_string_equal(device->type_name, "Drive 2 (AX1)");
    assert_string_equal(device->physics, "YY");
    assert_int_equal(device->sm_count, 4);
    for (size_t n = 0; n < 4; n++) {
        assert_int_equal(device->sm[n].type, roles[n]);
        assert_int_equal(device->sm[n].start, starts[n]);
    }
    assert_int_equal(device->sm[0].length, 128);
    assert_int_equal(ect_device_bytes(device, ECT_SM_OUTPUTS), 6);
    assert_int_equal(ect_device_bytes(device, ECT_SM_INPUTS), 6);
    assert_int_equal(device->mailbox_protocols, ECT_MAILBOX_COE);
    ect_esi_twin_free(twin);
}

static void ENI_015_objects_that_start_up_commands_write_exist_in_the_twin(void **state)
{
    (void)state;
    ect_esi_twin_t *twin = twin_of("drive", machine(), 1);
    const ect_od_t od = ect_device_od(device_of(twin), NULL);
    assert_non_null(ect_od_find(&od, 0x8000));
    assert_non_null(ect_od_find(&od, 0x1C12));
    assert_non_null(ect_od_find(&od, 0x6040));
    assert_null(ect_od_find(&od, 0x8001));
    ect_esi_twin_free(twin);
}

#define WRITE_SM(n, data)                                                                                              \
    "<InitCmd><Transition>PS</Transition><Cmd>5</Cmd><Adp>1001</Adp><Ado>" #n "</Ado><Data>" data "</Data></InitCmd>"

/* As exports have it that list no SyncManagers. */
static void ENI_013_sync_managers_follow_from_the_registers_that_the_master_writes(void **state)
{
    static const char text[] =
        ENI_ONE("", "<ProcessData><Send><BitStart>0</BitStart><BitLength>16</BitLength></Send></ProcessData>"
                    "<Mailbox><Send><Start>4096</Start><Length>64</Length></Send><Recv><Start>4160</Start><Length>64</"
                    "Length></Recv>"
                    "<Protocol>CoE</Protocol></Mailbox><InitCmds>" WRITE_SM(2064, "0011020064000100001303002000010000")
                        WRITE_SM(2080, "0014040020000000") "</InitCmds>");
    (void)state;
    ect_esi_twin_t *twin = twin_of("registers", eni_of("registers", text), 0);
    const ect_device_t *device = device_of(twin);
    assert_int_equal(device->sm_count, 4); /* SyncManager 4 is written and not enabled */
    assert_int_equal(device->sm[0].start, 0x1000);
    assert_int_equal(device->sm[1].length, 64);
    assert_int_equal(device->sm[2].start, 0x1100);
    assert_int_equal(ect_device_bytes(device, ECT_SM_OUTPUTS), 2); /* no PDO describes them: bytes */
    assert_int_equal(device->sm[3].start, 0x1300);
    assert_int_equal(ect_device_bytes(device, ECT_SM_INPUTS), 3);
    ect_esi_twin_free(twin);
}

static void ENI_013_registers_that_are_written_for_BOOT_are_not_those_of_the_twin(void **state)
{
    static const char text[] =
        ENI_ONE("", "<Mailbox><Protocol>CoE</Protocol></Mailbox><InitCmds><InitCmd><Transition>IB</Transition>"
                    "<Cmd>5</Cmd><Ado>2048</Ado><Data>00120001260001000013000122000100</Data></InitCmd>"
                    "<InitCmd><Transition>IP</Transition><Transition>IB</Transition><Cmd>5</Cmd><Ado>2048</Ado>"
                    "<Data>00104000260001004010400022000100</Data></InitCmd></InitCmds>");
    (void)state;
    ect_esi_twin_t *twin = twin_of("boot", eni_of("boot", text), 0);
    assert_int_equal(device_of(twin)->sm[0].start, 0x1000);
    assert_int_equal(device_of(twin)->sm[1].start, 0x1040);
    assert_int_equal(device_of(twin)->sm[1].length, 64);
    ect_esi_twin_free(twin);
}

static void ENI_011_every_port_of_Physics_is_one_of_the_twin(void **state)
{
    (void)state;
    ect_esi_twin_t *twin = twin_of("ports", eni_of("ports", ENI_ONE("<Physics>YBK</Physics>", "")), 0);
    assert_string_equal(device_of(twin)->physics, "YHK");
    ect_esi_twin_free(twin);
}

static void ENI_014_a_pdo_belongs_to_the_sync_manager_that_lists_it(void **state)
{
    static const char text[] = ENI_ONE(
        "", "<ProcessData><Sm0><Type>Outputs</Type><StartAddress>4096</StartAddress><ControlByte>100</ControlByte>"
            "<Pdo>#x1601</Pdo></Sm0>"
            "<RxPdo Fixed='1'><Index>#x1600</Index><Name>A</Name><Entry><Index>#x7000</Index><SubIndex>1</SubIndex>"
            "<BitLen>8</BitLen><Name>a</Name><DataType>USINT</DataType></Entry></RxPdo>"
            "<RxPdo Fixed='1'><Index>#x1601</Index><Name>B</Name><Entry><Index>#x7000</Index><SubIndex>2</SubIndex>"
            "<BitLen>16</BitLen><Name>b</Name><DataType>UINT</DataType></Entry></RxPdo></ProcessData>");
    (void)state;
    ect_esi_twin_t *twin = twin_of("lister", eni_of("lister", text), 0);
    assert_int_equal(ect_device_bytes(device_of(twin), ECT_SM_OUTPUTS), 2);
    ect_esi_twin_free(twin);
}

static void a_boot_mailbox_and_an_explicit_device_id_are_taken_over(void **state)
{
    static const char text[] =
        ENI_ONE("<Identification Value='5'><Ado>308</Ado></Identification>",
                "<Mailbox><Send><Start>4096</Start><Length>64</Length></Send><Recv><Start>4160</Start><Length>64</"
                "Length></Recv>"
                "<BootStrap><Send><Start>4608</Start><Length>256</Length></Send><Receive><Start>4864</Start>"
                "<Length>256</Length></Receive></BootStrap><Protocol>FoE</Protocol></Mailbox>");
    (void)state;
    ect_esi_twin_t *twin = twin_of("boot", eni_of("boot", text), 0);
    const ect_device_t *device = device_of(twin);
    assert_int_equal(device->boot_out.start, 0x1200);
    assert_int_equal(device->boot_in.length, 256);
    assert_int_equal(ect_device_general_flags(device) & ECT_GENERAL_ID_AL_STATUS, ECT_GENERAL_ID_AL_STATUS);
    ect_esi_twin_free(twin);
}

/* --- models ------------------------------------------------------------------------------------------------------- */

/* The model of the first slave; the ENI is closed. */
static const ect_esi_device_t *model_of(const char *what, const char *text, ect_esi_t **esi)
{
    char why[ROOM] = "";
    ect_eni_t *eni = eni_of(what, text);
    *esi = ect_eni_device(eni, 0, why, sizeof why);
    ect_eni_close(eni);
    const ect_esi_device_t *model = *esi != NULL ? ect_esi_select(*esi, "", why, sizeof why) : NULL;
    if (model == NULL)
        fail_msg("%s: expected a model, got: %s", what, why);
    return model;
}

static void ENI_014_a_pdo_of_a_sync_manager_that_the_slave_lacks_has_none(void **state)
{
#define SM_AND_PDO(sm)                                                                                                 \
    ENI_ONE("", "<ProcessData><Sm0><Type>Outputs</Type><StartAddress>4096</StartAddress><ControlByte>100"              \
                "</ControlByte></Sm0><Sm1><Type>Inputs</Type><StartAddress>4352</StartAddress><ControlByte>32"         \
                "</ControlByte></Sm1><RxPdo" sm "><Index>#x1600</Index><Name>A</Name></RxPdo></ProcessData>")
    static const struct {
        const char *what, *text;
        int sm;
    } rows[] = {
        {"none", SM_AND_PDO(""), -1},
        {"the first", SM_AND_PDO(" Sm='0'"), 0},
        {"the last", SM_AND_PDO(" Sm='1'"), 1},
        {"the one behind the last", SM_AND_PDO(" Sm='2'"), -1},
        {"a later one", SM_AND_PDO(" Sm='9'"), -1},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_esi_t *esi;
        const ect_esi_device_t *model = model_of(rows[i].what, rows[i].text, &esi);
        assert_int_equal(model->pdo_count, 1);
        if (model->pdos[0].sm != rows[i].sm)
            fail_msg("%s: expected SyncManager %d, got %d", rows[i].what, rows[i].sm, model->pdos[0].sm);
        ect_esi_close(esi);
    }
}

/* The line of the file is that of an error of the SyncManager. */
static void ENI_013_a_sync_manager_has_the_line_of_its_element_or_of_its_write(void **state)
{
    static const char listed[] = ENI_ONE(
        "", "<ProcessData>\n\n<Sm0><Type>Outputs</Type><StartAddress>4096</StartAddress><ControlByte>100</ControlByte>"
            "</Sm0></ProcessData>");
    static const char written[] = ENI_ONE("", "<InitCmds>\n\n\n" WRITE_SM(2048, "0010020064000100") "</InitCmds>");
    static const char box[] =
        ENI_ONE("", "<Mailbox>\n<Send><Start>4096</Start><Length>64</Length></Send><Recv><Start>4160</Start>"
                    "<Length>64</Length></Recv></Mailbox>");
    static const struct {
        const char *text;
        int line;
        uint16_t start;
        uint8_t control;
        size_t count;
    } rows[] = {{listed, 4, 4096, 100, 1}, {written, 5, 4096, 100, 1}, {box, 2, 4096, 0x26, 2}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_esi_t *esi;
        const ect_esi_device_t *model = model_of("lines", rows[i].text, &esi);
        assert_int_equal(model->sm_count, rows[i].count);
        assert_int_equal(model->line, 2);
        assert_int_equal(model->sms[0].line, rows[i].line);
        assert_int_equal(model->sms[0].start, rows[i].start);
        assert_true(rows[i].text != written || model->sms[0].size.given);
        assert_int_equal(model->sms[0].control, rows[i].control);
        ect_esi_close(esi);
    }
}

/* A file that has the mailboxes and start-up commands alone. */
static void ENI_013_sync_managers_of_assigned_pdos_lie_behind_the_mailboxes(void **state)
{
#define ASSIGN(attributes, index, sub, data)                                                                           \
    "<InitCmd" attributes "><Transition>PS</Transition><Index>" index "</Index><SubIndex>" sub "</SubIndex>" data      \
    "</InitCmd>"
#define BOXES_AND(send, send_length, receive, receive_length, commands)                                                \
    ENI_ONE("", "<Mailbox><Send><Start>" send "</Start><Length>" send_length "</Length></Send><Recv><Start>" receive   \
                "</Start><Length>" receive_length "</Length></Recv><CoE><InitCmds>" commands                           \
                "</InitCmds></CoE></Mailbox>")
#define ONE "<Data>0016</Data>"
    static const struct {
        const char *title, *text;
        size_t count;
        uint16_t start; /* of the last SyncManager */
        const char *type;
        uint8_t control;
    } rows[] = {
        {"SyncManager 2", BOXES_AND("4096", "128", "4224", "128", ASSIGN("", "#x1C12", "1", ONE)), 3, 0x1100, "Outputs",
         0x64},
        {"the mailboxes in the other order", BOXES_AND("4224", "128", "4096", "128", ASSIGN("", "#x1C12", "1", ONE)), 3,
         0x1100, "Outputs", 0x64},
        {"one byte more of the second", BOXES_AND("4096", "128", "4224", "129", ASSIGN("", "#x1C12", "1", ONE)), 3,
         0x1200, "Outputs", 0x64},
        {"one byte more of the first, behind the second",
         BOXES_AND("4224", "129", "4096", "128", ASSIGN("", "#x1C12", "1", ONE)), 3, 0x1200, "Outputs", 0x64},
        {"SyncManager 3", BOXES_AND("4096", "128", "4224", "128", ASSIGN("", "#x1C13", "1", "<Data>001a</Data>")), 4,
         0x1500, "Inputs", 0x20},
        {"the last PDO of outputs",
         BOXES_AND("4096", "128", "4224", "128", ASSIGN("", "#x1C12", "1", "<Data>ff19</Data>")), 3, 0x1100, "Outputs",
         0x64},
        {"complete access",
         BOXES_AND("4096", "128", "4224", "128", ASSIGN(" CompleteAccess='1'", "#x1C12", "0", "<Data>01000016</Data>")),
         3, 0x1100, "Outputs", 0x64},
        {"complete access from sub-index 1",
         BOXES_AND("4096", "128", "4224", "128", ASSIGN(" CompleteAccess='1'", "#x1C12", "1", ONE)), 3, 0x1100,
         "Outputs", 0x64},
        {"complete access to the count alone",
         BOXES_AND("4096", "128", "4224", "128", ASSIGN(" CompleteAccess='1'", "#x1C12", "0", "<Data>0000</Data>")), 2,
         0x1080, "MBoxIn", 0x22},
        {"the count", BOXES_AND("4096", "128", "4224", "128", ASSIGN("", "#x1C12", "0", ONE)), 2, 0x1080, "MBoxIn",
         0x22},
        {"one byte", BOXES_AND("4096", "128", "4224", "128", ASSIGN("", "#x1C12", "1", "<Data>16</Data>")), 2, 0x1080,
         "MBoxIn", 0x22},
        {"an upload", BOXES_AND("4096", "128", "4224", "128", ASSIGN("", "#x1C12", "1", "")), 2, 0x1080, "MBoxIn",
         0x22},
        {"SyncManager 15", BOXES_AND("4096", "128", "4224", "128", ASSIGN("", "#x1C1F", "1", ONE)), 16,
         0x1100 + 13 * 0x400, "Outputs", 0x64},
        {"no SyncManager of a twin", BOXES_AND("4096", "128", "4224", "128", ASSIGN("", "#x1C20", "1", ONE)), 2, 0x1080,
         "MBoxIn", 0x22},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_esi_t *esi;
        const ect_esi_device_t *model = model_of(rows[i].title, rows[i].text, &esi);
        const ect_esi_sm_t *sm = model->sm_count > 0 ? &model->sms[model->sm_count - 1] : NULL;
        if (sm == NULL || model->sm_count != rows[i].count || sm->start != rows[i].start ||
            strcmp(sm->type, rows[i].type) != 0 || sm->control != rows[i].control || sm->line != 2)
            fail_msg("%s: got %zu SyncManagers, the last at 0x%04X, %s, control 0x%02X, line %d", rows[i].title,
                     model->sm_count, sm != NULL ? sm->start : 0u, sm != NULL ? sm->type : "",
                     sm != NULL ? sm->control : 0u, sm != NULL ? sm->line : 0);
        ect_esi_close(esi);
    }
}

static void ENI_015_pdos_that_are_assigned_and_not_described_have_no_entries(void **state)
{
    static const struct {
        uint16_t index;
        const char *name;
        bool tx;
    } rows[] = {{0x1600, "PDO 1600", false},
                {0x17FF, "PDO 17FF", false},
                {0x1A00, "PDO 1A00", true},
                {0x1BFF, "PDO 1BFF", true}};
    ect_esi_t *esi;
    (void)state;
    const ect_esi_device_t *model =
        model_of("assigned",
                 BOXES_AND("4096", "128", "4224", "128",
                           ASSIGN(" CompleteAccess='1'", "#x1C12", "1", "<Data>0016ff170018ff15</Data>")
                               ASSIGN(" CompleteAccess='1'", "#x1C13", "1", "<Data>001aff1b001c001a</Data>")
                                   ASSIGN("", "#x1C0F", "1", "<Data>0116</Data>")
                                       ASSIGN("", "#x1C30", "1", "<Data>0216</Data>")),
                 &esi);
    assert_int_equal(model->pdo_count, sizeof rows / sizeof rows[0]);
    for (size_t i = 0; i < model->pdo_count; i++) {
        const ect_esi_pdo_t *pdo = &model->pdos[i];
        assert_int_equal(pdo->index, rows[i].index);
        assert_string_equal(pdo->name, rows[i].name);
        assert_int_equal(pdo->tx, rows[i].tx);
        assert_int_equal(pdo->sm, -1);
        assert_int_equal(pdo->samples, 1);
        assert_int_equal(pdo->entry_count, 0);
        assert_int_equal(pdo->line, 2);
    }
    assert_true(model->mailbox.pdo_assign && model->mailbox.complete_access && !model->mailbox.pdo_config);
    ect_esi_close(esi);
}

static void ENI_013_an_fmmu_for_each_direction_and_for_the_state_of_the_mailbox(void **state)
{
#define SENDS    "<Send><BitStart>0</BitStart><BitLength>8</BitLength></Send>"
#define RECEIVES "<Recv><BitStart>0</BitStart><BitLength>8</BitLength></Recv>"
#define HAS_BIT  "<Mailbox><Recv><StatusBitAddr>0</StatusBitAddr></Recv></Mailbox>"
    static const struct {
        const char *text, *fmmus[4];
    } rows[] = {
        {ENI_ONE("", ""), {NULL}},
        {ENI_ONE("", "<ProcessData>" SENDS "</ProcessData>"), {"Outputs"}},
        {ENI_ONE("", "<ProcessData>" RECEIVES "</ProcessData>"), {"Inputs"}},
        {ENI_ONE("", HAS_BIT), {"MBoxState"}},
        {ENI_ONE("", "<ProcessData>" SENDS RECEIVES "</ProcessData>" HAS_BIT), {"Outputs", "Inputs", "MBoxState"}},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_esi_t *esi;
        const ect_esi_device_t *model = model_of(rows[i].text, rows[i].text, &esi);
        size_t count = 0;
        for (; rows[i].fmmus[count] != NULL; count++) {
            assert_true(count < model->fmmu_count);
            assert_string_equal(model->fmmus[count], rows[i].fmmus[count]);
        }
        assert_int_equal(model->fmmu_count, count);
        ect_esi_close(esi);
    }
}

#define WRITE_DC(ado, data) ENI_ONE("", "<InitCmds>" WRITE_SM(ado, data) "</InitCmds>")

static void ENI_019_a_write_of_the_activation_makes_the_clock(void **state)
{
    static const struct {
        const char *title, *text;
        size_t count;
        uint16_t assign_activate;
    } rows[] = {
        {"cyclic unit and activation", WRITE_DC(2432, "0003"), 1, 0x0300},
        {"a write that begins before", WRITE_DC(2430, "05060007"), 1, 0x0700},
        {"the cyclic unit alone", WRITE_DC(2432, "01"), 0, 0},
        {"no activation", WRITE_DC(2432, "0100"), 0, 0},
        {"the activation alone", WRITE_DC(2433, "03"), 0, 0},
        {"nothing", ENI_ONE("", ""), 0, 0},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_esi_t *esi;
        const ect_esi_device_t *model = model_of(rows[i].title, rows[i].text, &esi);
        if (model->dc_count != rows[i].count ||
            (model->dc_count == 1 && model->dcs[0].assign_activate != rows[i].assign_activate))
            fail_msg("%s: expected %zu clocks, got %zu, 0x%04X", rows[i].title, rows[i].count, model->dc_count,
                     model->dc_count > 0 ? (unsigned int)model->dcs[0].assign_activate : 0u);
        ect_esi_close(esi);
    }
}

/* Commands by which a master finds a slave of a hot-connect group. */
static void ENI_021_IdentifyCmd_is_the_alias_of_a_slave_without_Identification(void **state)
{
#define IDENTIFY(cmd, ado, data)                                                                                       \
    "<IdentifyCmd><Cmd>" cmd "</Cmd><Adp>0</Adp><Ado>" ado "</Ado><DataLength>2</DataLength><Cnt>1</Cnt><Validate>"    \
    "<Data>" data "</Data><Timeout>100</Timeout></Validate></IdentifyCmd>"
#define HOT(commands) "<HotConnect><GroupName>G</GroupName><GroupMemberCnt>1</GroupMemberCnt>" commands "</HotConnect>"
    static const struct {
        const char *title, *text;
        unsigned int alias, ado;
    } rows[] = {
        {"the alias", ENI_ONE("", HOT(IDENTIFY("1", "18", "1700"))), 23, 0x0012},
        {"the identification in AL status code", ENI_ONE("", HOT(IDENTIFY("1", "308", "2a01"))), 298, 0x0134},
        {"one byte", ENI_ONE("", HOT(IDENTIFY("4", "18", "17"))), 23, 0x0012},
        {"the first of two", ENI_ONE("", HOT(IDENTIFY("1", "18", "0100") IDENTIFY("1", "308", "0200"))), 1, 0x0012},
        {"Identification comes first",
         ENI_ONE("<Identification Value='5'><Ado>18</Ado></Identification>", HOT(IDENTIFY("1", "18", "1700"))), 5,
         0x0012},
        {"a write is none", ENI_ONE("", HOT(IDENTIFY("2", "18", "1700"))), 0, 0},
        {"another register is none", ENI_ONE("", HOT(IDENTIFY("1", "304", "0100"))), 0, 0},
        {"no commands", ENI_ONE("", HOT("")), 0, 0},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_eni_t *eni = eni_of(rows[i].title, rows[i].text);
        const ect_eni_slave_t *slave = slave_of(eni, 0);
        if (ect_eni_alias(slave) != rows[i].alias || slave->identification_ado != rows[i].ado)
            fail_msg("%s: expected %u at %04X, got %u at %04X", rows[i].title, rows[i].alias, rows[i].ado,
                     ect_eni_alias(slave), slave->identification_ado);
        ect_eni_close(eni);
    }
}

static void ENI_021_the_identification_has_the_register_that_the_file_names(void **state)
{
    static const struct {
        const char *title, *text;
        bool in_al_status_code, given;
        unsigned int ado;
    } rows[] = {
        {"AL status code", ENI_ONE("<Identification Value='5'><Ado>308</Ado></Identification>", ""), true, false, 308},
        {"alias", ENI_ONE("<Identification Value='5'><Ado>18</Ado></Identification>", ""), false, false, 18},
        {"a register", ENI_ONE("<Identification Value='5'><Ado>4096</Ado></Identification>", ""), false, true, 4096},
        {"none", ENI_ONE("", ""), false, false, 0},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_esi_t *esi;
        const ect_esi_device_t *model = model_of(rows[i].title, rows[i].text, &esi);
        if (model->identification_134 != rows[i].in_al_status_code || model->identification_ado.given != rows[i].given)
            fail_msg("%s: expected 134h %d and another %d, got %d and %d", rows[i].title, rows[i].in_al_status_code,
                     rows[i].given, model->identification_134, model->identification_ado.given);
        assert_int_equal(model->identification_ado.value, rows[i].ado);
        ect_esi_close(esi);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ENI_010_the_previous_port_is_the_place_in_the_tree),
        cmocka_unit_test(ENI_010_an_impossible_place_is_refused_with_its_line),
        cmocka_unit_test(the_first_slave_is_at_the_master_whatever_its_previous_port),
        cmocka_unit_test(ENI_021_the_identification_is_the_alias),
        cmocka_unit_test(ENI_009_a_slave_alone_makes_a_twin_with_its_identity_and_layout),
        cmocka_unit_test(ENI_015_objects_that_start_up_commands_write_exist_in_the_twin),
        cmocka_unit_test(ENI_013_sync_managers_follow_from_the_registers_that_the_master_writes),
        cmocka_unit_test(ENI_013_registers_that_are_written_for_BOOT_are_not_those_of_the_twin),
        cmocka_unit_test(ENI_011_every_port_of_Physics_is_one_of_the_twin),
        cmocka_unit_test(ENI_014_a_pdo_belongs_to_the_sync_manager_that_lists_it),
        cmocka_unit_test(a_boot_mailbox_and_an_explicit_device_id_are_taken_over),
        cmocka_unit_test(ENI_014_a_pdo_of_a_sync_manager_that_the_slave_lacks_has_none),
        cmocka_unit_test(ENI_013_a_sync_manager_has_the_line_of_its_element_or_of_its_write),
        cmocka_unit_test(ENI_013_sync_managers_of_assigned_pdos_lie_behind_the_mailboxes),
        cmocka_unit_test(ENI_015_pdos_that_are_assigned_and_not_described_have_no_entries),
        cmocka_unit_test(ENI_013_an_fmmu_for_each_direction_and_for_the_state_of_the_mailbox),
        cmocka_unit_test(ENI_019_a_write_of_the_activation_makes_the_clock),
        cmocka_unit_test(ENI_021_IdentifyCmd_is_the_alias_of_a_slave_without_Identification),
        cmocka_unit_test(ENI_021_the_identification_has_the_register_that_the_file_names),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
