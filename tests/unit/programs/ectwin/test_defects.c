/* SPDX-License-Identifier: MIT */
/* Twins with a deliberate defect (programs/ectwin/defects.c): the datagrams that a defect changes, and those beside
 * them that it leaves alone. The conformance runner finds these defects, so a defect that changes more tests less. */
#define _GNU_SOURCE
#include "defect_steps.h"

#include "devices/fzm1/fzm1.h"
#include "sii/sii.h"

typedef struct row {
    const char *id, *lines;
} row_t;

#define RUN(rows, sii, size)                                                                                           \
    for (size_t i = 0; i < sizeof(rows) / sizeof(rows)[0]; i++)                                                        \
    step_run(&ect_fzm1, (rows)[i].id, (rows)[i].lines, sii, size)

/* --- registers ---------------------------------------------------------------------------------------------------- */

static void registers(void **state)
{
    static const row_t rows[] = {
        {"CF-001", "@0004 03\nFPWR 0630 00~16 :#0 =#1\nFPWR 0620 00~16 :#0\nFPWR 0630 00~15 :#0\nFPRD 0630 00~16 :#0"},
        {"CF-002", "BRD 0000 000000 ^1003\nBRD 0000 0000\nAPRD 0000 000000"},
        {"CF-003", "APRD 0130 0000 ^1001\nBRD 0130 0000"},
        {"CF-004", "@0010 0510\nFPRD 0130 0000 a1005 ^1001\nFPWR 0130 0000\nBRD 0130 0000"},
        /* COUNT: command, address and length are those of the row */
        {"CF-005", "FPWR 0000 00~4 :#0 =#1\nFPWR 0000 00~3 :#0\nFPRD 0000 00~4 :#0\nFPWR 0001 00~4 :#0"},
        {"CF-006", "ARMW 0600 00~4 :#5 =#0\nARMW 05FD 00~4 :#5 =#0\nARMW 05FC 00~4 :#5\nARMW 0601 00~4 :#5"},
        {"CF-007", "NOP 0600 00~4 :#0 =#8"},
        {"CF-008", "@0006 08\nFPRD 3000 00 :#0 =#1\nFPRD 2FFF 00 :#0\nFPWR 3000 00 :#0"},
        /* the register keeps the written byte until the chip's own one is written */
        {"CF-009", "@0134 1100\nFPRD 0134 0000 :1100\nFPWR 0134 2200 :#0 =#1\nFPRD 0134 0000 :1100#0 =2200#1\n"
                   "FPRD 0134 00 :11 =22\nFPRD 0130 00~6 :020000001100 =020000002200\nFPRD 0135 00 :07\n"
                   "BRD 0134 0000 :1100\nFPWR 0135 11 :#0\nBWR 0134 1100 :#0\nFPRD 0134 00 :11 =22\n"
                   "FPWR 0130 0000000011 :#0 =#1\nFPRD 0134 0000 :1100#0"},
        /* ANSWER: a reply that counts, at the address of the row */
        {"CF-010", "FPRD 0110 0000 :0300 =0200\nFPRD 0110 0000 :0300#0\nFPRD 010F 0000 :0303 =0302\nFPRD 0110 00 :03"},
        {"CF-011", "FPRD 030C 00 :FF =7F\nFPRD 030C 00 :FE"},
        /* a datagram without data, whatever its address */
        {"CF-013", "FPRD 0000 :#0 =#1\nFPRD 0000 00 :#0\nFPWR 0000 :#0"},
        {"CF-033", "@0130 01\nFPRD 0134 0000 :0000 =1100\n@0130 02\nFPRD 0134 0000 :0000"},
        {"CF-034", "@0130 14\nFPRD 0130 00~6 :140000001100 =140000001200\nFPRD 0130 00~6 :140000001101\n"
                   "FPRD 0130 00~6 :140000001000\n@0130 34\nFPRD 0130 00~6 :140000001100 =140000001200\n"
                   "@0130 12\nFPRD 0130 00~6 :120000001100\n@0130 04\nFPRD 0130 00~6 :040000001100"},
        {"CF-038", "@0130 12\nFPWR 0120 0200 >1200\nFPWR 0121 02\nFPRD 0120 0200\n@0130 0F\nFPWR 0120 0200"},
        /* REQUEST */
        {"CF-039", "@0130 12\nFPWR 0120 1400 >1200\nFPWR 011F 0014 >0012\nFPWR 0120 1800\nFPRD 0120 1400\n"
                   "@0130 02\nFPWR 0120 1400"},
        {"CF-040", "FPRD 0130 00~6 :120000001122\nFPWR 0120 0200\nFPRD 0130 00~6 :120000001122 =120000000000\n"
                   "FPRD 0130 00~6 :120000001122\nFPWR 0120 0200\nFPRD 0130 00~8 :1200000011220000\n"
                   "FPWR 0120 0200\nFPRW 0130 120000001122\nFPWR 0120 0200\nFPRD 0131 00~6 :120000001122\n"
                   "FPWR 0121 02\nFPRD 0130 00~6 :120000001122\nFPRD 0120 0200\nFPRD 0130 00~6 :120000001122"},
        {"CF-050", "@0420 0000\nFPRD 0440 0000 :FF00 =FE00\nFPWR 0440 0100\nFPRD 0442 0000 :0100\n"
                   "@0420 0001\nFPRD 0440 0000 :0100"},
        /* SWALLOW */
        {"CF-088b", "FPWR 0928 00~4 >- =#1\nFPWR 0928 00~3\nFPRD 0928 00~4\nNOP 0928 00~4 :#0"},
        /* INVERTED */
        {"CF-088", "FPRD 092C 00~4 :11223304 =11223384\nFPRD 092C 00~4 :11223384 =11223304"},
        {"CF-087", "FPRD 0900 00~4 :01020304 =02020304\nFPRD 0901 00~4 :01020304\nFPWR 0900 01020304\n"
                   "FPRD 0900 00~4 :01020304 =03020304"},
        {"CF-087b", "BWR 0900 00~4 >- =#1\nBWR 0910 00~4\nFPWR 0900 00~4"},
        {"CF-087c",
         "FPRD 091C 00~8 :0102030405060708 =0000000005060708\nFPRD 0918 00~8 :0102030405060708 =0102030400000000"},
        {"CF-089b", "@09A4 10270000\nFPRD 0998 00~8 :1127000001000000 =0100000001000000\n"
                    "FPRD 0998 00~4 :11270000\nFPRD 0990 00~8 :1127000001000000\nFPWR 0998 1127000001000000"},
        {"CF-094", "FPWR 0120 0200\n63 0000 00\nFPRD 0120 0200\nFPWR 0121 02\nFPWR 0120 0200 >- =#1\n63 0000 00\n"
                   "FPWR 0120 0200 >- =#1\nFPWR 0120 0200\n63 0000 00\nFPWR 0120 0200"},
        {"CF-096", "@0130 04\n@0010 0510\nAPWR 0010 0510\n@0010 0000\nFPWR 0010 0510\nAPWR 0012 0510\n"
                   "@0130 02\nAPWR 0010 0510\n@0130 04\nAPWR 0010 0510 >- =#0\nAPWR 0010 0510"},
        {"CF-097b", "@0210 0C01\nFPRD 0130 0000 i010C"},
        {"CF-097c", "FPRD 0130 0000 i0000"},
    };
    (void)state;
    RUN(rows, NULL, 0);
}

/* --- SyncManagers and process data -------------------------------------------------------------------------------- */

static void sync_managers(void **state)
{
    static const row_t rows[] = {
        /* full from a write that begins the mailbox and does not reach its end */
        {"CF-016", "FPRD 1100 00~4\nFPRD 1000 00~4\nFPRD 0805 00 :00\nFPWR 1000 00~127\nFPRD 0805 00 :01 =09\n"
                   "FPRD 1100 00~4\nFPWR 0FFF 00\nFPWR 0805 00\nFPRD 0804 00 :26\nFPRD 0805 00 :00 =08\n"
                   "FPWR 107F 00\nFPRD 0805 00 :00\nFPWR 1000 00~128\nFPRD 0805 00 :00\n"
                   "@0800 0000\nFPWR 0000 00~4\nFPRD 0805 00 :00"},
        /* empty from a read that begins it and does not reach its end; two bytes may be those of its length */
        {"CF-017", "FPRD 080D 00 :08\nFPRD 1100 00~3\nFPRD 080D 00 :89 =81\nFPRD 1100 00~2\nFPRD 080D 00 :08\n"
                   "FPRD 1100 00~127\nFPWR 1100 00~128\nFPRD 0120 0200\nFPWR 0121 00\nFPWR 080D 08\nFPRD 080C 08\n"
                   "FPRD 080D 00 :08 =00\nFPRD 1100 00~128\nFPRD 080D 00 :08\nFPRD 1100 00~3\nFPWR 0120 0200\n"
                   "FPRD 080D 00 :08\nFPRD 1101 00~3\nFPWR 1100 00~3\nFPRD 080D 00 :08\n"
                   "@0808 0000\nFPRD 0000 00~4\nFPRD 080D 00 :08"},
        {"CF-018", "FPRD 117F 00 =#0\nFPRD 117E 00\nFPRD 1180 00\nFPRD 117F 0000\nFPWR 117F 00"},
        {"CF-019b", "FPRD 1401 0000 :5566 =5666\nFPRD 1401 0000 :5566 =5766\nFPRD 1401 0000 :5566#0\n"
                    "FPRD 1400 0000 :5566\nFPRD 1401 00~3 :556677\nFPRW 1401 0000 :5566\n"
                    "FPRD 1401 0000 :5566 =5866"},
        {"CF-021", "@0130 21\nFPWR 1000 00~16 :#0 =#1\nFPWR 1000 00~15 :#0\nFPWR 1001 00~16 :#0\nFPRD 1000 00~16 :#0\n"
                   "FPRD 1100 00~16 :#0\n@0130 11\nFPWR 1000 00~16 :#0\n@0130 02\nFPWR 1000 00~16 :#0\n"
                   "@0130 01\n@0800 FF0F\nFPWR 0FFF 00~16 :#0"},
        {"CF-022", "FPWR 080E 00 >- =#1\nFPWR 080E 01\nFPWR 080E 0000\nFPWR 0806 00\nFPRD 080E 00\n"
                   "@0130 04\nFPWR 080E 00"},
        {"CF-023", "FPWR 080E 03 >- =#1\nFPRD 080D 00~3 :090100 =090302\nFPRD 080D 00~3 :FFFFFF\n"
                   "FPRD 080C 00~3 :090100\nFPRD 080D 00~2 :0901\nFPWR 080D 090100\nFPWR 080E 02\nFPWR 080E 0300\n"
                   "FPWR 0806 03\nFPRD 080E 03\n@0130 01\nFPWR 080E 03\n@0130 04\nFPWR 080E 01 >- =#1\n"
                   "FPRD 080D 00~3 :0903FF =0901FD"},
        {"CF-028", "LRD 0000 00~16 =01~16\nLRW 0000 00~16\nLRD 0000 00~15"},
        {"CF-029", "LRD 0000 00~4 :01020304 =01020305"},
        {"CF-M03", "LRW 0000 00~3 :010203 =000203\nLRD 0000 00~3 :010203\nLRW 0000 00~4 :01020304"},
        {"CF-031", "LRD 0000 00~4 :#0 =#1\nLRD 0000 00~4\nLRD 0000 00~3 :#0\nLRW 0000 00~4 :#0"},
        {"CF-032", "LRW 0000 00~16 :#6 =#5"},
        /* outputs as sent, in SAFEOP, until others come */
        {"CF-048", "FPRD 1100 00~16 :00~12\n@0130 04\nLRW 0000 5A00 :0101#3\n"
                   "FPRD 1100 00~16 =000000000000000000000000.5A~16\nFPRD 1100 00~16 :#0\nFPWR 1100 00~16\n"
                   "@0130 08\nFPRD 1100 00~16\nLRW 0000 7700\n@0130 04\nLRD 0000 7700\n"
                   "FPRD 1100 00~16 =000000000000000000000000.5A~16\nLRW 0000 0000\n"
                   "FPRD 1100 00~16 :000000000000000000000000.33~16"},
        {"CF-052", "FPRD 0440 0000\nFPWR 1180 00~5\nFPRD 0440 0000 =0100\nFPWR 1180 00~6\nFPRD 0440 0000\n"
                   "FPWR 1180 00~5\nFPRD 1180 00~6\nFPWR 1181 00~6\nFPWR 0440 0000\nFPRD 0442 0000\nLRD 0000 00\n"
                   "FPRD 0440 0000 =0100\nLRW 0000 00\nFPRD 0440 0000\nFPWR 1181 00~5\nFPRD 1180 00~5\n"
                   "FPRD 0440 0000"},
    };
    (void)state;
    RUN(rows, NULL, 0);
}

static void a_tenth_datagram_does_not_count(void **state)
{
    char lines[STEP_LINE] = "";
    (void)state;
    for (int n = 1; n <= 29; n++) { /* frames of 9, 9 and 11 datagrams */
        const bool first = n == 1 || n == 10 || n == 19;
        snprintf(lines + strlen(lines), sizeof lines - strlen(lines), "%s%s0130 00%s", n == 1 ? "" : "\n",
                 first ? "FPRD " : "& FPRD ", n == 28 ? " =#0" : "");
    }
    step_run(&ect_fzm1, "CF-015", lines, NULL, 0);
}

/* --- EEPROM ------------------------------------------------------------------------------------------------------- */

/* Categories from byte 0x80 on: SyncManagers at 0x84, RxPDO at 0x90, clocks of 18 bytes at 0xA0; nothing behind them.
 */
static size_t with_categories(uint8_t *sii, uint16_t pdo)
{
    uint8_t *at = sii + ECT_SII_CATEGORIES;
    const uint16_t rows[][2] = {{41, 4}, {pdo, 6}, {60, 9}, {0xFFFF, 0xFFFF}};
    memset(sii, 0, 256);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_store_le16(at, rows[i][0]);
        ect_store_le16(at + 2, rows[i][1]);
        at += 4 + 2 * (size_t)rows[i][1];
        if (rows[i][0] == 0xFFFF)
            break;
    }
    return 256;
}

static void eeprom(void **state)
{
    static const row_t rows[] = {
        /* the first read of the word is right */
        {"CF-066", "@0504 1000\nFPRD 0509 00~4 :01020304\nFPWR 0508 01020304\nFPRD 0508 00~4 :01020304\n"
                   "FPRD 0508 00~4 :01020304 =00020304\n@0504 0F00\nFPRD 0508 00~4 :01020304 =01020204\n"
                   "@0504 0E00\nFPRD 0508 00~4 :01020304\nFPRD 0508 00~8 :0102030405060708 =0102030404060708\n"
                   "@0504 1100\nFPRD 0508 00~4 :01020304\nFPRD 0508 00~4 :01020304"},
        /* SII_WORD: a read that has all bytes of the word */
        {"CF-057", "@0504 0E00\nFPRD 0508 00~4 :01020304 =11470304\nFPRD 0508 00~2 :0102 =1147\nFPRD 0508 00 :01\n"
                   "FPRD 0509 00~4 :01020304\nFPWR 0508 01020304\n@0504 0D00\nFPRD 0508 00~4 :01020304 =01021147\n"
                   "@0504 0F00\nFPRD 0508 00~4 :01020304\n@0504 0C00\nFPRD 0508 00~4 :01020304"},
        /* CATEGORY: the same at a byte of it */
        {"CF-027", "@0504 4300\nFPRD 0508 00~4 :01020304 =00000304\n@0504 4200\nFPRD 0508 00~4 :01020304 =01020000\n"
                   "FPRD 0508 00~3 :010203\n@0504 4400\nFPRD 0508 00~4 :01020304"},
        {"CF-061", "@0504 4D00\nFPRD 0508 00~4 :01020304 =77020304"},
        {"CF-062", "@0504 5900\nFPRD 0508 00~4 :01020304"}, /* byte 18 of 18 */
        {"CF-064", "@0504 0100\nFPRD 0508 00~4 :01020304"}, /* no such category */
    };
    uint8_t sii[256];
    (void)state;
    size_t size = with_categories(sii, ECT_SII_RXPDO);
    RUN(rows, sii, size);
    size = with_categories(sii, ECT_SII_TXPDO); /* a device without outputs: its inputs */
    step_run(&ect_fzm1, "CF-061", "@0504 4D00\nFPRD 0508 00~4 :01020304 =77020304", sii, size);
    step_run(&ect_fzm1, "CF-064", "@0504 4800\nFPRD 0508 00~4 :01020304", sii, size);
    size = with_categories(sii, ECT_SII_STRINGS);
    step_run(&ect_fzm1, "CF-061", "@0504 4D00\nFPRD 0508 00~4 :01020304", sii, size);
    sii[0x80 + 4 + 8 + 4 + 12 + 2] = 10; /* clocks of 20 bytes */
    step_run(&ect_fzm1, "CF-062", "@0504 5900\nFPRD 0508 00~4 :01020304 =F0020304", sii, size);
}

/* --- mailbox ------------------------------------------------------------------------------------------------------ */

static void mailbox(void **state)
{
    static const row_t rows[] = {
        /* MAIL of any protocol: a fetched one from SM1 */
        {"CF-024", "FPRD 1100 00~16 :0A0000000073~16 =0A0000000003~16\nFPRD 1100 00~16 :0A0000000063~16\n"
                   "FPRD 1100 00~16 :0A0000000073~16#0\nFPRD 1100 00~15 :0A0000000073~15\n"
                   "FPRD 1101 00~16 :0A0000000073~16\nFPRW 1100 00~16 :0A0000000073~16\n"
                   "FPWR 1000 0A0000000073~16\n@0808 FF0F\nFPRD 0FFF 00~16 :0A0000000073~16"},
        /* MAIL of an object: the service, the command and the entry of the row */
        {"CF-067", "FPRD 1100 00~16 :0A000000001300304F001C0103000000 =0A000000001300304F001C0102000000\n"
                   "FPRD 1100 00~16 :0A000000001300204F001C0103000000 =0A000000001300204F001C0102000000\n"
                   "FPRD 1100 00~16 :0A000000001300404F001C0103000000\n"
                   "FPRD 1100 00~16 :0A000000001400304F001C0103000000\n"
                   "FPRD 1100 00~16 :0A000000001300304B001C0103000000\n"
                   "FPRD 1100 00~16 :0A000000001300304F011C0103000000\n"
                   "FPRD 1100 00~16 :0A000000001300304F001C0203000000"},
        {"CF-070", "FPRD 1100 00~16 :0A0000000013003080181001.02000106 =0A0000000013003080181001.00000106\n"
                   "FPRD 1100 00~16 :0A00000000130030.43.181001.02000106 =0A00000000130030.43.181001.00000106"},
        {"CF-083", "@0130 08\nFPRD 1100 00~16 :0A0000000013003043181003.01020304 =0A0000000013003043181003.99020304\n"
                   "@0130 04\nFPRD 1100 00~16 :0A0000000013003043181003.01020304"},
        {"CF-025", "@080D F7\nFPWR 1000 00~16\n@080D 08\nFPWR 1000 00~16 >- =#1\nFPWR 1000 00~15\nFPWR 1001 00~16"},
        {"CF-026", "FPWR 1000 7B00~16 >0A00~16\nFPWR 1000 7A00~16\nFPWR 1000 7B00~15"},
        {"CF-072b", "FPWR 1000 0A000000001300208018~16 >- =#1\nFPWR 1000 0A000000001300204018~16\n"
                    "FPWR 1000 0A000000001400208018~16\nFPWR 1000 0A000000001300208018~15"},
        {"CF-076", "FPRD 1100 00~16 :0A0000000013008082000000.0000.05.00 =0A0000000013008082000000.0000.06.00\n"
                   "FPRD 1100 00~16 :0A0000000013008002000000.0000.05.00 =0A0000000013008002000000.0000.06.00\n"
                   "FPRD 1100 00~16 :0A0000000013008082000000.0000.05.00#0\n"
                   "FPRD 1101 00~16 :0A0000000013008082000000.0000.05.00\n"
                   "FPRD 1100 00~16 :0A0000000014008082000000.0000.05.00\n"
                   "FPRD 1100 00~16 :0A0000000013003082000000.0000.05.00\n"
                   "FPRD 1100 00~16 :0A0000000013008084000000.0000.05.00\n"
                   "FPRD 1100 00~16 :0A0000000013008082000000.0100.05.00"},
        {"CF-077", "FPRD 1100 00~20 :0E0000000013008004000000.1810.07000409.4964"
                   " =0E0000000013008004000000.1810.07000409.5864\n"
                   "FPRD 1100 00~20 :0E0000000013008004000000.1810.07000409.4964#0\n"
                   "FPRD 1101 00~20 :0E0000000013008004000000.1810.07000409.4964\n"
                   "FPRD 1100 00~20 :0E0000000014008004000000.1810.07000409.4964\n"
                   "FPRD 1100 00~20 :0E0000000013003004000000.1810.07000409.4964\n"
                   "FPRD 1100 00~20 :0E0000000013008003000000.1810.07000409.4964\n"
                   "FPRD 1100 00~20 :0E0000000013008004000000.1910.07000409.4964"},
        {"CF-084", "FPRD 1100 00~16 :060000000014.0500.05~16 =060000000014.0500.04~16\n"
                   "FPRD 1100 00~16 :060000000014.0500.05~16#0\nFPRD 1101 00~16 :060000000014.0500.05~16\n"
                   "FPRD 1100 00~16 :060000000013.0500.05~16\nFPRD 1100 00~16 :060000000014.0400.05~16\n"
                   "FPRD 1100 00~16 :060000000014.0500.06~16"},
        /* an error reply after a request of SoE */
        {"CF-086", "FPRD 1100 00~16 :040000000010.01000200~16\nFPWR 1000 000000000075~16\n"
                   "FPRD 1100 00~16 :040000000010.01000200~16 =040000000010.01000400~16\n"
                   "FPRD 1100 00~16 :040000000010.01000200~16#0\nFPRD 1101 00~16 :040000000010.01000200~16\n"
                   "FPRD 1100 00~16 :040000000015.01000200~16\nFPWR 1000 000000000073~16\n"
                   "FPRD 1100 00~16 :040000000010.01000200~16"},
        {"CF-094b", "FPWR 0120 0200\nFPWR 1000 000000000073~16\nFPWR 0120 0200\nFPWR 1000 00000000000D~15\n"
                    "FPWR 0120 0200\nFPWR 1000 00000000007D~16\nFPRD 0120 0200\nFPWR 0121 02\n"
                    "FPWR 0120 0200 >- =#1\nFPWR 1000 00000000000D~16\nFPWR 0120 0200 >- =#1\nFPWR 0120 0200\n"
                    "FPWR 1000 00000000000D~16\nFPWR 0120 0200"},
        {"DEAD-MAILBOX", "FPWR 1000 0A0000000013002040~16\nFPWR 1000 0A00000000140020E0~16\n"
                         "FPWR 1000 0A00000000130030E0~16\nFPWR 1000 0A00000000130020C0~16\n"
                         "FPWR 1000 0A00000000130020FF~16\nFPWR 1000 00~15\nFPWR 1000 00~16 >- =#0\n"
                         "FPWR 1000 00~16 >- =#0\nNOP 1000 00~16 :#7"},
    };
    (void)state;
    RUN(rows, NULL, 0);
}

static void aoe_and_soe(void **state)
{
    static const row_t rows[] = {
        {"CF-A01", "FPRD 1100 00~48 :29000000.00.11.00000000000000000000000000000000.0200~48"
                   " =29000000.00.11.00000000000000000000000000000000.0200.0000.00000000000000000000000000000000"
                   ".00000000.01~48\n"
                   "FPRD 1100 00~48 :28000000.00.11.00000000000000000000000000000000.0200~48\n"
                   "FPRD 1100 00~48 :29000000.00.11.00000000000000000000000000000000.0300~48\n"
                   "FPRD 1100 00~48 :29000000.00.12.00000000000000000000000000000000.0200~48"},
        {"CF-A02", "FPRD 1100 00~46 :24000000.00.11.00000000000000000000000000000000.0200.0000"
                   ".000000000000000000000000.01020304"
                   " =24000000.00.11.00000000000000000000000000000000.0200.0000"
                   ".000000000000000000000000.00000000~46\n"
                   "FPRD 1100 00~46 :23000000.00.11.00000000000000000000000000000000.0200.0000"
                   ".000000000000000000000000.01020304\n"
                   "FPRD 1100 00~46 :24000000.00.11.00000000000000000000000000000000.0200.0000"
                   ".000000000000000000000000.01020304#0\n"
                   "FPRD 1101 00~46 :24000000.00.11.00000000000000000000000000000000.0200.0000"
                   ".000000000000000000000000.01020304\n"
                   "FPRD 1100 00~46 :24000000.00.13.00000000000000000000000000000000.0200.0000"
                   ".000000000000000000000000.01020304"},
        {"CF-S01", "FPRD 1100 00~16 :060000000015.1200.0000.0110~16 =060000000015.1200.0000.0B80~16\n"
                   "FPRD 1100 00~16 :040000000015.1200.0000.0110~16 =040000000015.1200.0000.0B80~16\n"
                   "FPRD 1100 00~16 :030000000015.1200.0000.0110~16\n"
                   "FPRD 1100 00~16 :060000000015.0200.0000.0110~16\n"
                   "FPRD 1100 00~16 :060000000015.1200.0000.0210~16\n"
                   "FPRD 1100 00~16 :060000000013.1200.0000.0110~16\n"
                   "FPRD 1101 00~16 :060000000015.1200.0000.0110~16\n"
                   "FPRD 1100 00~16 :060000000015.1200.0000.0110~16#0"},
        {"CF-S02", "FPRD 1100 00~16 :0A0000000015.02.44.0000.0000.02~16 =0A0000000015.02.44.0000.0000.03~16\n"
                   "FPRD 1100 00~16 :0A0000000015.E2.44.0000.0000.02~16 =0A0000000015.E2.44.0000.0000.03~16\n"
                   "FPRD 1100 00~16 :0A0000000015.12.44.0000.0000.02~16\n"
                   "FPRD 1100 00~16 :0A0000000015.02.04.0000.0000.02~16\n"
                   "FPRD 1100 00~16 :030000000015.02.44.0000.0000.02~16"},
        {"CF-S03", "FPRD 1100 00~16 :060000000015.14.40.0000.0370~16 =040000000015.04.40.0000.0370~16\n"
                   "FPRD 1100 00~16 :060000000015.FC.40.0000.0370~16 =040000000015.EC.40.0000.0370~16\n"
                   "FPRD 1100 00~16 :060000000015.12.40.0000.0370~16\n"
                   "FPRD 1100 00~16 :060000000015.04.40.0000.0370~16\n"
                   "FPRD 1100 00~16 :060000000015.14.40.0000.0470~16\n"
                   "FPRD 1100 00~16 :060000000013.14.40.0000.0370~16"},
        {"CF-S04", "FPRD 1100 00~16 :060000000015.1200.0000.0A80~16 =060000000015.1200.0000.0110~16"},
        {"CF-S05", "FPRD 1100 00~16 :060000000015.FA00.0300~16 =060000000015.FA00.0100~16\n"
                   "FPRD 1100 00~16 :060000000015.0200.0300~16\nFPRD 1100 00~16 :060000000013.0A00.0300~16"},
        {"CF-S06", "FPRD 1100 00~16 :0A0000000015.02.04.0000.0000.02~16 =0A0000000015.02.04.0000.0000.03~16"},
    };
    (void)state;
    RUN(rows, NULL, 0);
}

static void eoe(void **state)
{
    static const row_t rows[] = {
        {"CF-E01", "FPRD 1100 00~16 :090000000012.1700.0000.FF~16 =090000000012.1700.0000.F7~16\n"
                   "FPRD 1100 00~16 :080000000012.1700.0000.FF~16\nFPRD 1100 00~16 :090000000012.1600.0000.FF~16\n"
                   "FPRD 1100 00~16 :090000000013.1700.0000.FF~16\nFPRD 1100 00~16 :090000000012.1700.0000.FF~16#0\n"
                   "FPRD 1101 00~16 :090000000012.1700.0000.FF~16"},
        {"CF-E02",
         "FPRD 1100 00~42 :240000000012.10FF~42 =240000000012.10FE~42\nFPRD 1100 00~42 :230000000012.10FF~42\n"
         "FPRD 1100 00~42 :250000000012.10FF~42\nFPRD 1100 00~42 :240000000012.11FF~42\n"
         "FPRD 1100 00~42 :240000000013.10FF~42"},
        {"CF-E03",
         "FPWR 1000 240000000012.1001.00A5~42 >240000000012.1001.0015~42\nFPWR 1000 240000000012.1101.00A5~42\n"
         "FPWR 1000 240000000013.1001.00A5~42"},
        {"CF-E04", "FPWR 1000 040000000012~16\nFPWR 1000 040000000012~16 >040000000002~16\nFPWR 1000 040000000022~16\n"
                   "FPWR 1000 040000000023~16\nFPWR 1000 040000000022~16 >040000000002~16"},
        {"CF-E05", "FPRD 1100 00~16 :040000000012.13000100~16 =040000000012.13000000~16\n"
                   "FPRD 1100 00~16 :040000000012.12000100~16\nFPRD 1100 00~16 :040000000013.13000100~16"},
        /* address behind the flags, or behind the MAC address that the flags or the length show */
        {"CF-E06", "FPWR 1000 0C0000000012.12000000.02000000.01020304 >0C0000000012.12000000.02000000.04030201\n"
                   "FPWR 1000 0B0000000012.12000000.02000000.01020304\n"
                   "FPWR 1000 0D0000000012.12000000.02000000.01020304\n"
                   "FPWR 1000 0C0000000012.12000000.01000000.01020304\n"
                   "FPWR 1000 0C0000000012.13000000.02000000.01020304\n"
                   "FPWR 1000 0C0000000013.12000000.02000000.01020304\n"
                   "FPWR 1000 120000000012.12000000.03000000.A1A2A3A4A5A6.01020304"
                   " >120000000012.12000000.03000000.A1A2A3A4A5A6.04030201\n"
                   "FPWR 1000 110000000012.12000000.03000000.A1A2A3A4A5A6.01020304\n"
                   "FPWR 1000 3D0000000012.12000000.02000000.01020304~68"
                   " >3D0000000012.12000000.02000000.04030201~68\n"
                   "FPWR 1000 3E0000000012.12000000.02000000.A1A2A3A4A5A6.01020304~68"
                   " >3E0000000012.12000000.02000000.A1A2A3A4A5A6.04030201~68\n"
                   "FPRD 1100 00~18 :0C0000000012.17000000.02000000.01020304 =0C0000000012.17000000.02000000.04030201\n"
                   "FPRD 1100 00~18 :0C0000000012.17000000.02000000.01020304#0\n"
                   "FPRD 1100 00~18 :0C0000000012.12000000.02000000.01020304"},
        /* SDO, then a fragment that is not the first */
        {"CF-E07", "FPWR 1000 0A0000000013~16\nFPWR 1000 240000000012.1001.C1~16 >- =#1\n"
                   "FPWR 1000 240000000012.1001.C1~16\nFPWR 1000 0A0000000013~16\nFPWR 1000 240000000012.1001.C0~16\n"
                   "FPWR 1000 0A0000000013~16\nFPWR 1000 240000000012.1101.C1~16\nFPWR 1000 0A0000000013~16\n"
                   "FPWR 1000 240000000014.1001.C1~16\nFPWR 1000 240000000012.1001.C1~16\n"
                   "FPWR 1000 0A0000000013~16\nFPWR 1001 240000000012.1001.C1~16\n"
                   "FPWR 1000 240000000012.1001.C1~16 >- =#1"},
        /* the second fragment after INIT gets the first one's bytes, if there is room */
        {"CF-E08",
         "@100A 0102030405060708090A0B0C0D0E0F101112131415161718191A1B1C1D1E1F20\n"
         "FPWR 1000 060000000012.1001.01.10.AABB~44\nFPRD 0120 1100\nFPWR 0121 11\nFPWR 0120 1200\n"
         "FPWR 1000 060000000012.1001.01.10.AABB~44\nFPWR 0120 1100\nFPWR 1000 060000000012.1101.01.10.AABB~44\n"
         "FPWR 1000 060000000013.1001.01.10.AABB~44\n"
         "FPWR 1000 060000000012.1001.41.1F.AABB~44"
         " >260000000012.1001.80.10.0102030405060708090A0B0C0D0E0F101112131415161718191A1B1C1D1E1F20.AABB\n"
         "FPWR 1000 060000000012.1001.01.10.AABB~44\nFPWR 0120 0100\n"
         "FPWR 1000 060000000012.1001.01.10.AABB~43\nFPWR 1000 060000000012.1001.01.10.AABB~44\n"
         "FPWR 0120 0100\nFPWR 1000 060000000012.1001.02.10.AABB~44\n"
         "FPWR 1000 060000000012.1001.01.10.AABB~44"},
        /* 50 reads of AL status between two mails */
        {"CF-E09", "49* FPRD 0130 0000\nFPRD 0131 00\nFPWR 0130 0000\nFPRD 1100 00~16 :0A0000000012.10~16\n"
                   "50* FPRD 0130 0000\nFPRD 1101 00~16\nFPRD 1100 00~16 :0A0000000012.10~16#0\n"
                   "FPRD 1100 00~16 :0A0000000012.10~16 =0A0000000012.100000000000000000.FF\n"
                   "FPRD 1100 00~16 :0A0000000012.10~16\n50* FPRD 012F 0000\nFPRD 1100 00~16 :050000000012.10~16"
                   " =050000000012.10000000.FF00~16\n"
                   "50* FPRD 0130 0000\nFPRD 1100 00~16 :040000000012.10~16\n"
                   "50* FPRD 0130 0000\nFPRD 1100 00~16 :0A0000000012.11~16\n"
                   "50* FPRD 0130 0000\nFPRD 1100 00~16 :0A0000000013.10~16"},
        {"CF-E10", "FPWR 1000 240000000012.1001.BE~16\nFPWR 1000 240000000012.1101.FF~16\n"
                   "FPWR 1000 240000000013.1001.FF~16\nFPWR 1000 240000000012.1001.00~16\n"
                   "FPWR 1000 240000000012.1001.BF~16 >- =#1\nFPRD 0120 1100\nFPWR 0121 11\nFPWR 0120 0200\n"
                   "FPWR 1000 240000000012.1101.00~16\nFPWR 1000 240000000012.1001.00~16 >- =#1\nFPWR 0120 1100\n"
                   "FPWR 1000 240000000012.1001.00~16"},
        {"CF-E12", "FPRD 1100 00~16 :040000000012.1A00.0200~16 =040000000012.1A00.0000~16\n"
                   "FPRD 1100 00~16 :040000000012.1900.0200~16\nFPRD 1100 00~16 :040000000012.1F00.0200~16"
                   " =040000000012.1F00.0000~16\nFPRD 1100 00~16 :040000000013.1A00.0200~16"},
    };
    (void)state;
    RUN(rows, NULL, 0);
}

/* --- drives ------------------------------------------------------------------------------------------------------- */

/* RxPDOs: one of another SyncManager, then control word, target, speed and torque at 0, 2, 6 and 10; TxPDOs: status
 * word and mode at 0 and 2. */
static size_t drive_image(uint8_t *sii)
{
    static const struct {
        uint16_t category;
        const char *data;
    } rows[] = {
        {ECT_SII_RXPDO, "0016.01.03.0000.0000"
                        "6060.00.00.05.08.0000"
                        "0116.02.02.0000.0000"
                        "4060.00.00.06.10.0000"
                        "7A60.00.00.04.20.0000"
                        "0216.02.02.0000.0000"
                        "FF60.00.00.04.20.0000"
                        "7160.00.00.03.10.0000"},
        {ECT_SII_TXPDO, "001A.03.03.0000.0000"
                        "4160.00.00.06.10.0000"
                        "0000.00.00.00.07.0000"
                        "6160.00.00.02.08.0000"},
    };
    uint8_t *at = sii + ECT_SII_CATEGORIES;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t bytes[STEP_DATA];
        const uint16_t length = step_bytes(rows[i].data, bytes, NULL);
        ect_store_le16(at, rows[i].category);
        ect_store_le16(at + 2, (uint16_t)(length / 2));
        memcpy(at + 4, bytes, length);
        at += 4 + length;
    }
    ect_store_le16(at, ECT_SII_END);
    ect_store_le16(at + 2, ECT_SII_END);
    return (size_t)(at + 4 - sii);
}

/* Process data of 12 and 3 bytes: control, target, speed, torque; status, mode. */
#define SIZES "@0812 0C00\n@081A 0300\n"

static void drives(void **state)
{
    static const row_t rows[] = {
        /* a command becomes another one in the state that was shown last */
        {"CF-D02", SIZES "LRW 0000 0200~15\n"
                         "LRW 0000 0200~15 :0200.00000000.00000000.0000.2102.00\n"
                         "LRW 0000 0200~15 >0600~15 :0600.00000000.00000000.0000.B1FF.00\n"
                         "LRW 0000 0200~15 >0600~15 :0600.00000000.00000000.0000.2102.00\n"
                         "LRW 0000 0600~15 :0600.00000000.00000000.0000.2102.00\n"
                         "LRW 0000 0200~14\n"
                         "LRD 0000 0200~15\n"
                         "LRW 0000 0200~15 >0600~15 :0600.00000000.00000000.0000.2302.00\n"
                         "LRW 0000 0200~15"},
        {"CF-D05", SIZES "LRW 0000 0700~15 :0700.00000000.00000000.0000.2302.00\n"
                         "LRW 0000 0600~15 >0700~15 :0700.00000000.00000000.0000.2702.00\nLRW 0000 0600~15"},
        {"CF-D06", SIZES "LRW 0000 0F00~15 :0F00.00000000.00000000.0000.2702.00\n"
                         "LRW 0000 0200~15 >0000~15 :0000.00000000.00000000.0000.0702.00\n"
                         "LRW 0000 0200~15 >0000~15 :0000.00000000.00000000.0000.2302.00\nLRW 0000 0200~15"},
        {"CF-D09", SIZES "LRW 0000 0600~15 :0600.00000000.00000000.0000.2802.00\n"
                         "LRW 0000 0600~15 >8000~15 :8000.00000000.00000000.0000.0802.00\n"
                         "LRW 0000 0600~15 >8000~15 :8000.00000000.00000000.0000.0F02.00\nLRW 0000 0600~15"},
        /* in process data and by SDO */
        {"CF-D03",
         SIZES "LRW 0000 00~15 :0000.00000000.00000000.0000.0000.03 =0000.00000000.00000000.0000.0000.01\n"
               "LRW 0000 00~15 :0000.00000000.00000000.0000.0000.04\n"
               "LRW 0000 00~14 :0000.00000000.00000000.0000.0000\n"
               "FPRD 1100 00~16 :0A0000000013.0030.4F.6160.00.03000000 =0A0000000013.0030.4F.6160.00.01000000\n"
               "FPRD 1100 00~16 :0A0000000013.0030.4F.6160.00.03000000#0\n"
               "FPRD 1101 00~16 :0A0000000013.0030.4F.6160.00.03000000\n"
               "FPRD 1100 00~16 :0A0000000014.0030.4F.6160.00.03000000\n"
               "FPRD 1100 00~16 :0A0000000013.0020.4F.6160.00.03000000\n"
               "FPRD 1100 00~16 :0A0000000013.0030.4F.6060.00.03000000\n"
               "FPRD 1100 00~16 :0A0000000013.0030.4F.6160.00.04000000"},
        {"CF-D07", SIZES "FPWR 1000 0A0000000013.0020.2F.5C60.00.01000000 >0A0000000013.0020.2F.5C60.00.00000000\n"
                         "FPWR 1001 0A0000000013.0020.2F.5C60.00.01000000\n"
                         "FPWR 1000 0A0000000014.0020.2F.5C60.00.01000000\n"
                         "FPWR 1000 0A0000000013.0020.4F.5C60.00.01000000\n"
                         "FPWR 1000 0A0000000013.0020.2F.5B60.00.01000000\n"
                         "FPWR 1000 0A0000000013.0020.2F.5C60.00.02000000"},
        {"CF-D08", SIZES "LRW 0000 0FFF~15 >0FFE~15\nLRW 0000 0FFF~14\n@0812 0000\n@081A 0F00\nLRW 0000 0FFF~15"},
        /* bit 12 from bit 4 until the drive is no longer enabled */
        {"CF-D10", SIZES "LRW 0000 1F00~15 :1F00.00000000.00000000.0000.2702.00\n"
                         "LRW 0000 0F00~15 :0F00.00000000.00000000.0000.2712.00\n"
                         "LRW 0000 0F00~15 :0F00.00000000.00000000.0000.2702.00\n"
                         "LRW 0000 1F00~15 :1F00.00000000.00000000.0000.2712.00\n"
                         "LRW 0000 0F00~15 :0F00.00000000.00000000.0000.2702.00"
                         " =0F00.00000000.00000000.0000.2712.00\n"
                         "LRW 0000 0F00~14\n"
                         "LRW 0000 0F00~15 :0F00.00000000.00000000.0000.2702.00"
                         " =0F00.00000000.00000000.0000.2712.00\n"
                         "LRW 0000 1700~15 :1700.00000000.00000000.0000.2312.00\n"
                         "LRW 0000 0F00~15 :0F00.00000000.00000000.0000.2702.00"},
        {"CF-D11", SIZES "LRW 0000 00~15 :0000.00000000.00000000.0000.FFFF.03 =0000.00000000.00000000.0000.FFEF.03\n"
                         "LRW 0000 00~15 :0000.00000000.00000000.0000.FFFF.06"},
        {"CF-D12", SIZES "LRW 0000 00~15 :0000.00000000.00000000.0000.FFFF.06 =0000.00000000.00000000.0000.FFEF.06\n"
                         "LRW 0000 00~15 :0000.00000000.00000000.0000.FFFF.03"},
        {"CF-D14", SIZES "LRW 0000 00~15 :0000.00000000.00000000.0000.FFFF.07 =0000.00000000.00000000.0000.FFEF.07\n"
                         "LRW 0000 00~15 :0000.00000000.00000000.0000.FFFF.06"},
        {"CF-D16", SIZES "LRW 0000 00~15 :0000.00000000.00000000.0000.0000.04 =0000.00000000.00000000.0000.0004.04\n"
                         "LRW 0000 00~15 :0000.00000000.00000000.0000.0000.03"},
        /* the target of the cycle before csp is enabled */
        {"CF-D13", SIZES "LRW 0000 0F00.11223344~15 :0F00.11223344.00000000.0000.2702.07\n"
                         "LRW 0000 0F00.55667788~15 :0F00.55667788.00000000.0000.2302.08\n"
                         "LRW 0000 0F00.99AABBCC~15 :0F00.99AABBCC.00000000.0000.3702.08\n"
                         "LRW 0000 0F00.01020304~15 >0F00.99AABBCC~15 :0F00.99AABBCC.00000000.0000.2702.08\n"
                         "LRW 0000 0F00.01020304~14\n"
                         "LRW 0000 0F00.01020304~15 >0F00.99AABBCC~15 :0F00.99AABBCC.00000000.0000.2702.07\n"
                         "LRW 0000 0F00.01020304~15"},
        {"CF-D15", SIZES "LRW 0000 0F00.00000000.FEFFFFFF~15 :0F00.00000000.FEFFFFFF.0000.2702.09\n"
                         "LRW 0000 0F00.00000000.FEFFFFFF~15 >0F00.00000000.02000000~15"
                         " :0F00.00000000.02000000.0000.2702.09\n"
                         "LRW 0000 0F00.00000000.FEFFFF7F~15 :0F00.00000000.FEFFFF7F.0000.2702.09\n"
                         "LRW 0000 0F00.00000000.FEFFFFFF~14\n"
                         "LRW 0000 0F00.00000000.FEFFFFFF~15 >0F00.00000000.02000000~15"
                         " :0F00.00000000.02000000.0000.2702.08\n"
                         "LRW 0000 0F00.00000000.FEFFFFFF~15"},
        {"CF-D17", SIZES "LRW 0000 0F00.00000000.00000000.FEFF~15 :0F00.00000000.00000000.FEFF.2702.0A\n"
                         "LRW 0000 0F00.00000000.00000000.FEFF~15 >0F00.00000000.00000000.0200~15"
                         " :0F00.00000000.00000000.0200.2702.0A\n"
                         "LRW 0000 0F00.00000000.00000000.FE7F~15 :0F00.00000000.00000000.FE7F.2702.0A\n"
                         "LRW 0000 0F00.00000000.00000000.FEFF~15 >0F00.00000000.00000000.0200~15"
                         " :0F00.00000000.00000000.0200.2702.09\n"
                         "LRW 0000 0F00.00000000.00000000.FEFF~15"},
    };
    uint8_t sii[512] = {0};
    (void)state;
    const size_t size = drive_image(sii);
    RUN(rows, sii, size);
}

/* A device without these entries, and PDOs that the end of their category cuts. */
static void no_drive(void **state)
{
    static const char lines[] = SIZES "LRW 0000 0FFF~15\nLRW 0000 00~15 :0000.00000000.00000000.0000.FFFF.03";
    uint8_t sii[512] = {0};
    (void)state;
    step_run(&ect_fzm1, "CF-D08", lines, sii, 128);
    step_run(&ect_fzm1, "CF-D11", lines, sii, 128);
    step_run(&ect_fzm1, "CF-D10", lines, sii, 128);
    step_run(&ect_fzm1, "CF-D13", lines, sii, 128);
    for (uint16_t words = 4; words <= 8; words += 2) { /* 4: no entry; 6: half an entry; 8: the entry */
        step_bytes("3300.0000.0016.01.02.0000.0000.4060.00.00.06.10.0000.0000.FFFF.FFFF", sii + 128, NULL);
        ect_store_le16(sii + 130, words);
        step_run(&ect_fzm1, "CF-D08", words < 8 ? SIZES "LRW 0000 0FFF~15" : SIZES "LRW 0000 0FFF~15 >0FFE~15", sii,
                 sizeof sii);
    }
}

/* --- frames ------------------------------------------------------------------------------------------------------- */

typedef struct change {
    size_t at;
    uint8_t value;
} change_t;

/* The frame of one FPRD of DL status, to which CF-010 has an answer. @return whether the reply is changed */
static bool is_changed(const change_t *changes, size_t count, size_t length, size_t length_after)
{
    wire_t w = {0};
    defect_t d = {0};
    (void)step_open(&w, &ect_fzm1);
    assert_true(defect_choose(&d, "CF-010"));
    wire_build(&w, FPRD, STEP_STATION, 0x0110, "\3\0", 2);
    for (size_t i = 0; i < count; i++)
        w.frame[changes[i].at] = changes[i].value;
    defect_before(&d, w.chain, w.frame, length ? length : w.frame_length);
    uint8_t *data = wire_datagram(&w, 0) + ECT_DATAGRAM_DATA;
    data[2] = 1;
    defect_after(&d, w.chain, w.frame, length_after ? length_after : w.frame_length);
    const bool changed = data[0] == 2;
    assert_true(changed || data[0] == 3);
    wire_close(&w);
    return changed;
}

static void frames(void **state)
{
    static const struct {
        change_t change;
        size_t length, length_after;
        bool changed;
    } rows[] = {
        {.changed = true},
        {.change = {12, 0x08}},                                  /* no EtherCAT */
        {.change = {15, 0x20}},                                  /* EtherCAT of another type */
        {.length = 29, .length_after = 29},                      /* without the counter's second byte */
        {.length = 1600, .length_after = 1600, .changed = true}, /* the longest that is changed */
        {.length = 1601, .length_after = 1601},
        {.length = 1600, .length_after = 1599}, /* another frame */
        {.change = {22, 3}},                    /* a datagram that the frame cuts */
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        if (is_changed(&rows[i].change, rows[i].change.at > 0, rows[i].length, rows[i].length_after) != rows[i].changed)
            fail_msg("row %zu: expected %d", i, rows[i].changed);
    }
}

static void a_datagram_behind_the_last_one_is_no_datagram(void **state)
{
    (void)state;
    wire_t w = {0};
    defect_t d = {0};
    (void)step_open(&w, &ect_fzm1);
    assert_true(defect_choose(&d, "CF-010"));
    wire_build(&w, FPRD, STEP_STATION, 0x0110, "\3\0", 2);
    wire_append(&w, FPRD, STEP_STATION, 0x0110, "\3\0", 2);
    wire_append(&w, FPRD, STEP_STATION, 0x0110, "\3\0", 2);
    wire_datagram(&w, 1)[ECT_DATAGRAM_LENGTH + 1] &= 0x7F;
    uint8_t *last = wire_datagram(&w, 1) + ECT_DATAGRAM_DATA + 4;
    defect_before(&d, w.chain, w.frame, w.frame_length);
    for (unsigned int n = 0; n < 2; n++)
        wire_datagram(&w, n)[ECT_DATAGRAM_DATA + 2] = 1;
    last[ECT_DATAGRAM_DATA + 2] = 1;
    defect_after(&d, w.chain, w.frame, w.frame_length);
    assert_int_equal(wire_datagram(&w, 0)[ECT_DATAGRAM_DATA], 2);
    assert_int_equal(wire_datagram(&w, 1)[ECT_DATAGRAM_DATA], 2);
    assert_int_equal(last[ECT_DATAGRAM_DATA], 3);
    wire_close(&w);
}

static void without_a_defect_nothing_is_changed(void **state)
{
    (void)state;
    wire_t w = {0};
    defect_t d = {0};
    (void)step_open(&w, &ect_fzm1);
    assert_false(defect_choose(&d, "CF-9999"));
    wire_build(&w, FPRD, STEP_STATION, 0x0110, "\3\0", 2);
    defect_before(&d, w.chain, w.frame, w.frame_length);
    defect_after(&d, w.chain, w.frame, w.frame_length);
    assert_int_equal(wire_datagram(&w, 0)[ECT_DATAGRAM_DATA], 3);
    wire_close(&w);
}

static void the_circulating_flag_is_taken_away(void **state)
{
    (void)state;
    wire_t w = {0};
    defect_t d = {0};
    (void)step_open(&w, &ect_fzm1);
    assert_true(defect_choose(&d, "CF-014"));
    wire_build(&w, FPRD, STEP_STATION, 0x0110, "\3\0", 2);
    wire_append(&w, FPRD, STEP_STATION, 0x0110, "\3\0", 2);
    wire_datagram(&w, 0)[ECT_DATAGRAM_LENGTH + 1] |= 0x40;
    defect_before(&d, w.chain, w.frame, w.frame_length);
    defect_after(&d, w.chain, w.frame, w.frame_length);
    assert_int_equal(wire_datagram(&w, 0)[ECT_DATAGRAM_LENGTH + 1], 0x80);
    assert_int_equal(wire_datagram(&w, 1)[ECT_DATAGRAM_LENGTH + 1], 0);
    wire_close(&w);
}

/* END-OF-FRAME: a read gets the status of before the frame, at any of the 16 SyncManagers; a write does not change. */
static void status_of_the_start_of_the_frame(void **state)
{
    static const uint16_t status_of[] = {0x0805, 0x087D, 0x0885}; /* SM0, SM15; no SM16 */
    (void)state;
    for (size_t i = 0; i < 3; i++) {
        wire_t w = {0};
        defect_t d = {0};
        ect_esc_t *esc = step_open(&w, &ect_fzm1);
        assert_true(defect_choose(&d, "END-OF-FRAME"));
        esc->memory[status_of[i]] = 0x11;
        wire_build(&w, FPWR, STEP_STATION, status_of[i], "\x22", 1);
        wire_append(&w, FPRD, STEP_STATION, (uint16_t)(status_of[i] - 1), "\0\0", 2);
        wire_append(&w, FPRD, STEP_STATION, (uint16_t)(status_of[i] + 1), "\0\0", 2);
        defect_before(&d, w.chain, w.frame, w.frame_length);
        esc->memory[status_of[i]] = 0x22;
        memcpy(wire_datagram(&w, 1) + ECT_DATAGRAM_DATA, "\x33\x22", 2);
        defect_after(&d, w.chain, w.frame, w.frame_length);
        assert_int_equal(wire_datagram(&w, 0)[ECT_DATAGRAM_DATA], 0x22);
        assert_int_equal(wire_datagram(&w, 1)[ECT_DATAGRAM_DATA], 0x33);
        assert_int_equal(wire_datagram(&w, 1)[ECT_DATAGRAM_DATA + 1], i < 2 ? 0x11 : 0x22);
        assert_int_equal(wire_datagram(&w, 2)[ECT_DATAGRAM_DATA], 0);
        wire_close(&w);
    }
}

/* --- the list ----------------------------------------------------------------------------------------------------- */

static void count_rows(void *ctx, const char *id, const char *what)
{
    defect_t d = {0};
    size_t *count = ctx;
    assert_true(defect_choose(&d, id));
    assert_true(strlen(what) > 5);
    (*count)++;
}

static void visit_last(void *ctx, const char *id, const char *what)
{
    (void)what;
    *(const char **)ctx = id;
}

static void every_defect_of_the_list_can_be_chosen(void **state)
{
    size_t count = 0;
    const char *last = NULL;
    (void)state;
    defect_list(count_rows, &count);
    assert_in_range(count, 120, 1000);
    defect_list(visit_last, &last);
    assert_string_equal(last, "END-OF-FRAME");
}

#define TEST(title, function) {title, function, NULL, NULL, NULL}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        TEST("CF-001 to CF-013, CF-033 to CF-040, CF-087 to CF-097: registers, working counters, addresses", registers),
        TEST("CF-016 to CF-023, CF-028 to CF-032, CF-048, CF-052, CF-M03: SyncManagers and process data",
             sync_managers),
        TEST("CF-015 counts the datagrams of one frame", a_tenth_datagram_does_not_count),
        TEST("CF-027, CF-057, CF-061 to CF-066: words and categories of the EEPROM, wherever the read begins", eeprom),
        TEST("CF-024 to CF-026, CF-067 to CF-094: mails, by protocol, service, command and entry", mailbox),
        TEST("CF-A01 to CF-S06: mails of AoE and SoE", aoe_and_soe),
        TEST("CF-E01 to CF-E12: mails of EoE", eoe),
        TEST("CF-D02 to CF-D17: entries of a drive's process data, where its SII maps them", drives),
        TEST("CF-D08 to CF-D13: a device without the entries, or with PDOs that are cut, is left alone", no_drive),
        TEST("frames that are no EtherCAT, cut, or too long are left alone", frames),
        TEST("bytes behind the last datagram are left alone", a_datagram_behind_the_last_one_is_no_datagram),
        TEST("an unknown defect is none", without_a_defect_nothing_is_changed),
        TEST("CF-014 clears the circulating flag and keeps the flag of more datagrams",
             the_circulating_flag_is_taken_away),
        TEST("END-OF-FRAME replies with the status of a SyncManager before the frame",
             status_of_the_start_of_the_frame),
        TEST("each listed defect can be chosen", every_defect_of_the_list_can_be_chosen),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("A twin with a defect changes the datagrams of its case, and no others", tests,
                                       NULL, NULL);
}
