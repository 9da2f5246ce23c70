/* SPDX-License-Identifier: MIT */
/* A modular device as an ESI file describes it, and its twin behind a wire. */
#ifndef TESTS_UNIT_ESI_RACK_H
#define TESTS_UNIT_ESI_RACK_H

#include "from_text.h"

#include "bus/chain/chain.h"
#include "support/wire.h"
#include "wire/bytes.h"

enum { PREOP = ECT_STATE_PREOP, SAFEOP = ECT_STATE_SAFEOP, IN = 0x110, OUT = 0x120, OTHER = 0x130 };

#define MODULE(ident, class, pdo)                                                                                      \
    "<Module><Type ModuleIdent='" ident                                                                                \
    "' ModuleClass='" class "'>M</Type><Name>M</Name>" pdo                                                             \
                            "<Profile><ProfileNo>401</ProfileNo><AddInfo>5</AddInfo></Profile></Module>"
#define TX_PDO                                                                                                         \
    "<TxPdo Fixed='1' Sm='3'><Index DependOnSlot='1'>#x1a00</Index><Name>P</Name><Entry><Index DependOnSlot='1'>"      \
    "#x6000</Index><SubIndex>1</SubIndex><BitLen>16</BitLen><Name>A</Name><DataType>INT</DataType></Entry></TxPdo>"
#define RX_PDO                                                                                                         \
    "<RxPdo Fixed='1' Sm='2'><Index DependOnSlot='1'>#x1600</Index><Name>P</Name><Entry><Index DependOnSlot='1'>"      \
    "#x7000</Index><SubIndex>1</SubIndex><BitLen>16</BitLen><Name>A</Name><DataType>INT</DataType></Entry></RxPdo>"

/* A rack with a slot that presets IN and takes OUT, and two optional ones for modules of the class IO. */
#define RACK(attributes, dictionary)                                                                                   \
    ESI_HEAD "\n<Device Physics='YY'><Type ProductCode='#x1' RevisionNo='#x2'>RACK</Type><Name>A rack</Name>"          \
             "<Profile><ProfileNo>5001</ProfileNo>" dictionary "</Profile>"                                            \
             "<Fmmu>Outputs</Fmmu><Fmmu>Inputs</Fmmu>" ESI_MAILBOX_SMS ESI_PROCESS_SMS                                 \
             "<Mailbox><CoE SdoInfo='1' CompleteAccess='1'/></Mailbox>"                                                \
             "<Slots MaxSlotCount='3' SlotPdoIncrement='1' SlotIndexIncrement='#x10' " attributes ">"                  \
             "<Slot MinInstances='1' MaxInstances='1'><Name>First</Name><ModuleIdent Default='1'>#x110</ModuleIdent>"  \
             "<ModuleIdent>#x120</ModuleIdent></Slot>"                                                                 \
             "<Slot MinInstances='0' MaxInstances='2'><Name>Others</Name><ModuleClass><Class>IO</Class>"               \
             "</ModuleClass></Slot></Slots>" ESI_EEPROM "</Device></Devices><Modules>" MODULE("#x110", "IO", TX_PDO)   \
                 MODULE("#x120", "IO", RX_PDO)                                                                         \
                     MODULE("#x130", "AX", TX_PDO) "</Modules></Descriptions></EtherCATInfo>"

/* Four optional slots for modules of the class IO; their idents are downloaded. */
#define MANY_SLOTS                                                                                                     \
    ESI_HEAD "\n<Device Physics='YY'><Type ProductCode='#x1' RevisionNo='#x2'>RACK</Type><Name>A rack</Name>"          \
             "<Profile><ProfileNo>5001</ProfileNo></Profile><Fmmu>Outputs</Fmmu><Fmmu>Inputs</"                        \
             "Fmmu>" ESI_MAILBOX_SMS ESI_PROCESS_SMS                                                                   \
             "<Mailbox><CoE SdoInfo='1' PdoAssign='1' CompleteAccess='1'/></Mailbox>"                                  \
             "<Slots MaxSlotCount='4' SlotPdoIncrement='1' SlotIndexIncrement='#x10' " DOWNLOAD ">"                    \
             "<Slot MinInstances='4' MaxInstances='4'><Name>Slots</Name><ModuleIdent Default='1'>#x110</ModuleIdent>"  \
             "<ModuleIdent>#x120</ModuleIdent></Slot></Slots>" ESI_EEPROM                                              \
             "</Device></Devices><Modules>" MODULE("#x110", "IO", TX_PDO)                                              \
                 MODULE("#x120", "IO", RX_PDO) "</Modules></Descriptions></EtherCATInfo>"

#define DOWNLOAD "DownloadModuleIdentList='1'"

typedef struct rig {
    made_t made;
    wire_t wire;
} rig_t;

static inline void open_rig(rig_t *r, const char *text, uint8_t state)
{
    r->made = make_text("a rack", text);
    const ect_product_t *product = ect_esi_twin_product(r->made.twin);
    const ect_twin_config_t config = ect_twin_default(product->device, product->plant);
    memset(&r->wire, 0, sizeof r->wire);
    wire_open_twins(&r->wire, &config, 1);
    wire_go(&r->wire, 0, state);
}

static inline void close_rig(rig_t *r)
{
    wire_close(&r->wire);
    free_made(&r->made);
}

static inline uint32_t read_number(rig_t *r, uint16_t index, uint8_t subindex)
{
    uint8_t bytes[8] = {0};
    size_t size = sizeof bytes;
    assert_int_equal(wire_sdo_upload(&r->wire, 0, index, subindex, false, bytes, &size), 0);
    return ect_load_le32(bytes);
}

static inline uint32_t write_number(rig_t *r, uint8_t subindex, uint32_t value, uint32_t size)
{
    uint8_t bytes[4];
    ect_store_le32(bytes, value);
    return wire_sdo_download(&r->wire, 0, 0xF030, subindex, false, bytes, size);
}

/* SyncManagers of process data as the dictionary has them now: a master reads it after it has written F030h. */
static inline void configure(rig_t *r)
{
    (void)read_number(r, 0x1C12, 0);
    wire_configure_process_data(&r->wire, 0);
}

#endif
