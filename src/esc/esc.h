/* SPDX-License-Identifier: MIT */
/**
 * @file
 * An EtherCAT slave controller in software: frame bytes in, frame bytes out.
 *
 * The chip has two sides. ECAT is the frame: ::ect_esc_process changes it in place, as the hardware does on the fly.
 * PDI is the slave's microcontroller: ::ect_esc_pdi_read and ::ect_esc_pdi_write have the signatures of the PDI seam
 * (seams/pdi.h). A chain of slaves is a loop over ::ect_esc_process.
 *
 * A personality defines the kind of chip: register values, number of FMMUs and SyncManagers, RAM. The caller owns all
 * memory; an instance keeps the pointers of its ::ect_esc_config_t as long as it is in use. No function allocates,
 * blocks or reads a clock: time is an argument, in nanoseconds of any monotonic clock, never smaller than in an earlier
 * call for the same instance.
 *
 * Context: one thread at a time for an instance; instances are independent.
 *
 * Clauses: ETG.1000.4 (data link layer); ESC data sheets sections I and II.
 */
#ifndef ECT_ESC_ESC_H
#define ECT_ESC_ESC_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "esc/personality.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** Most SyncManagers and FMMUs of any personality. */
enum { ECT_ESC_MAX_SM = 8, ECT_ESC_MAX_FMMU = 8 };

/** Greatest frequency error of an oscillator: 1000 ppm. */
enum { ECT_ESC_MAX_DRIFT_PPB = 1000000 };

/** Longest Ethernet frame that a port accepts, without FCS; a longer one is invalid (data sheet I §14.1). */
enum { ECT_ESC_MAX_FRAME = 2000 };

/** Memory that an ESC of this personality needs, bytes: 4 KB of registers and its process RAM. */
#define ECT_ESC_MEMORY_SIZE(ram_kb) (0x1000u + (size_t)(ram_kb) * 1024u)

/** For ect_esc_config_t::sii_command_ns: each EEPROM command takes as long as on an I²C bus of 149 kHz (ET1100 data
 * sheet III §8.2), and a written EEPROM is busy for another 5 ms, during which it acknowledges no command (0x0502 bit
 * 13). */
enum { ECT_ESC_SII_I2C = 0x7FFFFFFF };

/** Construction and wiring of an ESC. ::ect_esc_init checks it once. */
typedef struct ect_esc_config {
    const ect_esc_personality_t *personality; /**< not NULL */
    uint8_t *memory;   /**< ECT_ESC_MEMORY_SIZE(personality->ram_kb) bytes; content is overwritten */
    uint8_t *sii;      /**< EEPROM content; SII write commands change it. NULL: there is no EEPROM */
    uint32_t sii_size; /**< bytes; even, 0 with sii NULL */
    /** Duration of an EEPROM command, in which 0x0502 bit 15 reads 1; 0: it ends with its frame; ECT_ESC_SII_I2C */
    uint32_t sii_command_ns;
    uint8_t open_ports;   /**< bit n: port n has a link; bit 0 is assumed. 0: port 0 only */
    bool keep_source_mac; /**< false: set the "locally administered" bit of the source MAC, as the chip does */
    /** false: the PDI counts as permanently active, and its watchdog never expires; true: the watchdog observes the
     * accesses of the PDI (0x0410, 0x0443, DL status bit 1). See ::ect_esc_watch_pdi. */
    bool pdi_watched;
    int32_t
        drift_ppb; /**< frequency error of the oscillator, -ECT_ESC_MAX_DRIFT_PPB..ECT_ESC_MAX_DRIFT_PPB; >0: fast */
    /** The PDI emulates the EEPROM (0x0502 bit 5); `sii` must be NULL. Commands wait for the PDI, as AL event bit 5.
     * Only with ECT_UNIT_SII_EMULATION. */
    bool sii_emulated;
} ect_esc_config_t;

/** State of one SyncManager beyond its registers. Private. */
typedef struct ect_esc_sm {
    bool open[2];         /**< by side: its first byte was accessed and its last one not yet */
    uint8_t write_buffer; /**< buffered mode: owned by the producer */
    uint8_t read_buffer;  /**< owned by the consumer; 3: none */
    bool violated;        /**< sequential mode: a byte was left out since the buffer was opened */
    uint16_t next;        /**< sequential mode: the only byte that may be accessed next */
    uint16_t start;       /**< as in its registers; 0 while it is disabled */
    uint16_t length;      /**< 0: it is disabled */
} ect_esc_sm_t;

/** The local clock, as a straight line from a point on. Private. */
typedef struct ect_esc_clock {
    uint64_t real_ns;     /**< start of the line: real time, */
    uint64_t local_ns;    /**< local time at that moment, */
    int64_t fraction;     /**< and its fraction, 1e-9 ns */
    uint64_t slew_end_ns; /**< until this time slew_ppb applies too */
    int32_t drift_ppb;    /**< rate of the oscillator */
    int32_t trim_ppb;     /**< rate that the control loop adds */
    int32_t slew_ppb;
} ect_esc_clock_t;

/** The control loop that synchronises the clock to the reference clock. Private. */
typedef struct ect_esc_loop {
    int64_t mean_scaled; /**< difference, 2^-16 ns */
    int64_t rate_scaled; /**< permanent correction of the rate, 2^-16 ppb */
    uint64_t last_ns;    /**< time of the last sample */
    bool sampled;
} ect_esc_loop_t;

/** SYNC0 or SYNC1, in system time. Private. */
typedef struct ect_esc_sync {
    uint64_t next; /**< start of the next pulse; UINT64_MAX: none */
    uint64_t end;  /**< end of the last pulse */
} ect_esc_sync_t;

/** Delays between a frame's arrival at the chain and at this controller, caused by cables and other controllers. */
typedef struct ect_esc_arrival {
    uint32_t unit_ns;    /**< at its processing unit */
    uint32_t port_ns[4]; /**< at each port, on the way back; unchanged for a port that the frame does not reach */
} ect_esc_arrival_t;

/**
 * One controller. Allocate it anywhere, initialise with ::ect_esc_init; the members are private. The members from
 * `memory` to `sm` are those that each frame and each access of the PDI use: together, so that many controllers
 * have few lines in a processor's cache.
 */
typedef struct ect_esc {
    uint8_t *memory;
    uint32_t memory_size;
    uint8_t fmmu_reads;  /* bit n: FMMU n is active and maps reads */
    uint8_t fmmu_writes; /* bit n: FMMU n is active and maps writes */
    bool fmmus_plain;    /* all FMMUs map whole bytes, and no byte belongs to two FMMUs */
    bool sms_overlap;    /* two enabled SyncManagers share a byte: the lower number decides */
    uint64_t now_ns;
    uint64_t next_ns; /**< earliest time at which something happens without an access */
    uint32_t activity;
    uint32_t routing; /* changes with each state that affects the path of frames or data added to frames, except the
                         images of SyncManagers (route.h, cyclic.h) */
    uint32_t port_changes;
    uint32_t sii_writes;
    uint32_t resets;
    uint8_t per_frame; /**< work that is due at the end of this frame or the beginning of the next one */
    uint8_t closing; /* bit n: the present frame has left the buffer of SyncManager n, which is exchanged at its end */
    uint8_t listed;  /* bit n: SyncManager n is in the list of postponed effects */
    uint8_t sm_changed; /* bit n: the PDI has yet to read the changed activate register of SyncManager n */
    uint16_t postponed_length;
    bool sii_valid;
    bool latch_level[2];
    uint8_t sii_command;
    uint8_t reset_step[2]; /**< by side: progress of its reset sequence */
    ect_esc_config_t config;
    uint64_t pdi_ns;          /**< last access of the PDI; UINT64_MAX: its watchdog does not run */
    uint64_t loops_revert_ns; /**< end of temporary loop settings; UINT64_MAX: none */
    ect_esc_sm_t sm[ECT_ESC_MAX_SM];
    ect_esc_clock_t clock;
    ect_esc_loop_t loop;
    ect_esc_sync_t sync[2];
    ect_esc_arrival_t arrival;
    uint64_t sync_ns;        /**< next event of a pulse of SYNC0 or SYNC1; UINT64_MAX: none */
    uint64_t watchdog_ns;    /**< expiry of the process-data watchdog; UINT64_MAX: not running */
    uint64_t mii_done_ns;    /**< end of the pending command to a PHY; UINT64_MAX: none */
    uint64_t sii_done_ns;    /**< end of the pending SII command */
    uint64_t sii_rest_ns;    /**< end of the EEPROM's own work after a write: until then it acknowledges nothing */
    bool sii_unacknowledged; /**< the pending command has started before that */
    uint8_t sii_fault;       /**< ect_sii_fault_t */
    uint8_t sii_fault_bit;
    bool lose_al_event;
    uint8_t reloaded[16]; /**< words that a PDI that emulates the EEPROM has delivered so far */
    bool alias_loaded;
    bool al_control_locked;
    bool al_control_written; /**< by the present frame */
    bool pdi_late;           /**< the watchdog of the PDI has expired */
    bool reset_moved[2];     /**< by side: this frame or access has advanced the reset sequence */
    uint8_t held_ports;      /**< bit n: auto-close port n has lost its link, and stays closed until it is opened */
    uint8_t next_port[4];    /**< by port of arrival: the port by which a frame leaves */
    uint8_t kept_loops;      /**< loop settings that apply again after temporary ones */
    uint8_t err_code;        /**< code of the ERR LED, unless the register overrides it */
    bool fmmus_whole;        /* all FMMUs map whole bytes, and no byte belongs to two FMMUs of one direction */
    uint8_t scratch[ECT_ESC_MAX_FRAME];   /* data of the present datagram, in or out: one user at a time */
    uint8_t postponed[ECT_ESC_MAX_FRAME]; /* register writes of the present frame in order, and buffers left before */
} ect_esc_t;

/**
 * Power-on reset: sets registers to their reset values and loads the configuration from the SII.
 * @param[out] esc  the instance
 * @param config    copied; its memory must outlive the instance
 * @param now_ns    present time
 * @return 0, or negative with nothing initialised: -1 personality missing or out of range (more than 8 FMMUs or
 *         SyncManagers, no RAM), -2 memory missing, -3 SII size odd or without content, or emulation of the EEPROM by
 *         the PDI (sii_emulated) in addition to an EEPROM, or in a chip without emulation
 */
int ect_esc_init(ect_esc_t *esc, const ect_esc_config_t *config, uint64_t now_ns);

/** Result of ::ect_esc_process. */
typedef enum ect_frame_result {
    ECT_FRAME_FORWARD,   /**< continues to the next slave, or back to the master */
    ECT_FRAME_DESTROYED, /**< the chip destroys the frame: there is no reply */
} ect_frame_result_t;

/**
 * Passes a frame through the controller.
 *
 * Accepts Ethernet frames with EtherType 0x88A4, optionally with one VLAN tag, and EtherCAT in UDP (destination port
 * 0x88A4). Datagrams are executed in order; data, address, IRQ and working counter are changed in place, the length
 * never. Registers (0x0000..0x0F7F) and SyncManagers change when the frame has ended, in the order of the datagrams; a
 * later datagram of the same frame reads their previous values (data sheet I §3, §14.1). A frame whose datagrams exceed
 * it, or which is longer than ECT_ESC_MAX_FRAME, is not executed, counts in 0x0300 and 0x030C and is destroyed, because
 * a real chip forwards it with an invalid check sum. Any other EtherType is destroyed and counted in 0x030C while DL
 * control bit 0 is 1 (reset value), else forwarded unchanged.
 *
 * Cost: linear in the datagrams and in the bytes that this slave accesses.
 *
 * @param esc             the controller
 * @param[in,out] frame   `length` bytes from the destination MAC on, without FCS; no padding is needed
 * @param length          bytes
 * @param now_ns          time of arrival
 */
ect_frame_result_t ect_esc_process(ect_esc_t *esc, uint8_t *frame, size_t length, uint64_t now_ns);

/**
 * Reads from the PDI side, like the slave's microcontroller, with the side effects of the access (seams/pdi.h).
 * @param esc          an ::ect_esc_t
 * @param address      ESC address
 * @param[out] buffer  `length` bytes; inaccessible bytes (empty mailbox, address beyond the chip) read as 0
 * @param length       bytes
 * @return 0
 */
int ect_esc_pdi_read(void *esc, uint16_t address, void *buffer, uint16_t length);

/**
 * Writes from the PDI side, like the slave's microcontroller. Read-only registers and a full mailbox are unchanged.
 * @return 0
 */
int ect_esc_pdi_write(void *esc, uint16_t address, const void *buffer, uint16_t length);

/**
 * Advances the time: watchdog expiry, end of SII commands, SYNC0 and SYNC1. Must precede PDI accesses at a new time.
 * @return the next time, after now_ns, at which something happens without an access, or UINT64_MAX
 */
uint64_t ect_esc_tick(ect_esc_t *esc, uint64_t now_ns);

/** Next time at which ::ect_esc_tick has work to do, unless an access precedes it. */
static inline uint64_t ect_esc_due(const ect_esc_t *esc)
{
    return esc->next_ns;
}

/**
 * Whether frames leave by a port (1..3): it has a link and DL control has not closed its loop. Otherwise the frame
 * turns back here.
 */
bool ect_esc_port_open(const ect_esc_t *esc, unsigned int port);

/**
 * The port by which a frame leaves that has arrived at port `port` (0..3): the ports follow each other as 0, 3, 1, 2
 * and 0 again, without those whose loop is closed. A port whose loop is forced open without a link is included, and the
 * frame is lost there.
 */
static inline unsigned int ect_esc_next_port(const ect_esc_t *esc, unsigned int port)
{
    return esc->next_port[port];
}

/** A counter that changes with every change of links or loops. */
static inline uint32_t ect_esc_port_changes(const ect_esc_t *esc)
{
    return esc->port_changes;
}

/**
 * Whether port 0 has no link and its loop has closed automatically. A frame that returns from the slaves behind then
 * does not go to the master but through the controller and to those slaves again. The ESC marks it as circulating in
 * each datagram, and destroys a frame that already has the mark (data sheet I §3).
 */
bool ect_esc_circulates(const ect_esc_t *esc);

/**
 * Connects a cable to a port (0..3) or disconnects it. DL status follows and raises its ECAT event; the loss of a link
 * at a port that was open automatically is counted (0x0310). In mode "auto close" a port that has lost its link stays
 * closed until DL control opens it, or ::ect_esc_frame_at reports a frame there.
 */
void ect_esc_set_link(ect_esc_t *esc, unsigned int port, bool link);

/** Reports a valid frame at a port whose loop is closed. @return whether the port has opened (mode "auto close") */
bool ect_esc_frame_at(ect_esc_t *esc, unsigned int port);

/**
 * Reports a frame at a port (0..3) that was damaged on its way; none of its datagrams was executed. The error is
 * counted.
 * @param esc           the controller
 * @param port          0..3
 * @param found_before  another chip has detected the error before and marked the frame: counts in 0x0308, not 0x0300
 */
void ect_esc_damaged(ect_esc_t *esc, unsigned int port, bool found_before);

/**
 * Reports an invalid access of the PDI, such as an SPI transfer with a clock too many: it counts in 0x030D, and 0x030E
 * has the code of the last one. A write of the master to 0x030D clears both.
 */
void ect_esc_pdi_error(ect_esc_t *esc, uint8_t code);

/**
 * Starts or ends the observation of the PDI's accesses by its watchdog (ect_esc_config_t::pdi_watched).
 */
void ect_esc_watch_pdi(ect_esc_t *esc, bool watched);

/** Sets the delays of frames up to this controller (distributed clocks use them, nothing waits). Initially 0. */
void ect_esc_set_arrival(ect_esc_t *esc, const ect_esc_arrival_t *arrival);

/** Sets the frequency error of the oscillator (ect_esc_config_t::drift_ppb), from now on. It outlasts a reset. */
void ect_esc_set_drift(ect_esc_t *esc, int32_t ppb);

/** Adds a step to the local clock, as after a fault of the oscillator. Negative: backwards. */
void ect_esc_clock_jump(ect_esc_t *esc, int64_t by_ns);

/** The local copy of the system time at `now_ns`, which is not before the time of the previous call. */
uint64_t ect_esc_system_time(const ect_esc_t *esc, uint64_t now_ns);

/**
 * Level of the pin SYNC0 or SYNC1 (n 0 or 1; true: active) at the time of the last call: active for the length of a
 * pulse (0x0982), or until it is acknowledged.
 */
bool ect_esc_sync_pin(ect_esc_t *esc, unsigned int n);

/** Latches an edge of input LATCH0 or LATCH1: rising (`level` true) or falling. */
void ect_esc_latch_edge(ect_esc_t *esc, unsigned int n, bool level);

/** Sets the level of input LATCH0 or LATCH1 (n 0 or 1), initially low. An edge is latched at the time of the last
 * call. */
static inline void ect_esc_latch_input(ect_esc_t *esc, unsigned int n, bool level)
{
    if (esc->latch_level[n] != level)
        ect_esc_latch_edge(esc, n, level);
}

/** Faults of the EEPROM. */
typedef enum ect_sii_fault {
    ECT_SII_GOOD,
    ECT_SII_BUSY,      /**< a command does not end until the fault is removed */
    ECT_SII_NO_ANSWER, /**< a command ends with the bit for a missing acknowledge (0x0502 bit 13) */
    ECT_SII_BIT_ERROR, /**< each word is read with one inverted bit */
} ect_sii_fault_t;

/** Sets a fault of the EEPROM, until a reset. `bit` 0..15: position of the ECT_SII_BIT_ERROR, else ignored. */
void ect_esc_sii_fault(ect_esc_t *esc, ect_sii_fault_t fault, unsigned int bit);

/** Suppresses the event of the next write to AL control: the microcontroller does not notice that write. */
void ect_esc_lose_al_event(ect_esc_t *esc);

/** The AL event request word of the PDI, without the side effects of reading registers. */
uint32_t ect_esc_al_event(const ect_esc_t *esc);

/** Level of the interrupt line to the microcontroller: active while the AL event mask (0x0204) passes an event. */
bool ect_esc_line(const ect_esc_t *esc);

/**
 * A counter of actions of the ECAT side that may concern the slave's software: an AL event, new outputs, inputs that
 * were read, a repeat request. While it is unchanged, the software has nothing to do.
 */
static inline uint32_t ect_esc_activity(const ect_esc_t *esc)
{
    return esc->activity;
}

/** A counter of write commands that have changed the SII content (ect_esc_config_t::sii): 0 after ::ect_esc_init, kept
 * by a reset sequence. */
static inline uint32_t ect_esc_sii_writes(const ect_esc_t *esc)
{
    return esc->sii_writes;
}

/**
 * A counter of resets of the chip by a reset sequence of the master (0x0040) or the PDI (0x0041). The microcontroller
 * behind the chip has the same reset line and must restart.
 */
static inline uint32_t ect_esc_resets(const ect_esc_t *esc)
{
    return esc->resets;
}

ECT_C_END

#endif
