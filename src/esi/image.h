/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Devices without an ESI file: the model of a device from its EEPROM image.
 *
 * The result is an ::ect_esi_t as that of a file with one device, and serves wherever one does: twins, documents,
 * ESI files, comparisons. Its EEPROM is the image, byte by byte, with a check value that is right.
 *
 * An image lists the PDOs, and nothing else of the dictionary. A PDO that names a SyncManager is assigned to it, in the
 * order of the image, as long as the SyncManager's length has room. A SyncManager of process data without any PDO gets
 * one whose entries are bytes.
 *
 * Host only. Context: mainline. Clauses: ETG.1000.6 §5.4, ETG.2010.
 */
#ifndef ECT_ESI_IMAGE_H
#define ECT_ESI_IMAGE_H

#include <stddef.h>
#include <stdint.h>

#include "esi/read.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/**
 * Makes the model of an image of any origin; never reads beyond `size`. A category that is cut off by the end of the
 * image is left out.
 * @param name   prefix of messages
 * @param image  need not outlive the call
 * @param[out] text, room  the error, one line
 * @return to be freed by ::ect_esi_close; NULL: less than the 128 bytes of a header, without vendor id and product
 *         code, or no memory
 */
ect_esi_t *ect_esi_of_image(const char *name, const uint8_t *image, size_t size, char *text, size_t room);

ECT_C_END

#endif
