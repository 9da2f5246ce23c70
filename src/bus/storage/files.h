/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The files of a twin on a PC: those of a folder, which a master reads and writes by FoE.
 *
 * Names are those of files in the folder itself: 1 to 128 letters, digits and `. _ - +`, the first one no dot. So no
 * name leads out of it, nor to what is hidden in it; links are not followed, and only ordinary files are opened. What a
 * master writes becomes the file when it is whole, and until then stands beside it under a hidden name; what was there
 * before is replaced. At most 64 MiB.
 *
 * The disk is not waited for: a file that was written survives the end of the process at once, a power failure a little
 * later.
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
 * Opens a folder for one twin, and makes its device one that offers files in every state, BOOT among them; where the
 * device has no mailboxes for BOOT they are those of PREOP.
 * @param device        must outlive the files
 * @param password      that a master must give, 0: any
 * @param[out] message  on failure one line for the user; ECT_FILES_MESSAGE bytes
 * @return the files, to be closed with ::ect_files_close behind the chain, or NULL: no such folder; the device has no
 *         mailbox, or files of its own
 */
ect_files_t *ect_files_open(const char *folder, const ect_device_t *device, uint32_t password, char *message);

/** The device with files, in place of the one that was given; valid until the files are closed. */
const ect_device_t *ect_files_device(const ect_files_t *files);

/** Closes the folder; a file that is not whole is forgotten. NULL: nothing happens. */
void ect_files_close(ect_files_t *files);

ECT_C_END

#endif
