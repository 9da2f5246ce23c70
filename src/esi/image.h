/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Devices without an ESI file: the model of a device from its EEPROM image, and from the dictionary of a slave.
 *
 * The result is an ::ect_esi_t like that of a file with one device, with the same uses: twins, documents, ESI files,
 * comparisons. Its EEPROM is the image, byte by byte, with a valid checksum.
 *
 * An image describes the PDOs, but no other object. A PDO with a SyncManager is assigned to this SyncManager, in the
 * order of the image, while the SyncManager's length has room. A SyncManager of process data without PDOs gets one PDO
 * of one-byte entries.
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
 * Makes the model of an image of any origin; never reads beyond `size`. A truncated category is ignored.
 * @param name   prefix of messages
 * @param image  need not outlive the call
 * @param[out] text, room  the error, one line
 * @return to be freed by ::ect_esi_close; NULL: less than the 128 bytes of a header, without vendor id and product
 *         code, or no memory
 */
ect_esi_t *ect_esi_of_image(const char *name, const uint8_t *image, size_t size, char *text, size_t room);

/** An object of a slave's dictionary. */
typedef struct ect_esi_found_object {
    uint16_t index;
    bool described; /**< types of the object and its entries are known; false: only values, which define PDOs */
    uint8_t code;   /**< ECT_OBJECT_... */
    const char *name;
} ect_esi_found_object_t;

/** An entry of an object. Bytes are little-endian; none: unknown. */
typedef struct ect_esi_found_entry {
    uint8_t subindex;
    uint16_t type, bits, access; /**< as in SDO information */
    const char *name;
    ect_esi_bytes_t unit, minimum, maximum;
    ect_esi_bytes_t value; /**< the default of the twin's entry */
} ect_esi_found_entry_t;

/**
 * Adds an object read from the slave. Call it before ::ect_esi_select. An existing index is ignored. All data are
 * copied.
 * @param esi  from ::ect_esi_of_image or ::ect_esi_single_begin
 */
void ect_esi_found_object(ect_esi_t *esi, const ect_esi_found_object_t *object);

/** Adds an entry to the last added object. */
void ect_esi_found_entry(ect_esi_t *esi, const ect_esi_found_entry_t *entry);

/**
 * Ends the dictionary. Mappings (1600h to 17FFh, 1A00h to 1BFFh) with known values replace the PDOs of the image, and
 * assignments (1C10h to 1C2Fh) their SyncManagers: the present configuration of the slave replaces the vendor's.
 */
void ect_esi_found_end(ect_esi_t *esi);

ECT_C_END

#endif
