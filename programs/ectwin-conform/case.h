/* SPDX-License-Identifier: MIT */
/**
 * @file
 * How to write a case of ectwin-conform. This header is all that a case needs to include.
 *
 * A case is one function and one line in the table of its section:
 *
 *     static void full_mailbox_refuses(cf_t *c)
 *     {
 *         uint8_t mail[CF_MAX_MAIL] = {0};
 *         cf_go(c, CF_PREOP);
 *         cf_step(c, "all of a mail but its last byte");
 *         cf_expect_wkc(c, "the write", 1, cf_write(c, c->mailbox.out_start, mail, c->mailbox.out_size - 1u));
 *         cf_expect_bits(c, "status of SM0", ECT_SM_STATUS_FULL, 0, cf_get8(c, CF_SM(0) + ECT_SM_STATUS));
 *     }
 *
 *     {"CF-016", "A mailbox takes one mail and is full with its last byte", 'R', CF_MAILBOX, 0, full_mailbox_refuses},
 *
 * The functions and the table of a section stand in cases_SECTION.c, which ends with CF_SECTION; catalogue.c names the
 * section. `ectwin with DEVICE -- ectwin-conform -i {} --only CF-016` runs one case.
 *
 * What the engine does around it: before the function runs, the slave is in INIT without an error, its SyncManagers,
 * FMMUs, watchdogs, event masks and clocks are as after power-on, and its EEPROM belongs to the master
 * (::cf_known_state). The same is done after it, whatever happened; what it changed for good by ::cf_change or
 * ::cf_sii_write is put back before. A case whose needs the slave does not meet is
 * skipped with the reason; its function does not run.
 *
 * How a case ends: by returning (pass, or warn when ::cf_warn was called), or at the first step or expectation that
 * does not hold. Those do not return then: they leave the function by longjmp. So a case owns nothing that would have
 * to be given back (no heap, no files), and a local variable that it changes after a step is not looked at by anybody.
 * The same way leads out at the end of the time limit, when the slave no longer answers, and on Ctrl-C.
 *
 * What a case may assume of the slave: what cf_facts_t says, found at the start of the run, and the standard. Nothing
 * of any product, nothing of our twins. What only some chips do is asked from the feature word (0x0008) or skipped with
 * the reason. A case never judges how fast a slave is, but against a limit of the standard or of its ESI: it waits with
 * the *_wait_* steps, which return as soon as it is there.
 *
 * Races: a slave's software may act between any two frames, a chip between none. What has to be seen before the
 * software acts is sent as several datagrams of one frame (::cf_exchange), or tried on a SyncManager that the software
 * leaves alone (::cf_spare_sm). Twenty runs must give the same verdicts, on a loaded machine too.
 *
 * Evidence is free: each frame that leaves or comes is recorded with its number; ::cf_step puts a sentence between
 * them. Write expectations as `what` ("WKC of the second write"), expected and got; the rest of the sentence is theirs.
 *
 * Addresses are byte addresses of the chip, numbers those of the host (wire/bytes.h for what stands in buffers), times
 * milliseconds. Context: one thread. Clauses: ETG.1000.4, ETG.1000.6, ESC data sheets I and II.
 */
#ifndef ECTWIN_CONFORM_CASE_H
#define ECTWIN_CONFORM_CASE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "port.h"
#include "seams/device.h"
#include "wire/bytes.h"
#include "wire/registers.h"

/** States of AL control and AL status. */
enum { CF_INIT = 1, CF_PREOP = 2, CF_BOOT = 3, CF_SAFEOP = 4, CF_OP = 8 };

/** Datagram commands. */
enum {
    CF_NOP,
    CF_APRD,
    CF_APWR,
    CF_APRW,
    CF_FPRD,
    CF_FPWR,
    CF_FPRW,
    CF_BRD,
    CF_BWR,
    CF_BRW,
    CF_LRD,
    CF_LWR,
    CF_LRW,
    CF_ARMW,
    CF_FRMW,
};

/** Mailbox types, and their bits in SII word 0x1C. */
enum {
    CF_MBX_ERROR = 0,
    CF_MBX_AOE = 1,
    CF_MBX_EOE = 2,
    CF_MBX_COE = 3,
    CF_MBX_FOE = 4,
    CF_MBX_SOE = 5,
    CF_MBX_VOE = 15
};
enum {
    CF_PROTO_AOE = 0x01,
    CF_PROTO_EOE = 0x02,
    CF_PROTO_COE = 0x04,
    CF_PROTO_FOE = 0x08,
    CF_PROTO_SOE = 0x10,
    CF_PROTO_VOE = 0x20
};

enum { CF_MAX_DATA = 1486, CF_MAX_MAIL = 1486, CF_MAX_SMS = 16, CF_MAX_FMMUS = 16, CF_MAX_FRAME = 1514 };

/**
 * What a case needs. Beside the SII's word for it, a service counts as offered when it answers; advertised and dead is
 * then the case's failure, not its skip.
 */
enum {
    CF_MAILBOX = 1u << 0,      /**< a mailbox: SyncManagers 0 and 1 */
    CF_COE = 1u << 1,          /**< CANopen over EtherCAT */
    CF_SDO_INFO = 1u << 2,     /**< CoE's information service */
    CF_COMPLETE = 1u << 3,     /**< Complete Access */
    CF_FOE = 1u << 4,          /**< file access */
    CF_EOE = 1u << 5,          /**< Ethernet */
    CF_BOOTSTRAP = 1u << 6,    /**< BOOT: bootstrap mailboxes and FoE in the SII */
    CF_DC = 1u << 7,           /**< distributed clocks, beyond receive times */
    CF_OUTPUTS = 1u << 8,      /**< process data from the master */
    CF_INPUTS = 1u << 9,       /**< process data to the master */
    CF_APPLICATION = 1u << 10, /**< software behind the chip: no device emulation */
    CF_EMULATION = 1u << 11,   /**< device emulation: AL status mirrors AL control */
    CF_CHAIN = 1u << 12,       /**< at least one more slave on the segment */
    CF_RW = 1u << 13,          /**< the chip offers APRW, FPRW, BRW */
    CF_LRW_OK = 1u << 14,      /**< the chip offers LRW */
    CF_SII = 1u << 15,         /**< an EEPROM with a readable image */
    CF_WRITES_SII = 1u << 16,  /**< the user allows what writes the EEPROM (--destructive); put back what was there */
    CF_ESI = 1u << 17,         /**< the user names its ESI file (--esi) */
    CF_REAL_TIME = 1u << 18,   /**< time that passes for the slave as for the master: not with --emulated */
    CF_NEEDS_COUNT = 19,

    /* Not of the slave but of the user: who does not ask for such a case does not see it. */
    CF_STRESS = 1u << 24, /**< --stress */
    CF_FUZZ = 1u << 25,   /**< --fuzz */
    CF_TIMING = 1u << 26, /**< --timing */
    CF_ON_REQUEST = CF_STRESS | CF_FUZZ | CF_TIMING,
};

/** A SyncManager as the SII describes it, with the length that is in force for process data. */
typedef struct cf_sm {
    uint16_t start;
    uint16_t length; /**< of process data: from the mapping (CoE, else SII); 0 nothing mapped */
    uint8_t control;
    uint8_t enable; /**< bit 0: to be enabled */
    uint8_t type;   /**< ECT_SM_OUTPUTS etc. (seams/device.h), as in 1C00h */
} cf_sm_t;

typedef struct cf_mailbox {
    uint16_t out_start, out_size; /**< master to slave, SM0 */
    uint16_t in_start, in_size;   /**< slave to master, SM1 */
} cf_mailbox_t;

/** What was found out about the slave before the first case. Constant during the run. */
typedef struct cf_facts {
    uint32_t has;      /**< of the bits above */
    uint16_t slaves;   /**< on the segment */
    uint16_t position; /**< of this one, from 0 */
    uint16_t station;  /**< the address that the runner gave it; that at position n has CF_STATION + n */
    uint16_t ring;     /**< the ADP with which an AP* datagram reaches it: -position */
    uint8_t type, revision;
    uint16_t build;
    uint8_t fmmus, sms, ram_kb, ports;
    uint16_t features;
    uint16_t pdi; /**< 0x0140 */
    uint32_t vendor, product, revision_no, serial;
    uint16_t alias;     /**< SII word 4 */
    uint16_t protocols; /**< SII word 0x1C */
    cf_mailbox_t boot;  /**< sizes 0: none */
    uint8_t coe_details;
    char name[64]; /**< from the SII's strings or 1008h; "" none */
    cf_sm_t sm[CF_MAX_SMS];
    uint8_t sm_count; /**< that the SII names (or 1C00h) */
    uint8_t fmmu_use[CF_MAX_FMMUS];
    uint8_t fmmu_count;
    uint16_t output_bytes, input_bytes; /**< over all SyncManagers */
    const uint8_t *sii;                 /**< the image, from word 0 to behind its last category */
    size_t sii_size;                    /**< bytes of it */
    uint32_t eeprom_bytes;              /**< as word 0x3E says */
} cf_facts_t;

enum { CF_STATION = 0x1001 };

/** The run, as a case sees it. The engine's part is behind `engine`. */
typedef struct cf {
    cf_facts_t facts;
    cf_mailbox_t mailbox; /**< the standard mailbox, in force from PREOP on */
    bool destructive;     /**< --destructive was given */
    bool whole;           /**< --long was given: what takes long is done as long as the checklist says */
    bool emulated;        /**< --emulated was given: cases of CF_REAL_TIME are skipped */
    const char *power;    /**< --power: the command that switches the slave off and on; NULL: there is none */
    const char *file;     /**< --file: one that may be read by FoE; NULL: none is known */
    uint32_t password;    /**< --password: for it */
    uint32_t seconds;     /**< that --stress or --fuzz takes */
    uint64_t random;      /**< state of ::cf_random, from --seed; begins anew with each case */
    uint8_t mail_counter; /**< of the last mail sent, 1..7; 0 none yet */
    struct cf_esi *esi;   /**< what esi.h compares with; NULL: the user named no file */
    struct cf_engine *engine;
} cf_t;

/** A case: a line in the table of its section. */
typedef struct cf_case {
    const char *id;    /**< "CF-016" */
    const char *title; /**< what must hold, as a sentence without a full stop */
    char class;        /**< 'F' a plain master shows it, 'R' raw datagrams, 'S' static, 'T' measured time */
    uint32_t needs;
    uint32_t limit_ms; /**< 0: CF_LIMIT_MS */
    void (*run)(cf_t *c);
} cf_case_t;

enum { CF_LIMIT_MS = 20000 };

/** A section of the checklist, in a file of its own, named in catalogue.c. */
typedef struct cf_section {
    char letter;
    const char *title;
    const cf_case_t *cases;
    size_t count;
} cf_section_t;

#define CF_SECTION(symbol, its_letter, its_title, its_cases)                                                           \
    const cf_section_t symbol = {its_letter, its_title, its_cases, sizeof(its_cases) / sizeof((its_cases)[0])}

/* --- verdicts ----------------------------------------------------------------------------------------------------- */

#define CF_PRINTF(text, first) __attribute__((format(printf, text, first)))

/** Ends the case: fail. The sentence says what was expected and what was got. */
_Noreturn void cf_fail(cf_t *c, const char *format, ...) CF_PRINTF(2, 3);
/** Ends the case: skip. The sentence says why it cannot be judged on this slave. */
_Noreturn void cf_skip(cf_t *c, const char *format, ...) CF_PRINTF(2, 3);
/** Goes on, but the verdict will be warn (unless fail): allowed, and yet worth a word. The first one is kept. */
void cf_warn(cf_t *c, const char *format, ...) CF_PRINTF(2, 3);
/** Goes on; the sentence stands with a passed verdict, e.g. what was measured. The last one is kept. */
void cf_note(cf_t *c, const char *format, ...) CF_PRINTF(2, 3);
/** Says in the evidence, and in the capture, what the next frames are for. */
void cf_step(cf_t *c, const char *format, ...) CF_PRINTF(2, 3);
/** The same for what was found: a failure is told with the last step, not with a remark. */
void cf_remark(cf_t *c, const char *format, ...) CF_PRINTF(2, 3);

/** "`what`: expected 0x0016, got 0x0000". Both are printed as hexadecimal of the digits that the larger one needs. */
void cf_expect(cf_t *c, const char *what, uint64_t expected, uint64_t got);
/** Only the bits of `mask` are compared. */
void cf_expect_bits(cf_t *c, const char *what, uint64_t mask, uint64_t expected, uint64_t got);
/** A number that a reader counts in tens: lengths, counters. minimum..maximum inclusive. */
void cf_expect_range(cf_t *c, const char *what, uint64_t minimum, uint64_t maximum, uint64_t got);
/** A working counter: "WKC of `what`: expected 1, got 0". */
void cf_expect_wkc(cf_t *c, const char *what, unsigned int expected, unsigned int got);
void cf_expect_bytes(cf_t *c, const char *what, const void *expected, const void *got, size_t length);
/** Anything else: the sentence, with expected and got in it, when `holds` is false. */
void cf_expect_that(cf_t *c, bool holds, const char *format, ...) CF_PRINTF(3, 4);

/* --- datagrams ---------------------------------------------------------------------------------------------------- */

#define CF_AT(adp, ado) ((uint32_t)(uint16_t)(adp) | ((uint32_t)(uint16_t)(ado) << 16))

/**
 * Sends datagrams in one frame and waits for it. Leaves the case when the frame does not come back; it is sent once.
 * @param d  `count` (1..15) datagrams, CF_MAX_FRAME bytes together with their headers at most
 */
void cf_exchange(cf_t *c, cf_datagram_t *d, size_t count);
/**
 * Sends any Ethernet frame as it is, with a plain datagram behind it, and waits for the latter: a wire keeps the order,
 * so what has not come back by then does not come.
 * @param reply   CF_MAX_FRAME bytes; NULL: the answer's bytes are not wanted
 * @return length of the answer, 0: the frame was not answered
 */
size_t cf_raw_frame(cf_t *c, const void *frame, size_t length, uint8_t *reply);
/** One datagram. @return its working counter */
uint16_t cf_command(cf_t *c, uint8_t command, uint16_t adp, uint16_t ado, void *data, uint16_t length);
uint16_t cf_logical(cf_t *c, uint8_t command, uint32_t address, void *data, uint16_t length);

/** FPRD and FPWR of the slave under test. @return the working counter */
uint16_t cf_read(cf_t *c, uint16_t address, void *data, size_t length);
uint16_t cf_write(cf_t *c, uint16_t address, const void *data, size_t length);
/** The same for a value; a working counter other than 1 ends the case. */
uint8_t cf_get8(cf_t *c, uint16_t address);
uint16_t cf_get16(cf_t *c, uint16_t address);
uint32_t cf_get32(cf_t *c, uint16_t address);
uint64_t cf_get64(cf_t *c, uint16_t address);
void cf_put8(cf_t *c, uint16_t address, uint8_t value);
void cf_put16(cf_t *c, uint16_t address, uint16_t value);
void cf_put32(cf_t *c, uint16_t address, uint32_t value);
void cf_put64(cf_t *c, uint16_t address, uint64_t value);
/** Leaves the case when WKC is not 1. For blocks. */
void cf_get(cf_t *c, uint16_t address, void *data, size_t length);
void cf_put(cf_t *c, uint16_t address, const void *data, size_t length);

/* --- time --------------------------------------------------------------------------------------------------------- */

/** The next number of the case's sequence, 0..limit - 1. The same seed gives the same sequence. */
uint32_t cf_random(cf_t *c, uint32_t limit);
/**
 * Lets every waiting step call a function each time that it looks, e.g. for process data that go on. NULL: no longer;
 * so it is at the beginning of a case.
 */
void cf_while_waiting(cf_t *c, void (*look)(cf_t *c, void *ctx), void *ctx);
/** Adds a value to a histogram of the report. @param series  constant text; at most CF_SERIES_MOST different ones */
void cf_measure(cf_t *c, const char *series, uint64_t ns);
enum { CF_SERIES_MOST = 16 };
/** Waits; leaves the case at its time limit and on Ctrl-C. */
void cf_sleep_ms(cf_t *c, uint32_t ms);
/** Reads a byte until (value & mask) == wanted. @return whether that came within `ms`; *last: the last value */
bool cf_wait_bits(cf_t *c, uint16_t address, uint8_t mask, uint8_t wanted, uint32_t ms, uint8_t *last);

/** Gives the case so much more time. For one that takes longer when the user wants it (--long). */
void cf_extend(cf_t *c, uint32_t ms);

/* --- a slave that goes and comes ---------------------------------------------------------------------------------- */

/**
 * Cuts the slave off the wire for a while, as if its plug were pulled: by the port of the slave before it, or, when it
 * is the first one, by taking this PC's interface down. Leaves the case when the slave is not found again.
 * @param[out] why  when it cannot be done here: constant text, nothing has happened
 * @return whether it was done
 */
bool cf_pull_plug(cf_t *c, uint32_t ms, const char **why);
/**
 * Switches the slave off and on with the user's command (--power) and gives it its station address again. Leaves the
 * case when the command fails or the slave is not found again; so does a slave that still has its address.
 */
void cf_power_cycle(cf_t *c);
/** How long a slave may take from power-on or a link until it answers. */
enum { CF_FOUND_MS = 30000 };

/* --- SyncManagers and FMMUs --------------------------------------------------------------------------------------- */

#define CF_SM(n)   ((uint16_t)(ECT_REG_SM + ECT_SM_SIZE * (n)))
#define CF_FMMU(n) ((uint16_t)(ECT_REG_FMMU + ECT_FMMU_SIZE * (n)))

/** Writes a SyncManager's eight registers and enables it, or (length 0) clears and disables it. */
void cf_set_sm(cf_t *c, unsigned int n, uint16_t start, uint16_t length, uint8_t control);
/** Writes and enables FMMU `n`. @param type 1 read, 2 write, 3 both. Bits as in the registers. */
void cf_set_fmmu(cf_t *c, unsigned int n, uint32_t logical, uint16_t length, uint8_t start_bit, uint8_t stop_bit,
                 uint16_t physical, uint8_t physical_bit, uint8_t type);
void cf_clear_fmmu(cf_t *c, unsigned int n);
/**
 * A SyncManager that the slave's software leaves alone in INIT, for trying the chip itself. Skips the case when there
 * is none. It works on CF_SPARE_BYTES bytes (3 times that for three buffers) from ::cf_spare_ram.
 */
unsigned int cf_spare_sm(cf_t *c);
enum { CF_SPARE_BYTES = 16 };
/** Process RAM that is free in INIT: 3 * CF_SPARE_BYTES bytes and some. */
uint16_t cf_spare_ram(const cf_t *c);

/* --- states ------------------------------------------------------------------------------------------------------- */

/**
 * Takes the slave to a state the ordinary way, as a master does, from wherever it is: SM0 and SM1 before PREOP, process
 * data SyncManagers and FMMUs before SAFEOP, process data while it goes to OP. A refusal ends the case.
 */
void cf_go(cf_t *c, uint8_t state);
/**
 * Configures what ::cf_go would before PREOP (or BOOT), before SAFEOP; requests nothing. The process data watchdog gets
 * 6 s: a case has pauses that a controller has not. One that is about the watchdog sets its time after ::cf_go.
 */
void cf_set_mailbox(cf_t *c, uint8_t state);
void cf_set_process_data(cf_t *c);

/**
 * Writes AL control and waits until the slave has answered: the state is the one requested, or the error flag came, or
 * the time of the standard for that transition is over.
 * @param[out] code  AL status code, read after; may be NULL
 * @return AL status
 */
uint16_t cf_request(cf_t *c, uint16_t al_control, uint16_t *code);
/** ::cf_request, and the answer must be `stays` with the error flag and that code. */
void cf_expect_refused(cf_t *c, uint16_t al_control, uint8_t stays, uint16_t code);
/** ::cf_request, and the answer must be that state without an error, code 0. */
void cf_expect_state(cf_t *c, uint16_t al_control, uint8_t state);
/** Waits, with process data going when `cyclic`, until AL status is `status`. @return whether it came */
bool cf_wait_status(cf_t *c, uint16_t status, uint32_t ms, bool cyclic, uint16_t *last, uint16_t *code);
/** "PREOP", "SAFEOP + error" for a message. The text is constant. */
const char *cf_state_name(uint16_t al_status);

/** One exchange of process data by LRW (LWR and LRD where the chip lacks it). @return working counter */
uint16_t cf_cycle(cf_t *c, const uint8_t *outputs, uint8_t *inputs);
/** What ::cf_cycle returns when all is well. */
uint16_t cf_cycle_wkc(const cf_t *c);

/**
 * The state before each case. Leaves the case when the slave does not get there within the time of the standard.
 */
void cf_known_state(cf_t *c);

/* --- mailbox ------------------------------------------------------------------------------------------------------ */

typedef struct cf_mail {
    uint16_t length; /**< of `data`, as the header says */
    uint16_t address;
    uint8_t channel; /**< byte 4 */
    uint8_t type;
    uint8_t counter; /**< 0..7 */
    uint8_t data[CF_MAX_MAIL];
} cf_mail_t;

/**
 * Puts a mail into SM0 with the next counter (1..7), waiting while it is full; leaves the case when that lasts.
 * @param data  what follows the header; `length` may be anything that fits the mailbox
 */
void cf_send_mail(cf_t *c, uint8_t type, const void *data, uint16_t length);
/** The same with a header as the case wants it: all mailbox bytes. @param length 1..out_size, the rest is zero */
void cf_send_raw_mail(cf_t *c, const void *mail, uint16_t length);
/** @return whether a mail came within `ms`; any mail */
bool cf_receive_mail(cf_t *c, cf_mail_t *mail, uint32_t ms);
/** The next mail of that type, emergencies left aside; leaves the case when none comes in the standard's time. */
void cf_receive(cf_t *c, uint8_t type, cf_mail_t *mail);
/** A mailbox error with that detail must be the next mail. */
void cf_expect_mail_error(cf_t *c, uint16_t detail);
/** Whether SM1 holds a mail. */
bool cf_mail_waits(cf_t *c);
/** Nothing may come within that time (a slave that would be slower passes). */
void cf_expect_no_mail(cf_t *c, uint32_t ms);

enum { CF_MAIL_MS = 2000 }; /**< in which a slave answers a mail (ETG.2000: ResponseTimeout) */

/* --- CoE ---------------------------------------------------------------------------------------------------------- */

enum { CF_COE_EMERGENCY = 1, CF_COE_REQUEST = 2, CF_COE_RESPONSE = 3, CF_COE_INFO = 8 };

/** A CoE request of one SDO header: command, index, sub-index, four bytes of data. */
void cf_send_sdo(cf_t *c, uint8_t command, uint16_t index, uint8_t sub, uint32_t value);
/** Any CoE message: `data` follows the CoE header. */
void cf_send_coe(cf_t *c, uint8_t service, const void *data, uint16_t length);
/** The next CoE mail that is no emergency; data[2] is the SDO command byte. */
void cf_receive_coe(cf_t *c, cf_mail_t *mail);
/** The next CoE mail must be an abort of that object with that code, byte for byte. */
void cf_expect_abort(cf_t *c, uint16_t index, uint8_t sub, uint32_t code);

/**
 * Whole transfers, however long: expedited, normal, segmented. The protocol is checked on the way; what is wrong with
 * it ends the case. @return 0, or the abort code.
 * @param[in,out] size  room in, bytes out; more than fits ends the case
 */
uint32_t cf_upload(cf_t *c, uint16_t index, uint8_t sub, bool complete, void *data, size_t *size);
uint32_t cf_download(cf_t *c, uint16_t index, uint8_t sub, bool complete, const void *data, size_t size);
/**
 * A download that outlives the case: what was there is uploaded before and downloaded again, in PREOP and in the
 * reverse order of the changes, after the case, whatever happened. Values that the slave keeps over INIT are written
 * this way.
 * @param size  1..CF_CHANGE_MOST, as what is there. @return 0, or the abort code of the upload or the download
 */
uint32_t cf_change(cf_t *c, uint16_t index, uint8_t sub, const void *data, size_t size);
enum { CF_CHANGE_MOST = 64 };
/** A number of 1..8 bytes. An abort ends the case. */
uint64_t cf_upload_number(cf_t *c, uint16_t index, uint8_t sub);
/** Whether the object answers an upload, whatever the value; *code gets the abort code. */
bool cf_object_exists(cf_t *c, uint16_t index, uint8_t sub, uint32_t *code);

/**
 * The information service: what a request's fragments hold after their headers, put together.
 * @return bytes, or -1 with *code set when the slave answered with an info error
 */
int cf_info(cf_t *c, uint8_t opcode, const void *request, uint16_t request_length, void *data, size_t room,
            uint32_t *code);
/** List 1 of the information service. @return how many indices; at most `room` */
size_t cf_object_list(cf_t *c, uint16_t type, uint16_t *indices, size_t room);

/* --- FoE ---------------------------------------------------------------------------------------------------------- */

enum { CF_FOE_READ = 1, CF_FOE_WRITE = 2, CF_FOE_DATA = 3, CF_FOE_ACK = 4, CF_FOE_ERROR = 5, CF_FOE_BUSY = 6 };
enum { CF_FOE_HEADER = 6 };
enum { CF_FOE_LATER_MS = 10000, CF_FILE_MOST = 4 * 1024 * 1024 };

/** One FoE mail: operation, its number (of a packet, an error, a password), and `length` bytes that follow. */
typedef struct cf_foe {
    uint8_t operation;
    uint32_t number;
    const void *data;
    uint16_t length;
} cf_foe_t;

/** The mail that asks to read (CF_FOE_READ) or to write (CF_FOE_WRITE) --file. */
cf_foe_t cf_foe_open(const cf_t *c, uint8_t operation, uint32_t password);
/** Sends one that nothing answers. */
void cf_send_foe(cf_t *c, const cf_foe_t *sent);
/**
 * Sends one and waits for the answer; sends it again, after a pause, as long as that is BUSY: it was not taken then.
 * @return the operation of the answer; *number its number, `mail->data + CF_FOE_HEADER` what follows
 */
uint8_t cf_ask_foe(cf_t *c, const cf_foe_t *sent, cf_mail_t *mail, uint32_t *number);
/** Bytes of a full packet to the slave (`write`) or from it, in the AL state that it is in. */
uint16_t cf_foe_full(cf_t *c, bool write);
/**
 * Whole transfers of --file with a password. The protocol is checked on the way; what is wrong with it ends the case.
 * @return 0, or the error code of the slave
 * @param[in,out] size  room in, bytes out; more than fits ends the case
 */
uint32_t cf_read_file(cf_t *c, uint32_t password, void *data, size_t *size);
uint32_t cf_write_file(cf_t *c, uint32_t password, const void *data, size_t size);
/**
 * From here on the case may write the file: this content is written again after the case, in the AL state that the
 * slave is in now. @param data  copied
 */
void cf_keep_file(cf_t *c, const void *data, size_t size);

/* --- SII ---------------------------------------------------------------------------------------------------------- */

/** Reads from the EEPROM over its registers, 4 or 8 bytes as the chip has it. @return bytes that came: 4 or 8 */
unsigned int cf_sii_read(cf_t *c, uint16_t word, uint8_t data[8]);
/** Writes one word; what was there is put back after the case. Only in a case that needs CF_WRITES_SII. */
void cf_sii_write(cf_t *c, uint16_t word, uint16_t value);
/** Waits for the end of a command. @return the control and status word (0x0502) */
uint16_t cf_sii_wait(cf_t *c);
/** A category of the image in the facts. @return its data, NULL: there is none; *length in bytes */
const uint8_t *cf_sii_category(const cf_t *c, uint16_t category, size_t *length);
/** The same for the nth of several of that type, from 0: some images have one for each PDO. */
const uint8_t *cf_sii_block(const cf_t *c, uint16_t category, unsigned int nth, size_t *length);

#endif
