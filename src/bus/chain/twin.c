/* SPDX-License-Identifier: MIT */
#include "bus/chain/twin.h"

#include <stdlib.h>
#include <string.h>

#include "ports/virtual/virtual.h"
#include "seams/mailbox.h"
#include "seams/standard.h"
#include "sii/sii.h"
#include "wire/assert.h"

ect_twin_config_t ect_twin_default(const ect_device_t *device, const ect_plant_t *plant)
{
    return (ect_twin_config_t){
        .device = device, .plant = plant, .identity = device->identity, .eeprom_ns = ECT_TWIN_EEPROM_NS, .cable_m = 1};
}

static void *allocate(void *of, size_t size)
{
    ect_twin_t *twin = of;
    ECT_ASSERT(twin->blocks < ECT_TWIN_BLOCKS);
    void *block = calloc(1, size > 0 ? size : 1);
    if (block)
        twin->memory[twin->blocks++] = block;
    return block;
}

const ect_esc_personality_t *ect_twin_chip(const ect_twin_config_t *config)
{
    return ect_esc_personality(config->esc ? config->esc : config->device->esc);
}

_Static_assert(sizeof(void *) != 8 || offsetof(ect_twin_t, slave.config) % ECT_TWIN_LINE == 0,
               "on 64 bits the configuration of the slave begins at a line");

static size_t esc_size(const ect_twin_config_t *config)
{
    const ect_esc_personality_t *chip = ect_twin_chip(config);
    return chip ? ECT_ESC_MEMORY_SIZE(chip->ram_kb) : 0;
}

/* An odd number of lines puts the same register of many twins into different sets of the cache: sizes of ESCs are
 * multiples of 1 KB, which would leave that register a sixteenth of the sets or fewer. */
size_t ect_twin_ram_size(const ect_twin_config_t *config)
{
    return esc_size(config) + ECT_TWIN_LINE;
}

size_t ect_twin_buffer_size(const ect_twin_config_t *config)
{
    return (config->device->buffer_size + ECT_TWIN_LINE - 1) / ECT_TWIN_LINE * ECT_TWIN_LINE;
}

static bool make_esc(ect_twin_t *twin)
{
    const ect_twin_config_t *c = &twin->config;
    const ect_esc_personality_t *chip = ect_twin_chip(c);
    if (!chip)
        return false;
    uint8_t *sii = allocate(twin, c->device->sii_size);
    if (!sii || ect_sii_write(c->device, &c->identity, c->alias, sii, c->device->sii_size) < 0)
        return false;
    if (c->sii)
        memcpy(sii, c->sii, c->device->sii_size);
    twin->esc.config = (ect_esc_config_t){
        .personality = chip,
        .memory = twin->esc_memory,
        .sii = sii,
        .sii_size = c->device->sii_size,
        .sii_command_ns = c->eeprom_ns,
        .keep_source_mac = c->keep_source_mac,
        .drift_ppb = c->drift_ppb,
    };
    return true;
}

static bool make_slave(ect_twin_t *twin)
{
    const ect_plant_t *plant = twin->config.plant;
    twin->pdi = twin->slow ? ect_slow_pdi(twin->slow) : ect_virtual_pdi(&twin->esc);
    twin->slave.config = (ect_slave_config_t){
        .device = twin->config.device,
        .pdi = &twin->pdi,
        .identity = &twin->config.identity,
        .storage = twin->config.storage,
        .buffer = twin->buffer,
        .outside_offset = plant ? plant->outside_offset : 0,
        .outside_size = plant ? plant->outside_size : 0,
    };
    return ect_slave_take(&twin->slave.config, allocate, twin);
}

/* Restarts the twin: the configurations of controller and stack remain, all other state gets its initial value. */
static bool power_on(ect_twin_t *twin, const ect_slave_config_t *config, uint64_t now_ns)
{
    const ect_plant_t *plant = twin->config.plant;
    ect_esc_config_t esc = twin->esc.config;
    ect_slave_config_t slave = *config;
    const ect_esc_arrival_t arrival = twin->esc.arrival;
    esc.pdi_watched = false;
    slave.device_id = twin->config.alias;
    if (!slave.instance || ect_esc_init(&twin->esc, &esc, now_ns) != 0)
        return false;
    ect_esc_set_arrival(&twin->esc, &arrival);
    if (twin->slow)
        ect_slow_init(twin->slow, &twin->config.slow, &twin->esc, now_ns);
    slave.switches = plant && plant->station_alias ? plant->station_alias(slave.instance) : 0;
    for (unsigned int port = 0; port < ECT_TOPOLOGY_PORTS; port++)
        ect_esc_set_link(&twin->esc, port, twin->link[port]);
    twin->esc_ns = ECT_NEVER;
    twin->slave_ns = now_ns;
    if (twin->above)
        ect_above_restart(twin->above);
    return ect_slave_init(&twin->slave, &slave, now_ns) == 0;
}

/* The instance is already zero and is not cleared, so that untouched pages of a thousand instances stay unallocated.
 */
static bool power_on_first(ect_twin_t *twin, uint64_t now_ns)
{
    const ect_slave_config_t config = twin->slave.config;
    ect_slave_config_t fresh = config;
    fresh.outside_offset = sizeof(ect_standard_t);
    fresh.outside_size = config.device->instance_size - fresh.outside_offset;
    const bool done = power_on(twin, &fresh, now_ns);
    twin->slave.config.outside_offset = config.outside_offset;
    twin->slave.config.outside_size = config.outside_size;
    return done;
}

bool ect_twin_make(ect_twin_t *twin, const ect_twin_config_t *config, uint8_t *ram, uint8_t *buffer, uint64_t now_ns)
{
    ECT_ASSERT(config->beside.size <= ECT_BESIDE_MOST);
    twin->config = *config;
    twin->esc_memory = ram;
    twin->buffer = config->device->buffer_size > 0 ? buffer : NULL;
    twin->lamps = allocate(twin, sizeof *twin->lamps);
    bool slow = ect_slow_needed(&config->slow);
    twin->slow = slow ? allocate(twin, sizeof *twin->slow) : NULL;
    if (!twin->lamps || (slow && !twin->slow) || !make_esc(twin) || !make_slave(twin))
        return false;
    twin->wiring = (ect_wiring_t){.plug = {1, 1, 1, 1}, .drift_ppb = config->drift_ppb};
    return power_on_first(twin, now_ns);
}

void ect_twin_free(ect_twin_t *twin)
{
    for (size_t b = 0; b < twin->blocks; b++)
        free(twin->memory[b]);
    free(twin->above);
}

/* Unlike at the first power-on, the device may have written to the buffer. */
void ect_twin_restart(ect_twin_t *twin, uint64_t now_ns)
{
    if (twin->buffer)
        memset(twin->buffer, 0, twin->config.device->buffer_size);
    const ect_slave_config_t config = twin->slave.config;
    (void)power_on(twin, &config, now_ns); /* the same configuration has been accepted before */
}

/* Replaces the twin by one with the next product code. */
static void change_identity(ect_twin_t *twin)
{
    ect_esc_config_t *esc = &twin->esc.config;
    twin->config.identity.product_code++;
    (void)ect_sii_write(twin->config.device, &twin->config.identity, twin->config.alias, esc->sii, esc->sii_size);
}

static ect_sii_fault_t sii_fault_of(ect_fault_kind_t kind)
{
    switch (kind) {
    case ECT_FAULT_EEPROM_BUSY:
        return ECT_SII_BUSY;
    case ECT_FAULT_EEPROM_NACK:
        return ECT_SII_NO_ANSWER;
    case ECT_FAULT_EEPROM_FLIP:
        return ECT_SII_BIT_ERROR;
    default:
        return ECT_SII_GOOD;
    }
}

/* @return the reason of a refusal; NULL: done */
static const char *set_above(ect_twin_t *twin, const ect_fault_t *fault)
{
    if (!twin->above)
        twin->above = ect_above_new(&twin->esc);
    if (!twin->above)
        return "there is not enough memory";
    return ect_above_add(twin->above, fault, &twin->pdi) ? NULL
                                                         : "8 faults above the wire are set already: 'off' ends them";
}

/* @return the next lower state: OP, SAFEOP, PREOP, INIT */
static uint8_t below(uint8_t state)
{
    return state == ECT_STATE_BOOT ? ECT_STATE_INIT : state / 2;
}

/* Makes the device leave its state without a request. @return the reason of a refusal; NULL: done */
static const char *drop(ect_twin_t *twin, const ect_fault_t *fault)
{
    const ect_host_t *host = ect_slave_host(&twin->slave);
    uint8_t state = fault->kind == ECT_FAULT_INIT ? ECT_STATE_INIT
                    : fault->state != 0           ? fault->state
                                                  : below(twin->slave.state);
    if (state == 0 || state >= twin->slave.state)
        return "it is in that state already, or below: it can leave its state downwards only";
    host->drop(host->ctx, state, fault->code != 0 ? (uint16_t)fault->code : (uint16_t)ECT_AL_UNSPECIFIED);
    return NULL;
}

static const char *emergency(ect_twin_t *twin, const ect_fault_t *fault)
{
    const ect_protocol_t *const *protocol = twin->config.device->protocols;
    const ect_host_t *host = ect_slave_host(&twin->slave);
    while (protocol && *protocol && *protocol != &ect_protocol_emergency)
        protocol++;
    if (!protocol || !*protocol)
        return "its device has no emergencies";
    host->emergency(host->ctx, (uint16_t)fault->code, (uint8_t)fault->amount, fault->data);
    return NULL;
}

/* 0x030E on SPI: bits 0 to 2 are the clocks of the failed access, modulo 8. */
enum { SPI_CLOCK_TOO_MANY = 0x01 };

bool ect_twin_fault(ect_twin_t *twin, const ect_fault_t *fault, uint64_t now_ns, const char **why)
{
    ECT_ASSERT(!ect_fault_is_of_frames(fault));
    *why = NULL;
    if (ect_fault_is_above_wire(fault)) {
        *why = set_above(twin, fault);
        return false;
    }
    switch (fault->kind) {
    case ECT_FAULT_TO:
    case ECT_FAULT_INIT:
    case ECT_FAULT_AL:
        *why = drop(twin, fault);
        return false;
    case ECT_FAULT_EMERGENCY:
        *why = emergency(twin, fault);
        return false;
    case ECT_FAULT_HANG:
    case ECT_FAULT_RESUME:
        ect_esc_watch_pdi(&twin->esc, fault->kind == ECT_FAULT_HANG);
        return false;
    case ECT_FAULT_IDENTITY:
        change_identity(twin);
        ect_twin_restart(twin, now_ns);
        return true;
    case ECT_FAULT_RESET:
        ect_twin_restart(twin, now_ns);
        return true;
    case ECT_FAULT_LOSE_EVENT:
        ect_esc_lose_al_event(&twin->esc);
        return false;
    case ECT_FAULT_PDI_ERROR:
        ect_esc_pdi_error(&twin->esc, SPI_CLOCK_TOO_MANY);
        return false;
    case ECT_FAULT_CLOCK:
        ect_esc_clock_jump(&twin->esc, fault->amount);
        return false;
    default:
        ect_esc_sii_fault(&twin->esc, sii_fault_of(fault->kind), (unsigned int)fault->amount);
        return false;
    }
}

/* Signals of the surroundings that act on the chip. */
static void apply_wiring(ect_twin_t *twin)
{
    const ect_wiring_t *wiring = &twin->wiring;
    for (unsigned int n = 0; n < 2; n++)
        ect_esc_latch_input(&twin->esc, n, wiring->latch[n] != 0);
    if (twin->esc.config.drift_ppb != wiring->drift_ppb)
        ect_esc_set_drift(&twin->esc, wiring->drift_ppb);
}

static uint64_t run_slave(ect_twin_t *twin, uint64_t now_ns)
{
    if (!twin->above)
        return ect_slave_poll(&twin->slave, now_ns);
    ect_above_before(twin->above, now_ns);
    uint64_t next_ns = ect_slave_poll(&twin->slave, now_ns);
    return ect_earlier(next_ns, ect_above_after(twin->above, &twin->slave, &twin->pdi));
}

bool ect_twin_poll(ect_twin_t *twin, uint64_t now_ns)
{
    apply_wiring(twin);
    twin->seen = ect_esc_activity(&twin->esc);
    twin->slave_ns = ect_twin_hangs(twin) ? ECT_NEVER : run_slave(twin, now_ns);
    if (twin->slow)
        twin->slave_ns = ect_slow_end(twin->slow, twin->slave_ns);
    bool restarts = twin->slave.restart || ect_esc_resets(&twin->esc) != 0;
    if (restarts)
        ect_twin_restart(twin, now_ns);
    return restarts;
}

void ect_twin_report_sii(ect_twin_t *twin)
{
    if (twin->sii_seen == ect_esc_sii_writes(&twin->esc))
        return;
    twin->sii_seen = ect_esc_sii_writes(&twin->esc);
    if (twin->config.sii_written)
        twin->config.sii_written(twin->config.sii_ctx, twin->esc.config.sii, twin->esc.config.sii_size);
}

const ect_plant_t *ect_twin_plant(const ect_twin_t *twin)
{
    const ect_plant_t *plant = twin->config.plant;
    return plant && plant->present ? plant->present(twin->slave.config.instance) : plant;
}

bool ect_twin_signal(const ect_twin_t *twin, const char *name, ect_signal_ref_t *ref)
{
    return ect_signal_find(ect_twin_plant(twin), twin->slave.config.instance, name, ref) ||
           ect_signal_find(twin->config.beside.plant, twin->config.beside.instance, name, ref) ||
           ect_signal_find(&ect_lamps_plant, twin->lamps, name, ref) ||
           ect_signal_find(&ect_wiring_plant, (void *)&twin->wiring, name, ref);
}

bool ect_twin_save(const ect_twin_t *twin, ect_twin_snapshot_t *snapshot)
{
    size_t size = twin->config.device->instance_size;
    if (size > snapshot->room) {
        void *grown = realloc(snapshot->instance, size);
        if (!grown)
            return false;
        snapshot->instance = grown;
        snapshot->room = size;
    }
    memcpy(snapshot->instance, twin->slave.config.instance, size);
    snapshot->wiring = twin->wiring;
    if (twin->config.beside.size > 0)
        memcpy(snapshot->beside, twin->config.beside.instance, twin->config.beside.size);
    snapshot->off_bus = twin->slave.off_bus;
    snapshot->restart = twin->slave.restart;
    return true;
}

void ect_twin_restore(ect_twin_t *twin, const ect_twin_snapshot_t *snapshot)
{
    ECT_ASSERT(snapshot->room >= twin->config.device->instance_size);
    memcpy(twin->slave.config.instance, snapshot->instance, twin->config.device->instance_size);
    twin->wiring = snapshot->wiring;
    if (twin->config.beside.size > 0)
        memcpy(twin->config.beside.instance, snapshot->beside, twin->config.beside.size);
    twin->slave.off_bus = snapshot->off_bus;
    twin->slave.restart = snapshot->restart;
}

void ect_twin_snapshot_free(ect_twin_snapshot_t *snapshot)
{
    free(snapshot->instance);
}
