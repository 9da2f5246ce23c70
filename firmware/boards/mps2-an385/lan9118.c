/* SPDX-License-Identifier: MIT */
#include "lan9118.h"

/* Registers of the window. */
enum {
    RX_DATA = 0x00,
    TX_DATA = 0x20,
    RX_STATUS = 0x40,
    IRQ_CFG = 0x54,
    INT_STS = 0x58,
    INT_EN = 0x5C,
    BYTE_TEST = 0x64,
    FIFO_INT = 0x68,
    RX_CFG = 0x6C,
    TX_CFG = 0x70,
    HW_CFG = 0x74,
    RX_DP_CTL = 0x78,
    RX_FIFO_INF = 0x7C,
    TX_FIFO_INF = 0x80,
    PMT_CTRL = 0x84,
    MAC_CSR_CMD = 0xA4,
    MAC_CSR_DATA = 0xA8,
};

/* Registers of the MAC, and of the PHY. */
enum { MAC_CR = 1, MAC_MII_ACC = 6, MAC_MII_DATA = 7 };
enum { PHY_CONTROL = 0, PHY_ADVERTISED = 4 };

#define BYTE_TEST_VALUE 0x87654321u

#define IRQ_ON        0x00000111u /* enabled, active high, push-pull */
#define INT_RX_STATUS 0x00000008u /* interrupt level in received frames: above 0 */
#define HW_RESET      0x00000001u
#define HW_STORE      0x00150000u /* 5 KB of transmit FIFO; frames are sent when complete */
#define PMT_READY     0x00000001u
#define TX_ON         0x00000006u /* the status of sent frames is discarded */
#define RX_SKIP       0x80000000u
#define CSR_BUSY      0x80000000u
#define CSR_READ      0x40000000u
#define MAC_ALL       0x0014000Cu /* full duplex, promiscuous, transmitter, receiver */
#define MII_PHY       0x00000800u /* the internal PHY has the address 1 */
#define MII_WRITE     0x00000002u
#define MII_BUSY      0x00000001u
#define PHY_NEGOTIATE 0x1200u
#define PHY_100_FULL  0x0101u
#define TX_WHOLE      0x00003000u /* first and last buffer of a frame */
#define RX_ERROR      0x00008000u

/* Reads of a register until a wait gives up. A read takes 100 ns or more: 45 ns for the window, the rest for the
 * processor. The MAC needs about 10 reads, the serial PHY 30 us, and the longest reset, that of the PHY, 100 us. */
enum { PATIENCE_MAC = 100, PATIENCE_PHY = 1000, PATIENCE_RESET = 100000 };

enum { CHECK_SUM = 4 };

static volatile uint32_t *reg(const lan9118_t *mac, unsigned int offset)
{
    return (volatile uint32_t *)(mac->base + offset);
}

/* @return whether the bits have got the value in time */
static bool wait(const lan9118_t *mac, unsigned int offset, uint32_t bits, uint32_t value, unsigned int patience)
{
    while (patience-- > 0) {
        if ((*reg(mac, offset) & bits) == value)
            return true;
    }
    return false;
}

/* --- MAC and PHY -------------------------------------------------------------------------------------------------- */

static bool mac_write(const lan9118_t *mac, unsigned int number, uint32_t value)
{
    *reg(mac, MAC_CSR_DATA) = value;
    *reg(mac, MAC_CSR_CMD) = CSR_BUSY | number;
    return wait(mac, MAC_CSR_CMD, CSR_BUSY, 0, PATIENCE_MAC);
}

static bool mac_read(const lan9118_t *mac, unsigned int number, uint32_t *value)
{
    *reg(mac, MAC_CSR_CMD) = CSR_BUSY | CSR_READ | number;
    if (!wait(mac, MAC_CSR_CMD, CSR_BUSY, 0, PATIENCE_MAC))
        return false;
    *value = *reg(mac, MAC_CSR_DATA);
    return true;
}

static bool phy_write(const lan9118_t *mac, unsigned int number, uint32_t value)
{
    uint32_t busy = MII_BUSY;
    if (!mac_write(mac, MAC_MII_DATA, value) ||
        !mac_write(mac, MAC_MII_ACC, MII_PHY | number << 6 | MII_WRITE | MII_BUSY))
        return false;
    for (unsigned int n = 0; n < PATIENCE_PHY && (busy & MII_BUSY) != 0; n++) {
        if (!mac_read(mac, MAC_MII_ACC, &busy))
            return false;
    }
    return (busy & MII_BUSY) == 0;
}

/* --- setting up --------------------------------------------------------------------------------------------------- */

static bool reset(const lan9118_t *mac)
{
    *reg(mac, BYTE_TEST) = 0; /* a write wakes a sleeping controller */
    if (!wait(mac, PMT_CTRL, PMT_READY, PMT_READY, PATIENCE_RESET) || *reg(mac, BYTE_TEST) != BYTE_TEST_VALUE)
        return false;
    *reg(mac, HW_CFG) = HW_RESET;
    return wait(mac, HW_CFG, HW_RESET, 0, PATIENCE_RESET);
}

bool lan9118_init(lan9118_t *mac, uintptr_t base)
{
    *mac = (lan9118_t){.base = base};
    if (!reset(mac))
        return false;
    *reg(mac, HW_CFG) = HW_STORE;
    *reg(mac, RX_CFG) = 0; /* frames begin at a word, and occupy complete words */
    *reg(mac, TX_CFG) = TX_ON;
    *reg(mac, FIFO_INT) = 0;
    *reg(mac, INT_STS) = UINT32_MAX;
    *reg(mac, INT_EN) = INT_RX_STATUS;
    *reg(mac, IRQ_CFG) = IRQ_ON;
    return phy_write(mac, PHY_ADVERTISED, PHY_100_FULL) && phy_write(mac, PHY_CONTROL, PHY_NEGOTIATE) &&
           mac_write(mac, MAC_CR, MAC_ALL);
}

void lan9118_acknowledge(const lan9118_t *mac)
{
    *reg(mac, INT_STS) = INT_RX_STATUS;
}

/* --- frames ------------------------------------------------------------------------------------------------------- */

/* Discards the words of a frame in the FIFO. */
static void skip(const lan9118_t *mac, size_t words)
{
    if (words >= 4) { /* the fast-forward does not skip fewer words */
        *reg(mac, RX_DP_CTL) = RX_SKIP;
        (void)wait(mac, RX_DP_CTL, RX_SKIP, 0, PATIENCE_MAC);
        return;
    }
    while (words-- > 0)
        (void)*reg(mac, RX_DATA);
}

size_t lan9118_receive(lan9118_t *mac, uint32_t *frame, size_t size)
{
    while ((*reg(mac, RX_FIFO_INF) >> 16 & 0xFF) != 0) {
        uint32_t status = *reg(mac, RX_STATUS);
        size_t length = status >> 16 & 0x3FFF;
        size_t words = (length + 3) / 4;
        if ((status & RX_ERROR) != 0 || length <= CHECK_SUM || words * 4 > size) {
            skip(mac, words);
            mac->broken++;
            continue;
        }
        for (size_t n = 0; n < words; n++)
            frame[n] = *reg(mac, RX_DATA);
        return length - CHECK_SUM;
    }
    return 0;
}

bool lan9118_send(lan9118_t *mac, const uint32_t *frame, size_t length)
{
    size_t words = (length + 3) / 4;
    uint32_t bytes = (uint32_t)length;
    if ((*reg(mac, TX_FIFO_INF) & 0xFFFF) < 8 + words * 4) {
        mac->lost++;
        return false;
    }
    *reg(mac, TX_DATA) = TX_WHOLE | bytes;
    *reg(mac, TX_DATA) = bytes << 16 | bytes;
    for (size_t n = 0; n < words; n++)
        *reg(mac, TX_DATA) = frame[n];
    return true;
}
