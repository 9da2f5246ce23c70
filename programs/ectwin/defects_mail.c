/* SPDX-License-Identifier: MIT */
/* Defects of mailbox protocols: AoE, SoE. */
#include "defect_datagram.h"

/* @return whether the datagram is a mail of AoE from the slave with more than an AMS header */
static bool is_ads(const datagram_t *g)
{
    return is_mail(g, false) && counter(g) == 1 && (data(g)[5] & 0x0F) == 1 && ect_load_le16(data(g)) >= 36;
}

void defect_ads_value_is_wrong(defect_t *d, datagram_t *g)
{
    (void)d;
    if (is_ads(g) && data(g)[6 + 16] == 2 && ect_load_le16(data(g)) > 40)
        data(g)[6 + 40] ^= 1;
}

void defect_ads_refuses_nothing(defect_t *d, datagram_t *g)
{
    (void)d;
    if (is_ads(g))
        ect_store_le32(data(g) + 6 + 32, 0);
}

/* @return whether the datagram is a mail of SoE from the slave */
static bool is_drive(const datagram_t *g)
{
    return is_mail(g, false) && counter(g) == 1 && (data(g)[5] & 0x0F) == 5 && ect_load_le16(data(g)) >= 4;
}

/* Replaces an error code of SoE. */
static void change_code(const datagram_t *g, uint16_t code, uint16_t becomes)
{
    if (is_drive(g) && (data(g)[6] & 0x10) != 0 && ect_load_le16(data(g) + 10) == code)
        ect_store_le16(data(g) + 10, becomes);
}

void defect_idn_is_known(defect_t *d, datagram_t *g)
{
    (void)d;
    change_code(g, 0x1001, 0x800B);
}

void defect_drive_is_known(defect_t *d, datagram_t *g)
{
    (void)d;
    change_code(g, 0x800A, 0x1001);
}

void defect_long_value_is_taken(defect_t *d, datagram_t *g)
{
    (void)d;
    if (!is_drive(g) || (data(g)[6] & 0x17) != 0x14 || ect_load_le16(data(g) + 10) != 0x7003)
        return;
    ect_store_le16(data(g), 4);
    data(g)[6] &= 0xEF;
}

/* Another width in the attribute that a read of these elements gets. */
static void change_width(const datagram_t *g, uint8_t elements)
{
    if (is_drive(g) && (data(g)[6] & 0x1F) == 2 && data(g)[7] == elements)
        data(g)[12] ^= 1;
}

void defect_width_is_wrong(defect_t *d, datagram_t *g)
{
    (void)d;
    change_width(g, 0x44);
}

void defect_width_alone_is_wrong(defect_t *d, datagram_t *g)
{
    (void)d;
    change_width(g, 0x04);
}

void defect_pieces_are_not_counted(defect_t *d, datagram_t *g)
{
    (void)d;
    if (is_drive(g) && (data(g)[6] & 0x0F) == 0x0A)
        ect_store_le16(data(g) + 8, 1);
}
