/* SPDX-License-Identifier: MIT */
/* The slave of a SOES application, made from SDOobjects, ecat_options.h and the hooks of its configuration. */
#include <string.h>

#include "seams/standard.h"
#include "slave/service.h"
#include "soes/describe.h"
#include "soes/internal.h"
#include "wire/bytes.h"
#include "wire/registers.h"

enum {
    OUT_ROOM = MAX(MBX0_sml, MBX0_sml_b),
    IN_ROOM = MAX(MBX1_sml, MBX1_sml_b),
};

static ect_device_t device;
static uint8_t mailbox[OUT_ROOM + 2 * IN_ROOM];

#if MAX_MAPPINGS_SM2 > 0
static uint8_t rxpdo[MAX_RXPDO_SIZE > 0 ? MAX_RXPDO_SIZE : 1];
enum { OUTPUTS_ROOM = sizeof rxpdo };
#else
extern uint8_t rxpdo[];
enum { OUTPUTS_ROOM = UINT16_MAX };
#endif
#if MAX_MAPPINGS_SM3 > 0
static uint8_t txpdo[MAX_TXPDO_SIZE > 0 ? MAX_TXPDO_SIZE : 1];
enum { INPUTS_ROOM = sizeof txpdo };
#else
extern uint8_t txpdo[];
enum { INPUTS_ROOM = UINT16_MAX };
#endif

/* --- the exchange ------------------------------------------------------------------------------------------------- */

static void fetch_outputs(void)
{
    if (ESCvar.rxpdo_override) {
        ESCvar.rxpdo_override();
        return;
    }
    ESC_read(ESC_SM2_sma, rxpdo, ESCvar.ESC_SM2_sml);
    COE_pdoUnpack(rxpdo, ESCvar.sm2mappings, SMmap2);
}

void ect_soes_outputs(void)
{
    uint8_t state = CC_ATOMIC_GET(ESCvar.App.state);
    if ((ESCvar.ALevent & ESCREG_ALEVENT_SM2) == 0 || ESCvar.ESC_SM2_sml == 0)
        return;
    if ((state & APPSTATE_OUTPUT) != 0) {
        fetch_outputs();
        CC_ATOMIC_SET(ect_soes.watchdog, ESCvar.watchdogcnt);
        cb_set_outputs();
    } else if (state != APPSTATE_IDLE) {
        ESC_read(ESC_SM2_sma, rxpdo, ESCvar.ESC_SM2_sml); /* reads and discards the outputs, which frees the buffer */
    }
}

void ect_soes_inputs(void)
{
    cb_get_inputs();
    if (ESCvar.txpdo_override) {
        ESCvar.txpdo_override();
        return;
    }
    COE_pdoPack(txpdo, ESCvar.sm3mappings, SMmap3);
    if (ESCvar.ESC_SM3_sml > 0)
        ESC_write(ESC_SM3_sma, txpdo, ESCvar.ESC_SM3_sml);
}

/* --- states ------------------------------------------------------------------------------------------------------- */

/* Refuses an invalid mapping, or a mapping of more bytes than the application has room for. */
static bool is_wrong(int mappings, uint32_t bytes, uint32_t room)
{
    return mappings < 0 || bytes > room;
}

static uint16_t check_sizes(void)
{
    ESCvar.ESC_SM2_sml = sizeOfPDO(RX_PDO_OBJIDX, &ESCvar.sm2mappings, SMmap2, MAX_MAPPINGS_SM2);
    if (is_wrong(ESCvar.sm2mappings, ESCvar.ESC_SM2_sml, OUTPUTS_ROOM))
        return ALERR_INVALIDOUTPUTMAPPING;
    ESCvar.ESC_SM3_sml = sizeOfPDO(TX_PDO_OBJIDX, &ESCvar.sm3mappings, SMmap3, MAX_MAPPINGS_SM3);
    if (is_wrong(ESCvar.sm3mappings, ESCvar.ESC_SM3_sml, INPUTS_ROOM))
        return ALERR_INVALIDINPUTMAPPING;
    return ALERR_NONE;
}

static uint16_t check_dc(void)
{
    uint8_t activation = 0;
    ESC_read(ESCREG_SYNC_ACT, &activation, 1);
    if ((activation & (ESCREG_SYNC_ACT_ACTIVATED | ESCREG_SYNC_AUTO_ACTIVATED)) == 0) {
        ESCvar.dcsync = 0;
        ESCvar.synccounter = 0;
        return ALERR_NONE;
    }
    return ESCvar.esc_check_dc_handler ? ESCvar.esc_check_dc_handler() : ALERR_DCINVALIDSYNCCFG;
}

static uint16_t enter_safeop(void)
{
    uint16_t code = check_sizes();
    if (code == ALERR_NONE && ESCvar.use_interrupt != 0)
        code = check_dc();
    if (code != ALERR_NONE || ESCvar.use_interrupt == 0 || !ESCvar.esc_hw_interrupt_enable)
        return code;
    uint32_t events = ESCvar.ESC_SM2_sml == 0 ? ESCREG_ALEVENT_SM3 : ESCREG_ALEVENT_SM2;
    ESCvar.esc_hw_interrupt_enable(events | (ESCvar.dcsync > 0 ? ESCREG_ALEVENT_DC_SYNC0 : 0u));
    return ALERR_NONE;
}

static void enter_mailbox(uint8_t to)
{
    uint8_t bytes[2] = {0};
    ESC_read(ESCREG_ADDRESS, bytes, sizeof bytes);
    ESCvar.address = ect_load_le16(bytes);
    ESCvar.activemb0 = to == ESCboot ? &ESCvar.mbboot[0] : &ESCvar.mb[0];
    ESCvar.activemb1 = to == ESCboot ? &ESCvar.mbboot[1] : &ESCvar.mb[1];
    ESCvar.activembxsize = to == ESCboot ? MBXSIZEBOOT : MBXSIZE;
}

static uint16_t go_up(uint8_t to)
{
    if (to == ESCop)
        return ALERR_NONE;
    if (to == ESCsafeop)
        return enter_safeop();
    enter_mailbox(to);
    return ALERR_NONE;
}

/* Sets App.state to the lower state before the hooks run, as SOES does. */
static void go_down(uint8_t from, uint8_t to)
{
    if (from < ESCsafeop)
        return;
    CC_ATOMIC_AND(ESCvar.App.state, APPSTATE_INPUT);
    if (to >= ESCsafeop)
        return;
    CC_ATOMIC_SET(ESCvar.App.state, APPSTATE_IDLE);
    if (ESCvar.use_interrupt != 0 && ESCvar.esc_hw_interrupt_disable)
        ESCvar.esc_hw_interrupt_disable(ESCREG_ALEVENT_DC_SYNC0 | ESCREG_ALEVENT_SM2 | ESCREG_ALEVENT_SM3);
}

static uint16_t state_change(void *unused, uint8_t from, uint8_t to, uint64_t now_ns)
{
    uint8_t as = (uint8_t)(to << 4 | from);
    uint8_t an = from;
    bool falls = to < from && !ect_soes.requested;
    uint16_t code = ALERR_NONE;
    (void)unused;
    (void)now_ns;
    ESCvar.ALerror = falls ? ect_soes.fall_code : (uint16_t)ALERR_NONE;
    ect_soes.fall_code = ALERR_NONE;
    if (ESCvar.pre_state_change_hook)
        ESCvar.pre_state_change_hook(&as, &an);
    if (to > from)
        code = go_up(to);
    else
        go_down(from, to);
    as = (uint8_t)(to << 4 | from);
    an = code != ALERR_NONE ? from | ESCerror : falls ? to | ESCerror : to;
    if (ESCvar.post_state_change_hook)
        ESCvar.post_state_change_hook(&as, &an);
    if (code != ALERR_NONE || falls || (an & ESCerror) == 0)
        return code;
    return ESCvar.ALerror != ALERR_NONE ? ESCvar.ALerror : ALERR_UNSPECIFIEDERROR;
}

static void safe_outputs(void *unused, uint64_t now_ns)
{
    (void)unused;
    (void)now_ns;
    if (!ect_soes.outputs_safe)
        APP_safeoutput();
    ect_soes.outputs_safe = false;
}

/* --- objects ------------------------------------------------------------------------------------------------------ */

/* The present transfer: an upload, for the hook after its end; a download, whose second pass stores the values that the
 * first pass has passed to the hook. */
static struct {
    bool reading;
    uint16_t index, flags;
    uint8_t subindex;
    int16_t last_written;
    bool second_walk;
} transfer;

/* @return the reason for a result of a hook: an abort code is sent unchanged */
static ect_reason_t reason_of(uint32_t abort)
{
    return abort == 0 ? ECT_OK : abort > UINT16_MAX ? abort : ECT_REASON_GENERAL;
}

static const ect_entry_t *find(uint16_t index, uint16_t subindex)
{
    const ect_object_t *object = NULL;
    const ect_entry_t *entry = NULL;
    (void)ect_od_lookup(&ect_soes.slave.od, index, subindex == ECT_WHOLE_OBJECT ? 0 : (uint8_t)subindex, &object,
                        &entry);
    return entry ? entry : object->entries;
}

static uint16_t flags_of(const ect_entry_t *entry, bool complete)
{
    return (uint16_t)(entry->access | (complete ? COMPLETE_ACCESS_FLAG : 0u));
}

static ect_reason_t sdo_request(void *unused, uint16_t index, uint8_t subindex)
{
    (void)unused;
    (void)index;
    (void)subindex;
    transfer.reading = false;
    transfer.last_written = -1;
    transfer.second_walk = false;
    return ECT_OK;
}

/* Calls the hook, which may change the length. A text without a length in the list has the length of its content. */
static ect_reason_t sdo_read(void *unused, uint16_t index, uint16_t subindex, ect_span_t *instead)
{
    const ect_entry_t *entry = find(index, subindex);
    bool unmeasured = entry->bit_length == 0 && entry->data && ect_od_is_string(entry);
    size_t room = unmeasured ? strlen(entry->data) : ect_od_bytes(entry);
    size_t size = room;
    void *data = entry->data ? entry->data : (void *)(uintptr_t)&entry->value;
    (void)unused;
    transfer.index = index;
    transfer.subindex = (uint8_t)entry->subindex;
    transfer.flags = flags_of(entry, subindex == ECT_WHOLE_OBJECT);
    uint32_t abort = ESC_upload_pre_objecthandler(index, transfer.subindex, data, &size, transfer.flags);
    transfer.reading = abort == 0;
    if (abort == 0 && instead && entry->data && (unmeasured || size != room))
        *instead = (ect_span_t){entry->data, (uint16_t)size};
    return reason_of(abort);
}

/* Calls the hook after an upload. Its result is ignored, because the reply has already been sent. */
static void end_of_upload(void)
{
    if (!transfer.reading || ect_slave_in_transfer(&ect_soes.slave))
        return;
    transfer.reading = false;
    (void)ESC_upload_post_objecthandler(transfer.index, transfer.subindex, transfer.flags);
}

static ect_reason_t write_value(ect_slave_t *s, const ect_download_t *d)
{
    (void)s;
    transfer.second_walk |= d->subindex <= transfer.last_written;
    transfer.last_written = d->subindex;
    if (transfer.second_walk)
        return ECT_OK;
    return reason_of(ESC_download_pre_objecthandler(d->index, d->subindex, (void *)(uintptr_t)d->data, d->size,
                                                    flags_of(find(d->index, d->subindex), d->complete)));
}

static ect_reason_t value_written(ect_slave_t *s, uint16_t index, uint8_t subindex, bool complete)
{
    (void)s;
    return reason_of(ESC_download_post_objecthandler(index, subindex, flags_of(find(index, subindex), complete)));
}

static const ect_service_t hooks = {.write = write_value, .written = value_written};

static uint16_t coe_request(const ect_protocol_t *self, ect_slave_t *slave, const uint8_t *mail, uint16_t length)
{
    (void)self;
    uint16_t error = ect_protocol_sdo.request(&ect_protocol_sdo, slave, mail, length);
    end_of_upload();
    return error;
}

static void coe_reset(const ect_protocol_t *self, ect_slave_t *slave)
{
    (void)self;
    transfer.reading = false;
    ect_protocol_sdo.reset(&ect_protocol_sdo, slave);
}

/* --- the slave ---------------------------------------------------------------------------------------------------- */

static void init(void *unused, const ect_host_t *host, uint64_t now_ns)
{
    (void)unused;
    (void)host;
    (void)now_ns;
    APP_safeoutput();
    COE_initDefaultValues();
#if USE_EOE
    ect_soes_network_init();
#endif
}

ect_slave_config_t ect_soes_slave_config(void)
{
    static const ect_protocol_t coe = {
        .type = ECT_MAILBOX_TYPE_COE, .states = ECT_IN_PREOP_AND_ABOVE, .request = coe_request, .reset = coe_reset};
    static const ect_protocol_t *const protocols[] = {
        &coe,
        &ect_protocol_sdo_info,
#if USE_FOE
        &ect_soes_files.protocol,
#endif
#if USE_EOE
        &ect_soes_network.protocol,
#endif
        NULL,
    };
    static const ect_service_t *const services[] = {&hooks, NULL};
    static const ect_dc_mode_t clocks = {.name = "SYNC0"};
    static ect_pdo_run_t no_runs[1];
    ect_soes_describe(&device);
    device.dc_modes = &clocks; /* the application's handler refuses unsupported requests */
    device.dc_mode_count = 1;
    device.protocols = protocols;
    device.instance_size = sizeof ect_soes_instance;
    device.init = init;
    device.state_change = state_change;
    device.safe_outputs = safe_outputs;
    device.services = services;
    device.sdo_request = sdo_request;
    device.sdo_read = sdo_read;
    return (ect_slave_config_t){
        .device = &device,
        .instance = &ect_soes_instance,
        .mailbox = mailbox,
        .staging = ESCvar.mbxdata,
        .staging_size = sizeof ESCvar.mbxdata,
        .process_data = mailbox, /* neither memory is accessed */
        .process_size = UINT16_MAX,
        .runs = no_runs,
        .run_count = UINT16_MAX,
        .exchange_is_callers = true,
    };
}
