/* SPDX-License-Identifier: MIT */
#include "eni/check.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "eni/bus.h"
#include "esc/route.h"
#include "wire/bytes.h"
#include "wire/registers.h"

enum { LINE = 400, SMS = 16, SM_BYTES = 8, FMMUS = 16, FMMU_BYTES = 16, FMMU_READS = 1, BYTE_BITS = 8, RAM = 0x1000 };

typedef struct checker {
    const ect_eni_t *eni;
    void (*report)(void *ctx, const char *line);
    void *ctx;
    size_t lines;
    const ect_eni_slave_t *slave;
    size_t number; /* of the slave, from 1 */
} checker_t;

__attribute__((format(printf, 3, 4))) static void say(checker_t *c, int line, const char *format, ...)
{
    char text[LINE];
    va_list values;
    int length = snprintf(text, sizeof text, "%.200s:%d: ", ect_eni_file(c->eni), line);
    if (c->slave != NULL)
        length += snprintf(text + length, sizeof text - (size_t)length, "slave %zu: ", c->number);
    va_start(values, format);
    (void)vsnprintf(text + length, sizeof text - (size_t)length, format, values);
    va_end(values);
    c->lines++;
    c->report(c->ctx, text);
}

/* --- a slave ------------------------------------------------------------------------------------------------------ */

/* @return the `length` bytes that the last InitCmd writes to the registers at `at`; NULL: none. @param[out] line of the
 * InitCmd */
static const uint8_t *written(const ect_eni_slave_t *slave, unsigned int at, size_t length, int *line)
{
    const uint8_t *bytes = NULL;
    for (size_t i = 0; i < slave->command_count; i++) {
        const ect_eni_command_t *command = &slave->commands[i];
        const bool writes = command->command == ECT_APWR || command->command == ECT_FPWR;
        if (!writes || ect_eni_is_of_boot(command) || command->ado > at ||
            at + length > command->ado + command->data.length)
            continue;
        bytes = command->data.bytes + (at - command->ado);
        *line = command->line;
    }
    return bytes;
}

static void check_place(checker_t *c)
{
    char why[LINE] = "";
    ect_eni_place_t place;
    const uint16_t expected = (uint16_t)(0 - (c->number - 1));
    if (c->slave->place.given && (uint16_t)c->slave->place.value != expected)
        say(c, c->slave->line, "AutoIncAddr is %" PRId64 "; its place in the file requires %u", c->slave->place.value,
            expected);
    if (ect_eni_place(c->eni, c->number - 1, &place, why, sizeof why))
        return;
    c->lines++;
    c->report(c->ctx, why);
}

static void check_sm(checker_t *c, unsigned int n)
{
    const ect_eni_sm_t *sm = &c->slave->sms[n];
    int line = 0;
    const uint8_t *bytes = written(c->slave, ECT_REG_SM + SM_BYTES * n, SM_BYTES, &line);
    if (!sm->given || bytes == NULL || bytes[6] == 0)
        return;
    if (ect_load_le16(bytes) != sm->start)
        say(c, line, "SyncManager %u is written with start 0x%04X; Sm%u has 0x%04X", n, ect_load_le16(bytes), n,
            sm->start);
    if (sm->size.given && ect_load_le16(bytes + 2) != sm->size.value)
        say(c, line, "SyncManager %u is written with %u bytes; Sm%u has %" PRId64, n, ect_load_le16(bytes + 2), n,
            sm->size.value);
    if (bytes[4] != sm->control)
        say(c, line, "SyncManager %u is written with control 0x%02X; Sm%u has 0x%02X", n, bytes[4], n, sm->control);
}

static void check_box(checker_t *c, unsigned int n, const ect_eni_box_t *box)
{
    int line = 0;
    const uint8_t *bytes = written(c->slave, ECT_REG_SM + SM_BYTES * n, SM_BYTES, &line);
    if (bytes == NULL || bytes[6] == 0 ||
        (ect_load_le16(bytes) == box->start && ect_load_le16(bytes + 2) == box->length))
        return;
    say(c, line, "SyncManager %u is written with %u bytes at 0x%04X; the mailbox has %u at 0x%04X", n,
        ect_load_le16(bytes + 2), ect_load_le16(bytes), box->length, box->start);
}

static void check_mailbox(checker_t *c)
{
    const ect_eni_box_t *send = &c->slave->mailbox.send, *receive = &c->slave->mailbox.receive;
    if (!c->slave->mailbox.given)
        return;
    check_box(c, 0, send);
    check_box(c, 1, receive);
    if (send->start < RAM || receive->start < RAM)
        say(c, c->slave->line, "a mailbox begins below 0x1000, where there are registers");
    if (send->start < receive->start + receive->length && receive->start < send->start + send->length)
        say(c, c->slave->line, "its mailboxes overlap");
}

/* --- bits of process data ------------------------------------------------------------------------------------------
 */

typedef struct bits {
    uint64_t exact, rounded; /* rounded: each part fills whole bytes */
    bool given;
} bits_t;

static void add_bits(bits_t *bits, uint64_t count)
{
    bits->given = true;
    bits->exact += count;
    bits->rounded += (count + BYTE_BITS - 1) / BYTE_BITS * BYTE_BITS;
}

/* @return whether the SyncManager lists the PDO, or the PDO names the SyncManager */
static bool is_assigned(const ect_eni_slave_t *slave, const ect_esi_pdo_t *pdo, int n)
{
    const ect_eni_sm_t *sm = &slave->sms[n];
    for (size_t i = 0; i < sm->pdo_count; i++) {
        if (sm->pdos[i] == pdo->index)
            return true;
    }
    return sm->pdo_count == 0 && pdo->sm == n;
}

/* @return the bits of the assigned PDOs, rounded for each SyncManager */
static bits_t bits_of_pdos(const ect_eni_slave_t *slave, bool inputs)
{
    bits_t all = {0};
    for (int n = 0; n < SMS; n++) {
        uint64_t sum = 0;
        for (size_t i = 0; i < slave->pdo_count; i++) {
            const ect_esi_pdo_t *pdo = &slave->pdos[i];
            for (size_t k = 0; pdo->tx == inputs && is_assigned(slave, pdo, n) && k < pdo->entry_count; k++)
                sum += pdo->entries[k].bits;
        }
        if (sum > 0)
            add_bits(&all, sum);
    }
    return all;
}

/* Process data are in memory, or in registers that have a SyncManager: digital outputs, virtual SyncManagers. */
static bool is_of_process_data(const ect_eni_slave_t *slave, uint16_t start)
{
    bool found = start >= RAM;
    for (unsigned int n = 0; n < SMS; n++)
        found |= slave->sms[n].given && slave->sms[n].start == start;
    return found;
}

static bits_t bits_of_fmmus(const ect_eni_slave_t *slave, bool inputs)
{
    bits_t all = {0};
    for (unsigned int n = 0; n < FMMUS; n++) {
        int line;
        const uint8_t *f = written(slave, ECT_REG_FMMU + FMMU_BYTES * n, FMMU_BYTES, &line);
        const unsigned int length = f != NULL ? ect_load_le16(f + 4) : 0;
        if (length == 0 || f[12] == 0 || (f[11] == FMMU_READS) != inputs ||
            !is_of_process_data(slave, ect_load_le16(f + 8)))
            continue;
        const unsigned int unused = (f[6] & 7u) + 7u - (f[7] & 7u);
        add_bits(&all, length * BYTE_BITS > unused ? length * BYTE_BITS - unused : 0);
    }
    return all;
}

static void compare_bits(checker_t *c, const char *element, uint64_t listed, const bits_t *bits, const char *source)
{
    if (!bits->given || listed == bits->exact || listed == bits->rounded)
        return;
    say(c, c->slave->line, "%s has %" PRIu64 " bits, %s %" PRIu64, element, listed, source, bits->exact);
}

static void check_bits(checker_t *c, bool inputs)
{
    const ect_eni_slave_t *slave = c->slave;
    const ect_eni_bits_t *list = inputs ? slave->receives : slave->sends;
    const size_t count = inputs ? slave->receive_count : slave->send_count;
    const bits_t pdos = bits_of_pdos(slave, inputs), fmmus = bits_of_fmmus(slave, inputs);
    const char *element = inputs ? "Recv" : "Send";
    uint64_t listed = 0;
    for (size_t i = 0; i < count; i++)
        listed += list[i].length;
    compare_bits(c, element, listed, &pdos, "its assigned PDOs");
    compare_bits(c, element, listed, &fmmus, "its FMMUs");
}

static void check_slave(checker_t *c)
{
    check_place(c);
    for (unsigned int n = 0; n < SMS; n++)
        check_sm(c, n);
    check_mailbox(c);
    check_bits(c, false);
    check_bits(c, true);
}

/* Checks that a request of FoE, with the name of its file, fits one mail. */
static void check_files(checker_t *c)
{
    enum { MAIL_HEADER = 6 };
    const ect_eni_mailbox_t *mailbox = &c->slave->mailbox;
    for (size_t i = 0; i < mailbox->mail_count; i++) {
        const ect_eni_mail_t *mail = &mailbox->mails[i];
        const size_t bytes =
            mail->protocol == ECT_MAILBOX_TYPE_FOE ? MAIL_HEADER + ECT_ENI_FOE_HEADER + strlen(mail->file) : 0;
        if (bytes > mailbox->send.length)
            say(c, mail->line, "the FoE request of the file '%.60s' has %zu bytes, the mailbox %u", mail->file, bytes,
                mailbox->send.length);
        if (bytes > 0 && mail->type == ECT_ENI_FOE_READS && mail->data.length > 0)
            say(c, mail->line, "the FoE command reads the file '%.60s', and has Data", mail->file);
    }
}

/* --- process image -------------------------------------------------------------------------------------------------
 */

static void check_range(checker_t *c, const ect_eni_command_t *command, bool inputs)
{
    const ect_eni_network_t *network = ect_eni_network(c->eni);
    const ect_eni_image_t *image = inputs ? &network->inputs : &network->outputs;
    const uint64_t end = (uint64_t)(inputs ? command->input_offset : command->output_offset) + command->data.length;
    if (image->given && end > image->bytes)
        say(c, command->line, "the command reaches byte %" PRIu64 " of the %s, which have %u", end,
            inputs ? "inputs" : "outputs", image->bytes);
}

/* A copy of bits of the inputs to the outputs. */
static void check_copy(checker_t *c, const ect_eni_copy_t *copy)
{
    const ect_eni_network_t *network = ect_eni_network(c->eni);
    const struct {
        const ect_eni_image_t *image;
        const char *name;
        uint64_t end;
    } ends[] = {{&network->inputs, "inputs", (uint64_t)copy->source + copy->bits},
                {&network->outputs, "outputs", (uint64_t)copy->target + copy->bits}};
    if (copy->bits == 0)
        say(c, copy->line, "the CopyInfo copies no bits: BitSize is missing");
    for (size_t i = 0; i < sizeof ends / sizeof ends[0]; i++) {
        if (ends[i].image->given && ends[i].end > (uint64_t)ends[i].image->bytes * BYTE_BITS)
            say(c, copy->line, "the CopyInfo reaches bit %" PRIu64 " of the %s, which have %u bytes", ends[i].end,
                ends[i].name, ends[i].image->bytes);
    }
}

static void check_cyclic(checker_t *c, const ect_eni_command_t *command)
{
    for (size_t i = 0; i < command->copy_count; i++)
        check_copy(c, &command->copies[i]);
    if (command->command == ECT_LWR || command->command == ECT_LRW)
        check_range(c, command, false);
    if (command->command == ECT_LRD || command->command == ECT_LRW)
        check_range(c, command, true);
}

static int by_offset(const void *a, const void *b)
{
    const ect_eni_variable_t *first = a, *second = b;
    return (first->offset > second->offset) - (first->offset < second->offset);
}

static void check_variables(checker_t *c, const ect_eni_image_t *image)
{
    ect_eni_variable_t *sorted = calloc(image->variable_count + 1, sizeof *sorted);
    uint64_t end = 0;
    for (size_t i = 0; sorted != NULL && i < image->variable_count; i++)
        sorted[i] = image->variables[i];
    if (sorted != NULL)
        qsort(sorted, image->variable_count, sizeof *sorted, by_offset);
    for (size_t i = 0; sorted != NULL && i < image->variable_count; i++) {
        const uint64_t behind = (uint64_t)sorted[i].offset + sorted[i].bits;
        if (behind > (uint64_t)image->bytes * BYTE_BITS)
            say(c, sorted[i].line, "Variable %.60s reaches bit %" PRIu64 " of an image of %u bytes", sorted[i].name,
                behind, image->bytes);
        if (sorted[i].offset < end && sorted[i].bits > 0)
            say(c, sorted[i].line, "Variable %.60s begins at bit %u, inside another one", sorted[i].name,
                sorted[i].offset);
        end = behind > end ? behind : end;
    }
    free(sorted);
}

size_t ect_eni_check(const ect_eni_t *eni, void (*report)(void *ctx, const char *line), void *ctx)
{
    const ect_eni_network_t *network = ect_eni_network(eni);
    checker_t c = {.eni = eni, .report = report, .ctx = ctx};
    for (size_t i = 0; i < network->slave_count; i++) {
        c.slave = &network->slaves[i];
        c.number = i + 1;
        check_slave(&c);
        check_files(&c);
    }
    c.slave = NULL;
    for (size_t i = 0; i < network->cyclic_count; i++) {
        for (size_t k = 0; k < network->cyclics[i].frame_count; k++) {
            const ect_eni_frame_t *frame = &network->cyclics[i].frames[k];
            for (size_t n = 0; n < frame->command_count; n++)
                check_cyclic(&c, &frame->commands[n]);
        }
    }
    check_variables(&c, &network->inputs);
    check_variables(&c, &network->outputs);
    return c.lines;
}
