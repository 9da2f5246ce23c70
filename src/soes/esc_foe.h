/* SPDX-License-Identifier: MIT */
/**
 * @file
 * SOES's API: files by FoE.
 */
#ifndef ECT_SOES_ESC_FOE_H
#define ECT_SOES_ESC_FOE_H

#include "soes/cc.h"

#include "wire/linkage.h"

ECT_C_BEGIN

/** Longest name of a file, characters. */
#define FOE_FN_MAX 31

/** A file that a master may write; must outlive the slave. */
typedef struct foe_file_cfg foe_file_cfg_t;
struct foe_file_cfg {
    const char *name;
    uint32_t max_data;           /**< largest size, bytes */
    uint32_t dest_start_address; /**< the application's */
    uint32_t address_offset;     /**< bytes passed to write_function before this call */
    uint32_t total_size;         /**< bytes received with earlier mails */
    uint32_t filepass;           /**< required password */
    uint8_t write_only_in_boot;  /**< 1: only in BOOT */
    uint32_t padding : 24;
    /** Gets the next `length` bytes, at most foe_cfg_t::buffer_size. @return 0, or an error of FoE (FOE_ERR_...) */
    uint32_t (*write_function)(foe_file_cfg_t *self, uint8_t *data, size_t length);
};

typedef struct foe_cfg {
    uint8_t *fbuffer;     /**< buffer_size bytes, which collect a file before write_function */
    uint32_t buffer_size; /**< bytes */
    uint32_t n_files;
    foe_file_cfg_t *files;
} foe_cfg_t;

/**
 * Sets the files that masters may write; files cannot be read. Due before ecat_slv_init; `cfg` must outlive the slave.
 * write_function is called when fbuffer is full, and with the rest, which may be of 0 bytes, at the end.
 */
void FOE_config(foe_cfg_t *cfg);
/** Drops a transfer under way. */
void FOE_init(void);
/** No effect, because ::ESC_state does this work. For loops that call the parts. */
void ESC_foeprocess(void);

ECT_C_END

#endif
