/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "verify_network.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bus/chain/chain.h"
#include "eni/bus.h"
#include "eni/check.h"
#include "eni/play.h"
#include "network.h"
#include "products.h"
#include "reader/packet.h"
#include "wire/bytes.h"
#include "wire/sii.h"

enum { SAME = 0, DIFFERENT = 1, TROUBLE = 2, CYCLES = 10 };
#define START_NS UINT64_C(1000000000)

static void print_line(void *ctx, const char *line)
{
    size_t *lines = ctx;
    (*lines)++;
    printf("%s\n", line);
}

static int trouble(const char *message)
{
    fprintf(stderr, "ectwin verify: %s\n", message);
    return TROUBLE;
}

/* --- with twins --------------------------------------------------------------------------------------------------- */

/* A bus of twins on a clock of its own. */
typedef struct bench {
    ect_chain_t *chain;
    uint64_t now_ns;
    size_t lines;
} bench_t;

static bool exchange(void *ctx, uint8_t *frame, size_t length)
{
    bench_t *b = ctx;
    const bool came = ect_chain_process(b->chain, frame, length, b->now_ns);
    (void)ect_chain_poll(b->chain, b->now_ns);
    return came;
}

static void pass_time(void *ctx, uint64_t ns)
{
    bench_t *b = ctx;
    const uint64_t until = b->now_ns + ns;
    for (;;) {
        const uint64_t next = ect_chain_poll(b->chain, b->now_ns);
        if (b->now_ns >= until)
            return;
        b->now_ns = next > b->now_ns && next < until ? next : until;
    }
}

static void report(void *ctx, const char *line)
{
    bench_t *b = ctx;
    print_line(&b->lines, line);
}

static void play(bench_t *b, const ect_eni_t *eni)
{
    const ect_eni_wire_t wire = {.ctx = b, .exchange = exchange, .wait = pass_time, .report = report};
    ect_eni_player_t player = {.eni = eni, .wire = &wire};
    bool fine = ect_eni_play(&player, ECT_ENI_OPERATIONAL);
    for (unsigned int i = 0; i < CYCLES && fine; i++)
        fine = ect_eni_play_cycle(&player);
}

static ect_twin_config_t *make_twins(const network_names_t *names, const char *path, char *message)
{
    ect_twin_config_t *twins = calloc(names->count, sizeof *twins);
    for (size_t i = 0; twins && i < names->count; i++) {
        const ect_product_t *product = product_find(names->names[i], NULL, 0, ECT_BEHAVIOUR_BY_FILE, message);
        if (!product) {
            free(twins);
            return NULL;
        }
        twins[i] = ect_twin_default(product->device, product->plant);
    }
    if (twins && network_apply(path, twins, 0, message)) {
        if (ect_chain_check_wires(twins, names->count) == names->count)
            return twins;
        snprintf(message, PRODUCT_MESSAGE, "%s: a PreviousPort names a port that its slave lacks, or one that is taken",
                 path);
    }
    free(twins);
    return NULL;
}

/* Commands that the player does not send are no difference. */
static void print_unsent(const ect_eni_t *eni)
{
    const ect_eni_network_t *network = ect_eni_network(eni);
    for (size_t i = 0; i < network->slave_count; i++) {
        const ect_eni_slave_t *slave = &network->slaves[i];
        if (slave->mailbox.others > 0)
            fprintf(stderr,
                    "ectwin verify: %s:%d: slave %zu, %s: %zu start-up commands of FoE, or without a mail, are "
                    "not sent\n",
                    ect_eni_file(eni), slave->line, i + 1, slave->name, slave->mailbox.others);
    }
}

/* A slave without an ESI file is a difference; its twin is made from the ENI alone. */
static size_t print_missing(const network_names_t *names, const ect_eni_t *eni)
{
    const ect_eni_network_t *network = ect_eni_network(eni);
    size_t lines = 0;
    for (size_t i = 0; i < names->count; i++) {
        const ect_eni_slave_t *slave = &network->slaves[i];
        if (strncmp(names->names[i], "eni:", 4) != 0)
            continue;
        printf("%s:%d: slave %zu, %s: no ESI file has vendor 0x%08" PRIX32 ", product 0x%08" PRIX32
               ", revision 0x%08" PRIX32 "\n",
               ect_eni_file(eni), slave->line, i + 1, slave->name, slave->vendor_id, slave->product_code,
               slave->revision);
        lines++;
    }
    return lines;
}

static int with_twins(const char *path, const char *const files[], size_t count)
{
    char message[PRODUCT_MESSAGE] = "no memory left";
    network_names_t names;
    bench_t b = {.now_ns = START_NS};
    product_quiet();
    const bool found = network_names_of_files(&names, path, files, count, message);
    const ect_eni_t *eni = found ? product_network(path, message) : NULL;
    ect_twin_config_t *twins = eni ? make_twins(&names, path, message) : NULL;
    b.chain = twins ? ect_chain_new(twins, names.count, b.now_ns) : NULL;
    if (b.chain) {
        eni = product_network(path, message);
        b.lines += count > 0 ? print_missing(&names, eni) : 0;
        print_unsent(eni);
        (void)ect_eni_check(eni, report, &b);
        play(&b, eni);
    }
    ect_chain_free(b.chain);
    free(twins);
    network_names_free(&names);
    if (!b.chain)
        return trouble(message);
    return b.lines > 0 ? DIFFERENT : SAME;
}

/* --- with slaves -------------------------------------------------------------------------------------------------- */

static size_t compare(const ect_eni_t *eni, size_t i, const uint8_t *header)
{
    static const struct {
        const char *name;
        unsigned int at;
    } parts[] = {{"vendor id", ECT_SII_AT_VENDOR},
                 {"product code", ECT_SII_AT_PRODUCT},
                 {"revision", ECT_SII_AT_REVISION},
                 {"serial number", ECT_SII_AT_SERIAL}};
    const ect_eni_slave_t *slave = &ect_eni_network(eni)->slaves[i];
    const uint32_t expected[] = {slave->vendor_id, slave->product_code, slave->revision, slave->serial};
    size_t lines = 0;
    for (size_t k = 0; k < sizeof parts / sizeof parts[0]; k++) {
        const uint32_t found = ect_load_le32(header + parts[k].at);
        if (found == expected[k] || (parts[k].at == ECT_SII_AT_SERIAL && expected[k] == 0))
            continue;
        printf("%s:%d: slave %zu, %s: %s 0x%08" PRIX32 ", the slave has 0x%08" PRIX32 "\n", ect_eni_file(eni),
               slave->line, i + 1, slave->name, parts[k].name, expected[k], found);
        lines++;
    }
    return lines;
}

/* @param[out] present  number of slaves @return number of lines; -1: the slave cannot be read, which is printed */
static long compare_slave(const ect_eni_t *eni, size_t i, ect_packet_t *port, uint16_t *present)
{
    const ect_reader_link_t link = ect_reader_packet_link(port);
    const ect_reader_config_t config = {.position = (uint16_t)i};
    ect_reader_t *reader = calloc(1, sizeof *reader);
    long lines = -1;
    if (reader) {
        if (ect_reader_open(reader, &link, &config) == ECT_READER_OK)
            lines = (long)compare(eni, i, reader->header);
        else if (i < reader->count)
            (void)trouble(reader->text);
        *present = reader->count;
        ect_reader_close(reader);
    }
    free(reader);
    return lines;
}

static int with_slaves(const char *path, const char *iface)
{
    char message[PRODUCT_MESSAGE], why[ECT_PACKET_MESSAGE];
    ect_packet_t port;
    size_t lines = 0;
    uint16_t present = 0;
    bool fine = true;
    const ect_eni_t *eni = product_network(path, message);
    if (!eni)
        return trouble(message);
    if (ect_packet_open(&port, iface, why) != 0)
        return trouble(why);
    const size_t count = ect_eni_network(eni)->slave_count;
    for (size_t i = 0; fine && i < count && (i == 0 || i < present); i++) {
        const long one = compare_slave(eni, i, &port, &present);
        fine = one >= 0 || present == 0;
        lines += one > 0 ? (size_t)one : 0;
    }
    ect_packet_close(&port);
    if (!fine)
        return TROUBLE;
    if (present != count) {
        printf("%s: %zu slaves, the bus has %u\n", path, count, present);
        lines++;
    }
    return lines > 0 ? DIFFERENT : SAME;
}

int verify_network(const char *path, const char *const operands[], size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (strncmp(operands[i], "slave:", 6) == 0 && count > 1)
            return trouble("slave:IFACE is the only operand behind a network file");
    }
    if (count == 1 && strncmp(operands[0], "slave:", 6) == 0)
        return with_slaves(path, operands[0] + 6);
    return with_twins(path, operands, count);
}
