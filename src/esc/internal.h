/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Interface between the files of esc/. No file outside esc/ includes this header.
 *
 * The files from the lowest to the highest; each uses only files above it in this list (tests/check/order.py):
 *
 *   personality.c     types of chips
 *   fmmu_registers.c  registers of the FMMUs
 *   memory.c     bytes of an access, event words, counters
 *   postpone.c   effects of a frame that wait for its end
 *   led.c        RUN and ERR LEDs
 *   port.c       link and loop bits, damaged frames
 *   watchdog.c   watchdogs of the process data and of the PDI
 *   clock.c      local clock
 *   syncman.c    SyncManagers: access to their buffers
 *   sync.c       distributed clocks: SYNC0, SYNC1, latch inputs
 *   dc.c         distributed clocks: receive times, system time, control loop
 *   sii.c        EEPROM interface
 *   mii.c        PHY management
 *   protect.c    write protection, reset sequences
 *   registers.c  the registers, with their reset values, access rights and effects
 *   access.c     one access to the address space, from either side: registers or RAM
 *   esc.c        reset, time, the PDI side
 *   route.c      properties of a controller that affect passing frames
 *   fmmu.c       logical addresses
 *   cyclic.c     the part of a controller in the exchange of process data, determined in advance
 *   frame.c      datagrams: addressing, working counter
 */
#ifndef ECT_ESC_INTERNAL_H
#define ECT_ESC_INTERNAL_H

#include <string.h>

#include "esc/esc.h"
#include "wire/assert.h"
#include "wire/bytes.h"
#include "wire/registers.h"

enum { ECT_ESC_PORTS = 4 };

/** Side of an access, and index into ect_esc_sm_t::open. */
typedef enum ect_side { ECT_SIDE_ECAT, ECT_SIDE_PDI } ect_side_t;

/** Bits of ect_esc_t::per_frame. */
enum {
    ECT_FRAME_END_SII = 0x01, /**< the EEPROM write enable, valid for one frame, is set */
    ECT_FRAME_BEGINS = 0x02,  /**< another write enable is set, or a reset sequence is not complete */
    ECT_FRAME_END_MII = 0x08, /**< the write enable of PHYs is set */
    ECT_FRAME_COMMITS = 0x04, /**< writes of this frame are postponed to its end */
};

/** The master's writes to registers have two stages; every other access has one. */
typedef enum ect_stage {
    ECT_STAGE_PASSING, /**< the datagram passes: RAM changes, register writes are postponed */
    ECT_STAGE_ASKS,    /**< only determines whether registers accept a write */
    ECT_STAGE_COMMITS, /**< the frame has ended: a postponed write takes effect */
} ect_stage_t;

/** One access, by a datagram or by a PDI call. */
typedef struct ect_access {
    ect_side_t side;
    ect_stage_t stage;
    bool write;
    bool unread;         /**< a read of a buffer may leave `data` unchanged */
    bool latches;        /**< a write by station address or broadcast, which latches the receive times at 0x0900 */
    uint8_t *data;       /**< read: destination; write: source, not changed */
    const uint8_t *mask; /**< bits that apply, one byte for each byte of data; NULL: all */
} ect_access_t;

/** The part of an access from `offset` on. */
static inline ect_access_t ect_esc_slice(const ect_access_t *access, uint16_t offset)
{
    ect_access_t part = *access;
    part.data += offset;
    if (part.mask)
        part.mask += offset;
    return part;
}

/** Removes the lowest number from a set, one bit each. @param[in,out] set  not empty */
static inline unsigned int ect_esc_take(unsigned int *set)
{
    ECT_ASSERT(*set != 0);
    unsigned int n = (unsigned int)__builtin_ctz(*set);
    *set &= *set - 1;
    return n;
}

/** Whether an access from `address` to `end` (exclusive) contains the byte at `wanted`. */
static inline bool ect_esc_within(uint32_t address, uint32_t end, uint32_t wanted)
{
    return address <= wanted && wanted < end;
}

/* --- memory.c --------------------------------------------------------------------------------------------------- */
void ect_esc_copy_bits(const ect_access_t *access, uint8_t *memory, uint16_t offset, uint16_t length);
void ect_esc_set_ecat(ect_esc_t *esc, uint16_t events);
void ect_esc_count(ect_esc_t *esc, uint16_t counter_register);
/* Copies bytes of an access, from `offset` on, to or from memory. */
static inline void ect_esc_copy(const ect_access_t *access, uint8_t *memory, uint16_t offset, uint16_t length)
{
    uint8_t *data = access->data + offset;
    ECT_ASSERT(access->data && memory);
    if (access->mask)
        ect_esc_copy_bits(access, memory, offset, length);
    else if (access->write)
        memcpy(memory, data, length);
    else
        memcpy(data, memory, length);
}

static inline void ect_esc_raise(ect_esc_t *esc, uint32_t al_event)
{
    ECT_ASSERT(al_event != 0);
    uint8_t *event = esc->memory + ECT_REG_AL_EVENT;
    ect_store_le32(event, ect_load_le32(event) | al_event);
    esc->activity++;
}

static inline void ect_esc_clear(ect_esc_t *esc, uint32_t al_event)
{
    uint8_t *event = esc->memory + ECT_REG_AL_EVENT;
    ect_store_le32(event, ect_load_le32(event) & ~al_event);
}

/* Changes the ECAT events only if necessary: datagrams collect the events, so a change affects passing frames. */
static inline void ect_esc_raise_ecat(ect_esc_t *esc, uint16_t ecat_event)
{
    uint16_t events = ect_load_le16(esc->memory + ECT_REG_ECAT_EVENT);
    ECT_ASSERT(ecat_event != 0);
    if ((~events & ecat_event) != 0)
        ect_esc_set_ecat(esc, events | ecat_event);
}

static inline void ect_esc_clear_ecat(ect_esc_t *esc, uint16_t ecat_event)
{
    uint16_t events = ect_load_le16(esc->memory + ECT_REG_ECAT_EVENT);
    if ((events & ecat_event) != 0)
        ect_esc_set_ecat(esc, (uint16_t)(events & ~ecat_event));
}

/* Schedules ect_esc_tick at this time. */
static inline void ect_esc_expect(ect_esc_t *esc, uint64_t at_ns)
{
    if (at_ns < esc->next_ns)
        esc->next_ns = at_ns;
}

/* Whether the chip has a unit (ECT_UNIT_...). */
static inline bool ect_esc_has(const ect_esc_t *esc, unsigned int unit)
{
    return (esc->config.personality->units & unit) != 0;
}
/* Whether the chip itself replies to AL control: a device without a microcontroller. */
static inline bool ect_esc_emulates(const ect_esc_t *esc)
{
    return (esc->memory[ECT_REG_PDI_CONTROL + 1] & 0x01) != 0;
}

/* The ECAT events that datagrams collect. */
static inline uint16_t ect_esc_shown_events(const ect_esc_t *esc)
{
    return ect_load_le16(esc->memory + ECT_REG_ECAT_EVENT) & ect_load_le16(esc->memory + ECT_REG_ECAT_EVENT_MASK);
}
/* The second address: the alias, if the master has enabled it, else the station address. */
static inline uint16_t ect_esc_second_station(const ect_esc_t *esc)
{
    bool alias = (esc->memory[ECT_REG_DL_CONTROL + 3] & 0x01) != 0;
    return ect_load_le16(esc->memory + (alias ? ECT_REG_STATION_ALIAS : ECT_REG_STATION_ADDRESS));
}

/* --- postpone.c ------------------------------------------------------------------------------------------------- */
/* A postponed write; length 0: the end of accesses to SyncManagers, bit n of `address` for SyncManager n. */
typedef struct ect_postponed {
    ect_access_t access; /* its data are in ect_esc_t::postponed */
    uint16_t address;
    uint16_t length;
} ect_postponed_t;

/* Postpones a register write of the master to the end of the frame. @return false: no room, nothing is changed */
bool ect_esc_postpone_write(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);
/* Removes SyncManager `n` from the list: the frame has begun the buffer again, which is exchanged later. */
void ect_esc_unlist(ect_esc_t *esc, unsigned int n);
/* The entry at `*at`, initially 0, which is advanced. @return false: there is none */
bool ect_esc_next_postponed(ect_esc_t *esc, uint16_t *at, ect_postponed_t *next);

/* --- led.c ------------------------------------------------------------------------------------------------------ */
/* Sets the RUN LED after a change of AL status, even if the register had overridden it. */
void ect_esc_led_state(ect_esc_t *esc);
/* Updates the ERR LED after a change of its causes. */
void ect_esc_led_errors(ect_esc_t *esc);
void ect_esc_led_write(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);

/* --- port.c ----------------------------------------------------------------------------------------------------- */
/* Computes link and loop bits from cabling and DL control; a change raises the ECAT event. */
void ect_esc_update_dl_status(ect_esc_t *esc);
void ect_esc_port_control(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);
void ect_esc_port_tick(ect_esc_t *esc);
bool ect_esc_marks_source(const ect_esc_t *esc);

/* --- watchdog.c ------------------------------------------------------------------------------------------------- */
void ect_esc_watchdog_trigger(ect_esc_t *esc);
void ect_esc_watchdog_time_written(ect_esc_t *esc);
/* Reports an access of the PDI, or a change of whether its accesses are observed. */
void ect_esc_watchdog_pdi(ect_esc_t *esc);
void ect_esc_watchdog_tick(ect_esc_t *esc);

/* --- clock.c ---------------------------------------------------------------------------------------------------- */
static inline bool ect_esc_dc_present(const ect_esc_t *esc)
{
    return (esc->config.personality->features & ECT_FEATURE_DC) != 0;
}
void ect_esc_clock_reset(ect_esc_t *esc);
/* The local clock at a time not before the last change of its rate. */
uint64_t ect_esc_local_at(const ect_esc_t *esc, uint64_t real_ns);
/* The local clock at the moment when this frame reached the processing unit. */
uint64_t ect_esc_frame_time(const ect_esc_t *esc);
/* Time at which the local clock will have advanced by `wait_ns`; UINT64_MAX: beyond the range of time. */
uint64_t ect_esc_real_after(const ect_esc_t *esc, uint64_t wait_ns);
/* Starts a new line of the clock at this moment, so that its rates may change. */
void ect_esc_clock_rebase(ect_esc_t *esc);

/* --- syncman.c -------------------------------------------------------------------------------------------------- */
static inline uint8_t *ect_esc_sm_registers(const ect_esc_t *esc, unsigned int n)
{
    return esc->memory + ECT_REG_SM + ECT_SM_SIZE * n;
}
static inline bool ect_esc_sm_enabled(const ect_esc_t *esc, unsigned int n)
{
    return esc->sm[n].length > 0;
}
void ect_esc_sm_reset(ect_esc_t *esc, unsigned int n);
bool ect_esc_sm_access(ect_esc_t *esc, unsigned int n, const ect_access_t *access, uint16_t offset, uint16_t length);
/* Closes the buffers of a set (bit n: SyncManager n) that a frame has left, except buffers that the frame has begun
 * again, or of which the frame has restarted the SyncManager. */
void ect_esc_sm_close(ect_esc_t *esc, unsigned int set);
/* Whether at least one byte accepts a write of the master. */
bool ect_esc_sm_accepts(const ect_esc_t *esc, uint16_t address, uint16_t length);
bool ect_esc_sm_write_register(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);
void ect_esc_sm_read_register(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);

/* --- sync.c ----------------------------------------------------------------------------------------------------- */
void ect_esc_sync_reset(ect_esc_t *esc);
void ect_esc_sync_tick(ect_esc_t *esc);
/* Completes all pulses up to now with the present clock, system time and cycle, before one of these changes. */
void ect_esc_sync_settle(ect_esc_t *esc);
/* Computes the time of the next pulse after a change of clock or system time. */
void ect_esc_sync_moved(ect_esc_t *esc);
void ect_esc_sync_refresh(ect_esc_t *esc, uint16_t address, uint16_t end);
/* Whether the master controls start, cycle times and latch inputs. */
bool ect_esc_sync_control_accepts(const ect_esc_t *esc, uint16_t address, uint16_t length);
bool ect_esc_sync_start_accepts(const ect_esc_t *esc, uint16_t address, uint16_t length);
bool ect_esc_sync_cycle_accepts(const ect_esc_t *esc, uint16_t address, uint16_t length);
bool ect_esc_latch_control_accepts(const ect_esc_t *esc, uint16_t address, uint16_t length);
bool ect_esc_sync_control(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);
bool ect_esc_sync_activate(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);
bool ect_esc_sync_start(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);
bool ect_esc_sync_cycle(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);
void ect_esc_sync_acknowledge(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);
bool ect_esc_latch_control(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);
void ect_esc_latch_read(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);

/* --- dc.c ------------------------------------------------------------------------------------------------------- */
/* Updates the time-dependent registers between `address` and `end` before they are read. */
void ect_esc_dc_refresh(ect_esc_t *esc, ect_side_t side, uint16_t address, uint16_t end);
bool ect_esc_dc_latch(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);
/* Whether a system time written by this side controls the clock. */
bool ect_esc_dc_follows(const ect_esc_t *esc, ect_side_t side);
/* Takes the system time of a frame as a sample of the control loop. */
void ect_esc_dc_take(ect_esc_t *esc, uint32_t time);
bool ect_esc_dc_accepts(const ect_esc_t *esc, uint16_t address, uint16_t length);
bool ect_esc_dc_compare(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);
bool ect_esc_dc_write_loop(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);
bool ect_esc_dc_write_speed(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);

/* --- sii.c ------------------------------------------------------------------------------------------------------ */
void ect_esc_sii_load(ect_esc_t *esc, bool power_on);
void ect_esc_sii_tick(ect_esc_t *esc);
bool ect_esc_sii_write_register(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);
bool ect_esc_sii_accepts(const ect_esc_t *esc, uint16_t address, uint16_t length);
void ect_esc_sii_end_of_frame(ect_esc_t *esc);

/* --- mii.c ------------------------------------------------------------------------------------------------------ */
void ect_esc_mii_tick(ect_esc_t *esc);
bool ect_esc_mii_accepts(const ect_esc_t *esc, uint16_t address, uint16_t length);
bool ect_esc_mii_write_register(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);
void ect_esc_mii_end_of_frame(ect_esc_t *esc);

/* --- protect.c -------------------------------------------------------------------------------------------------- */
/* Applies the write enables that a write of the master contains. @return whether one was valid */
bool ect_esc_unlock(ect_esc_t *esc, uint16_t address, uint16_t length);
/* First address that the master may write: 0 all, UINT32_MAX none. */
uint32_t ect_esc_first_writable(const ect_esc_t *esc);
bool ect_esc_protect_write(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);
bool ect_esc_reset_write(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);
/* Begins a frame or a PDI access: write enables and reset steps of the previous one expire. */
void ect_esc_protect_begins(ect_esc_t *esc, ect_side_t side);
/* Whether a reset sequence is complete. */
bool ect_esc_reset_due(const ect_esc_t *esc);

/* --- registers.c ------------------------------------------------------------------------------------------------ */
/* Sets all registers to their reset values; the EEPROM is loaded later. */
void ect_esc_registers_reset(ect_esc_t *esc);
/* Ends the writes of a frame: AL control remains as written until the PDI reads it. */
void ect_esc_lock_al_control(ect_esc_t *esc);
/* Whether at least one byte was accessible; 1 to 4096 bytes below ECT_RAM. */
bool ect_esc_register_access(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);

/* --- access.c --------------------------------------------------------------------------------------------------- */
/* Whether write protection may refuse an access. */
static inline bool ect_esc_guards(const ect_esc_t *esc, const ect_access_t *access)
{
    return access->write && access->side == ECT_SIDE_ECAT &&
           (esc->memory[ECT_REG_WRITE_PROTECTION] | esc->memory[ECT_REG_ESC_WRITE_PROTECTION]) != 0;
}
bool ect_esc_any_access(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);
/* Executes the postponed writes of a frame, and closes the buffers that the frame has left before the last write. */
void ect_esc_commit_writes(ect_esc_t *esc);

/* Executes all effects of a frame. Cyclic data close buffers and write no register. */
static inline void ect_esc_commit(ect_esc_t *esc)
{
    if (esc->postponed_length != 0)
        ect_esc_commit_writes(esc);
    esc->per_frame &= (uint8_t)~ECT_FRAME_COMMITS;
    ect_esc_sm_close(esc, esc->closing);
}

/* Whether at least one byte was accessible. Cyclic data, the most frequent case, lie inside one SyncManager. */
static inline bool ect_esc_access(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    uint32_t end = (uint32_t)address + length;
    bool managed = address >= ECT_RAM && esc->sii_valid && !esc->sms_overlap && end <= esc->memory_size &&
                   !ect_esc_guards(esc, access);
    for (unsigned int n = 0; managed && n < ECT_ESC_MAX_SM; n++) {
        uint32_t offset = (uint32_t)address - esc->sm[n].start;
        if (offset >= esc->sm[n].length)
            continue;
        if (offset + length > esc->sm[n].length)
            break;
        return ect_esc_sm_access(esc, n, access, (uint16_t)offset, length);
    }
    return ect_esc_any_access(esc, access, address, length);
}

/* --- esc.c ------------------------------------------------------------------------------------------------------ */
/* As ect_esc_tick, with less cost while no event is due. */
void ect_esc_advance(ect_esc_t *esc, uint64_t now_ns);
/* Ends a frame or a PDI access: executes a reset if a reset sequence is complete. */
void ect_esc_access_ends(ect_esc_t *esc);

/* Size of a 16-bit address space. */
enum { ECT_ESC_ADDRESS_SPACE = 0x10000 };

/* --- fmmu_registers.c ------------------------------------------------------------------------------------------- */
bool ect_esc_fmmu_accepts(const ect_esc_t *esc, uint16_t address, uint16_t length);
bool ect_esc_fmmu_write_register(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);

/* --- fmmu.c ----------------------------------------------------------------------------------------------------- */
/* @param part  ECT_PART_READ, ECT_PART_WRITE, ECT_PART_UNREAD. @return ECT_PART_READ and ECT_PART_WRITE that succeeded
 */
unsigned int ect_esc_fmmu_bits(ect_esc_t *esc, uint32_t logical, uint8_t *data, uint16_t length, unsigned int part);
/* The same for FMMUs as most masters configure them (ect_esc_t::fmmus_plain). */
unsigned int ect_esc_fmmu_bytes(ect_esc_t *esc, uint32_t logical, uint8_t *data, uint16_t length, unsigned int part);
static inline const uint8_t *ect_esc_fmmu_registers(const ect_esc_t *esc, unsigned int n)
{
    return esc->memory + ECT_REG_FMMU + ECT_FMMU_SIZE * n;
}

#endif
