/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What the files of esc/ know of each other. Nobody else includes this.
 *
 * From the lowest to the highest; each knows only those above it in this list (tests/check/order.py):
 *
 *   memory.c     bytes of an access, event words, counters
 *   led.c        what the RUN and ERR lamps show
 *   port.c       link and loop bits, damaged frames
 *   watchdog.c   the watchdogs of the process data and of the PDI
 *   clock.c      the local clock
 *   syncman.c    SyncManagers: who may enter which buffer
 *   sync.c       distributed clocks: SYNC0, SYNC1, latch inputs
 *   dc.c         distributed clocks: receive times, system time, control loop
 *   sii.c        the EEPROM interface
 *   protect.c    write protection, reset sequences
 *   registers.c  which registers there are, their reset values, rights and effects
 *   access.c     one access to the address space, from either side: registers or RAM
 *   fmmu.c       logical addresses
 *   route.c      what a passing frame needs to know
 *   esc.c        reset, time, the PDI side
 *   frame.c      datagrams: addressing, working counter
 */
#ifndef ECT_ESC_INTERNAL_H
#define ECT_ESC_INTERNAL_H

#include "esc/esc.h"
#include "wire/assert.h"
#include "wire/bytes.h"
#include "wire/registers.h"

enum { ECT_ESC_PORTS = 4 };

/** Which side makes an access. Also the index into ect_esc_sm_t::open. */
typedef enum ect_side { ECT_SIDE_ECAT, ECT_SIDE_PDI } ect_side_t;

/** ect_esc_t::per_frame. */
enum {
    ECT_FRAME_END_SII = 0x01, /**< EEPROM write enable lasts for one frame */
    ECT_FRAME_BEGINS = 0x02,  /**< so do other write enables, and a reset sequence that is not gone on with */
};

/** One access, as it travels down from the datagram or the PDI call. */
typedef struct ect_access {
    ect_side_t side;
    bool write;
    bool latches;        /**< a write by station address or broadcast: at 0x0900 it takes the receive times */
    uint8_t *data;       /**< read: destination; write: source, only read */
    const uint8_t *mask; /**< bits that count, a byte for each byte of data; NULL: all */
} ect_access_t;

/** The rest of an access from `offset` on. */
static inline ect_access_t ect_esc_slice(const ect_access_t *access, uint16_t offset)
{
    ect_access_t part = *access;
    part.data += offset;
    if (part.mask)
        part.mask += offset;
    return part;
}

/** Whether the byte at `wanted` is one of an access from `address` to before `end`. */
static inline bool ect_esc_within(uint32_t address, uint32_t end, uint32_t wanted)
{
    return address <= wanted && wanted < end;
}

/* --- memory.c --------------------------------------------------------------------------------------------------- */
void ect_esc_copy(const ect_access_t *access, uint8_t *memory, uint16_t offset, uint16_t length);
void ect_esc_raise(ect_esc_t *esc, uint32_t al_event);
void ect_esc_clear(ect_esc_t *esc, uint32_t al_event);
void ect_esc_raise_ecat(ect_esc_t *esc, uint16_t ecat_event);
void ect_esc_clear_ecat(ect_esc_t *esc, uint16_t ecat_event);
void ect_esc_count(ect_esc_t *esc, uint16_t counter_register);
/* Something will happen by itself at that time. */
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
/* The chip answers AL control itself: a device without a microcontroller. */
static inline bool ect_esc_emulates(const ect_esc_t *esc)
{
    return (esc->memory[ECT_REG_PDI_CONTROL + 1] & 0x01) != 0;
}

/* The ECAT events that datagrams take along. */
static inline uint16_t ect_esc_shown_events(const ect_esc_t *esc)
{
    return ect_load_le16(esc->memory + ECT_REG_ECAT_EVENT) & ect_load_le16(esc->memory + ECT_REG_ECAT_EVENT_MASK);
}
/* Where it is reached besides its station address: its alias, if the master has enabled it, else that same address. */
static inline uint16_t ect_esc_second_station(const ect_esc_t *esc)
{
    bool alias = (esc->memory[ECT_REG_DL_CONTROL + 3] & 0x01) != 0;
    return ect_load_le16(esc->memory + (alias ? ECT_REG_STATION_ALIAS : ECT_REG_STATION_ADDRESS));
}

/* --- led.c ------------------------------------------------------------------------------------------------------ */
/* AL status has changed: the RUN lamp follows, whoever has had it. */
void ect_esc_led_state(ect_esc_t *esc);
/* Something that the ERR lamp shows may have changed. */
void ect_esc_led_errors(ect_esc_t *esc);
void ect_esc_led_write(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);

/* --- port.c ----------------------------------------------------------------------------------------------------- */
/* Link and loop bits anew from the cabling and from DL control; a change raises the ECAT event. */
void ect_esc_update_dl_status(ect_esc_t *esc);
void ect_esc_port_control(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);
void ect_esc_port_tick(ect_esc_t *esc);
bool ect_esc_marks_source(const ect_esc_t *esc);

/* --- watchdog.c ------------------------------------------------------------------------------------------------- */
void ect_esc_watchdog_trigger(ect_esc_t *esc);
void ect_esc_watchdog_time_written(ect_esc_t *esc);
/* The PDI has looked in, or whether it is watched is another thing now. */
void ect_esc_watchdog_pdi(ect_esc_t *esc);
void ect_esc_watchdog_tick(ect_esc_t *esc);

/* --- clock.c ---------------------------------------------------------------------------------------------------- */
static inline bool ect_esc_dc_present(const ect_esc_t *esc)
{
    return (esc->config.personality->features & ECT_FEATURE_DC) != 0;
}
void ect_esc_clock_reset(ect_esc_t *esc);
/* The local clock at a time that is not before the last change of its rate. */
uint64_t ect_esc_local_at(const ect_esc_t *esc, uint64_t real_ns);
/* The local clock when this frame reached the processing unit. */
uint64_t ect_esc_frame_time(const ect_esc_t *esc);
/* When the local clock will have gone on by `wait_ns`; UINT64_MAX: not in this life. */
uint64_t ect_esc_real_after(const ect_esc_t *esc, uint64_t wait_ns);
/* Begins its line anew at this moment, so that rates may be changed. */
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
bool ect_esc_sm_write_register(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);
void ect_esc_sm_read_register(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);

/* --- sync.c ----------------------------------------------------------------------------------------------------- */
void ect_esc_sync_reset(ect_esc_t *esc);
void ect_esc_sync_tick(ect_esc_t *esc);
/* Clock, system time or grid are about to change: what there were of pulses until now is by what held until now,
 * whether or not somebody has looked meanwhile. */
void ect_esc_sync_settle(ect_esc_t *esc);
/* Clock or system time have changed: the time of the next pulse has to be found anew. */
void ect_esc_sync_moved(ect_esc_t *esc);
void ect_esc_sync_refresh(ect_esc_t *esc, uint16_t address, uint16_t end);
bool ect_esc_sync_control(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);
bool ect_esc_sync_activate(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);
bool ect_esc_sync_start(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);
bool ect_esc_sync_cycle(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);
void ect_esc_sync_acknowledge(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);
bool ect_esc_latch_control(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);
void ect_esc_latch_read(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);

/* --- dc.c ------------------------------------------------------------------------------------------------------- */
/* Somebody is about to read from `address` to `end`: registers that follow the time are brought up to date. */
void ect_esc_dc_refresh(ect_esc_t *esc, ect_side_t side, uint16_t address, uint16_t end);
bool ect_esc_dc_latch(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);
/* Whether the system time that comes from a side regulates the clock. */
bool ect_esc_dc_follows(const ect_esc_t *esc, ect_side_t side);
/* A frame, which the clock follows, brings the system time. */
void ect_esc_dc_take(ect_esc_t *esc, uint32_t time);
bool ect_esc_dc_compare(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);
bool ect_esc_dc_write_loop(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);
bool ect_esc_dc_write_speed(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);

/* --- sii.c ------------------------------------------------------------------------------------------------------ */
void ect_esc_sii_load(ect_esc_t *esc, bool power_on);
void ect_esc_sii_tick(ect_esc_t *esc);
bool ect_esc_sii_write_register(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);
void ect_esc_sii_end_of_frame(ect_esc_t *esc);

/* --- protect.c -------------------------------------------------------------------------------------------------- */
/* Takes the write enables that a write of the master brings along. @return whether there was one that can be taken */
bool ect_esc_unlock(ect_esc_t *esc, uint16_t address, uint16_t length);
/* From where on the master may write: 0 everywhere, UINT32_MAX nowhere. */
uint32_t ect_esc_first_writable(const ect_esc_t *esc);
bool ect_esc_protect_write(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);
bool ect_esc_reset_write(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);
/* A frame, or a PDI access, begins: what lasts for one only has ended. */
void ect_esc_protect_begins(ect_esc_t *esc, ect_side_t side);
/* Whether a reset sequence is complete. */
bool ect_esc_reset_due(const ect_esc_t *esc);

/* --- registers.c ------------------------------------------------------------------------------------------------ */
/* All of them as after a reset; what stands in the EEPROM is loaded later. */
void ect_esc_registers_reset(ect_esc_t *esc);
/* Whether at least one byte was accessible; 1 to 4096 bytes below ECT_RAM. */
bool ect_esc_register_access(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);

/* --- access.c --------------------------------------------------------------------------------------------------- */
/* Whether protection has a say in an access. */
static inline bool ect_esc_guards(const ect_esc_t *esc, const ect_access_t *access)
{
    return access->write && access->side == ECT_SIDE_ECAT &&
           (esc->memory[ECT_REG_WRITE_PROTECTION] | esc->memory[ECT_REG_ESC_WRITE_PROTECTION]) != 0;
}
bool ect_esc_any_access(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);

/* Whether at least one byte was accessible. Cyclic data, and those are most, stay inside one SyncManager. */
static inline bool ect_esc_access(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    uint32_t end = (uint32_t)address + length;
    bool managed = address >= ECT_RAM && esc->sii_valid && end <= esc->memory_size && !ect_esc_guards(esc, access);
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
/* As ect_esc_tick, and cheap while nothing is due. */
void ect_esc_advance(ect_esc_t *esc, uint64_t now_ns);
/* What a frame or a PDI access has begun ends: a reset, if a sequence is complete. */
void ect_esc_access_ends(ect_esc_t *esc);

/* Bytes that 16 bits can name. */
enum { ECT_ESC_ADDRESS_SPACE = 0x10000 };

/* --- fmmu_registers.c ------------------------------------------------------------------------------------------- */
bool ect_esc_fmmu_write_register(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);

/* --- fmmu.c ----------------------------------------------------------------------------------------------------- */
/* Bit 0 read succeeded, bit 1 write succeeded. */
unsigned int ect_esc_fmmu_access(ect_esc_t *esc, uint32_t logical, uint8_t *data, uint16_t length, bool read,
                                 bool write);
static inline const uint8_t *ect_esc_fmmu_registers(const ect_esc_t *esc, unsigned int n)
{
    return esc->memory + ECT_REG_FMMU + ECT_FMMU_SIZE * n;
}

#endif
