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

/** A file that a master may write. Lives as long as the slave. */
typedef struct foe_file_cfg foe_file_cfg_t;
struct foe_file_cfg {
    const char *name;
    uint32_t max_data;           /**< bytes that it may have */
    uint32_t dest_start_address; /**< the application's */
    uint32_t address_offset;     /**< bytes handed to write_function before this call */
    uint32_t total_size;         /**< bytes that have come with earlier mails */
    uint32_t filepass;           /**< password that the master must give */
    uint8_t write_only_in_boot;  /**< 1: only in BOOT */
    uint32_t padding : 24;
    /** Takes the next `length` bytes, at most foe_cfg_t::buffer_size. @return 0, or an error of FoE (FOE_ERR_...) */
    uint32_t (*write_function)(foe_file_cfg_t *self, uint8_t *data, size_t length);
};

typedef struct foe_cfg {
    uint8_t *fbuffer;     /**< buffer_size bytes, where a file is collected before it is handed over */
    uint32_t buffer_size; /**< bytes */
    uint32_t n_files;
    foe_file_cfg_t *files;
} foe_cfg_t;

/**
 * Which files there are, for masters to write; they cannot be read. Before ecat_slv_init; `cfg` must live as long as
 * the slave. write_function is called when fbuffer is full, and with the rest, perhaps of 0 bytes, at the end.
 */
void FOE_config(foe_cfg_t *cfg);
/** Forgets a transfer that is under way. */
void FOE_init(void);
/** Nothing is left to do: ::ESC_state does it. For loops that are made of the pieces. */
void ESC_foeprocess(void);

ECT_C_END

#endif
