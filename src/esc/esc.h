/* SPDX-License-Identifier: MIT */
/**
 * @file
 * An EtherCAT slave controller in software: frame bytes in, frame bytes out.
 *
 * The chip has two sides. ECAT is the frame: ::ect_esc_process changes it in place the way the hardware does on the
 * fly. PDI is the slave's microcontroller: ::ect_esc_pdi_read and ::ect_esc_pdi_write have the shape of the PDI seam.
 * A chain of slaves is a loop over ::ect_esc_process.
 *
 * What kind of chip it is (register values, number of FMMUs and SyncManagers, RAM) comes from a personality. The
 * caller owns all memory; an instance keeps the pointers that ::ect_esc_init was given until it is no longer used.
 * Nothing allocates, blocks or reads a clock: time is an argument, nanoseconds of any monotonic clock, never smaller
 * than in an earlier call for the same instance.
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

/** SyncManagers and FMMUs that any personality may have. */
enum { ECT_ESC_MAX_SM = 8, ECT_ESC_MAX_FMMU = 8 };

/** What an oscillator may be wrong by: 1000 ppm. */
enum { ECT_ESC_MAX_DRIFT_PPB = 1000000 };

/** Longest Ethernet frame that a port takes, without FCS; longer ones count as invalid (data sheet I §14.1). */
enum { ECT_ESC_MAX_FRAME = 2000 };

/** Bytes of memory that an ESC of this personality needs: 4 KB of registers and its process RAM. */
#define ECT_ESC_MEMORY_SIZE(ram_kb) (0x1000u + (size_t)(ram_kb) * 1024u)

/** How an ESC is built and wired. Checked once by ::ect_esc_init. */
typedef struct ect_esc_config {
    const ect_esc_personality_t *personality; /**< not NULL */
    uint8_t *memory;      /**< ECT_ESC_MEMORY_SIZE(personality->ram_kb) bytes; content is overwritten */
    uint8_t *sii;         /**< EEPROM content; written by SII write commands. NULL: no EEPROM answers */
    uint32_t sii_size;    /**< bytes; even, 0 with sii NULL */
    uint8_t open_ports;   /**< bit n: port n has a link; bit 0 is assumed. 0: port 0 only */
    bool keep_source_mac; /**< false: set the "locally administered" bit of the source MAC, as the chip does */
    /** false: the PDI is taken to look in all the time, so that its watchdog never expires; true: it is counted by the
     * accesses that there are (0x0410, 0x0443, DL status bit 1). See ::ect_esc_watch_pdi. */
    bool pdi_watched;
    int32_t drift_ppb; /**< its oscillator is too fast by so much, -ECT_ESC_MAX_DRIFT_PPB..ECT_ESC_MAX_DRIFT_PPB */
    /** The PDI stands for the EEPROM (0x0502 bit 5), which must be NULL then: commands wait for it, as AL event bit 5.
     * Only with ECT_UNIT_SII_EMULATION. */
    bool sii_emulated;
} ect_esc_config_t;

/** State of one SyncManager that no register shows. Private. */
typedef struct ect_esc_sm {
    bool open[2];         /**< by side: the buffer was entered at its first byte and not left at its last */
    uint8_t write_buffer; /**< buffered mode: owned by the producer */
    uint8_t read_buffer;  /**< owned by the consumer, 3 none */
    bool violated;        /**< sequential mode: a byte was left out since the buffer was opened */
    uint16_t next;        /**< sequential mode: the byte that has to come next */
    uint16_t start;       /**< as in its registers; 0 while it is not enabled */
    uint16_t length;      /**< 0: it is not enabled */
} ect_esc_sm_t;

/** The local clock, as a line from a point on. Private. */
typedef struct ect_esc_clock {
    uint64_t real_ns;     /**< then ... */
    uint64_t local_ns;    /**< ... it was this, */
    int64_t fraction;     /**< and so many 1e-9 ns more */
    uint64_t slew_end_ns; /**< until then it gains slew_ppb as well */
    int32_t drift_ppb;    /**< what it gains by itself */
    int32_t trim_ppb;     /**< and by the control loop */
    int32_t slew_ppb;
} ect_esc_clock_t;

/** The loop that makes the clock follow another one. Private. */
typedef struct ect_esc_loop {
    int64_t mean_scaled; /**< difference, 2^-16 ns */
    int64_t rate_scaled; /**< what the clock has to gain for good, 2^-16 ppb */
    uint64_t last_ns;    /**< when the last sample came */
    bool sampled;
} ect_esc_loop_t;

/** SYNC0 or SYNC1, in system time. Private. */
typedef struct ect_esc_sync {
    uint64_t next; /**< pulse; UINT64_MAX: none */
    uint64_t end;  /**< of the last pulse */
} ect_esc_sync_t;

/** How long after it has come in a frame reaches this controller: cables and other controllers take their time. */
typedef struct ect_esc_arrival {
    uint32_t unit_ns;    /**< its processing unit */
    uint32_t port_ns[4]; /**< each port, on its way back; of a port that it does not reach: whatever it was */
} ect_esc_arrival_t;

/** One controller. Allocate it anywhere, initialise with ::ect_esc_init; the members are private. */
typedef struct ect_esc {
    ect_esc_config_t config;
    uint8_t *memory;
    uint32_t memory_size;
    ect_esc_sm_t sm[ECT_ESC_MAX_SM];
    uint64_t now_ns;
    uint64_t next_ns; /**< nothing happens by itself before */
    ect_esc_clock_t clock;
    ect_esc_loop_t loop;
    ect_esc_sync_t sync[2];
    ect_esc_arrival_t arrival;
    uint64_t sync_ns; /**< when a pulse of SYNC0 or SYNC1 has to be looked at; UINT64_MAX: none */
    bool latch_level[2];
    uint64_t watchdog_ns; /**< when the process-data watchdog expires; UINT64_MAX: not running */
    uint64_t sii_done_ns; /**< when the pending SII command finishes */
    uint8_t sii_command;
    uint8_t sii_fault; /**< ect_sii_fault_t */
    uint8_t sii_fault_bit;
    bool lose_al_event;
    uint8_t reloaded[16]; /**< what a PDI that stands for the EEPROM has delivered so far */
    bool alias_loaded;
    uint64_t pdi_ns;          /**< when the PDI last looked in; UINT64_MAX: its watchdog is not running */
    uint64_t loops_revert_ns; /**< when temporary loop settings end; UINT64_MAX: there are none */
    bool al_control_locked;
    bool sii_valid;
    bool pdi_late;         /**< its watchdog has expired */
    uint8_t per_frame;     /**< what has to be done when this frame ends, or the next one begins */
    uint8_t reset_step[2]; /**< by side: how far its reset sequence has come */
    bool reset_moved[2];   /**< by side: this frame, or access, has moved it on */
    uint8_t held_ports;    /**< bit n: auto-close port n has lost its link and waits to be opened */
    uint8_t next_port[4];  /**< by port: where a frame leaves that has come in there */
    uint32_t port_changes;
    uint8_t kept_loops;  /**< loop settings that come back after temporary ones */
    uint8_t err_code;    /**< what the ERR LED shows by itself */
    uint8_t fmmu_reads;  /* FMMUs that are active and read through, a bit each */
    uint8_t fmmu_writes; /* those that are written through */
    bool fmmus_plain;    /* all of them are of whole bytes, and no byte is of two */
    uint8_t sm_changed;  /* SyncManagers whose activate register the PDI has yet to look at */
    uint32_t activity;
    uint32_t routing; /* moves when what decides on the way of frames, or what they take along, does (route.h) */
    uint32_t sii_writes;
    uint32_t resets;
    uint8_t scratch[ECT_ESC_MAX_FRAME]; /* what a datagram brought, or is about to be given: one user at a time */
} ect_esc_t;

/**
 * Power-on reset: registers at their reset values, configuration loaded from the SII.
 * @return 0, or negative with nothing initialised: -1 personality missing or out of range (more than 8 FMMUs or
 *         SyncManagers, no RAM), -2 memory missing, -3 SII size odd or without content, or an EEPROM that the PDI is to
 *         stand for (sii_emulated) though there is one, or the chip cannot.
 */
int ect_esc_init(ect_esc_t *esc, const ect_esc_config_t *config, uint64_t now_ns);

/** What becomes of a frame. */
typedef enum ect_frame_result {
    ECT_FRAME_FORWARD,   /**< goes on to the next slave, or back to the master */
    ECT_FRAME_DESTROYED, /**< the chip lets nothing intelligible leave: no reply */
} ect_frame_result_t;

/**
 * Lets a frame pass through the controller.
 *
 * Takes Ethernet frames with EtherType 0x88A4, with one VLAN tag, and EtherCAT in UDP (destination port 0x88A4).
 * Datagrams are executed in order; data, address, IRQ and working counter are changed in place, the length never.
 * A frame whose datagrams do not fit into it, or longer than ECT_ESC_MAX_FRAME, executes nothing, counts in 0x0300
 * and 0x030C and is destroyed, for a real chip passes it on with a spoilt check sum. Anything that is not EtherCAT is
 * destroyed and counted in 0x030C while DL control bit 0 is 1 (reset value), else forwarded untouched.
 *
 * @param frame   `length` bytes from the destination MAC on, without FCS; no padding is needed
 * @param now_ns  time of arrival
 * Cost: linear in the datagrams and in the bytes that this slave touches.
 */
ect_frame_result_t ect_esc_process(ect_esc_t *esc, uint8_t *frame, size_t length, uint64_t now_ns);

/**
 * The PDI side: reads like the slave's microcontroller, with the side effects of that (seams/pdi.h).
 * @param esc     an ::ect_esc_t
 * @param buffer  `length` bytes; what may not be read now (empty mailbox, address beyond the chip) reads as 0
 * @return 0
 */
int ect_esc_pdi_read(void *esc, uint16_t address, void *buffer, uint16_t length);

/**
 * The PDI side: writes like the slave's microcontroller. Read-only registers and a full mailbox stay unchanged.
 * @return 0
 */
int ect_esc_pdi_write(void *esc, uint16_t address, const void *buffer, uint16_t length);

/**
 * Lets time pass: watchdog expiry, the end of SII commands, SYNC0. Call it before PDI accesses that come at a new time.
 * @return the time, after now_ns, at which something will happen next without an access, or UINT64_MAX.
 */
uint64_t ect_esc_tick(ect_esc_t *esc, uint64_t now_ns);

/** When ::ect_esc_tick has something to do, if nobody touches the controller before. */
static inline uint64_t ect_esc_due(const ect_esc_t *esc)
{
    return esc->next_ns;
}

/**
 * Whether frames leave by a port (1..3): it has a link and DL control has not closed its loop. A frame that does not
 * leave goes back to the master from here.
 */
bool ect_esc_port_open(const ect_esc_t *esc, unsigned int port);

/**
 * Where a frame leaves that has come in at a port (0..3): the ports follow each other as 0, 3, 1, 2, and 0 again, those
 * with a closed loop left out. A port whose loop was forced open without a link is not: frames vanish there.
 */
static inline unsigned int ect_esc_next_port(const ect_esc_t *esc, unsigned int port)
{
    return esc->next_port[port];
}

/** A counter that moves whenever links or loops have changed. */
static inline uint32_t ect_esc_port_changes(const ect_esc_t *esc)
{
    return esc->port_changes;
}

/**
 * Whether port 0 has no link and its loop has closed itself: a frame that comes back from the slaves behind does not go
 * to the master, but through the controller and to them again. It is marked as circulating in each datagram then; one
 * that carries the mark already is destroyed (data sheet I §3).
 */
bool ect_esc_circulates(const ect_esc_t *esc);

/**
 * Plugs a cable into a port (0..3) or pulls it: DL status follows and raises its ECAT event; the end of a link at a
 * port that was open by itself counts (0x0310). In mode "auto close" a port that has lost its link stays closed until
 * DL control opens it, or ::ect_esc_frame_at tells of a frame there.
 */
void ect_esc_set_link(ect_esc_t *esc, unsigned int port, bool link);

/** A good frame has reached a port whose loop is closed. @return whether that has opened it (mode "auto close") */
bool ect_esc_frame_at(ect_esc_t *esc, unsigned int port);

/**
 * A frame that was damaged on its way has reached a port (0..3); no datagram of it was executed. Counts.
 * @param found_before  another chip has found it already, and marked it: 0x0308, not 0x0300
 */
void ect_esc_damaged(ect_esc_t *esc, unsigned int port, bool found_before);

/**
 * Begins to count the PDI's accesses for its watchdog, or takes the PDI to look in all the time
 * (ect_esc_config_t::pdi_watched).
 */
void ect_esc_watch_pdi(ect_esc_t *esc, bool watched);

/** Says how long frames travel before they are here (distributed clocks see it, nothing waits). First: no time. */
void ect_esc_set_arrival(ect_esc_t *esc, const ect_esc_arrival_t *arrival);

/** Gives its oscillator another drift (ect_esc_config_t::drift_ppb); what was is kept. It outlasts a reset. */
void ect_esc_set_drift(ect_esc_t *esc, int32_t ppb);

/** Lets the local clock jump, as after a fault of the oscillator. Negative: back. */
void ect_esc_clock_jump(ect_esc_t *esc, int64_t by_ns);

/** The local copy of the system time. @param now_ns  not before the time of the last call that had one */
uint64_t ect_esc_system_time(const ect_esc_t *esc, uint64_t now_ns);

/**
 * Level of the pin SYNC0 or SYNC1 (n 0 or 1; true: active) at the time of the last call: for the length of a pulse
 * (0x0982), or until it is acknowledged.
 */
bool ect_esc_sync_pin(ect_esc_t *esc, unsigned int n);

/* The level is another one than before. */
void ect_esc_latch_edge(ect_esc_t *esc, unsigned int n, bool level);

/** Level of the input LATCH0 or LATCH1 (n 0 or 1), first low: an edge is latched at the time of the last call. */
static inline void ect_esc_latch_input(ect_esc_t *esc, unsigned int n, bool level)
{
    if (esc->latch_level[n] != level)
        ect_esc_latch_edge(esc, n, level);
}

/** What may be wrong with the EEPROM. */
typedef enum ect_sii_fault {
    ECT_SII_GOOD,
    ECT_SII_BUSY,      /**< a command does not end, until this is over */
    ECT_SII_NO_ANSWER, /**< a command ends with the bit for a missing acknowledge (0x0502 bit 13) */
    ECT_SII_BIT_ERROR, /**< one bit of each word that is read is wrong */
} ect_sii_fault_t;

/** From now on until a reset. @param bit  of a BIT_ERROR, 0..15 */
void ect_esc_sii_fault(ect_esc_t *esc, ect_sii_fault_t fault, unsigned int bit);

/** The next write to AL control raises no event: the microcontroller does not get to know of it. */
void ect_esc_lose_al_event(ect_esc_t *esc);

/** The AL event request word as the PDI sees it, without the side effects of reading registers. */
uint32_t ect_esc_al_event(const ect_esc_t *esc);

/** Level of the interrupt line to the microcontroller: an AL event that the AL event mask (0x0204) lets through. */
bool ect_esc_line(const ect_esc_t *esc);

/**
 * A counter that moves whenever the ECAT side did something that the slave's software may have to look at: an AL
 * event, new outputs, inputs fetched, a repeat request. Equal to the last value: nothing to do.
 */
static inline uint32_t ect_esc_activity(const ect_esc_t *esc)
{
    return esc->activity;
}

/** A counter that moves whenever a write command has changed the SII content (ect_esc_config_t::sii); 0 after
 * ::ect_esc_init, kept by a reset sequence.
 */
static inline uint32_t ect_esc_sii_writes(const ect_esc_t *esc)
{
    return esc->sii_writes;
}

/**
 * A counter that moves whenever a reset sequence, written by the master (0x0040) or the PDI (0x0041), has reset the
 * chip: the microcontroller behind it, which hangs on the same reset line, has to start anew.
 */
static inline uint32_t ect_esc_resets(const ect_esc_t *esc)
{
    return esc->resets;
}

ECT_C_END

#endif
