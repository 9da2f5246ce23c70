/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What the files of esc/ know of each other. Nobody else includes this.
 *
 * From the lowest to the highest; each knows only those above it in this list (tests/check/order.py):
 *
 *   memory.c     bytes of an access, event words, counters
 *   port.c       link and loop bits
 *   watchdog.c   the process-data watchdog
 *   syncman.c    SyncManagers: who may enter which buffer
 *   dc.c         distributed clocks
 *   sii.c        the EEPROM interface
 *   registers.c  access rights and effects of the registers
 *   access.c     one access to the address space, from either side: registers or RAM
 *   fmmu.c       logical addresses
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

/** One access, as it travels down from the datagram or the PDI call. */
typedef struct ect_access {
    ect_side_t side;
    bool write;
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

/* --- memory.c --------------------------------------------------------------------------------------------------- */
void ect_esc_copy(const ect_access_t *access, uint8_t *memory, uint16_t offset, uint16_t length);
void ect_esc_raise(ect_esc_t *esc, uint32_t al_event);
void ect_esc_clear(ect_esc_t *esc, uint32_t al_event);
void ect_esc_raise_ecat(ect_esc_t *esc, uint16_t ecat_event);
void ect_esc_clear_ecat(ect_esc_t *esc, uint16_t ecat_event);
void ect_esc_count(ect_esc_t *esc, uint16_t counter_register);

/* --- port.c ----------------------------------------------------------------------------------------------------- */
/* Link and loop bits anew from the cabling and from DL control; a change raises the ECAT event. */
void ect_esc_update_dl_status(ect_esc_t *esc);

/* --- watchdog.c ------------------------------------------------------------------------------------------------- */
void ect_esc_watchdog_trigger(ect_esc_t *esc);
void ect_esc_watchdog_time_written(ect_esc_t *esc);
void ect_esc_watchdog_tick(ect_esc_t *esc);

/* --- syncman.c -------------------------------------------------------------------------------------------------- */
static inline uint8_t *ect_esc_sm_registers(const ect_esc_t *esc, unsigned int n)
{
    return esc->memory + ECT_REG_SM + ECT_SM_SIZE * n;
}
bool ect_esc_sm_enabled(const ect_esc_t *esc, unsigned int n);
void ect_esc_sm_reset(ect_esc_t *esc, unsigned int n);
bool ect_esc_sm_access(ect_esc_t *esc, unsigned int n, const ect_access_t *access, uint16_t offset, uint16_t length);
bool ect_esc_sm_write_register(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);
void ect_esc_sm_read_register(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);

/* --- dc.c ------------------------------------------------------------------------------------------------------- */
bool ect_esc_dc_present(const ect_esc_t *esc);
uint64_t ect_esc_dc_tick(ect_esc_t *esc);
void ect_esc_dc_refresh(ect_esc_t *esc);
bool ect_esc_dc_latch(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);
bool ect_esc_dc_compare(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);
bool ect_esc_dc_write_plain(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);
bool ect_esc_dc_write_speed(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);
bool ect_esc_dc_activate(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);
void ect_esc_dc_acknowledge(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);

/* --- sii.c ------------------------------------------------------------------------------------------------------ */
void ect_esc_sii_load(ect_esc_t *esc, bool power_on);
void ect_esc_sii_tick(ect_esc_t *esc);
bool ect_esc_sii_write_register(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);
void ect_esc_sii_end_of_frame(ect_esc_t *esc);

/* --- registers.c ------------------------------------------------------------------------------------------------ */
/* Whether at least one byte was accessible; 1 to 4096 bytes below ECT_RAM. */
bool ect_esc_register_access(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);

/* --- access.c --------------------------------------------------------------------------------------------------- */
/* Whether at least one byte was accessible. */
bool ect_esc_access(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);

/* --- fmmu.c ----------------------------------------------------------------------------------------------------- */
/* Bit 0 read succeeded, bit 1 write succeeded. */
unsigned int ect_esc_fmmu_access(ect_esc_t *esc, uint32_t logical, uint8_t *data, uint16_t length, bool read,
                                 bool write);

#endif
