/* SPDX-License-Identifier: MIT */
/* Modules that change in a running twin (src/esi/change.c, src/esi/rack.c): by a user, and by a master through F030h.
 */
#include "rack.h"

#include "bus/chain/settings.h"

enum { OP = ECT_STATE_OP, INIT = ECT_STATE_INIT, NO_OBJECT = 0x06020000 };

static bool plug(rig_t *r, unsigned int slot, uint32_t ident)
{
    char name[32], value[16], message[ECT_SIGNAL_MESSAGE];
    (void)snprintf(name, sizeof name, "slot%u.module", slot);
    (void)snprintf(value, sizeof value, "0x%X", (unsigned int)ident);
    const ect_setting_t setting = {.name = name, .value = value};
    bool good = ect_settings_apply(r->wire.chain, 0, &setting, 1, r->wire.now_ns, message);
    wire_poll(&r->wire);
    return good;
}

static void set(rig_t *r, const char *name, const char *value)
{
    char message[ECT_SIGNAL_MESSAGE];
    const ect_setting_t setting = {.name = name, .value = value};
    if (!ect_settings_apply(r->wire.chain, 0, &setting, 1, r->wire.now_ns, message))
        fail_msg("%s=%s: %s", name, value, message);
    wire_poll(&r->wire);
}

static bool has_signal(rig_t *r, const char *name)
{
    ect_signal_ref_t ref;
    return ect_chain_signal(r->wire.chain, 0, name, &ref);
}

static uint32_t abort_of(rig_t *r, uint16_t index, uint8_t subindex)
{
    uint8_t bytes[64];
    size_t size = sizeof bytes;
    return wire_sdo_upload(&r->wire, 0, index, subindex, false, bytes, &size);
}

/* The AL state, with the error flag. */
static uint8_t al(rig_t *r, uint16_t *code)
{
    *code = wire_read16(&r->wire, 0, 0x0134);
    return wire_read8(&r->wire, 0, 0x0130);
}

static void expect_pdos(rig_t *r, const char *what, const uint16_t outputs[4], const uint16_t inputs[4])
{
    for (unsigned int sm = 2; sm <= 3; sm++) {
        const uint16_t *want = sm == 2 ? outputs : inputs;
        uint8_t count = 0;
        while (want[count] != 0)
            count++;
        if (read_number(r, (uint16_t)(0x1C10 + sm), 0) != count)
            fail_msg("%s: 1C1%Xh has %u PDOs, expected %u", what, sm,
                     (unsigned int)read_number(r, (uint16_t)(0x1C10 + sm), 0), count);
        for (uint8_t i = 0; i < count; i++)
            assert_int_equal(read_number(r, (uint16_t)(0x1C10 + sm), (uint8_t)(i + 1)) & 0xFFFF, want[i]);
    }
}

static void inserted(void **state)
{
    static const struct {
        unsigned int slot;
        uint32_t ident;
        uint16_t outputs[4], inputs[4];
    } rows[] = {
        {2, OUT, {0x1601}, {0x1A00}}, {3, IN, {0x1601}, {0x1A00, 0x1A02}}, {1, OUT, {0x1600, 0x1601}, {0x1A02}},
        {2, 0, {0x1600}, {0x1A02}},   {1, IN, {0}, {0x1A00, 0x1A02}},      {3, 0, {0}, {0x1A00}},
    };
    rig_t r;
    (void)state;
    open_rig(&r, RACK(DOWNLOAD, ""), PREOP);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char what[40];
        (void)snprintf(what, sizeof what, "slot %u: %X", rows[i].slot, (unsigned int)rows[i].ident);
        assert_true(plug(&r, rows[i].slot, rows[i].ident));
        assert_int_equal(read_number(&r, 0xF050, (uint8_t)rows[i].slot), rows[i].ident);
        expect_pdos(&r, what, rows[i].outputs, rows[i].inputs);
        const uint16_t input = (uint16_t)(0x6000 + 0x10 * (rows[i].slot - 1));
        const uint16_t output = (uint16_t)(0x7000 + 0x10 * (rows[i].slot - 1));
        assert_int_equal(abort_of(&r, input, 1), rows[i].ident == IN ? 0 : NO_OBJECT);
        assert_int_equal(abort_of(&r, output, 1), rows[i].ident == OUT ? 0 : NO_OBJECT);
        configure(&r);
        wire_go(&r.wire, 0, OP);
        wire_go(&r.wire, 0, PREOP);
    }
    close_rig(&r);
}

static void refused(void **state)
{
    rig_t r;
    (void)state;
    open_rig(&r, RACK(DOWNLOAD, ""), PREOP);
    assert_false(plug(&r, 2, OTHER));
    assert_false(plug(&r, 1, 0x999));
    assert_false(has_signal(&r, "slot4.module"));
    assert_int_equal(read_number(&r, 0xF050, 1), IN);
    close_rig(&r);
}

static void by_the_master(void **state)
{
    rig_t r;
    uint16_t code;
    (void)state;
    open_rig(&r, RACK(DOWNLOAD, ""), PREOP);
    assert_int_equal(write_number(&r, 1, OUT, 4), 0);
    assert_int_equal(write_number(&r, 2, IN, 4), 0);
    expect_pdos(&r, "F030h", (const uint16_t[4]){0x1600}, (const uint16_t[4]){0x1A01});
    assert_int_equal(abort_of(&r, 0x6010, 1), 0);
    assert_int_equal(abort_of(&r, 0x6000, 1), NO_OBJECT);
    assert_int_equal(read_number(&r, 0xF050, 1), IN);
    configure(&r);
    assert_int_equal(wire_al(&r.wire, 0, SAFEOP, &code), PREOP | 0x10);
    assert_int_equal(code, 0x0070);
    assert_int_equal(wire_al(&r.wire, 0, PREOP | 0x10, &code), PREOP);
    assert_true(plug(&r, 1, OUT) && plug(&r, 2, IN)); /* the modules that the master expects */
    wire_go(&r.wire, 0, OP);
    close_rig(&r);
}

/* A master that requests SAFEOP at once, with the SyncManagers of its own configuration. */
static void without_another_request(void **state)
{
    rig_t r;
    (void)state;
    open_rig(&r, RACK(DOWNLOAD, ""), PREOP);
    assert_true(plug(&r, 2, OUT));
    configure(&r);
    assert_int_equal(write_number(&r, 1, IN, 4), 0);
    assert_int_equal(write_number(&r, 2, OUT, 4), 0);
    wire_go(&r.wire, 0, OP);
    close_rig(&r);
}

/* Pulls the module of slot 1 in a state, with a reaction of `modules.on_change`, and checks the AL status. */
static void pull_in(rig_t *r, uint8_t state, const char *reaction, uint8_t want_al, uint16_t want_code)
{
    uint16_t code;
    open_rig(r, RACK(DOWNLOAD, ""), PREOP);
    configure(r);
    wire_go(&r->wire, 0, state);
    set(r, "modules.on_change", reaction);
    assert_true(plug(r, 1, 0));
    wire_advance(&r->wire, 10000000);
    const uint8_t status = al(r, &code);
    if (status != want_al || code != want_code)
        fail_msg("on_change=%s: AL status %02X, code %04X", reaction, status, code);
}

static void pulled_in_op(void **state)
{
    static const struct {
        const char *reaction;
        uint8_t al;
        uint16_t code;
    } rows[] = {{"0", PREOP | 0x10, 0x0070}, {"1", SAFEOP | 0x10, 0x0070}, {"2", OP, 0}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        rig_t r;
        uint16_t code;
        pull_in(&r, OP, rows[i].reaction, rows[i].al, rows[i].code);
        assert_int_equal(read_number(&r, 0xF050, 1), 0);
        assert_int_equal(abort_of(&r, 0x6000, 1), i == 0 ? NO_OBJECT : 0); /* the mapping of SAFEOP and OP stays */
        assert_int_equal(wire_al(&r.wire, 0, PREOP | 0x10, &code), PREOP);
        assert_false(has_signal(&r, "p.a"));
        assert_int_equal(abort_of(&r, 0x6000, 1), NO_OBJECT);
        close_rig(&r);
    }
}

/* In SAFEOP only a fall to PREOP leaves the state. */
static void pulled_in_safeop(void **state)
{
    static const struct {
        const char *reaction;
        uint8_t al;
        uint16_t code;
    } rows[] = {{"0", PREOP | 0x10, 0x0070}, {"1", SAFEOP, 0}, {"2", SAFEOP, 0}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        rig_t r;
        pull_in(&r, SAFEOP, rows[i].reaction, rows[i].al, rows[i].code);
        assert_int_equal(abort_of(&r, 0x6000, 1), i == 0 ? NO_OBJECT : 0);
        close_rig(&r);
    }
}

/* The slots beyond the count of F030h keep the modules that are in them. */
static void shorter_list(void **state)
{
    rig_t r;
    (void)state;
    open_rig(&r, RACK(DOWNLOAD, ""), PREOP);
    assert_true(plug(&r, 3, OUT));
    assert_int_equal(write_number(&r, 0, 0, 1), 0);
    assert_int_equal(write_number(&r, 1, OUT, 4), 0);
    assert_int_equal(write_number(&r, 2, IN, 4), 0);
    assert_int_equal(write_number(&r, 0, 2, 1), 0);
    expect_pdos(&r, "two of three", (const uint16_t[4]){0x1600, 0x1602}, (const uint16_t[4]){0x1A01});
    assert_int_equal(write_number(&r, 0, 1, 1), 0);
    expect_pdos(&r, "one of three", (const uint16_t[4]){0x1600, 0x1602}, (const uint16_t[4]){0});
    assert_int_equal(write_number(&r, 0, 3, 1), 0);
    expect_pdos(&r, "all three", (const uint16_t[4]){0x1600}, (const uint16_t[4]){0x1A01});
    assert_int_equal(write_number(&r, 0, 0, 1), 0);
    expect_pdos(&r, "none", (const uint16_t[4]){0x1602}, (const uint16_t[4]){0x1A00});
    assert_int_equal(write_number(&r, 1, 0, 4), 0);
    assert_int_equal(write_number(&r, 0, 1, 1), 0);
    expect_pdos(&r, "an empty one of three", (const uint16_t[4]){0x1602}, (const uint16_t[4]){0x1A00});
    close_rig(&r);
}

/* One ident is a configuration, also of the last slot. */
static void last_element(void **state)
{
    rig_t r;
    (void)state;
    open_rig(&r, RACK(DOWNLOAD, ""), PREOP);
    assert_int_equal(write_number(&r, 3, OUT, 4), 0);
    expect_pdos(&r, "the last slot", (const uint16_t[4]){0x1602}, (const uint16_t[4]){0});
    close_rig(&r);
}

static void same_module(void **state)
{
    rig_t r;
    uint16_t code;
    (void)state;
    open_rig(&r, RACK(DOWNLOAD, ""), PREOP);
    configure(&r);
    wire_go(&r.wire, 0, OP);
    assert_true(plug(&r, 1, IN));
    wire_advance(&r.wire, 10000000);
    assert_int_equal(al(&r, &code), OP);
    close_rig(&r);
}

static void values(void **state)
{
    rig_t r;
    (void)state;
    open_rig(&r, RACK(DOWNLOAD, ""), PREOP);
    assert_true(plug(&r, 2, IN));
    set(&r, "p_2.a", "7");
    set(&r, "p.a", "5");
    assert_true(plug(&r, 3, IN));
    assert_int_equal(read_number(&r, 0x6000, 1), 5);
    assert_int_equal(read_number(&r, 0x6010, 1), 7);
    assert_true(plug(&r, 2, OUT));
    assert_true(plug(&r, 2, IN)); /* another one of that kind: with its default */
    assert_int_equal(read_number(&r, 0x6000, 1), 5);
    assert_int_equal(read_number(&r, 0x6010, 1), 0);
    close_rig(&r);
}

/* A reference that a client keeps never reaches the value of another module. */
static void references(void **state)
{
    rig_t r;
    ect_signal_ref_t ref;
    char message[ECT_SIGNAL_MESSAGE];
    (void)state;
    open_rig(&r, RACK(DOWNLOAD, ""), PREOP);
    assert_true(ect_chain_signal(r.wire.chain, 0, "p.a", &ref));
    assert_true(plug(&r, 1, OUT));
    assert_true(ect_signal_write(&ref, "99", r.wire.now_ns, message));
    assert_int_equal(read_number(&r, 0x7000, 1), 0);
    close_rig(&r);
}

static void power_cycle(void **state)
{
    rig_t r;
    (void)state;
    open_rig(&r, RACK(DOWNLOAD, ""), PREOP);
    assert_false(has_signal(&r, "p_2.a"));
    assert_true(plug(&r, 2, OUT));
    assert_int_equal(write_number(&r, 1, OUT, 4), 0);
    ect_chain_power_cycle(r.wire.chain, r.wire.now_ns);
    wire_poll(&r.wire);
    assert_true(has_signal(&r, "p_2.a")); /* of the second slot */
    wire_assign_stations(&r.wire);
    wire_configure_mailbox(&r.wire, 0);
    wire_go(&r.wire, 0, PREOP);
    assert_int_equal(read_number(&r, 0xF030, 1), 0);
    assert_int_equal(read_number(&r, 0xF050, 2), OUT);
    expect_pdos(&r, "after a power cycle", (const uint16_t[4]){0x1601}, (const uint16_t[4]){0x1A00});
    close_rig(&r);
}

static void strict(void **state)
{
    static const struct {
        uint8_t subindex;
        uint32_t ident, tolerant, strict;
    } rows[] = {{1, IN, 0, 0}, {1, OUT, 0, 0x06090033},           {2, OUT, 0, 0x06090033}, {3, OUT, 0, 0x06090033},
                {1, 0, 0, 0},  {1, OTHER, 0x06090030, 0x06090030}};
    (void)state;
    for (unsigned int on = 0; on < 2; on++) {
        rig_t r;
        open_rig(&r, RACK(DOWNLOAD, ""), PREOP);
        set(&r, "modules.strict", on != 0 ? "1" : "0");
        for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
            const uint32_t code = write_number(&r, rows[i].subindex, rows[i].ident, 4);
            if (code != (on != 0 ? rows[i].strict : rows[i].tolerant))
                fail_msg("strict %u, row %zu: abort code %08X", on, i, (unsigned int)code);
        }
        close_rig(&r);
    }
}

/* One request of a master; index 0: the AL state in `value`. */
typedef struct step {
    uint16_t index;
    uint8_t subindex, size;
    uint32_t value;
} step_t;

#define COUNT(index, count)   {index, 0, 1, count}
#define IDENT(slot, ident)    {0xF030, slot, 4, ident}
#define ASSIGN(index, n, pdo) {index, n, 2, pdo}
#define ENTER(state)          {.value = (state)}
#define READ(index, n)        {index, n, 0, 0}
#define ASSIGNED                                                                                                       \
    COUNT(0x1C12, 0), COUNT(0x1C13, 0), ASSIGN(0x1C12, 1, 0x1601), ASSIGN(0x1C13, 1, 0x1A00),                          \
        ASSIGN(0x1C13, 2, 0x1A03), COUNT(0x1C12, 1), COUNT(0x1C13, 2)
#define IDENTS IDENT(1, IN), IDENT(2, OUT), IDENT(3, 0), IDENT(4, IN)

/* The order of requests of masters for modular devices: linuxcnc-ethercat over the IgH master, which configures a slave
 * again from INIT; its driver for couplers that copies the detected modules; the IgH tool, used manually; commands of a
 * network file. The modules are IN, OUT, none, IN. */
static const struct {
    const char *master;
    step_t steps[28];
} sequences[] = {
    {"idents, count, the state machine from INIT, assignments",
     {IDENTS, COUNT(0xF030, 4), ENTER(INIT), ENTER(PREOP), IDENTS, COUNT(0xF030, 4), ASSIGNED, ENTER(SAFEOP),
      ENTER(OP)}},
    {"the detected idents are read and copied, assignments",
     {READ(0xF050, 0), READ(0xF050, 1), READ(0xF050, 2), READ(0xF050, 3), READ(0xF050, 4), IDENTS, ASSIGNED,
      ENTER(SAFEOP), ENTER(OP)}},
    {"assignments before the idents, which replace them",
     {COUNT(0x1C12, 0), COUNT(0x1C13, 0), ASSIGN(0x1C13, 1, 0x1A03), COUNT(0x1C13, 1), COUNT(0xF030, 0), IDENTS,
      COUNT(0xF030, 4), ENTER(SAFEOP), ENTER(OP)}},
    {"count 0, idents, count, no assignments", {COUNT(0xF030, 0), IDENTS, COUNT(0xF030, 4), ENTER(SAFEOP), ENTER(OP)}},
    {"no idents at all, the present mapping", {READ(0x1C12, 0), READ(0x1C13, 0), ENTER(SAFEOP), ENTER(OP)}},
};

static void play_step(rig_t *r, const char *master, size_t n, const step_t *step)
{
    uint8_t bytes[4];
    ect_store_le32(bytes, step->value);
    if (step->index == 0 && step->value == SAFEOP)
        configure(r);
    if (step->index == 0)
        wire_go(&r->wire, 0, (uint8_t)step->value);
    else if (step->size == 0)
        (void)read_number(r, step->index, step->subindex);
    else {
        const uint32_t code = wire_sdo_download(&r->wire, 0, step->index, step->subindex, false, bytes, step->size);
        if (code != 0)
            fail_msg("%s: step %zu, %04X:%u: abort code %08X", master, n, step->index, step->subindex,
                     (unsigned int)code);
    }
}

static void masters(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof sequences / sizeof sequences[0]; i++) {
        const step_t *steps = sequences[i].steps;
        rig_t r;
        open_rig(&r, MANY_SLOTS, PREOP);
        assert_true(plug(&r, 2, OUT) && plug(&r, 3, 0));
        for (size_t n = 0; steps[n].index != 0 || steps[n].value != 0; n++)
            play_step(&r, sequences[i].master, n, &steps[n]);
        expect_pdos(&r, sequences[i].master, (const uint16_t[4]){0x1601}, (const uint16_t[4]){0x1A00, 0x1A03});
        assert_int_equal(wire_read8(&r.wire, 0, 0x0130), OP);
        close_rig(&r);
    }
}

/* More sets of modules than a device has: the last one stays, and the device does not leave PREOP with it. */
static void too_many(void **state)
{
    static const uint32_t kinds[] = {0, IN, OUT};
    rig_t r;
    uint16_t code;
    (void)state;
    open_rig(&r, MANY_SLOTS, PREOP);
    for (unsigned int i = 0; i < 81; i++) {
        unsigned int rest = i;
        for (unsigned int slot = 1; slot <= 4; slot++, rest /= 3)
            assert_true(plug(&r, slot, kinds[rest % 3]));
    }
    configure(&r);
    assert_int_equal(wire_al(&r.wire, 0, SAFEOP, &code), PREOP | 0x10);
    assert_int_equal(code, 0x0070);
    assert_int_equal(wire_al(&r.wire, 0, PREOP | 0x10, &code), PREOP);
    for (unsigned int slot = 1; slot <= 4; slot++)
        assert_true(plug(&r, slot, IN)); /* the first set */
    configure(&r);
    wire_go(&r.wire, 0, OP);
    close_rig(&r);
}

/* A rack whose parts vary. */
#define PARTS(objects, pdos, protocols, most, modules)                                                                 \
    ESI_HEAD "\n<Device Physics='YY'><Type ProductCode='#x1' RevisionNo='#x2'>RACK</Type><Name>A rack</Name>"          \
             "<Profile><ProfileNo>5001</ProfileNo>" objects "</Profile><Fmmu>Outputs</Fmmu><Fmmu>Inputs</"             \
             "Fmmu>" ESI_MAILBOX_SMS ESI_PROCESS_SMS pdos "<Mailbox>" protocols "</Mailbox>"                           \
             "<Slots MaxSlotCount='" most "' SlotPdoIncrement='1' SlotIndexIncrement='#x10' " DOWNLOAD ">"             \
             "<Slot MinInstances='0' MaxInstances='" most "'><Name>Slots</Name><ModuleClass><Class>IO</Class>"         \
             "</ModuleClass></Slot></Slots>" ESI_EEPROM "</Device></Devices><Modules>" modules                         \
             "</Modules></Descriptions></EtherCATInfo>"
#define OBJECTS(objects)                                                                                               \
    "<Dictionary><DataTypes><DataType><Name>UINT</Name><BitSize>16</BitSize></DataType>"                               \
    "<DataType><Name>STRING(12)</Name><BitSize>96</BitSize></DataType>"                                                \
    "<DataType><Name>STRING(7000)</Name><BitSize>56000</BitSize></DataType></DataTypes><Objects>" objects              \
    "</Objects></Dictionary>"
#define OBJECT(index, type, bits, rest)                                                                                \
    "<Object><Index>#x" index "</Index><Name>N</Name><Type>" type "</Type><BitSize>" bits "</BitSize>" rest "</"       \
    "Object>"
#define WORD(index)  OBJECT(index, "UINT", "16", "")
#define LARGE(index) OBJECT(index, "STRING(7000)", "56000", "")
#define LARGE_ONES   OBJECTS(LARGE("2000") LARGE("2001") LARGE("2002") LARGE("2003") LARGE("2004"))
#define PDO_WITH(index)                                                                                                \
    "<RxPdo Fixed='1' Sm='2'><Index>#x1680</Index><Name>P</Name><Entry><Index>#x" index                                \
    "</Index><SubIndex>0</SubIndex><BitLen>16</BitLen><Name>A</Name><DataType>UINT</DataType></Entry></RxPdo>"
#define MODULE_WITH(ident, objects)                                                                                    \
    "<Module><Type ModuleIdent='" ident "' ModuleClass='IO'>M</Type><Name>M</Name><Profile>" objects                   \
    "</Profile></Module>"

/* Modules of drives do not change, nor do those of a device without CoE, with EoE, or that needs too much memory. */
static void racks(void **state)
{
    static const struct {
        const char *what, *text;
        bool changes;
    } rows[] = {
        {"inputs", PARTS("", "", "<CoE/>", "4", MODULE("#x110", "IO", TX_PDO)), true},
        {"a PDO with 603Fh", PARTS("", PDO_WITH("603F"), "<CoE/>", "4", MODULE("#x110", "IO", TX_PDO)), true},
        {"a PDO with A040h", PARTS("", PDO_WITH("A040"), "<CoE/>", "4", MODULE("#x110", "IO", TX_PDO)), true},
        {"a PDO with 6040h", PARTS("", PDO_WITH("6040"), "<CoE/>", "4", MODULE("#x110", "IO", TX_PDO)), false},
        {"a PDO with 9840h", PARTS("", PDO_WITH("9840"), "<CoE/>", "4", MODULE("#x110", "IO", TX_PDO)), false},
        {"an object 2040h", PARTS(OBJECTS(WORD("2040")), "", "<CoE/>", "4", MODULE("#x110", "IO", TX_PDO)), true},
        {"an object 6840h", PARTS(OBJECTS(WORD("6840")), "", "<CoE/>", "4", MODULE("#x110", "IO", TX_PDO)), false},
        {"a module's PDO with 6040h", PARTS("", "", "<CoE/>", "4", MODULE("#x110", "IO", PDO_WITH("6040"))), false},
        {"a module's object 6040h", PARTS("", "", "<CoE/>", "4", MODULE_WITH("#x110", OBJECTS(WORD("6040")))), false},
        {"a drive after inputs",
         PARTS("", "", "<CoE/>", "4", MODULE("#x110", "IO", TX_PDO) MODULE("#x120", "IO", PDO_WITH("6040"))), false},
        {"a drive before inputs",
         PARTS("", "", "<CoE/>", "4", MODULE("#x120", "IO", PDO_WITH("6040")) MODULE("#x110", "IO", TX_PDO)), false},
        {"no CoE", PARTS("", "", "<FoE/>", "4", MODULE("#x110", "IO", TX_PDO)), false},
        {"EoE", PARTS("", "", "<CoE/><EoE/>", "4", MODULE("#x110", "IO", TX_PDO)), false},
        {"SoE beside CoE", PARTS("", "", "<CoE/><SoE/>", "4", MODULE("#x110", "IO", TX_PDO)), true},
        {"255 slots", PARTS("", "", "<CoE/>", "255", MODULE("#x110", "IO", TX_PDO)), true},
        {"256 slots", PARTS("", "", "<CoE/>", "256", MODULE("#x110", "IO", TX_PDO)), false},
        {"35 kB in each of 4 slots", PARTS("", "", "<CoE/>", "4", MODULE_WITH("#x110", LARGE_ONES)), true},
        {"35 kB in each of 255 slots",
         PARTS("", "", "<CoE/>", "255", MODULE_WITH("#x110", LARGE_ONES) MODULE("#x120", "IO", TX_PDO)), false},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        made_t m = make_text(rows[i].what, rows[i].text);
        const ect_plant_t *plant = ect_esi_twin_product(m.twin)->plant;
        bool changes = false;
        for (size_t k = 0; k < plant->signal_group_count; k++)
            changes |= strcmp(plant->signal_groups[k].prefix, "slot") == 0;
        if (changes != rows[i].changes)
            fail_msg("%s: expected modules that %s", rows[i].what, rows[i].changes ? "change" : "do not change");
        free_made(&m);
    }
}

#define MODULE_OF(ident, class, objects)                                                                               \
    "<Module><Type ModuleIdent='" ident "' ModuleClass='" class "'>M</Type><Name>M</Name><Profile>" objects            \
                                                                "</Profile></Module>"

/* The twin has memory for each module that a slot takes, in each of these slots: the value of each entry with 9 bytes
 * for its place, and 10 bytes for its object; the objects of 1C12h and 1C13h with their counts, too. */
static void memory(void **state)
{
    static const struct {
        const char *what, *text;
        size_t bytes; /* of a slot */
        uint16_t runs, value;
    } rows[] = {
#define RACK_WITH(modules) PARTS("", "", "<CoE/>", "8", modules)
        {"no module", RACK_WITH(""), 0, 1024, 0},
        {"a word", RACK_WITH(MODULE_OF("#x110", "IO", OBJECTS(WORD("2000")))), 40 + 10 + 2 + 9, 1024, 2},
        {"a byte", RACK_WITH(MODULE_OF("#x110", "IO", OBJECTS(OBJECT("2000", "USINT", "8", "")))), 40 + 10 + 1 + 9,
         1024, 1},
        {"a bit", RACK_WITH(MODULE_OF("#x110", "IO", OBJECTS(OBJECT("2000", "BOOL", "1", "")))), 40 + 10 + 1 + 9, 1024,
         1},
        {"two words", RACK_WITH(MODULE_OF("#x110", "IO", OBJECTS(WORD("2000") WORD("2001")))), 40 + 42, 1024, 2},
        {"7000 bytes", RACK_WITH(MODULE_OF("#x110", "IO", OBJECTS(LARGE("2000")))), 40 + 10 + 7000 + 9, 1024, 7000},
        {"7000 bytes and a word", RACK_WITH(MODULE_OF("#x110", "IO", OBJECTS(LARGE("2000") WORD("2001")))), 40 + 7040,
         1024, 7000},
        /* 1A00h with its count and its element, 6000h:1, an element of 1C13h */
        {"a PDO", RACK_WITH(MODULE("#x110", "IO", TX_PDO)), 40 + (10 + 10 + 13) + (10 + 11) + 11, 1024 + 8, 4},
        {"a word, and a word of another module",
         RACK_WITH(MODULE_OF("#x110", "IO", OBJECTS(WORD("2000"))) MODULE_OF("#x120", "IO", OBJECTS(WORD("2000")))),
         2 * (40 + 21), 1024, 2},
        {"a word, and a word that no slot takes",
         RACK_WITH(MODULE_OF("#x110", "IO", OBJECTS(WORD("2000"))) MODULE_OF("#x120", "AX", OBJECTS(WORD("2000")))),
         40 + 21, 1024, 2},
    };
    size_t least = 0;
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        made_t m = make_text(rows[i].what, rows[i].text);
        const ect_device_t *device = device_of(&m);
        least = i == 0 ? device->instance_size : least;
        if (device->instance_size != least + 8 * rows[i].bytes || device->growth.runs != rows[i].runs ||
            device->growth.value != rows[i].value)
            fail_msg("%s: expected %zu bytes in each slot, %u runs and %u bytes, got %zu bytes in 8, %u and %u",
                     rows[i].what, rows[i].bytes, rows[i].runs, rows[i].value, device->instance_size - least,
                     device->growth.runs, device->growth.value);
        assert_int_equal(device->growth.image, 1486);
        free_made(&m);
    }
}

/* Modules change where all of them need at most 8 MiB, 4096 bytes for assignments included: 149 texts of 7000 bytes and
 * a last one in each of 8 slots. */
static void largest(void **state)
{
    enum { TEXTS = 149, ROOM = 40000 };
    static const struct {
        unsigned int last;
        const char *other; /* a second module */
        bool changes;
    } rows[] = {{2174, "", true}, {2175, "", false}, {2174, MODULE("#x120", "IO", TX_PDO), false}};
    char *objects = malloc(ROOM), *text = malloc(ROOM);
    (void)state;
    assert_true(objects != NULL && text != NULL);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        size_t length = 0;
        for (unsigned int n = 0; n < TEXTS; n++)
            length += (size_t)snprintf(objects + length, ROOM - length, LARGE("%X"), 0x2000 + n);
        (void)snprintf(objects + length, ROOM - length, OBJECT("3000", "STRING(%u)", "%u", ""), rows[i].last,
                       8 * rows[i].last);
        (void)snprintf(text, ROOM, RACK_WITH(MODULE_OF("#x110", "IO", OBJECTS("%s")) "%s"), objects, rows[i].other);
        made_t m = make_text("large modules", text);
        if ((device_of(&m)->growth.image != 0) != rows[i].changes)
            fail_msg("%u bytes: expected modules that %s", rows[i].last, rows[i].changes ? "change" : "do not change");
        free_made(&m);
    }
    free(objects);
    free(text);
}

/* A list has at most 255 elements. */
static void lists_of_many_slots(void **state)
{
    static const struct {
        const char *text;
        uint8_t elements;
    } rows[] = {
        {PARTS("", "", "<CoE/>", "254", MODULE("#x110", "IO", TX_PDO)), 254},
        {PARTS("", "", "<CoE/>", "255", MODULE("#x110", "IO", TX_PDO)), 255},
        {PARTS("", "", "<CoE/>", "256", MODULE("#x110", "IO", TX_PDO)), 255},
    };
    static const uint16_t indices[] = {0xF010, 0xF030, 0xF050};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        made_t m = make_text("many slots", rows[i].text);
        const ect_od_t od = od_of(&m);
        for (size_t k = 0; k < sizeof indices / sizeof indices[0]; k++) {
            const ect_object_t *list = ect_od_find(&od, indices[k]);
            if (list == NULL || ect_od_element(list, 0) != rows[i].elements || list->max_subindex != rows[i].elements)
                fail_msg("%04X: expected %u elements, got %u", indices[k], rows[i].elements,
                         list != NULL ? list->max_subindex : 0);
        }
        assert_int_equal(ect_od_element(ect_od_find(&od, 0xF000), 2), rows[i].elements);
        free_made(&m);
    }
}

/* The last slot of as many as a list can have. */
static void last_of_many_slots(void **state)
{
    static const char text[] = PARTS("", "", "<CoE/>", "255", MODULE("#x110", "IO", TX_PDO));
    rig_t r;
    (void)state;
    open_rig(&r, text, PREOP);
    assert_int_equal(read_number(&r, 0xF050, 0), 255);
    assert_int_equal(read_number(&r, 0xF050, 255), 0);
    assert_true(plug(&r, 255, IN));
    assert_int_equal(read_number(&r, 0xF050, 0), 255);
    assert_int_equal(read_number(&r, 0xF050, 255), IN);
    assert_int_equal(abort_of(&r, 0x6000 + 0x10 * 254, 1), 0);
    assert_int_equal(write_number(&r, 255, IN, 4), 0);
    assert_int_equal(abort_of(&r, 0x6000 + 0x10 * 254, 1), 0);
    close_rig(&r);
}

static void expect_text(rig_t *r, uint16_t index, const char *expected, size_t length)
{
    char text[32] = "";
    size_t size = sizeof text;
    assert_int_equal(wire_sdo_upload(&r->wire, 0, index, 0, false, text, &size), 0);
    assert_int_equal(size, length);
    assert_memory_equal(text, expected, length);
}

/* Values of the device that do not belong to a module are kept over a change: constants by their defaults, others
 * unchanged. */
static void values_of_the_device(void **state)
{
    static const char text[] =
        PARTS(OBJECTS(OBJECT("2000", "STRING(12)", "96", "<Info><DefaultString>abcdefghijkl</DefaultString></Info>")
                          OBJECT("2001", "STRING(12)", "96", "")
                              OBJECT("2003", "STRING(12)", "96", "<Info><DefaultString>a</DefaultString></Info>")
                                  OBJECT("2002", "UINT", "16", "<Flags><Access>rw</Access></Flags>")),
              "", "<CoE/>", "4", MODULE("#x110", "IO", TX_PDO));
    const uint8_t seven[2] = {7, 0};
    rig_t r;
    (void)state;
    open_rig(&r, text, PREOP);
    set(&r, "modules.strict", "1"); /* strict about F030h:01 and on alone */
    assert_int_equal(wire_sdo_download(&r.wire, 0, 0x2002, 0, false, seven, sizeof seven), 0);
    assert_int_equal(write_number(&r, 0, 4, 1), 0);
    assert_int_equal(write_number(&r, 1, IN, 4), 0x06090033);
    assert_true(plug(&r, 2, IN));
    assert_int_equal(abort_of(&r, 0x6010, 1), 0);
    expect_text(&r, 0x2000, "abcdefghijkl", 12);
    expect_text(&r, 0x2001, "", 0);
    expect_text(&r, 0x2003, "a", 1);
    assert_int_equal(read_number(&r, 0x2002, 0), 7);
    close_rig(&r);
}

/* A master that has changed a mapping gets the original one again, with the modules. */
static void mappings(void **state)
{
    static const char text[] =
        PARTS("",
              "<RxPdo Sm='2'><Index>#x1680</Index><Name>P</Name><Entry><Index>#x2002</Index><SubIndex>0</SubIndex>"
              "<BitLen>16</BitLen><Name>A</Name><DataType>UINT</DataType></Entry></RxPdo>"
              "<TxPdo Sm='3'><Index>#x1A80</Index><Name>P</Name><Entry><Index>#x2003</Index><SubIndex>0</SubIndex>"
              "<BitLen>16</BitLen><Name>A</Name><DataType>UINT</DataType></Entry></TxPdo>",
              "<CoE PdoConfig='1' PdoAssign='1'/>", "4", MODULE("#x110", "IO", TX_PDO));
    static const uint16_t lists[] = {0x1680, 0x1A80};
    const uint8_t none = 0;
    rig_t r;
    (void)state;
    open_rig(&r, text, PREOP);
    for (size_t i = 0; i < 2; i++) {
        assert_int_equal(wire_sdo_download(&r.wire, 0, lists[i], 0, false, &none, 1), 0);
        assert_int_equal(read_number(&r, lists[i], 0), 0);
    }
    assert_true(plug(&r, 2, IN));
    for (size_t i = 0; i < 2; i++)
        assert_int_equal(read_number(&r, lists[i], 0), 1);
    close_rig(&r);
}

/* An object of a module has its default, even if no object has a lower index. */
static void lowest_object(void **state)
{
    static const char text[] = PARTS(
        "", "", "<CoE/>", "4",
        MODULE("#x110", "IO", TX_PDO) MODULE_WITH(
            "#x120", OBJECTS(OBJECT("0800", "UINT", "16",
                                    "<Info><DefaultValue>7</DefaultValue></Info><Flags><Access>rw</Access></Flags>"))));
    rig_t r;
    (void)state;
    open_rig(&r, text, PREOP);
    assert_true(plug(&r, 1, IN));
    assert_int_equal(abort_of(&r, 0x0800, 0), NO_OBJECT);
    assert_true(plug(&r, 2, OUT));
    assert_int_equal(read_number(&r, 0x0800, 0), 7);
    close_rig(&r);
}

static void addresses(void **state)
{
    static const struct {
        uint16_t index;
        uint8_t subindex;
        uint32_t value;
    } rows[] = {{0xF020, 0, 3}, {0xF020, 1, 0},          {0xF040, 1, 1}, {0xF040, 2, 0},
                {0xF010, 0, 3}, {0xF010, 1, 0x00050191}, {0xF010, 2, 0}};
    rig_t r;
    uint16_t code;
    uint8_t address[2] = {2, 0};
    (void)state;
    open_rig(&r, RACK("DownloadModuleAddressList='1'", ""), PREOP);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        assert_int_equal(read_number(&r, rows[i].index, rows[i].subindex), rows[i].value);
    assert_int_equal(abort_of(&r, 0xF030, 0), NO_OBJECT);
    configure(&r);
    assert_int_equal(wire_sdo_download(&r.wire, 0, 0xF020, 1, false, address, 2), 0);
    assert_int_equal(wire_al(&r.wire, 0, SAFEOP, &code), PREOP | 0x10);
    assert_int_equal(code, 0x0070);
    assert_int_equal(wire_al(&r.wire, 0, PREOP | 0x10, &code), PREOP);
    address[0] = 1;
    assert_int_equal(wire_sdo_download(&r.wire, 0, 0xF020, 1, false, address, 2), 0);
    wire_go(&r.wire, 0, SAFEOP);
    close_rig(&r);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"MDP-009 MDP-011: a module inserted in PREOP brings its objects and PDOs, one removed takes them away",
         inserted, NULL, NULL, NULL},
        {"MDP-015: a slot refuses a module that it does not take", refused, NULL, NULL, NULL},
        {"MDP-009 MDP-016: F030h changes objects, PDOs and assignments at once; F050h has the modules in the slots",
         by_the_master, NULL, NULL, NULL},
        {"MDP-009 MDP-010: SAFEOP requested right after F030h is checked with the new mapping", without_another_request,
         NULL, NULL, NULL},
        {"MDP-020: a module pulled in OP ends it as the user chooses; the dictionary follows below SAFEOP",
         pulled_in_op, NULL, NULL, NULL},
        {"MDP-020: a module pulled in SAFEOP ends it by a fall to PREOP only", pulled_in_safeop, NULL, NULL, NULL},
        {"MDP-009: a F030h shorter than the slots leaves the modules of the others", shorter_list, NULL, NULL, NULL},
        {"MDP-009: an ident of the last slot alone is a configuration", last_element, NULL, NULL, NULL},
        {"MDP-020: a module replaced by one of the same ident changes nothing", same_module, NULL, NULL, NULL},
        {"MDP-009: values of other modules stay, a new module has its defaults", values, NULL, NULL, NULL},
        {"a reference to a signal does not reach the values of another module", references, NULL, NULL, NULL},
        {"MDP-003: a power cycle empties F030h, the modules stay in their slots", power_cycle, NULL, NULL, NULL},
        {"MDP-005 MDP-006: a strict device refuses idents unlike F050h with 06090033h", strict, NULL, NULL, NULL},
        {"MDP-004 MDP-009 MDP-010: the sequences of masters for modular devices lead to OP", masters, NULL, NULL, NULL},
        {"MDP-007: a set of modules that cannot be built is refused at SAFEOP", too_many, NULL, NULL, NULL},
        {"MDP-009: devices whose modules change", racks, NULL, NULL, NULL},
        {"MDP-009 MDP-016: a module in the last of 255 slots", last_of_many_slots, NULL, NULL, NULL},
        {"MDP-002: lists of more than 255 slots have 255 elements", lists_of_many_slots, NULL, NULL, NULL},
        {"MDP-009: memory of the modules that the slots take", memory, NULL, NULL, NULL},
        {"MDP-009: modules of 8 MiB change, larger ones do not", largest, NULL, NULL, NULL},
        {"MDP-009 MDP-005: values of the device outlast a change of modules", values_of_the_device, NULL, NULL, NULL},
        {"MDP-009 MDP-010: mappings return to their defaults with other modules", mappings, NULL, NULL, NULL},
        {"MDP-009: the first object of the dictionary has its default with its module", lowest_object, NULL, NULL,
         NULL},
        {"MDP-016: F020h and F040h of a file whose addresses are downloaded; F010h", addresses, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("ESI: modules that change", tests, NULL, NULL);
}
