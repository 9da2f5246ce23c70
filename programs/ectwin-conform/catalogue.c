/* SPDX-License-Identifier: MIT */
/* The sections in the order of the checklist. A new section needs a file and a line here. */
#include "catalogue.h"

extern const cf_section_t cf_datalink;
extern const cf_section_t cf_syncman;
extern const cf_section_t cf_fmmu;
extern const cf_section_t cf_machine;
extern const cf_section_t cf_watchdog;
extern const cf_section_t cf_eeprom;
extern const cf_section_t cf_coe;
extern const cf_section_t cf_coe_more;
extern const cf_section_t cf_modules;
extern const cf_section_t cf_mailbox;
extern const cf_section_t cf_dc;
extern const cf_section_t cf_system;
extern const cf_section_t cf_beyond;
extern const cf_section_t cf_drive;

const cf_section_t *const cf_catalogue[] = {
    &cf_datalink, &cf_syncman, &cf_fmmu,    &cf_machine, &cf_watchdog, &cf_eeprom, &cf_coe,
    &cf_coe_more, &cf_modules, &cf_mailbox, &cf_dc,      &cf_system,   &cf_beyond, &cf_drive,
};
const size_t cf_catalogue_count = sizeof cf_catalogue / sizeof cf_catalogue[0];

const char *cf_need_text(uint32_t bit)
{
    static const char *const texts[CF_NEEDS_COUNT] = {
        "the slave has no mailbox",
        "the slave has no CoE",
        "the slave has no SDO information service",
        "the slave has no Complete Access",
        "the slave has no FoE",
        "the slave has no EoE",
        "the SII contains no bootstrap mailbox, or no FoE",
        "the chip has no distributed clocks",
        "the slave has no outputs",
        "the slave has no inputs",
        "no software behind the chip (device emulation)",
        "there is software behind the chip (no device emulation)",
        "there is no other slave on the segment",
        "the chip has no APRW, FPRW, BRW",
        "the chip has no LRW",
        "the EEPROM cannot be read",
        "needs --destructive: it writes the EEPROM",
        "no ESI file was given (--esi FILE)",
        "needs real time, which an emulated slave does not have (--emulated)",
        "the slave is no CiA 402 drive (6040h, 6041h)",
        "needs --move: it gives torque to the motor and turns it",
    };
    for (unsigned int n = 0; n < CF_NEEDS_COUNT; n++) {
        if ((bit & (1u << n)) != 0)
            return texts[n];
    }
    return "";
}
