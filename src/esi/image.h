/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Devices without an ESI file: the model of a device from its EEPROM image, and from the dictionary that a slave has.
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

/** An object of a slave's dictionary. */
typedef struct ect_esi_found_object {
    uint16_t index;
    bool described; /**< its type and those of its entries are known; else only its values, which name PDOs */
    uint8_t code;   /**< ECT_OBJECT_... */
    const char *name;
} ect_esi_found_object_t;

/** An entry of an object. Bytes are in the order of the wire; none: not known. */
typedef struct ect_esi_found_entry {
    uint8_t subindex;
    uint16_t type, bits, access; /**< as SDO information has them */
    const char *name;
    ect_esi_bytes_t unit, minimum, maximum;
    ect_esi_bytes_t value; /**< the default of the twin's entry */
} ect_esi_found_entry_t;

/**
 * Adds an object that was read from the slave, before any call of ::ect_esi_select. An index that is
 * there already is ignored. Everything that the arguments point to is copied.
 * @param esi  from ::ect_esi_of_image or ::ect_esi_single_begin
 */
void ect_esi_found_object(ect_esi_t *esi, const ect_esi_found_object_t *object);

/** Adds an entry to the object that was added last. */
void ect_esi_found_entry(ect_esi_t *esi, const ect_esi_found_entry_t *entry);

/**
 * Ends the dictionary. Mappings (1600h to 17FFh, 1A00h to 1BFFh) whose values were read replace the PDOs of the image,
 * and assignments (1C10h to 1C2Fh) their SyncManagers: what the slave has now, not what its vendor preset.
 */
void ect_esi_found_end(ect_esi_t *esi);

ECT_C_END

#endif
