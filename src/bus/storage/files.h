/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The files of a twin on a PC: a folder that a master reads and writes by FoE.
 *
 * Names have 1 to 128 letters, digits and `. _ - +`, and do not begin with a dot, so no name leads out of the folder or
 * to a hidden file. Symbolic links are not followed, and only regular files are opened. A written file has a hidden
 * name until it is complete, and then replaces the previous file. A file has at most 64 MiB.
 *
 * Calls do not wait for the disk: a written file survives the end of the process at once, a power failure after some
 * seconds.
 */
#ifndef ECT_BUS_STORAGE_FILES_H
#define ECT_BUS_STORAGE_FILES_H

#include "seams/device.h"
#include "seams/foe.h"
#include "wire/linkage.h"

ECT_C_BEGIN

enum { ECT_FILES_MESSAGE = 640, ECT_FILES_MOST = 64 * 1024 * 1024 };

typedef struct ect_files ect_files_t;

/**
 * Opens a folder for one twin, and derives a device with FoE in every state with a mailbox, and in BOOT. A device
 * without mailboxes for BOOT uses those of PREOP.
 * @param device        must outlive the files
 * @param password      of the FoE requests; 0: any
 * @param[out] message  on failure one line for the user; ECT_FILES_MESSAGE bytes
 * @return the files, to be closed with ::ect_files_close after the chain; NULL: no such folder, or the device has no
 *         mailbox, or files of its own
 */
ect_files_t *ect_files_open(const char *folder, const ect_device_t *device, uint32_t password, char *message);

/** The derived device; valid until the files are closed. */
const ect_device_t *ect_files_device(const ect_files_t *files);

/** @return whether a name of `length` bytes is allowed for files */
bool ect_files_fits(const char *name, size_t length);

/** Closes the folder; an incomplete file is removed. NULL: no effect */
void ect_files_close(ect_files_t *files);

ECT_C_END

#endif
