/* SPDX-License-Identifier: MIT */
/* An EEPROM that the microcontroller emulates for its ESC (ET1100 data sheet, 0x0502 bit 5). */
#include "soes/esc_eep.h"

/* Defaults for a slave whose ESC has an EEPROM of its own; the hardware file's functions replace these. */
__attribute__((weak)) void EEP_init(void)
{
}

__attribute__((weak)) int8_t EEP_read(uint32_t addr, uint8_t *data, uint16_t size)
{
    (void)addr;
    (void)data;
    (void)size;
    return -1;
}

__attribute__((weak)) int8_t EEP_write(uint32_t addr, uint8_t *data, uint16_t size)
{
    (void)addr;
    (void)data;
    (void)size;
    return -1;
}

enum { LARGEST_READ = 8, COMMANDS = 64 /* successive commands; the loop then continues, because the event remains */ };

static uint16_t read_size = LARGEST_READ;
static void (*reload)(eep_stat_t *stat);

void EEP_set_read_size(uint16_t size)
{
    if (size == 4 || size == LARGEST_READ)
        read_size = size;
}

void EEP_set_reload_function_pointer(void (*reload_ptr)(eep_stat_t *stat))
{
    reload = reload_ptr;
}

/* Copies bytes of the EEPROM to the data register. @return whether the EEPROM has the bytes */
static bool deliver(uint32_t word, uint16_t size)
{
    uint8_t data[LARGEST_READ];
    if (EEP_read(word * 2, data, size) != 0)
        return false;
    ESC_write(ESCREG_EEDATA, data, size);
    return true;
}

/* With 4 bytes for each read, a reload requests only the station alias. */
static bool deliver_reload(uint32_t word)
{
    return read_size == LARGEST_READ ? deliver(word, read_size) : deliver(EEP_CONFIG_ALIAS_WORD_OFFSET, 2);
}

static bool store(uint32_t word)
{
    uint8_t data[EEP_WRITE_SIZE];
    ESC_read(ESCREG_EEDATA, data, sizeof data);
    return EEP_write(word * 2, data, sizeof data) == 0;
}

static void carry_out(eep_stat_t *stat)
{
    bool done = true;
    switch (stat->contstat.bits.cmdReg) {
    case EEP_CMD_IDLE:
        break;
    case EEP_CMD_READ:
        done = deliver(stat->addr, read_size);
        break;
    case EEP_CMD_WRITE:
        done = store(stat->addr);
        break;
    case EEP_CMD_RELOAD:
        if (reload)
            reload(stat);
        else
            done = deliver_reload(stat->addr);
        break;
    default:
        done = false;
        break;
    }
    if (!done)
        stat->contstat.bits.ackErr = 1;
}

/* The ESC presents the next command as soon as this one is acknowledged. */
void EEP_process(void)
{
    eep_stat_t stat;
    if ((ESCvar.ALevent & ESCREG_ALEVENT_EEP) == 0)
        return;
    for (unsigned int n = 0; n < COMMANDS; n++) {
        ESC_read(ESCREG_EECONTSTAT, &stat, sizeof stat);
        stat.contstat.reg = etohs(stat.contstat.reg);
        stat.addr = etohl(stat.addr);
        if (stat.contstat.bits.busy == 0)
            return;
        stat.contstat.bits.csumErr = 0;
        stat.contstat.bits.eeLoading = 0;
        stat.contstat.bits.ackErr = 0;
        stat.contstat.bits.wrErr = 0;
        carry_out(&stat);
        uint16_t reg = htoes(stat.contstat.reg);
        ESC_write(ESCREG_EECONTSTAT, &reg, sizeof reg);
    }
}
