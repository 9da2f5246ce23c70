/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The configuration of one twin of a chain.
 */
#ifndef ECT_BUS_CHAIN_TWIN_CONFIG_H
#define ECT_BUS_CHAIN_TWIN_CONFIG_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/chain/slow_config.h"
#include "seams/device.h"
#include "seams/plant.h"
#include "seams/storage.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** Signals in addition to the device's, such as those of the network behind it. Zeroed: none. */
typedef struct ect_beside {
    const ect_plant_t *plant; /**< must outlive the chain */
    void *instance; /**< must outlive the chain; keeps its content in a power cycle; 1 to ECT_BESIDE_MOST bytes */
    size_t size;    /**< of the instance */
} ect_beside_t;

enum { ECT_BESIDE_MOST = 16 };

/** One twin of a chain. ::ect_twin_default sets all members. */
typedef struct ect_twin_config {
    const ect_device_t *device;   /**< must outlive the chain; ::ect_device_check accepts it */
    const ect_plant_t *plant;     /**< must outlive the chain; NULL: none */
    ect_beside_t beside;          /**< more signals */
    ect_identity_t identity;      /**< vendor, product, revision, serial number; copied */
    uint16_t alias;               /**< configured station alias and explicit device id; 0 none */
    const ect_storage_t *storage; /**< non-volatile memory, must outlive the chain; NULL: none */
    /**
     * Initial content of the EEPROM, sii_size bytes of the description; copied. NULL: generated from the description.
     */
    const uint8_t *sii;
    /** Called by the poll after the master has written to the EEPROM, with the entire content. NULL: not called. */
    void (*sii_written)(void *sii_ctx, const uint8_t *sii, uint32_t size);
    void *sii_ctx; /**< passed to `sii_written` */
    size_t up;     /**< if up_port is not 0: position of the slave that port 0 is wired to; less than the twin's own */
    uint8_t up_port;    /**< port of that slave, 1, 2 or 3; 0: port 1 of the slave before this one */
    uint16_t cable_m;   /**< length of the cable at port 0, metres; adds to propagation delays */
    int32_t drift_ppb;  /**< deviation of the oscillator, -ECT_ESC_MAX_DRIFT_PPB..ECT_ESC_MAX_DRIFT_PPB; > 0: fast */
    uint32_t eeprom_ns; /**< duration of an EEPROM command (ect_esc_config_t::sii_command_ns) */
    ect_slow_config_t slow; /**< delays of the microcontroller */
    const char *esc;        /**< name of the chip (esc/personality.h); NULL: the chip of the description */
    bool keep_source_mac;   /**< true: bit 1 of the first byte of the source address is not changed */
} ect_twin_config_t;

/**
 * Default duration of an EEPROM command: long enough for a master that does not wait for the end to read the previous
 * data, short enough for a fast scan of many slaves.
 */
enum { ECT_TWIN_EEPROM_NS = 20000 };

/**
 * Returns the configuration that the description implies: its identity, chip and EEPROM, EEPROM commands of
 * ECT_TWIN_EEPROM_NS, 1 m of cable, no storage.
 */
ect_twin_config_t ect_twin_default(const ect_device_t *device, const ect_plant_t *plant);

ECT_C_END

#endif
