/* SPDX-License-Identifier: MIT */
/* A slave of a network file: identity, layout, and the commands that bring it to OP. */
#include "eni/write_slave.h"

#include <string.h>

#include "eni/model.h"
#include "esc/personality.h"
#include "esc/route.h"
#include "wire/bytes.h"
#include "wire/registers.h"
#include "wire/sii.h"

enum {
    SM_BYTES = 8,
    FMMU_BYTES = 16,
    FMMU_READS = 1,
    FMMU_WRITES = 2,
    SII_READ = 0x0100,
    SII_BUSY = 0x8000,
    SII_TIMEOUT_MS = 100,
    STATE_MASK = 0x1F, /* with the error flag */
    MAILBOX_TIMEOUT_MS = 2000,
    POLL_MS = 10,
    CCS_DOWNLOAD = 1,
    CCS_UPLOAD = 2,
    NS_PER_US = 1000
};

typedef struct slave {
    ect_xml_writer_t *xml;
    const ect_eni_part_t *part;
    size_t i;
    uint16_t station;
    const eni_share_t *share;
} slave_t;

static uint16_t station_of(size_t i)
{
    return (uint16_t)(ENI_FIRST_STATION + i);
}

static uint8_t role_of(bool inputs)
{
    return inputs ? ECT_SM_INPUTS : ECT_SM_OUTPUTS;
}

uint32_t eni_bytes(const ect_device_t *device, bool inputs)
{
    uint32_t bytes = 0;
    for (unsigned int n = 0; n < device->sm_count; n++) {
        if (ect_sm_role(&device->sm[n]) == role_of(inputs))
            bytes += ect_device_sm_bytes(device, n);
    }
    return bytes;
}

/* --- commands ----------------------------------------------------------------------------------------------------- */

static void write_transitions(ect_xml_writer_t *xml, const char *transitions)
{
    while (*transitions != '\0') {
        char one[4] = "";
        const size_t length = strcspn(transitions, " ");
        memcpy(one, transitions, length < sizeof one ? length : sizeof one - 1);
        ect_xml_text(xml, "Transition", one);
        transitions += length;
        transitions += strspn(transitions, " ");
    }
}

void eni_write_init(ect_xml_writer_t *xml, const eni_init_t *init)
{
    ect_xml_open(xml, "InitCmd");
    write_transitions(xml, init->transition);
    if (init->before_slave)
        ect_xml_text(xml, "BeforeSlave", "true");
    ect_xml_text(xml, "Comment", init->comment);
    ect_xml_number(xml, "Cmd", init->command);
    ect_xml_number(xml, "Adp", init->adp);
    ect_xml_number(xml, "Ado", init->ado);
    if (init->data != NULL)
        ect_xml_bytes(xml, "Data", init->data, init->length);
    else
        ect_xml_number(xml, "DataLength", (int64_t)init->length);
    if (!init->uncounted)
        ect_xml_number(xml, "Cnt", (int64_t)init->counter);
    if (init->expected != NULL) {
        ect_xml_open(xml, "Validate");
        ect_xml_bytes(xml, "Data", init->expected, init->length);
        if (init->mask != NULL)
            ect_xml_bytes(xml, "DataMask", init->mask, init->length);
        ect_xml_number(xml, "Timeout", init->timeout_ms);
        ect_xml_close(xml);
    }
    ect_xml_close(xml);
}

static void write_bytes(const slave_t *s, const char *transition, const char *comment, unsigned int ado,
                        const uint8_t *data, size_t length)
{
    const eni_init_t init = {.transition = transition,
                             .comment = comment,
                             .command = ECT_FPWR,
                             .adp = s->station,
                             .ado = (uint16_t)ado,
                             .data = data,
                             .length = length,
                             .counter = 1};
    eni_write_init(s->xml, &init);
}

static void expect(const slave_t *s, const char *transition, const char *comment, unsigned int ado,
                   const uint8_t *expected, const uint8_t *mask, size_t length, uint32_t timeout_ms)
{
    const eni_init_t init = {.transition = transition,
                             .comment = comment,
                             .command = ECT_FPRD,
                             .adp = s->station,
                             .ado = (uint16_t)ado,
                             .length = length,
                             .counter = 1,
                             .expected = expected,
                             .mask = mask,
                             .timeout_ms = timeout_ms};
    eni_write_init(s->xml, &init);
}

static void go_to(const slave_t *s, const char *transition, uint8_t state, uint32_t timeout_ms)
{
    const uint8_t request[] = {state, 0}, mask[] = {STATE_MASK, 0};
    write_bytes(s, transition, "request the state", ECT_REG_AL_CONTROL, request, sizeof request);
    expect(s, transition, "wait for the state", ECT_REG_AL_STATUS, request, mask, sizeof request, timeout_ms);
}

static void check_word(const slave_t *s, const char *comment, unsigned int byte, uint32_t value)
{
    static const uint8_t idle[2] = {0}, mask[2] = {0, SII_BUSY >> 8};
    uint8_t request[6], expected[4];
    ect_store_le16(request, SII_READ);
    ect_store_le32(request + 2, byte / 2);
    ect_store_le32(expected, value);
    write_bytes(s, "IP", comment, ECT_REG_SII_CONTROL, request, sizeof request);
    expect(s, "IP", "wait for the EEPROM", ECT_REG_SII_CONTROL, idle, mask, sizeof idle, SII_TIMEOUT_MS);
    expect(s, "IP", comment, ECT_REG_SII_DATA, expected, NULL, sizeof expected, SII_TIMEOUT_MS);
}

/* --- layout ------------------------------------------------------------------------------------------------------- */

static void set_sm(const slave_t *s, const char *transition, unsigned int n)
{
    const ect_sm_t *sm = &s->part->device->sm[n];
    const uint16_t length = ect_device_sm_bytes(s->part->device, n);
    uint8_t bytes[SM_BYTES] = {0};
    if ((sm->flags & ECT_SM_FLAG_VIRTUAL) != 0 || sm->type == ECT_SM_UNUSED)
        return;
    ect_store_le16(bytes, sm->start);
    ect_store_le16(bytes + 2, length);
    bytes[4] = sm->control;
    bytes[6] = length > 0;
    write_bytes(s, transition, "SyncManager", ECT_REG_SM + SM_BYTES * n, bytes, sizeof bytes);
}

static void set_fmmus(const slave_t *s, bool inputs, uint32_t offset, unsigned int *fmmu)
{
    const ect_device_t *device = s->part->device;
    uint32_t address = (inputs ? ENI_LOGICAL_INPUTS : ENI_LOGICAL_OUTPUTS) + offset;
    for (unsigned int n = 0; n < device->sm_count; n++) {
        const uint16_t length = ect_device_sm_bytes(device, n);
        uint8_t bytes[FMMU_BYTES] = {0};
        if (ect_sm_role(&device->sm[n]) != role_of(inputs) || length == 0)
            continue;
        ect_store_le32(bytes, address);
        ect_store_le16(bytes + 4, length);
        bytes[7] = 7; /* last bit */
        ect_store_le16(bytes + 8, device->sm[n].start);
        bytes[11] = inputs ? FMMU_READS : FMMU_WRITES;
        bytes[12] = 1;
        write_bytes(s, "PS", inputs ? "FMMU of inputs" : "FMMU of outputs", ECT_REG_FMMU + FMMU_BYTES * (*fmmu)++,
                    bytes, sizeof bytes);
        address += length;
    }
}

static bool has_mailbox(const ect_device_t *device)
{
    return device->mailbox_protocols != 0 && device->sm_count >= 2;
}

/* @return the FMMUs of process data: one for each SyncManager that has any, virtual ones included */
static unsigned int count_fmmus(const ect_device_t *device)
{
    unsigned int count = 0;
    for (unsigned int n = 0; n < device->sm_count; n++) {
        const uint8_t role = ect_sm_role(&device->sm[n]);
        count += (role == ECT_SM_OUTPUTS || role == ECT_SM_INPUTS) && ect_device_sm_bytes(device, n) > 0;
    }
    return count;
}

bool eni_has_state(const ect_device_t *device)
{
    const ect_esc_personality_t *chip = ect_esc_personality(device->esc);
    return has_mailbox(device) && chip != NULL && count_fmmus(device) < chip->fmmu_count;
}

/* Maps bit 0 of the status of SyncManager 1, which is set from a mail of the slave until the master reads it, to a bit
 * of the logical memory. */
static void map_state(const slave_t *s)
{
    uint8_t bytes[FMMU_BYTES] = {0};
    if (s->share->state_bit < 0)
        return;
    const unsigned int bit = (unsigned int)s->share->state_bit;
    ect_store_le32(bytes, ENI_LOGICAL_STATES + bit / 8);
    ect_store_le16(bytes + 4, 1);
    bytes[6] = bytes[7] = bit % 8;
    ect_store_le16(bytes + 8, ECT_REG_SM + SM_BYTES + ECT_SM_STATUS);
    bytes[11] = FMMU_READS;
    bytes[12] = 1;
    write_bytes(s, "IP", "FMMU of the mailbox state", ECT_REG_FMMU + FMMU_BYTES * count_fmmus(s->part->device), bytes,
                sizeof bytes);
}

/* --- clocks ------------------------------------------------------------------------------------------------------- */

static uint32_t sync0_ns(const slave_t *s)
{
    const ect_dc_mode_t *mode = s->part->clock;
    const uint32_t cycle_ns = s->share->cycle_us * (uint32_t)NS_PER_US;
    if (mode->cycle_sync0_ns != 0)
        return mode->cycle_sync0_ns;
    const int32_t factor = mode->factor_sync0;
    if (factor < 0)
        return cycle_ns / (uint32_t)-factor;
    return factor > 0 ? cycle_ns * (uint32_t)factor : cycle_ns;
}

/* SYNC1 follows every nth SYNC0 after its shift. The register has the time between both signals, minus one SYNC0 cycle.
 */
static uint32_t sync1_ns(const slave_t *s)
{
    const ect_dc_mode_t *mode = s->part->clock;
    const uint32_t behind = mode->factor_sync1 > 1 ? ((uint32_t)mode->factor_sync1 - 1) * sync0_ns(s) : 0;
    return behind + (uint32_t)mode->shift_sync1_ns;
}

/* Writes cycles, start and units in the order of configuration tools. The master adds the system time to the start. */
static void start_clock(const slave_t *s)
{
    uint8_t cycles[8], start[8], units[2], none[2] = {0};
    if (s->part->clock == NULL)
        return;
    ect_store_le32(cycles, sync0_ns(s));
    ect_store_le32(cycles + 4, sync1_ns(s));
    ect_store_le64(start, (uint64_t)(int64_t)s->part->clock->shift_sync0_ns);
    ect_store_le16(units, s->part->clock->assign_activate);
    write_bytes(s, "IP", "clear DC activation", ECT_REG_DC_CYCLIC_CONTROL, none, sizeof none);
    write_bytes(s, "PS", "set DC cycle time", ECT_REG_DC_SYNC0_CYCLE, cycles, sizeof cycles);
    write_bytes(s, "PS", "set DC start time", ECT_REG_DC_START_TIME, start, sizeof start);
    write_bytes(s, "PS", "set DC activation", ECT_REG_DC_CYCLIC_CONTROL, units, sizeof units);
    write_bytes(s, "SP OP", "clear DC activation", ECT_REG_DC_CYCLIC_CONTROL, none, sizeof none);
}

static void write_dc(const slave_t *s)
{
    if (s->part->clock == NULL)
        return;
    ect_xml_open(s->xml, "DC");
    ect_xml_number(s->xml, "PotentialReferenceClock", 1);
    ect_xml_number(s->xml, "ReferenceClock", s->share->reference);
    ect_xml_number(s->xml, "CycleTime0", sync0_ns(s));
    ect_xml_number(s->xml, "CycleTime1", sync1_ns(s));
    ect_xml_number(s->xml, "ShiftTime", s->part->clock->shift_sync0_ns);
    ect_xml_close(s->xml);
}

static void write_hot_connect(const slave_t *s)
{
    if (s->part->group == NULL)
        return;
    ect_xml_open(s->xml, "HotConnect");
    if (*s->part->group != '\0')
        ect_xml_text(s->xml, "GroupName", s->part->group);
    ect_xml_number(s->xml, "GroupMemberCnt", s->part->members);
    ect_xml_close(s->xml);
}

/* --- start-up ----------------------------------------------------------------------------------------------------- */

static void write_commands(const slave_t *s)
{
    const ect_device_t *device = s->part->device;
    const ect_timeouts_t *t = &device->timeouts;
    const unsigned int first = has_mailbox(device) ? 2 : 0;
    unsigned int fmmu = 0;
    uint8_t station[2], eeprom[1] = {0};
    ect_store_le16(station, s->station);
    const eni_init_t address = {.transition = "IP",
                                .comment = "station address",
                                .command = ECT_APWR,
                                .adp = (uint16_t)(0 - s->i),
                                .ado = ECT_REG_STATION_ADDRESS,
                                .data = station,
                                .length = sizeof station,
                                .counter = 1};
    ect_xml_open(s->xml, "InitCmds");
    eni_write_init(s->xml, &address);
    write_bytes(s, "IP", "EEPROM to the master", ECT_REG_SII_CONFIG, eeprom, sizeof eeprom);
    check_word(s, "vendor id", ECT_SII_AT_VENDOR, s->part->identity.vendor_id);
    check_word(s, "product code", ECT_SII_AT_PRODUCT, s->part->identity.product_code);
    check_word(s, "revision", ECT_SII_AT_REVISION, s->part->identity.revision);
    for (unsigned int n = 0; n < first; n++)
        set_sm(s, "IP", n);
    map_state(s);
    eeprom[0] = 1;
    write_bytes(s, "IP", "EEPROM to the slave", ECT_REG_SII_CONFIG, eeprom, sizeof eeprom);
    go_to(s, "IP", ECT_STATE_PREOP, t->preop_ms != 0 ? t->preop_ms : 3000);
    for (unsigned int n = first; n < device->sm_count; n++)
        set_sm(s, "PS", n);
    set_fmmus(s, false, s->share->offsets[0], &fmmu);
    set_fmmus(s, true, s->share->offsets[1], &fmmu);
    start_clock(s);
    go_to(s, "PS", ECT_STATE_SAFEOP, t->safeop_op_ms != 0 ? t->safeop_op_ms : 10000);
    go_to(s, "SO", ECT_STATE_OP, t->safeop_op_ms != 0 ? t->safeop_op_ms : 10000);
    go_to(s, "OS", ECT_STATE_SAFEOP, t->back_to_safeop_ms != 0 ? t->back_to_safeop_ms : 200);
    go_to(s, "SP", ECT_STATE_PREOP, t->back_to_init_ms != 0 ? t->back_to_init_ms : 5000);
    go_to(s, "PI", ECT_STATE_INIT, t->back_to_init_ms != 0 ? t->back_to_init_ms : 5000);
    ect_xml_close(s->xml);
}

/* --- mailbox ------------------------------------------------------------------------------------------------------ */

static void write_box(ect_xml_writer_t *xml, const char *element, uint16_t start, uint16_t length)
{
    ect_xml_open(xml, element);
    ect_xml_number(xml, "Start", start);
    ect_xml_number(xml, "Length", length);
    ect_xml_close(xml);
}

static void write_receive(const slave_t *s)
{
    const ect_sm_t *sm = &s->part->device->sm[1];
    ect_xml_open(s->xml, "Recv");
    ect_xml_number(s->xml, "Start", sm->start);
    ect_xml_number(s->xml, "Length", sm->length);
    ect_xml_number(s->xml, "PollTime", POLL_MS);
    if (s->share->state_bit >= 0)
        ect_xml_number(s->xml, "StatusBitAddr", s->share->state_bit);
    ect_xml_close(s->xml);
}

/* The cycle in the format of 60C2h (CiA 402): a mantissa of 8 bits and a power of ten, in seconds. */
static bool split_cycle(uint32_t ns, uint8_t *mantissa, uint8_t *power)
{
    int8_t exponent = -9;
    for (; ns > UINT8_MAX && ns % 10 == 0; ns /= 10)
        exponent++;
    for (; ns > 0 && exponent < -3 && ns % 10 == 0; ns /= 10)
        exponent++;
    *mantissa = (uint8_t)ns;
    *power = (uint8_t)exponent;
    return ns > 0 && ns <= UINT8_MAX;
}

/* Computes the data of a command with `adapts` from the configured cycle: the interpolation time of each axis (60C2h,
 * in steps of 800h), the cycle times 1C32h:2 and 1C33h:2. */
static const uint8_t *adapted(const slave_t *s, const ect_init_command_t *command, uint8_t room[4])
{
    enum { INTERPOLATION = 0x60C2, AXES_END = 0xA000, AXIS = 0x800 };
    const uint32_t cycle_ns = s->part->clock != NULL ? sync0_ns(s) : s->share->cycle_us * (uint32_t)NS_PER_US;
    const bool is_time = (command->index == 0x1C32 || command->index == 0x1C33) && command->subindex == 2;
    const bool is_axis = command->index >= INTERPOLATION && command->index < AXES_END &&
                         (command->index - INTERPOLATION) % AXIS == 0 && command->subindex >= 1 &&
                         command->subindex <= 2;
    uint8_t split[2];
    ect_store_le32(room, cycle_ns);
    if (!command->adapts || command->complete)
        return command->data;
    if (is_time && command->size == 4)
        return room;
    if (!is_axis || command->size != 1 || !split_cycle(cycle_ns, &split[0], &split[1]))
        return command->data;
    room[0] = split[command->subindex - 1];
    return room;
}

static void write_coe(const slave_t *s)
{
    ect_xml_writer_t *xml = s->xml;
    const ect_device_t *device = s->part->device;
    ect_xml_open(xml, "CoE");
    ect_xml_open(xml, "InitCmds");
    for (unsigned int i = 0; i < device->init_command_count; i++) {
        const ect_init_command_t *command = &device->init_commands[i];
        uint8_t room[4];
        ect_xml_open(xml, "InitCmd");
        ect_xml_flag(xml, "CompleteAccess", command->complete);
        write_transitions(xml, command->transitions);
        if (command->comment != NULL)
            ect_xml_text(xml, "Comment", command->comment);
        ect_xml_number(xml, "Timeout", MAILBOX_TIMEOUT_MS);
        ect_xml_number(xml, "Ccs", command->upload ? CCS_UPLOAD : CCS_DOWNLOAD);
        ect_xml_number(xml, "Index", command->index);
        ect_xml_number(xml, "SubIndex", command->subindex);
        if (!command->upload)
            ect_xml_bytes(xml, "Data", adapted(s, command, room), command->size);
        if (command->disabled)
            ect_xml_number(xml, "Disabled", 1);
        ect_xml_close(xml);
    }
    ect_xml_close(xml);
    ect_xml_close(xml);
}

/* Writes a request of FoE, the name of its file, and the content that may follow. */
static void write_foe(ect_xml_writer_t *xml, const ect_init_mail_t *mail)
{
    const char *name = (const char *)mail->data + ECT_ENI_FOE_HEADER;
    const size_t room = mail->size > ECT_ENI_FOE_HEADER ? (size_t)mail->size - ECT_ENI_FOE_HEADER : 0;
    const char *end = room > 0 ? memchr(name, 0, room) : NULL;
    if (end == NULL)
        return;
    ect_xml_number(xml, "OpCode", mail->data[0]);
    if (ect_load_le32(mail->data + 2) != 0)
        ect_xml_number(xml, "Password", ect_load_le32(mail->data + 2));
    ect_xml_text(xml, "FileName", name);
    const size_t left = room - (size_t)(end - name) - 1;
    if (left > 0)
        ect_xml_bytes(xml, "Data", (const uint8_t *)end + 1, left);
}

/* Writes the parts before the data of a mail: its type, or the elements of an IDN. */
static void write_mail_head(ect_xml_writer_t *xml, const ect_init_mail_t *mail)
{
    if (mail->protocol == ECT_MAILBOX_TYPE_EOE)
        ect_xml_number(xml, "Type", mail->type);
    if (mail->protocol != ECT_MAILBOX_TYPE_SOE)
        return;
    ect_xml_number(xml, "OpCode", mail->type);
    ect_xml_number(xml, "DriveNo", mail->drive);
    ect_xml_number(xml, "IDN", mail->idn);
    ect_xml_number(xml, "Elements", mail->elements);
    ect_xml_number(xml, "Attribute", 0);
}

static void write_mails(const slave_t *s, const char *element, uint8_t protocol)
{
    ect_xml_writer_t *xml = s->xml;
    const ect_device_t *device = s->part->device;
    bool any = false;
    for (unsigned int i = 0; i < device->init_mail_count; i++) {
        const ect_init_mail_t *mail = &device->init_mails[i];
        if (mail->protocol != protocol)
            continue;
        if (!any) {
            ect_xml_open(xml, element);
            ect_xml_open(xml, "InitCmds");
        }
        any = true;
        ect_xml_open(xml, "InitCmd");
        write_transitions(xml, mail->transitions);
        if (mail->comment != NULL)
            ect_xml_text(xml, "Comment", mail->comment);
        ect_xml_number(xml, "Timeout", MAILBOX_TIMEOUT_MS);
        write_mail_head(xml, mail);
        if (protocol == ECT_MAILBOX_TYPE_FOE)
            write_foe(xml, mail);
        else if (mail->size > 0)
            ect_xml_bytes(xml, "Data", mail->data, mail->size);
        if (mail->disabled)
            ect_xml_number(xml, "Disabled", 1);
        ect_xml_close(xml);
    }
    if (any) {
        ect_xml_close(xml);
        ect_xml_close(xml);
    }
}

static void write_mailbox(const slave_t *s)
{
    ect_xml_writer_t *xml = s->xml;
    const ect_device_t *device = s->part->device;
    static const struct {
        uint8_t bit;
        const char *name;
    } protocols[] = {{ECT_MAILBOX_AOE, "AoE"}, {ECT_MAILBOX_EOE, "EoE"}, {ECT_MAILBOX_COE, "CoE"},
                     {ECT_MAILBOX_FOE, "FoE"}, {ECT_MAILBOX_SOE, "SoE"}, {ECT_MAILBOX_VOE, "VoE"}};
    if (!has_mailbox(device))
        return;
    ect_xml_open(xml, "Mailbox");
    ect_xml_flag(xml, "DataLinkLayer", (ect_device_general_flags(device) & ECT_GENERAL_MAIL_REPEAT) != 0);
    write_box(xml, "Send", device->sm[0].start, device->sm[0].length);
    write_receive(s);
    if (device->boot_out.length > 0) {
        ect_xml_open(xml, "BootStrap");
        write_box(xml, "Send", device->boot_out.start, device->boot_out.length);
        write_box(xml, "Recv", device->boot_in.start, device->boot_in.length);
        ect_xml_close(xml);
    }
    for (size_t i = 0; i < sizeof protocols / sizeof protocols[0]; i++) {
        if ((device->mailbox_protocols & protocols[i].bit) != 0)
            ect_xml_text(xml, "Protocol", protocols[i].name);
    }
    if ((device->mailbox_protocols & ECT_MAILBOX_COE) != 0 && device->init_command_count > 0)
        write_coe(s);
    write_mails(s, "SoE", ECT_MAILBOX_TYPE_SOE);
    write_mails(s, "AoE", ECT_MAILBOX_TYPE_AOE);
    write_mails(s, "EoE", ECT_MAILBOX_TYPE_EOE);
    write_mails(s, "FoE", ECT_MAILBOX_TYPE_FOE);
    ect_xml_close(xml);
}

/* ------------------------------------------------------------------------------------------------------------------ */

/* The schema has signed numbers of 32 bits here. */
static void write_identity(ect_xml_writer_t *xml, const char *element, uint32_t value)
{
    ect_xml_number(xml, element, (int32_t)value);
}

static const char *name_of(const slave_t *s)
{
    return ect_arena_print(s->xml->arena, "Slave %zu (%s)", s->i + 1, s->part->device->type_name);
}

static void write_info(const slave_t *s)
{
    ect_xml_writer_t *xml = s->xml;
    ect_xml_open(xml, "Info");
    ect_xml_text(xml, "Name", name_of(s));
    ect_xml_number(xml, "PhysAddr", s->station);
    ect_xml_number(xml, "AutoIncAddr", (uint16_t)(0 - s->i));
    if (s->part->alias != 0) {
        ect_xml_open(xml, "Identification");
        ect_xml_attribute(xml, "Value", "%u", s->part->alias);
        ect_xml_number(xml, "Ado", ECT_REG_STATION_ALIAS);
        ect_xml_close(xml);
    }
    ect_xml_text(xml, "Physics", s->part->device->physics);
    write_identity(xml, "VendorId", s->part->identity.vendor_id);
    write_identity(xml, "ProductCode", s->part->identity.product_code);
    write_identity(xml, "RevisionNo", s->part->identity.revision);
    if (s->part->identity.serial != 0)
        write_identity(xml, "SerialNo", s->part->identity.serial);
    ect_xml_close(xml);
}

static void write_bits(ect_xml_writer_t *xml, const char *element, uint32_t offset, uint32_t bytes)
{
    if (bytes == 0)
        return;
    ect_xml_open(xml, element);
    ect_xml_number(xml, "BitStart", offset * 8);
    ect_xml_number(xml, "BitLength", bytes * 8);
    ect_xml_close(xml);
}

static void write_sm(ect_xml_writer_t *xml, const ect_device_t *device, unsigned int n)
{
    static const char *const roles[] = {"", "MBoxOut", "MBoxIn", "Outputs", "Inputs"};
    const ect_sm_t *sm = &device->sm[n];
    const uint16_t bytes = ect_device_sm_bytes(device, n);
    const ect_od_t od = ect_device_od(device, NULL);
    const ect_object_t *assignment = ect_od_find(&od, (uint16_t)(ECT_OD_ASSIGNMENT + n));
    char name[8] = "Sm0";
    if (ect_sm_role(sm) == ECT_SM_UNUSED)
        return;
    name[2] = (char)('0' + n);
    ect_xml_open(xml, name);
    ect_xml_text(xml, "Type", ect_sm_role(sm) < sizeof roles / sizeof roles[0] ? roles[ect_sm_role(sm)] : "");
    if (sm->minimum != 0)
        ect_xml_number(xml, "MinSize", sm->minimum);
    if (sm->maximum != 0)
        ect_xml_number(xml, "MaxSize", sm->maximum);
    ect_xml_number(xml, "DefaultSize", bytes);
    ect_xml_number(xml, "StartAddress", sm->start);
    ect_xml_number(xml, "ControlByte", sm->control);
    ect_xml_number(xml, "Enable", bytes > 0);
    for (uint32_t k = 1;
         ect_device_sm_is_process(device, n) && assignment != NULL && k <= ect_od_element(assignment, 0); k++)
        ect_xml_number(xml, "Pdo", ect_od_element(assignment, k));
    ect_xml_close(xml);
}

/* Writes the neighbour towards the master, which the first slave does not have. */
static void write_previous(const slave_t *s)
{
    const char port[] = {(char)('A' + (s->part->up_port != 0 ? s->part->up_port : 1)), '\0'};
    if (s->i == 0)
        return;
    ect_xml_open(s->xml, "PreviousPort");
    ect_xml_attribute(s->xml, "Selected", "1");
    ect_xml_text(s->xml, "Port", port);
    ect_xml_number(s->xml, "PhysAddr", station_of(s->part->up_port != 0 ? s->part->up : s->i - 1));
    ect_xml_close(s->xml);
}

void eni_write_slave(ect_xml_writer_t *xml, const ect_eni_part_t *parts, size_t i, const eni_share_t *share)
{
    const slave_t s = {.xml = xml, .part = &parts[i], .i = i, .station = station_of(i), .share = share};
    const ect_device_t *device = parts[i].device;
    ect_xml_open(xml, "Slave");
    write_info(&s);
    ect_xml_open(xml, "ProcessData");
    write_bits(xml, "Send", share->offsets[0], eni_bytes(device, false));
    write_bits(xml, "Recv", share->offsets[1], eni_bytes(device, true));
    for (unsigned int n = 0; n < device->sm_count; n++)
        write_sm(xml, device, n);
    ect_xml_pdos(xml, device, true);
    ect_xml_pdos(xml, device, false);
    ect_xml_close(xml);
    write_mailbox(&s);
    write_commands(&s);
    write_previous(&s);
    write_hot_connect(&s);
    write_dc(&s);
    ect_xml_close(xml);
}

/* --- variables ---------------------------------------------------------------------------------------------------- */

/* @return the first bit after the PDO */
static uint32_t write_pdo_variables(ect_xml_writer_t *xml, const ect_device_t *device, size_t i, uint16_t index,
                                    uint32_t bit)
{
    const ect_od_t od = ect_device_od(device, NULL);
    const ect_object_t *pdo = ect_od_find(&od, index);
    for (uint32_t n = 1; pdo != NULL && n <= ect_od_element(pdo, 0); n++) {
        const uint32_t mapping = ect_od_element(pdo, n);
        const ect_entry_t *entry = ect_od_mapped(&od, mapping);
        if (entry != NULL && (mapping & 0xFF) > 0) {
            const char *name =
                ect_arena_print(xml->arena, "Slave %zu (%s).%s.%s", i + 1, device->type_name,
                                pdo->name != NULL ? pdo->name : "", entry->name != NULL ? entry->name : "");
            ect_xml_open(xml, "Variable");
            ect_xml_text(xml, "Name", name);
            ect_xml_number(xml, "BitSize", mapping & 0xFF);
            ect_xml_number(xml, "BitOffs", bit);
            ect_xml_close(xml);
        }
        bit += mapping & 0xFF;
    }
    return bit;
}

void eni_write_variables(ect_xml_writer_t *xml, const ect_device_t *device, size_t i, bool inputs, uint32_t offset)
{
    const ect_od_t od = ect_device_od(device, NULL);
    for (unsigned int n = 0; n < device->sm_count; n++) {
        if (ect_sm_role(&device->sm[n]) != role_of(inputs))
            continue;
        const ect_object_t *assignment = ect_od_find(&od, (uint16_t)(ECT_OD_ASSIGNMENT + n));
        uint32_t bit = offset * 8;
        for (uint32_t k = 1; ect_device_sm_is_process(device, n) && k <= ect_od_element(assignment, 0); k++)
            bit = write_pdo_variables(xml, device, i, (uint16_t)ect_od_element(assignment, k), bit);
        offset += ect_device_sm_bytes(device, n);
    }
}
