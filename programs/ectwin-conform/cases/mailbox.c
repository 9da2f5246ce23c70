/* SPDX-License-Identifier: MIT */
/* H. Mailbox protocols other than CoE. Files are written and restored with --destructive only. */
#include <stdlib.h>
#include <string.h>

#include "cases/beyond.h"
#include "seams/foe.h"

enum { UNKNOWN = 0x33, FAR = 77, ENDLESS_MOST = 1024 * 1024 };
enum { ERROR_PROTOCOL = 2 };

/* --- files -------------------------------------------------------------------------------------------------------- */

/* Buffer for the content of the file before the case. */
static uint8_t *content(cf_t *c)
{
    return cf_room(c, 0);
}

/* Buffer for the content of the file after a change. */
static uint8_t *again(cf_t *c)
{
    return cf_room(c, 1);
}

/* @return the error code */
static uint32_t expect_error(cf_t *c, const char *what, const cf_foe_t *sent)
{
    cf_mail_t mail;
    uint32_t number;
    uint8_t operation = cf_request_foe(c, sent, &mail, &number);
    cf_expect_that(c, operation == CF_FOE_ERROR, "%s: expected an error (operation 5), got operation %u", what,
                   operation);
    cf_expect_bits(c, "error code: one of FoE", 0xFFFFFFE0u, ECT_FOE_UNDEFINED, number);
    return number;
}

/* Requests that need no existing file. */
static void refusals(cf_t *c)
{
    static const char name[] = "none"; /* fits the smallest mailbox */
    uint8_t longest[CF_MAX_MAIL];
    const struct {
        const char *what;
        cf_foe_t sent;
    } table[] = {
        {"a non-existent file", {CF_FOE_READ, 0, name, sizeof name - 1}},
        {"a name that fills the mailbox", {CF_FOE_READ, 0, longest, cf_foe_full(c, true)}},
        {"an acknowledge without a transfer", {CF_FOE_ACK, FAR, NULL, 0}},
        {"a packet without a transfer", {CF_FOE_DATA, 1, NULL, 0}},
        {"an unknown operation", {UNKNOWN, 0, NULL, 0}},
    };
    memset(longest, 'n', sizeof longest);
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        cf_step(c, "%s", table[i].what);
        (void)expect_error(c, table[i].what, &table[i].sent);
    }
}

/* Reads the file in `state`, unless the error code requires the other state. @return the state of FoE; 0: not `state`
 */
static uint8_t foe_state(cf_t *c, uint8_t state, uint32_t elsewhere, size_t *size)
{
    cf_go(c, CF_INIT);
    cf_go(c, state);
    cf_step(c, "'%s' is read in %s", c->file, cf_state_name(state));
    *size = CF_FILE_MOST;
    uint32_t code = cf_read_file(c, c->password, content(c), size);
    cf_expect_that(c, code == 0 || code == elsewhere, "'%s' in %s: expected data or error 0x%04X, got error 0x%04X",
                   c->file, cf_state_name(state), elsewhere, code);
    return code == 0 ? state : 0;
}

static void expect_content(cf_t *c, const uint8_t *expected, size_t size)
{
    size_t got = CF_FILE_MOST;
    uint32_t code = cf_read_file(c, c->password, again(c), &got);
    cf_expect_that(c, code == 0, "the file, read: expected data, got error 0x%04X", code);
    cf_expect_range(c, "bytes of the file", size, size, got);
    cf_expect_bytes(c, "the file", expected, again(c), size);
}

static void wrong_password(cf_t *c)
{
    uint32_t code;
    size_t size = CF_FILE_MOST;
    cf_step(c, "another password");
    code = cf_read_file(c, c->password + 1, again(c), &size);
    cf_expect_that(c, code != 0 || c->password == 0, "a wrong password: expected an error, got the file");
}

static void wrong_acknowledge(cf_t *c)
{
    static const char what[] = "an acknowledge of an unsent packet";
    const cf_foe_t open = cf_foe_open(c, CF_FOE_READ, c->password);
    cf_mail_t mail;
    uint32_t number;
    cf_step(c, "%s", what);
    cf_expect(c, "FoE operation of a file's packet", CF_FOE_DATA, cf_request_foe(c, &open, &mail, &number));
    cf_expect(c, "error code", ECT_FOE_PACKET_NUMBER, expect_error(c, what, &(cf_foe_t){CF_FOE_ACK, FAR, NULL, 0}));
}

/* --- files, written ----------------------------------------------------------------------------------------------- */

static void expect_ack(cf_t *c, uint32_t expected, const cf_foe_t *sent)
{
    cf_mail_t mail;
    uint32_t number;
    uint8_t operation = cf_request_foe(c, sent, &mail, &number);
    cf_expect_that(c, operation == CF_FOE_ACK && number == expected,
                   "packet %u: expected an acknowledge of the packet, got operation %u, number 0x%04X", expected,
                   operation, number);
}

/* @return whether the slave accepts a file of this length; a firmware may have a fixed length */
static bool write_size(cf_t *c, size_t size)
{
    cf_step(c, "%zu bytes are written and read", size);
    for (size_t i = 0; i < size; i++)
        again(c)[i] = (uint8_t)cf_random(c, 256);
    uint32_t code = cf_write_file(c, c->password, again(c), size);
    if (code != 0)
        return false;
    uint8_t *sent = content(c) + CF_FILE_MOST - size;
    memcpy(sent, again(c), size);
    expect_content(c, sent, size);
    return true;
}

static unsigned int write_sizes(cf_t *c)
{
    const size_t full = cf_foe_full(c, true);
    const size_t sizes[] = {0, 1, full - 1, full, full + 1, 3 * full};
    unsigned int taken = 0;
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++)
        taken += write_size(c, sizes[i]);
    return taken;
}

static void packet_jump(cf_t *c)
{
    uint8_t packet[CF_MAX_MAIL] = {0};
    const uint16_t full = cf_foe_full(c, true);
    const cf_foe_t open = cf_foe_open(c, CF_FOE_WRITE, c->password);
    cf_step(c, "packet 3 behind packet 1");
    expect_ack(c, 0, &open);
    expect_ack(c, 1, &(cf_foe_t){CF_FOE_DATA, 1, packet, full});
    cf_expect(c, "error code", ECT_FOE_PACKET_NUMBER,
              expect_error(c, "a packet out of order", &(cf_foe_t){CF_FOE_DATA, 3, packet, full}));
}

/* The slave refuses the file at some point, or accepts all of it. @return bytes accepted */
static size_t without_end(cf_t *c)
{
    uint8_t packet[CF_MAX_MAIL] = {0};
    const uint16_t full = cf_foe_full(c, true);
    const cf_foe_t open = cf_foe_open(c, CF_FOE_WRITE, c->password);
    cf_mail_t mail;
    uint32_t number, n = 0;
    size_t taken = 0;
    cf_step(c, "an endless file");
    expect_ack(c, 0, &open);
    for (; taken < ENDLESS_MOST; taken += full) {
        uint8_t operation = cf_request_foe(c, &(cf_foe_t){CF_FOE_DATA, ++n, packet, full}, &mail, &number);
        if (operation == CF_FOE_ERROR)
            return taken;
        cf_expect_that(c, operation == CF_FOE_ACK, "packet %u: expected an acknowledge or an error, got operation %u",
                       n, operation);
    }
    cf_send_foe(c, &(cf_foe_t){CF_FOE_ERROR, ECT_FOE_UNDEFINED, NULL, 0}); /* the master aborts the transfer */
    cf_sleep_ms(c, 20);
    return taken;
}

static void written(cf_t *c, size_t size)
{
    cf_keep_file(c, content(c), size);
    unsigned int sizes = write_sizes(c);
    packet_jump(c);
    size_t taken = without_end(c);
    if (cf_mail_waits(c)) { /* a reply to the error, which requires none */
        cf_mail_t mail;
        (void)cf_receive_mail(c, &mail, CF_MAIL_MS);
    }
    cf_note(c, "%u of 6 lengths written and read back; %zu bytes accepted of an endless file%s", sizes, taken,
            taken >= ENDLESS_MOST ? " and more" : "");
}

static void known_file(cf_t *c)
{
    size_t size = 0, in_boot = 0;
    uint8_t state = foe_state(c, CF_PREOP, ECT_FOE_BOOT_ONLY, &size);
    if ((c->facts.has & CF_BOOTSTRAP) != 0 && foe_state(c, CF_BOOT, ECT_FOE_NOT_IN_BOOT, &in_boot) != 0 && state == 0) {
        state = CF_BOOT;
        size = in_boot;
    }
    cf_expect_that(c, state != 0, "'%s': expected to be read in PREOP%s, got errors", c->file,
                   (c->facts.has & CF_BOOTSTRAP) != 0 ? " or BOOT" : "");
    cf_go(c, CF_INIT);
    cf_go(c, state);
    cf_step(c, "the file once more");
    expect_content(c, content(c), size);
    wrong_password(c);
    wrong_acknowledge(c);
    cf_step(c, "and the file again");
    expect_content(c, content(c), size);
    cf_note(c, "%zu bytes read; written with --destructive only", size);
    if (c->destructive)
        written(c, size);
}

static void files(cf_t *c)
{
    cf_go(c, (c->facts.has & CF_BOOTSTRAP) != 0 ? CF_BOOT : CF_PREOP);
    refusals(c);
    cf_note(c, "refusals only; name a file to read with --file");
    if (c->file)
        known_file(c);
}

/* --- others ------------------------------------------------------------------------------------------------------- */

/* A request of an unsupported protocol must be refused, and the mailbox must continue. */
static void not_offered(cf_t *c)
{
    static const struct {
        uint8_t type, bit;
    } others[] = {{CF_MBX_AOE, CF_PROTO_AOE}, {CF_MBX_SOE, CF_PROTO_SOE}, {CF_MBX_VOE, CF_PROTO_VOE}};
    const uint8_t nothing[8] = {0};
    unsigned int tried = 0;
    cf_go(c, CF_PREOP);
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++) {
        if ((c->facts.protocols & others[i].bit) != 0)
            continue;
        cf_step(c, "mailbox type %u", others[i].type);
        cf_send_mail(c, others[i].type, nothing, sizeof nothing);
        cf_expect_mail_error(c, ERROR_PROTOCOL);
        tried++;
    }
    if (tried == 0)
        cf_skip(c, "the slave supports all of them");
}

static const cf_case_t cases[] = {
    {"CF-084", "FoE: files are read and written completely; wrong names, passwords, packets are refused", 'F',
     CF_MAILBOX | CF_FOE, 60000, files},
    {"CF-085",
     "EoE: address and filter are reported; fragmented frames of any length pass, incomplete ones are dropped", 'F',
     CF_MAILBOX | CF_EOE, 60000, cf_ethernet},
    {"CF-E01", "EoE: IP parameters are accepted and reported, packed and in the full layout", 'R', CF_MAILBOX | CF_EOE,
     0, cf_eoe_parameters},
    {"CF-E02", "EoE: frames of each length pass completely, in both directions", 'R', CF_MAILBOX | CF_EOE, 120000,
     cf_eoe_lengths},
    {"CF-E03", "EoE: a gap, an overlap, a wrong number or size, or 1540 bytes affect only the present frame", 'R',
     CF_MAILBOX | CF_EOE, 60000, cf_eoe_wrong_fragments},
    {"CF-E04", "EoE: time stamps, repeated mails and the counter 0 neither lose nor duplicate a frame", 'R',
     CF_MAILBOX | CF_EOE, 60000, cf_eoe_repeats},
    {"CF-E05", "EoE: truncated IP parameters are refused and change nothing", 'R', CF_MAILBOX | CF_EOE, 0,
     cf_eoe_short_parameters},
    {"CF-E06", "EoE: SOEM and IgH set an address and read it back, in the order in which it is printed", 'F',
     CF_MAILBOX | CF_EOE | CF_SII, 60000, cf_eoe_masters},
    {"CF-E07", "EoE: SDOs between fragments do not affect frames, and frames of the slave do not delay SDOs", 'R',
     CF_MAILBOX | CF_EOE | CF_COE, 60000, cf_eoe_beside_sdo},
    {"CF-E08", "EoE: INIT discards incomplete frames of both directions; BOOT refuses EoE", 'R', CF_MAILBOX | CF_EOE,
     60000, cf_eoe_restart},
    {"CF-E09", "EoE: each ping returns whole, also after a master has fetched nothing for 10 s", 'F',
     CF_MAILBOX | CF_EOE, 120000, cf_eoe_pings},
    {"CF-E10", "EoE: random fragments change nothing, and the next good frame passes", 'R', CF_MAILBOX | CF_EOE, 120000,
     cf_eoe_random},
    {"CF-E11", "EoE: SII word 0x1C, the General category and the ESI agree; both mailboxes have 42 bytes", 'S',
     CF_MAILBOX | CF_SII, 0, cf_eoe_described},
    {"CF-E12", "EoE: reserved types and unknown ports are refused, replies without a request are ignored", 'R',
     CF_MAILBOX | CF_EOE, 0, cf_eoe_unsupported},
    {"CF-A01", "AoE: state, device information and identity are read", 'R', CF_MAILBOX, 0, cf_ads_reads},
    {"CF-A02", "AoE: unknown groups, objects and commands, and wrong lengths are refused", 'R', CF_MAILBOX, 0,
     cf_ads_refusals},
    {"CF-S01", "SoE: unknown IDNs, no elements and malformed mails are refused", 'R', CF_MAILBOX, 0, cf_soe_refusals},
    {"CF-S02", "SoE: each IDN of S-0-0017 has its elements, alone and together", 'R', CF_MAILBOX, 60000,
     cf_soe_elements},
    {"CF-S03", "SoE: writes of a wrong length or beyond the limits are refused, and the value stays", 'R', CF_MAILBOX,
     0, cf_soe_writes},
    {"CF-S04", "SoE: the drives of the SII reply, the others are refused", 'R', CF_MAILBOX | CF_SII, 0, cf_soe_drives},
    {"CF-S05", "SoE: replies and writes in pieces", 'R', CF_MAILBOX, 60000, cf_soe_pieces},
    {"CF-S06", "SoE: S-0-0016 and S-0-0024 give the sizes of the process data", 'F', CF_MAILBOX, 0,
     cf_soe_process_data},
    {"CF-086", "AoE, SoE and VoE get a mailbox error if not supported", 'R', CF_MAILBOX, 0, not_offered},
};

CF_SECTION(cf_mailbox, 'H', "Other mailbox protocols", cases);
