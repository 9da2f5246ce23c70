/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Model of a network file (ENI) as plain structures: the slaves that a master expects, and the commands for them.
 *
 * The model contains the elements uninterpreted. All memory belongs to the ::ect_eni_t. Texts are UTF-8 and never NULL.
 * Parts that an ENI shares with an ESI file have the types of esi/model.h.
 *
 * Clauses: ETG.2100.
 */
#ifndef ECT_ENI_MODEL_H
#define ECT_ENI_MODEL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "esi/model.h"
#include "seams/device.h"
#include "seams/mailbox.h"

/** `<Transition>`; bits. */
enum {
    ECT_ENI_II = 1 << 0,
    ECT_ENI_IP = 1 << 1,
    ECT_ENI_PP = 1 << 2,
    ECT_ENI_PO = 1 << 3,
    ECT_ENI_PS = 1 << 4,
    ECT_ENI_PI = 1 << 5,
    ECT_ENI_SS = 1 << 6,
    ECT_ENI_SP = 1 << 7,
    ECT_ENI_SO = 1 << 8,
    ECT_ENI_SI = 1 << 9,
    ECT_ENI_OS = 1 << 10,
    ECT_ENI_OP = 1 << 11,
    ECT_ENI_OI = 1 << 12,
    ECT_ENI_IB = 1 << 13,
    ECT_ENI_BI = 1 << 14,
};

/** `<State>` of a cyclic command; bits. */
enum { ECT_ENI_INIT = 1, ECT_ENI_PREOP = 2, ECT_ENI_SAFEOP = 4, ECT_ENI_OPERATIONAL = 8 };

/** Comparison of the reply, `Validate/@Type`. */
typedef enum ect_eni_compare {
    ECT_ENI_EQ,
    ECT_ENI_NOT_EQ,
    ECT_ENI_G,
    ECT_ENI_L,
    ECT_ENI_EQ_OR_G,
    ECT_ENI_EQ_OR_L,
    ECT_ENI_NONE,
} ect_eni_compare_t;

/** `<Validate>`: the master repeats the command until the reply matches. */
typedef struct ect_eni_validate {
    bool given;
    bool is_signed;
    ect_eni_compare_t compare;
    ect_esi_bytes_t data;
    ect_esi_bytes_t mask; /**< as long as `data`; none: all bits count */
    uint32_t timeout_ms;
} ect_eni_validate_t;

/** `<CopyInfo>`: bits of the inputs that the master copies to the outputs, between two slaves. */
typedef struct ect_eni_copy {
    uint32_t source, target, bits; /**< places in the process image, bits */
    int line;
} ect_eni_copy_t;

/** A datagram that the master sends: `<InitCmd>` of master or slave, `<Cmd>` of a cyclic frame. */
typedef struct ect_eni_command {
    unsigned int transitions; /**< ECT_ENI_II …, of an InitCmd; 0: none is given */
    unsigned int states;      /**< ECT_ENI_INIT …, of a cyclic command */
    bool before_slave;        /**< `BeforeSlave`: a command of the master that precedes those of the slaves */
    const char *comment;
    uint8_t command;      /**< 0 to 14: NOP, APRD … FRMW */
    uint16_t adp, ado;    /**< of a command with a physical address */
    uint32_t address;     /**< of LRD, LWR, LRW */
    ect_esi_bytes_t data; /**< `<Data>`, or zeros of `<DataLength>` */
    int counter;          /**< `Cnt`: the working counter of the reply, -1: not checked */
    uint32_t retries;
    ect_eni_validate_t validate;
    uint32_t input_offset, output_offset; /**< of a cyclic command: bytes in the process image */
    const ect_eni_copy_t *copies;
    size_t copy_count;
    int line;
} ect_eni_command_t;

/** `<InitCmd>` of CoE. */
typedef struct ect_eni_coe {
    unsigned int transitions; /**< ECT_ENI_II … */
    const char *comment;
    uint32_t timeout_ms;
    uint16_t index;
    uint8_t subindex;
    bool complete;
    bool download; /**< the command has `<Data>`; `Ccs` is ignored */
    bool disabled;
    ect_esi_bytes_t data;
    int line;
} ect_eni_coe_t;

/** Requests of FoE. */
enum {
    ECT_ENI_FOE_READS = 1,
    ECT_ENI_FOE_WRITES = 2,
    ECT_ENI_FOE_HEADER = 6 /**< bytes before the name of the file */
};

/** `<InitCmd>` of AoE, EoE, FoE or SoE. */
typedef struct ect_eni_mail {
    unsigned int transitions; /**< ECT_ENI_II … */
    const char *comment;
    uint32_t timeout_ms;
    uint8_t protocol; /**< ECT_MAILBOX_TYPE_AOE, _EOE, _FOE, _SOE */
    uint8_t type;     /**< as ect_init_mail_t::type; of FoE: ECT_ENI_FOE_READS, ECT_ENI_FOE_WRITES */
    uint8_t drive;    /**< of SoE, 0 to 7 */
    uint8_t elements; /**< of SoE: bit 6 is the value */
    uint16_t idn;     /**< of SoE */
    bool disabled;
    const char *file;     /**< of FoE; else "" */
    uint32_t password;    /**< of FoE */
    ect_esi_bytes_t data; /**< as ect_init_mail_t::data; of FoE: the content of the file */
    int line;
} ect_eni_mail_t;

/** `<Sm0>` to `<Sm15>`. */
typedef struct ect_eni_sm {
    bool given;
    const char *type; /**< "Outputs", "Inputs" …, "" when absent */
    uint16_t minimum, maximum;
    ect_esi_number_t size; /**< `DefaultSize` */
    uint16_t start;
    uint8_t control;
    const uint16_t *pdos;
    size_t pdo_count;
    int line;
} ect_eni_sm_t;

/** Bits of the process image, `<Send>` and `<Recv>` of `<ProcessData>`. */
typedef struct ect_eni_bits {
    uint32_t start, length;
} ect_eni_bits_t;

/** `<Send>` and `<Recv>` of `<Mailbox>`: a mailbox of the slave; the direction is that of the master. */
typedef struct ect_eni_box {
    uint16_t start, length; /**< 0: absent */
} ect_eni_box_t;

/** `<Mailbox>`. */
typedef struct ect_eni_mailbox {
    bool given;
    bool data_link_layer;
    ect_eni_box_t send, receive;
    ect_eni_box_t boot_send, boot_receive;
    ect_esi_number_t status_bit; /**< `StatusBitAddr`: logical bit address of SyncManager 1's full bit */
    bool aoe, eoe, coe, foe, soe, voe;
    const ect_eni_coe_t *commands;
    size_t command_count;
    const ect_eni_mail_t *mails; /**< of AoE, then of EoE, of SoE, of FoE */
    size_t mail_count;
    size_t others; /**< number of start-up commands that no player sends: of FoE, or without a mail */
} ect_eni_mailbox_t;

/** The selected `<PreviousPort>`, or the only one. */
typedef struct ect_eni_previous {
    bool given;
    uint8_t port;     /**< 0 to 3: A to D */
    uint16_t address; /**< `PhysAddr` of the neighbour towards the master; 0: not given */
    int line;
} ect_eni_previous_t;

/** `<Slave>`. */
typedef struct ect_eni_slave {
    const char *name;
    uint16_t address;       /**< `PhysAddr`, 0 when absent */
    ect_esi_number_t place; /**< `AutoIncAddr`: 0, 65535, 65534 … */
    ect_esi_number_t identification;
    uint16_t identification_ado; /**< 0x0012 or 0x0134, with `identification` */
    const char *physics;
    uint32_t vendor_id, product_code, revision, serial;
    const ect_eni_bits_t *sends; /**< outputs */
    size_t send_count;
    const ect_eni_bits_t *receives; /**< inputs */
    size_t receive_count;
    ect_eni_sm_t sms[16];
    const ect_esi_pdo_t *pdos;
    size_t pdo_count;
    ect_eni_mailbox_t mailbox;
    const ect_eni_command_t *commands;
    size_t command_count;
    ect_eni_previous_t previous;
    const char *group;    /**< `GroupName` of `<HotConnect>`, "": a group without a name; NULL: no group */
    unsigned int members; /**< `GroupMemberCnt`, at least 1; with `group` */
    bool clocked;         /**< the slave has `<DC>` */
    int64_t cycle0_ns, cycle1_ns, shift_ns;
    int line;
} ect_eni_slave_t;

/** `<Frame>` of `<Cyclic>`. */
typedef struct ect_eni_frame {
    const ect_eni_command_t *commands;
    size_t command_count;
    int line;
} ect_eni_frame_t;

/** `<Cyclic>`. */
typedef struct ect_eni_cyclic {
    uint32_t cycle_us; /**< 0 when absent */
    const ect_eni_frame_t *frames;
    size_t frame_count;
} ect_eni_cyclic_t;

/** `<Variable>` of the process image. */
typedef struct ect_eni_variable {
    const char *name;
    uint32_t bits, offset;
    int line;
} ect_eni_variable_t;

/** `<Inputs>` or `<Outputs>` of `<ProcessImage>`. */
typedef struct ect_eni_image {
    bool given;
    uint32_t bytes;
    const ect_eni_variable_t *variables;
    size_t variable_count;
} ect_eni_image_t;

/** `<Config>`: a network. */
typedef struct ect_eni_network {
    const char *name; /**< of the master */
    const ect_eni_command_t *commands;
    size_t command_count;
    ect_esi_number_t status_start; /**< `MailboxStates/StartAddr` */
    uint32_t status_count;
    const ect_eni_slave_t *slaves; /**< in bus order */
    size_t slave_count;
    const ect_eni_cyclic_t *cyclics;
    size_t cyclic_count;
    ect_eni_image_t inputs, outputs;
} ect_eni_network_t;

#endif
