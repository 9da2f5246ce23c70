/* SPDX-License-Identifier: MIT */
/**
 * @file
 * How to write a case of ectwin-conform. A case includes this header only, as "steps/case.h".
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
 * A new case has four places:
 *   1. cases/SECTION.c: the function, and a line in the table, with an id that no other case has. Ids are unique, not
 *      ascending: a case belongs to its section. A new section ends with CF_SECTION and is named in catalogue.c.
 *   2. programs/ectwin/defects.c: a defect with the same id (`ectwin run --break CF-nnn`), which the case finds.
 *   3. tests/integration/conform.py: FOLLOW names the other cases that find the defect, DEFECT_TWINS the twin that has
 *      the defect when an fzm1 cannot.
 *   4. docs/conformance.md: the table, written by `tests/integration/conform.py devices ECTWIN CONFORM --write`.
 * `ectwin with DEVICE -- ectwin-conform -i {} --only CF-016` runs one case.
 *
 * State of the slave at the start of a case: INIT without an error; SyncManagers, FMMUs, watchdogs, event masks and
 * clocks as after power-on; the EEPROM assigned to the master (::cf_known_state). The runner restores this state after
 * the case, and before that undoes the lasting changes made by ::cf_change, ::cf_keep and ::cf_sii_write. A case with
 * needs that the slave does not meet is skipped with the reason; its function does not run.
 *
 * End of a case: the function returns (pass, or warn after ::cf_warn), or a step or an expectation does not hold. The
 * step then leaves the function by longjmp. So a case owns nothing that it would have to release (no heap, no files),
 * and no code reads a local variable that the function changed after a step. The same way out serves the time limit,
 * a slave that no longer replies, and Ctrl-C.
 *
 * Knowledge of the slave: cf_facts_t, collected at the start of the run, and the standard. A case knows no product and
 * no twin. A feature that only some chips have is read from the feature word (0x0008), or the case is skipped with the
 * reason. A case measures a slave's speed only against a limit of the standard or of its ESI: the *_wait_* steps return
 * as soon as the condition holds.
 *
 * Races: a slave's software may act between any two frames, a chip between none. Observations that must precede the
 * software travel as several datagrams of one frame (::cf_exchange), or use a SyncManager that the software does not
 * touch (::cf_spare_sm). A SyncManager of a real chip changes its status at the end of the frame: read the status in
 * the next frame. Twenty runs must give the same verdicts, on a loaded machine too.
 *
 * Evidence: every frame is recorded with its number; ::cf_step puts a sentence between frames. The `what` of an
 * expectation is a noun ("WKC of the second write"); the expectation adds the expected and the actual value.
 *
 * Addresses are byte addresses of the chip; numbers have the host's byte order (wire/bytes.h for buffers); times are
 * milliseconds. Context: one thread. Clauses: ETG.1000.4, ETG.1000.6, ESC data sheets I and II.
 */
#ifndef ECTWIN_CONFORM_CASE_H
#define ECTWIN_CONFORM_CASE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "seams/device.h"
#include "steps/port.h"
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
 * Needs of a case. A service counts as offered when the SII advertises it or when it replies: a service that is
 * advertised and dead fails its case and is not skipped.
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
    CF_WRITES_SII =
        1u << 16,      /**< the user allows writes to the EEPROM (--destructive); the runner restores the content */
    CF_ESI = 1u << 17, /**< the user names its ESI file (--esi) */
    CF_REAL_TIME = 1u << 18, /**< slave and master share real time: not with --emulated */
    CF_DRIVE = 1u << 19,     /**< an axis of CiA 402: 6040h and 6041h */
    CF_MOVE = 1u << 20,      /**< the user allows torque and motion (--move) */
    CF_NEEDS_COUNT = 21,

    /* Cases on request: not run, not listed without the option. */
    CF_STRESS = 1u << 24, /**< --stress */
    CF_FUZZ = 1u << 25,   /**< --fuzz */
    CF_TIMING = 1u << 26, /**< --timing */
    CF_ON_REQUEST = CF_STRESS | CF_FUZZ | CF_TIMING,
};

/** A SyncManager as the SII describes it; of process data with the length of the mapping. */
typedef struct cf_sm {
    uint16_t start;
    uint16_t length; /**< bytes; of process data from the mapping (CoE, else SII); 0 nothing mapped */
    uint8_t control;
    uint8_t enable; /**< bit 0: to be enabled */
    uint8_t type;   /**< ECT_SM_OUTPUTS etc. (seams/device.h), as in 1C00h */
} cf_sm_t;

typedef struct cf_mailbox {
    uint16_t out_start, out_size; /**< master to slave, SM0 */
    uint16_t in_start, in_size;   /**< slave to master, SM1 */
} cf_mailbox_t;

/** Facts about the slave, collected before the first case. Constant during the run. */
typedef struct cf_facts {
    uint32_t has;      /**< needs that the slave meets: bits above */
    uint16_t slaves;   /**< on the segment */
    uint16_t position; /**< of the slave under test, from 0 */
    uint16_t station;  /**< station address set by the runner: CF_STATION + position */
    uint16_t ring;     /**< ADP of an AP* datagram for this slave: -position */
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
    uint8_t sm_count; /**< SyncManagers of the SII */
    uint8_t fmmu_use[CF_MAX_FMMUS];
    uint8_t fmmu_count;
    uint16_t output_bytes, input_bytes; /**< over all SyncManagers */
    const uint8_t *sii;                 /**< image from word 0 to the end mark; owned by the run */
    size_t sii_size;                    /**< bytes of `sii` */
    uint32_t eeprom_bytes;              /**< from word 0x3E */
} cf_facts_t;

enum { CF_STATION = 0x1001 };

/** --move: limits of each motion, in the units of 607Ah, 60FFh and 6083h. */
typedef struct cf_move {
    int64_t distance; /**< from the place at the start, each way; 0: motion is not allowed */
    int64_t speed, acceleration;
} cf_move_t;

/** The run, with the members for cases. `engine` is private. */
typedef struct cf {
    cf_facts_t facts;
    cf_mailbox_t mailbox; /**< the standard mailbox, valid from PREOP on */
    bool destructive;     /**< --destructive was given */
    bool whole;           /**< --long was given: long procedures take the time of the checklist */
    bool emulated;        /**< --emulated was given: cases of CF_REAL_TIME are skipped */
    const char *power;    /**< --power: command that switches the slave off and on; NULL: none */
    const char *plug;     /**< --plug: command that pulls and reinserts the slave's plug; NULL: none */
    const char *file;     /**< --file: name of a file to read by FoE; NULL: none */
    uint32_t password;    /**< --password: FoE password of `file`; 0 none */
    cf_move_t move;       /**< --move */
    uint32_t seconds;     /**< duration of --stress and --fuzz */
    uint64_t random;      /**< state of ::cf_random; every case starts with --seed */
    uint8_t mail_counter; /**< of the last mail sent, 1..7; 0 none yet */
    struct cf_esi *esi;   /**< the ESI file (steps/esi.h); NULL: none given */
    struct cf_engine *engine;
} cf_t;

/** A case: a line in the table of its section. */
typedef struct cf_case {
    const char *id;    /**< "CF-016" */
    const char *title; /**< the requirement as a sentence without a full stop */
    char class;        /**< 'F' a plain master suffices, 'R' raw datagrams, 'S' static, 'T' measured time */
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

/** Ends the case with fail. The sentence names the expected and the actual value. */
_Noreturn void cf_fail(cf_t *c, const char *format, ...) CF_PRINTF(2, 3);
/** Ends the case with skip. The sentence names the reason why this slave cannot be judged. */
_Noreturn void cf_skip(cf_t *c, const char *format, ...) CF_PRINTF(2, 3);
/** Sets the verdict to warn (unless the case fails later) and continues: allowed, but unusual. The first warning is
 * kept. */
void cf_warn(cf_t *c, const char *format, ...) CF_PRINTF(2, 3);
/** Adds a sentence to the verdict pass, a measured value for example, and continues. The last note is kept. */
void cf_note(cf_t *c, const char *format, ...) CF_PRINTF(2, 3);
/** Writes the purpose of the next frames into the evidence and the capture. */
void cf_step(cf_t *c, const char *format, ...) CF_PRINTF(2, 3);
/** Writes an observation into the evidence and the capture. A failure names the last step, never a remark. */
void cf_remark(cf_t *c, const char *format, ...) CF_PRINTF(2, 3);

/** "`what`: expected 0x0016, got 0x0000". The larger value sets the number of hexadecimal digits of both. */
void cf_expect(cf_t *c, const char *what, uint64_t expected, uint64_t got);
/** Compares the bits of `mask` only. */
void cf_expect_bits(cf_t *c, const char *what, uint64_t mask, uint64_t expected, uint64_t got);
/** Decimal values, lengths and counters for example: minimum..maximum inclusive. */
void cf_expect_range(cf_t *c, const char *what, uint64_t minimum, uint64_t maximum, uint64_t got);
/** A working counter: "WKC of `what`: expected 1, got 0". */
void cf_expect_wkc(cf_t *c, const char *what, unsigned int expected, unsigned int got);
void cf_expect_bytes(cf_t *c, const char *what, const void *expected, const void *got, size_t length);
/** Any other condition: if `holds` is false, ends the case with the sentence, which names both values. */
void cf_expect_that(cf_t *c, bool holds, const char *format, ...) CF_PRINTF(3, 4);

/* --- datagrams ---------------------------------------------------------------------------------------------------- */

#define CF_AT(adp, ado) ((uint32_t)(uint16_t)(adp) | ((uint32_t)(uint16_t)(ado) << 16))

/**
 * Sends one frame of datagrams, once, and waits for its return. Leaves the case when the frame does not return.
 * @param d  `count` (1..15) datagrams, at most CF_MAX_FRAME bytes including headers
 */
void cf_exchange(cf_t *c, cf_datagram_t *d, size_t count);
/**
 * Sends any Ethernet frame unchanged, then a NOP, and waits for the NOP. A wire keeps the order of frames: a frame that
 * has not returned before the NOP is lost.
 * @param[out] reply  CF_MAX_FRAME bytes; NULL: the bytes of the reply are dropped
 * @return length of the reply, 0: the frame did not return
 */
size_t cf_raw_frame(cf_t *c, const void *frame, size_t length, uint8_t *reply);
/** One datagram. @return its working counter */
uint16_t cf_command(cf_t *c, uint8_t command, uint16_t adp, uint16_t ado, void *data, uint16_t length);
uint16_t cf_logical(cf_t *c, uint8_t command, uint32_t address, void *data, uint16_t length);

/** FPRD and FPWR of the slave under test. @return the working counter */
uint16_t cf_read(cf_t *c, uint16_t address, void *data, size_t length);
uint16_t cf_write(cf_t *c, uint16_t address, const void *data, size_t length);
/** Reads and writes of one value. A working counter other than 1 ends the case. */
uint8_t cf_get8(cf_t *c, uint16_t address);
uint16_t cf_get16(cf_t *c, uint16_t address);
uint32_t cf_get32(cf_t *c, uint16_t address);
uint64_t cf_get64(cf_t *c, uint16_t address);
void cf_put8(cf_t *c, uint16_t address, uint8_t value);
void cf_put16(cf_t *c, uint16_t address, uint16_t value);
void cf_put32(cf_t *c, uint16_t address, uint32_t value);
void cf_put64(cf_t *c, uint16_t address, uint64_t value);
/** Reads and writes of a block. A working counter other than 1 ends the case. */
void cf_get(cf_t *c, uint16_t address, void *data, size_t length);
void cf_put(cf_t *c, uint16_t address, const void *data, size_t length);

/* --- time --------------------------------------------------------------------------------------------------------- */

/** @return next random number of the case, 0..limit - 1. Equal seeds give equal sequences. @param limit  1..2^32 - 1 */
uint32_t cf_random(cf_t *c, uint32_t limit);
/**
 * Sets a function that every waiting step calls between two polls, for cyclic process data for example.
 * @param idle  NULL: none, the state at the start of a case
 */
void cf_while_waiting(cf_t *c, void (*idle)(cf_t *c, void *ctx), void *ctx);
/** Pauses between two polls of a wait: calls the function of ::cf_while_waiting, or sleeps 200 us. Limits the rate of
 * frames. */
void cf_poll_pause(cf_t *c);
/** Adds a value to a histogram of the report. @param series  constant text; at most CF_SERIES_MOST different ones */
void cf_measure(cf_t *c, const char *series, uint64_t ns);
enum { CF_SERIES_MOST = 16 };
/** Waits. Leaves the case at its time limit and on Ctrl-C. */
void cf_sleep_ms(cf_t *c, uint32_t ms);
/** Polls a byte until (value & mask) == wanted. @return false after `ms`; *last (may be NULL): the last value */
bool cf_wait_bits(cf_t *c, uint16_t address, uint8_t mask, uint8_t wanted, uint32_t ms, uint8_t *last);

/** Extends the time limit of the case by `ms`, for --long. */
void cf_extend(cf_t *c, uint32_t ms);

/* --- plug and power ----------------------------------------------------------------------------------------------- */

/**
 * Disconnects the slave for `ms` as a pulled plug does: closes the port of the previous slave or, for the first slave,
 * takes this PC's interface down. With --plug that command disconnects the slave, for a time of its own. Leaves the
 * case when the command fails or the slave does not return.
 * @param[out] why  on false: the reason, constant text
 * @return false: not possible here; the wire is unchanged
 */
bool cf_pull_plug(cf_t *c, uint32_t ms, const char **why);
/**
 * Switches the slave off and on with the user's command (--power) and sets its station address again. Leaves the case
 * when the command fails, the slave does not return, or the slave still has its station address.
 */
void cf_power_cycle(cf_t *c);
/** Longest time from power-on or link-up to the first reply of a slave. */
enum { CF_FOUND_MS = 30000 };

/* --- SyncManagers and FMMUs --------------------------------------------------------------------------------------- */

#define CF_SM(n)   ((uint16_t)(ECT_REG_SM + ECT_SM_SIZE * (n)))
#define CF_FMMU(n) ((uint16_t)(ECT_REG_FMMU + ECT_FMMU_SIZE * (n)))

/** Writes the eight registers of a SyncManager and enables it; length 0 clears and disables it. */
void cf_set_sm(cf_t *c, unsigned int n, uint16_t start, uint16_t length, uint8_t control);
/** Writes and enables FMMU `n`. @param type 1 read, 2 write, 3 both. Bits as in the registers. */
void cf_set_fmmu(cf_t *c, unsigned int n, uint32_t logical, uint16_t length, uint8_t start_bit, uint8_t stop_bit,
                 uint16_t physical, uint8_t physical_bit, uint8_t type);
void cf_clear_fmmu(cf_t *c, unsigned int n);
/**
 * @return a SyncManager that the slave's software does not access in INIT, for tests of the chip alone. Skips the case
 * when there is none. Use CF_SPARE_BYTES bytes (three buffers: 3 * CF_SPARE_BYTES) from ::cf_spare_ram.
 */
unsigned int cf_spare_sm(cf_t *c);
enum { CF_SPARE_BYTES = 16 };
/** @return address of process RAM that is free in INIT, at least 3 * CF_SPARE_BYTES bytes */
uint16_t cf_spare_ram(const cf_t *c);

/* --- states ------------------------------------------------------------------------------------------------------- */

/**
 * Takes the slave from any state to `state` as a master does: SM0 and SM1 before PREOP, process data SyncManagers and
 * FMMUs before SAFEOP, cyclic process data during the change to OP. A refusal ends the case.
 */
void cf_go(cf_t *c, uint8_t state);
/**
 * Writes the configuration of ::cf_go before PREOP (or BOOT) and before SAFEOP; requests no state. Sets the process
 * data watchdog to 6 s, because a case pauses where a controller does not. A case about the watchdog sets the watchdog
 * time after ::cf_go.
 */
void cf_set_mailbox(cf_t *c, uint8_t state);
void cf_set_process_data(cf_t *c);

/**
 * Writes AL control and waits for the reply: the requested state, the error flag, or the end of the standard's time for
 * the transition.
 * @param[out] code  AL status code, read last; may be NULL
 * @return AL status
 */
uint16_t cf_request(cf_t *c, uint16_t al_control, uint16_t *code);
/** ::cf_request; the reply must be the state `stays` with the error flag, and `code`. */
void cf_expect_refused(cf_t *c, uint16_t al_control, uint8_t stays, uint16_t code);
/** ::cf_request; the reply must be `state` without the error flag, and code 0. */
void cf_expect_state(cf_t *c, uint16_t al_control, uint8_t state);
/** Polls AL status for `status`, with process data between polls when `cyclic`. @return false after `ms` */
bool cf_wait_status(cf_t *c, uint16_t status, uint32_t ms, bool cyclic, uint16_t *last, uint16_t *code);
/** @return "PREOP", "SAFEOP + error": constant text */
const char *cf_state_name(uint16_t al_status);

/** One exchange of process data by LRW, or by LWR and LRD when the chip lacks LRW. @return working counter */
uint16_t cf_cycle(cf_t *c, const uint8_t *outputs, uint8_t *inputs);
/** Reads the inputs alone, by LRD, so that the watchdog of the outputs expires. @return working counter */
uint16_t cf_read_inputs(cf_t *c, uint8_t *inputs);
/** @return the expected working counter of a ::cf_cycle, with all process data SyncManagers active */
uint16_t cf_cycle_wkc(const cf_t *c);

/**
 * Establishes the state before each case (above). Leaves the case when the slave exceeds the time of the standard.
 */
void cf_known_state(cf_t *c);

/**
 * Lets SOEM, unmodified, configure all slaves and take the slave under test to OP with process data.
 * @param[out] what  on failure: the state that was reached
 */
bool cf_soem_to_op(cf_t *c, char *what, size_t room);
/**
 * Lets SOEM, unmodified, configure all slaves, take the slave under test to PREOP, set its IP address, and read it.
 * @param set       octets in the order in which they are printed
 * @param[out] got  the address that SOEM has read, in the same order
 * @param[out] what  on failure: the reason
 */
bool cf_soem_address(cf_t *c, const uint8_t set[4], uint8_t got[4], char *what, size_t room);

/* --- mailbox ------------------------------------------------------------------------------------------------------ */

typedef struct cf_mail {
    uint16_t length; /**< bytes of `data`, from the header */
    uint16_t address;
    uint8_t channel; /**< byte 4 */
    uint8_t type;
    uint8_t counter; /**< 0..7 */
    uint8_t data[CF_MAX_MAIL];
} cf_mail_t;

/**
 * Writes a mail with the next counter (1..7) into SM0, after waiting while SM0 is full; leaves the case when SM0 stays
 * full for CF_MAIL_MS.
 * @param data  bytes after the mailbox header; any `length` that fits the mailbox
 */
void cf_send_mail(cf_t *c, uint8_t type, const void *data, uint16_t length);
/** Writes a mail with its own header. @param length  1..out_size bytes of `mail`; the rest of SM0 is zero */
void cf_send_raw_mail(cf_t *c, const void *mail, uint16_t length);
/** Reads the next mail of any type. @return false: none within `ms` */
bool cf_receive_mail(cf_t *c, cf_mail_t *mail, uint32_t ms);
/** Reads the next mail except emergencies. Leaves the case when there is none within CF_MAIL_MS, or of another type. */
void cf_receive(cf_t *c, uint8_t type, cf_mail_t *mail);
/** The next mail must be a mailbox error with that detail. */
void cf_expect_mail_error(cf_t *c, uint16_t detail);
/** @return whether SM1 holds a mail */
bool cf_mail_waits(cf_t *c);
/** Leaves the case when a mail arrives within `ms`. A slower slave passes. */
void cf_expect_no_mail(cf_t *c, uint32_t ms);

enum { CF_MAIL_MS = 2000 }; /**< time for the reply to a mail (ETG.2000: ResponseTimeout) */

/* --- CoE ---------------------------------------------------------------------------------------------------------- */

enum { CF_COE_EMERGENCY = 1, CF_COE_REQUEST = 2, CF_COE_RESPONSE = 3, CF_COE_INFO = 8 };

/** Sends a CoE request of one SDO header: command, index, sub-index, four bytes of data. */
void cf_send_sdo(cf_t *c, uint8_t command, uint16_t index, uint8_t sub, uint32_t value);
/** Sends any CoE message: `data` follows the CoE header. */
void cf_send_coe(cf_t *c, uint8_t service, const void *data, uint16_t length);
/** Reads the next CoE mail except emergencies; data[2] is the SDO command byte. */
void cf_receive_coe(cf_t *c, cf_mail_t *mail);
/** The next CoE mail must be an abort of that object with that code, byte for byte. */
void cf_expect_abort(cf_t *c, uint16_t index, uint8_t sub, uint32_t code);

/**
 * Whole transfers of any length: expedited, normal, segmented. A violation of the protocol ends the case.
 * @param[in,out] size  room in, bytes out; data beyond the room end the case
 * @return 0, or the abort code
 */
uint32_t cf_upload(cf_t *c, uint16_t index, uint8_t sub, bool complete, void *data, size_t *size);
uint32_t cf_download(cf_t *c, uint16_t index, uint8_t sub, bool complete, const void *data, size_t size);
/**
 * Downloads a value that INIT does not reset, after uploading the old value. After the case, whatever the verdict, the
 * runner downloads the old values in PREOP, in the reverse order of the changes.
 * @param size  1..CF_CHANGE_MOST, the size of the old value
 * @return 0, or the abort code of the upload or the download
 */
uint32_t cf_change(cf_t *c, uint16_t index, uint8_t sub, const void *data, size_t size);
enum { CF_CHANGE_MOST = 64 };
/**
 * Allows the case to change a setting that is neither an object nor a file. After the case, whatever the verdict, the
 * runner calls `put_back` in PREOP, in the reverse order of the changes.
 * @param data  the old value, 0..CF_CHANGE_MOST bytes; copied
 */
void cf_keep(cf_t *c, void (*put_back)(cf_t *c, const uint8_t *data, size_t size), const void *data, size_t size);
/** @return a number of 1..8 bytes. An abort ends the case. */
uint64_t cf_upload_number(cf_t *c, uint16_t index, uint8_t sub);
/** @return whether an upload succeeds; *code: 0, or the abort code */
bool cf_object_exists(cf_t *c, uint16_t index, uint8_t sub, uint32_t *code);

/**
 * One request of the information service; `data` gets the content of all fragments of the reply, without headers.
 * @return bytes, or -1 with *code set when the slave replied with an info error
 */
int cf_info(cf_t *c, uint8_t opcode, const void *request, uint16_t request_length, void *data, size_t room,
            uint32_t *code);
/** List `type` of the information service. @return number of indices, at most `room` */
size_t cf_object_list(cf_t *c, uint16_t type, uint16_t *indices, size_t room);

/* --- FoE ---------------------------------------------------------------------------------------------------------- */

enum { CF_FOE_READ = 1, CF_FOE_WRITE = 2, CF_FOE_DATA = 3, CF_FOE_ACK = 4, CF_FOE_ERROR = 5, CF_FOE_BUSY = 6 };
enum { CF_FOE_HEADER = 6 };
enum { CF_FOE_LATER_MS = 10000, CF_FILE_MOST = 4 * 1024 * 1024 };

/**
 * @return one of two buffers of CF_FILE_MOST bytes, which are too large for a stack, keep their content from case to
 * case, and belong to the run. Leaves the case when there is no memory.
 * @param n  0 or 1
 */
uint8_t *cf_room(cf_t *c, unsigned int n);

/** One FoE mail: operation, number (packet, error code or password), and `length` further bytes. */
typedef struct cf_foe {
    uint8_t operation;
    uint32_t number;
    const void *data;
    uint16_t length;
} cf_foe_t;

/** @return the request to read (CF_FOE_READ) or to write (CF_FOE_WRITE) --file */
cf_foe_t cf_foe_open(const cf_t *c, uint8_t operation, uint32_t password);
/** Sends a mail without waiting for a reply. */
void cf_send_foe(cf_t *c, const cf_foe_t *sent);
/**
 * Sends a mail and reads the reply; repeats both, after a pause, while the reply is BUSY (mail not accepted).
 * @return operation of the reply; *number: its number; further bytes at `mail->data + CF_FOE_HEADER`
 */
uint8_t cf_request_foe(cf_t *c, const cf_foe_t *sent, cf_mail_t *mail, uint32_t *number);
/** @return bytes of a full packet to the slave (`write`) or from the slave, in its present AL state */
uint16_t cf_foe_full(cf_t *c, bool write);
/**
 * Whole transfers of --file with a password. A violation of the protocol ends the case.
 * @param[in,out] size  room in, bytes out; data beyond the room end the case
 * @return 0, or the error code of the slave
 */
uint32_t cf_read_file(cf_t *c, uint32_t password, void *data, size_t *size);
uint32_t cf_write_file(cf_t *c, uint32_t password, const void *data, size_t size);
/**
 * Allows the case to write the file: after the case the runner writes this content, in the present AL state.
 * @param data  copied
 */
void cf_keep_file(cf_t *c, const void *data, size_t size);

/* --- SII ---------------------------------------------------------------------------------------------------------- */

/** Reads the EEPROM by its registers. @return bytes read, 4 or 8 as the chip does */
unsigned int cf_sii_read(cf_t *c, uint16_t word, uint8_t data[8]);
/** Writes one word; the runner restores the old word after the case. Only in a case that needs CF_WRITES_SII. */
void cf_sii_write(cf_t *c, uint16_t word, uint16_t value);
/** Waits for the end of a command. @return the control and status word (0x0502) */
uint16_t cf_sii_wait(cf_t *c);
/** A category of the image in the facts. @return its data, NULL: none; *length in bytes */
const uint8_t *cf_sii_category(const cf_t *c, uint16_t category, size_t *length);
/** The nth category of that type, from 0: some images have one category per PDO. */
const uint8_t *cf_sii_block(const cf_t *c, uint16_t category, unsigned int nth, size_t *length);

#endif
