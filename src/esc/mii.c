/* SPDX-License-Identifier: MIT */
/*
 * PHY management (0x0510 to 0x0515): the master reads and writes the PHYs' registers over the chip's management
 * interface (data sheet I §5.6, II §2.12). Each MII port has a PHY of its own, at the address of its number, with the
 * registers of IEEE 802.3 clause 22 that report the link; it ignores writes.
 */
#include "esc/internal.h"

/* Bits of control and status. A command is in bits 8 and 9. */
enum { WRITE_ENABLE = 0x0001, COMMAND = 0x0300, READ_ERROR = 0x2000, COMMAND_ERROR = 0x4000, BUSY = 0x8000 };
enum { COMMAND_NONE, COMMAND_READ, COMMAND_WRITE };

/* A management frame: 64 bits at 2.5 MHz. */
enum { FRAME_NS = 25600 };

/* Full duplex at 100 Mbit/s, negotiated; the abilities of 10BASE-T and 100BASE-TX. */
enum {
    BASIC_CONTROL = 0x3100,
    BASIC_STATUS = 0x7809,
    BASIC_STATUS_LINK = 0x0024,
    ABILITIES = 0x01E1,
    PARTNER = 0x41E1,
};

static uint8_t *reg(const ect_esc_t *esc, unsigned int address)
{
    return esc->memory + address;
}

static unsigned int status(const ect_esc_t *esc)
{
    return ect_load_le16(reg(esc, ECT_REG_MII_CONTROL));
}

static void set_status(ect_esc_t *esc, unsigned int value)
{
    ect_store_le16(reg(esc, ECT_REG_MII_CONTROL), (uint16_t)value);
}

static bool has_phy(const ect_esc_t *esc, unsigned int phy)
{
    return phy < ECT_ESC_PORTS && ((esc->config.personality->port_types >> (2 * phy)) & 3u) == 3;
}

static uint16_t phy_register(const ect_esc_t *esc, unsigned int phy, unsigned int number)
{
    bool link = (esc->config.open_ports & (1u << phy)) != 0;
    switch (number) {
    case 0:
        return BASIC_CONTROL;
    case 1:
        return link ? BASIC_STATUS | BASIC_STATUS_LINK : BASIC_STATUS;
    case 4:
        return ABILITIES;
    case 5:
        return link ? PARTNER : 0;
    default:
        return 0;
    }
}

/* The result of the command under way. */
static void finish(ect_esc_t *esc)
{
    unsigned int phy = *reg(esc, ECT_REG_MII_PHY) & 0x1Fu;
    unsigned int now = status(esc);
    if (((now & COMMAND) >> 8) == COMMAND_READ) {
        if (has_phy(esc, phy))
            ect_store_le16(reg(esc, ECT_REG_MII_DATA), phy_register(esc, phy, *reg(esc, ECT_REG_MII_REGISTER) & 0x1Fu));
        else
            now |= READ_ERROR;
    }
    set_status(esc, now & ~(unsigned int)(BUSY | COMMAND));
    esc->mii_done_ns = UINT64_MAX;
}

/* Command 0 only clears the errors. */
static void start(ect_esc_t *esc, unsigned int command)
{
    unsigned int now = status(esc) & ~(unsigned int)(COMMAND | READ_ERROR | COMMAND_ERROR);
    bool enabled = (now & WRITE_ENABLE) != 0;
    if (command == COMMAND_READ || (command == COMMAND_WRITE && enabled)) {
        esc->mii_done_ns = esc->now_ns + FRAME_NS;
        ect_esc_expect(esc, esc->mii_done_ns);
        now |= BUSY | command << 8;
    } else if (command != COMMAND_NONE) {
        now |= COMMAND_ERROR;
    }
    set_status(esc, now);
}

void ect_esc_mii_tick(ect_esc_t *esc)
{
    if (esc->now_ns >= esc->mii_done_ns)
        finish(esc);
    else
        ect_esc_expect(esc, esc->mii_done_ns);
}

bool ect_esc_mii_accepts(const ect_esc_t *esc, uint16_t address, uint16_t length)
{
    (void)address;
    (void)length;
    return (status(esc) & BUSY) == 0;
}

/* A command begins when all bytes of the access are stored, since address, data and command may share a datagram. */
bool ect_esc_mii_write_register(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    unsigned int before = status(esc);
    uint16_t end = (uint16_t)(address + length);
    ECT_ASSERT(access->side == ECT_SIDE_ECAT && access->write && address >= ECT_REG_MII_CONTROL);
    if (!ect_esc_mii_accepts(esc, address, length))
        return false;
    ect_esc_copy(access, reg(esc, address), 0, length);
    unsigned int command = (status(esc) & COMMAND) >> 8;
    unsigned int enable = (address == ECT_REG_MII_CONTROL ? status(esc) : before) & (unsigned int)WRITE_ENABLE;
    set_status(esc, (before & ~(unsigned int)WRITE_ENABLE) | enable);
    if (enable != 0)
        esc->per_frame |= ECT_FRAME_END_MII;
    if (ect_esc_within(address, end, ECT_REG_MII_CONTROL + 1))
        start(esc, command);
    return true;
}

void ect_esc_mii_end_of_frame(ect_esc_t *esc)
{
    esc->per_frame &= (uint8_t)~ECT_FRAME_END_MII;
    set_status(esc, status(esc) & ~(unsigned int)WRITE_ENABLE);
}
