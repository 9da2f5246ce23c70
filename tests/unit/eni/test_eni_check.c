/* SPDX-License-Identifier: MIT */
/* Contradictions inside a network file: each is one line, and a file without one has none. */
#include "from_text.h"

#include <stdlib.h>

#include "eni/check.h"

enum { LINES = 2000 };

static void collect(void *ctx, const char *line)
{
    char *lines = ctx;
    size_t used = strlen(lines);
    (void)snprintf(lines + used, LINES - used, "%s\n", line);
}

#define BITS(element, bits) "<" element "><BitStart>0</BitStart><BitLength>" #bits "</BitLength></" element ">"
#define SM2(start, size, control)                                                                                      \
    "<Sm2><Type>Outputs</Type><DefaultSize>" #size "</DefaultSize><StartAddress>" #start                               \
    "</StartAddress><ControlByte>" #control "</ControlByte></Sm2>"
#define SM_OF_REGISTER "<Sm1><Type>Inputs</Type><StartAddress>2320</StartAddress><ControlByte>0</ControlByte></Sm1>"
#define RXPDO(bits)                                                                                                    \
    "<RxPdo "                                                                                                          \
    "Sm='2'><Index>#x1600</Index><Name>A</Name><Entry><Index>#x7000</Index><SubIndex>1</SubIndex><BitLen>" #bits       \
    "</BitLen></Entry></RxPdo>"
#define RXPDO_OF(sm, index, bits)                                                                                      \
    "<RxPdo Sm='" sm "'><Index>#x" #index "</Index><Name>A</Name><Entry><Index>#x7000</Index><SubIndex>1</SubIndex>"   \
    "<BitLen>" #bits "</BitLen></Entry></RxPdo>"
#define WRITE(ado, data) "<InitCmd><Cmd>5</Cmd><Adp>1001</Adp><Ado>" #ado "</Ado><Data>" data "</Data></InitCmd>"
#define WRITE_BOOT(ado, data)                                                                                          \
    "<InitCmd><Transition>IB</Transition><Cmd>5</Cmd><Adp>1001</Adp><Ado>" #ado "</Ado><Data>" data "</Data></"        \
    "InitCmd>"
#define BOX(element, start, length) "<" element "><Start>" #start "</Start><Length>" #length "</Length></" element ">"
#define BOXES(recv, commands)                                                                                          \
    ENI_ONE("", "<Mailbox>" BOX("Send", 4096, 128) BOX("Recv", recv, 128) "</Mailbox><InitCmds>" commands "</"         \
                                                                          "InitCmds>")
#define FMMU_12               "00000100020000030011000101000000"
#define FMMU_8                "00000100010000070012000101000000"
#define DATA(parts, commands) ENI_ONE("", "<ProcessData>" parts "</ProcessData><InitCmds>" commands "</InitCmds>")
#define CYCLIC(command, image)                                                                                         \
    ENI_HEAD ENI_SLAVE("", "") "<Cyclic><Frame>\n<Cmd>" command "</Cmd></Frame></Cyclic><ProcessImage>\n" image        \
                               "</ProcessImage>" ENI_TAIL

#define COPY(source, target, bits)                                                                                     \
    "<CopyInfos><CopyInfo><SrcBitOffs>" source "</SrcBitOffs><DstBitOffs>" target "</DstBitOffs><BitSize>" bits        \
    "</BitSize></CopyInfo></CopyInfos>"

#define FOE(size, body)                                                                                                \
    ENI_ONE("", "<Mailbox>" BOX("Send", 4096, size) BOX("Recv", 4224, 128) "<FoE><InitCmds><InitCmd>" body             \
                                                                           "</InitCmd></InitCmds></FoE></Mailbox>")
#define NAME_70 "1234567890123456789012345678901234567890123456789012345678901234567890"

static const struct {
    const char *title, *text, *lines;
} rows[] = {
    {"nothing but a slave", ENI_ONE("", ""), ""},
    {"ENI-008 another place", ENI_ONE("<AutoIncAddr>65535</AutoIncAddr>", ""),
     "t.xml:2: slave 1: AutoIncAddr is 65535; its place in the file requires 0\n"},
    {"ENI-010 an unknown neighbour",
     ENI_HEAD ENI_SLAVE("", "") "\n" ENI_SLAVE("", "<PreviousPort><Port>B</Port><PhysAddr>9</PhysAddr></PreviousPort>")
         ENI_TAIL,
     "t.xml:2: PreviousPort has the PhysAddr 9, which no previous slave has\n"},
    {"ENI-013 a SyncManager that agrees", DATA(SM2(4352, 6, 100), WRITE(2064, "0011060064000100")), ""},
    {"ENI-013 another start", DATA(SM2(4608, 6, 100), WRITE(2064, "0011060064000100")),
     "t.xml:2: slave 1: SyncManager 2 is written with start 0x1100; Sm2 has 0x1200\n"},
    {"ENI-013 another length", DATA(SM2(4352, 7, 100), WRITE(2064, "0011060064000100")),
     "t.xml:2: slave 1: SyncManager 2 is written with 6 bytes; Sm2 has 7\n"},
    {"ENI-013 another control byte", DATA(SM2(4352, 6, 36), WRITE(2064, "0011060064000100")),
     "t.xml:2: slave 1: SyncManager 2 is written with control 0x64; Sm2 has 0x24\n"},
    {"ENI-013 one that is disabled is not compared", DATA(SM2(4352, 7, 100), WRITE(2064, "0011060064000000")), ""},
    {"ENI-013 the first SyncManager is compared too",
     DATA("<Sm0><Type>Outputs</Type><StartAddress>4608</StartAddress><ControlByte>100</ControlByte></Sm0>",
          WRITE(2048, "0011060064000100")),
     "t.xml:2: slave 1: SyncManager 0 is written with start 0x1100; Sm0 has 0x1200\n"},
    {"ENI-013 the last write counts",
     DATA(SM2(4352, 6, 100), WRITE(2064, "0011070064000100") WRITE(2064, "0011060064000100")), ""},
    {"ENI-013 a mailbox at another place", BOXES(4224, WRITE(2048, "00108000260001008010400022000100")),
     "t.xml:2: slave 1: SyncManager 1 is written with 64 bytes at 0x1080; the mailbox has 128 at 0x1080\n"},
    {"ENI-013 the mailbox of BOOT is another one", BOXES(4224, WRITE_BOOT(2048, "00120001260001000013000122000100")),
     ""},
    {"ENI-012 mailboxes that overlap",
     ENI_ONE("", "<Mailbox>" BOX("Send", 4096, 128) BOX("Recv", 4223, 128) "</Mailbox>"),
     "t.xml:2: slave 1: its mailboxes overlap\n"},
    {"ENI-012 mailboxes side by side",
     ENI_ONE("", "<Mailbox>" BOX("Send", 4096, 128) BOX("Recv", 4224, 128) "</Mailbox>"), ""},
    {"ENI-012 a mailbox in the registers",
     ENI_ONE("", "<Mailbox>" BOX("Send", 4096, 128) BOX("Recv", 2048, 128) "</Mailbox>"),
     "t.xml:2: slave 1: a mailbox begins below 0x1000, where there are registers\n"},
    {"ENI-012 mailboxes side by side in the other order",
     ENI_ONE("", "<Mailbox>" BOX("Send", 4224, 128) BOX("Recv", 4096, 128) "</Mailbox>"), ""},
    {"ENI-012 mailboxes that overlap in the other order",
     ENI_ONE("", "<Mailbox>" BOX("Send", 4223, 128) BOX("Recv", 4096, 128) "</Mailbox>"),
     "t.xml:2: slave 1: its mailboxes overlap\n"},
    {"ENI-012 the first mailbox one byte below the memory",
     ENI_ONE("", "<Mailbox>" BOX("Send", 4095, 128) BOX("Recv", 4224, 128) "</Mailbox>"),
     "t.xml:2: slave 1: a mailbox begins below 0x1000, where there are registers\n"},
    {"ENI-012 the second mailbox one byte below the memory",
     ENI_ONE("", "<Mailbox>" BOX("Send", 4224, 128) BOX("Recv", 4095, 128) "</Mailbox>"),
     "t.xml:2: slave 1: a mailbox begins below 0x1000, where there are registers\n"},
    {"ENI-025 a request of FoE that fills the mailbox", FOE(20, "<FileName>12345678</FileName>"), ""},
    {"ENI-025 a request of FoE one byte too long", FOE(19, "<FileName>12345678</FileName>"),
     "t.xml:2: slave 1: the FoE request of the file '12345678' has 20 bytes, the mailbox 19\n"},
    {"ENI-025 a request of FoE with a long name", FOE(80, "<FileName>" NAME_70 "</FileName>"),
     "t.xml:2: slave 1: the FoE request of the file '123456789012345678901234567890123456789012345678901234567890' has "
     "82 "
     "bytes, the mailbox 80\n"},
    {"ENI-025 FoE reads a file, and has data", FOE(128, "<OpCode>1</OpCode><FileName>a</FileName><Data>00</Data>"),
     "t.xml:2: slave 1: the FoE command reads the file 'a', and has Data\n"},
    {"ENI-025 FoE writes a file", FOE(128, "<OpCode>2</OpCode><FileName>a</FileName><Data>00</Data>"), ""},
    {"ENI-025 FoE writes an empty file", FOE(128, "<OpCode>2</OpCode><FileName>a</FileName>"), ""},
    {"ENI-025 a mail of another protocol that is longer than the mailbox",
     ENI_ONE("", "<Mailbox>" BOX("Send", 4096, 8)
                     BOX("Recv", 4224, 128) "<EoE><InitCmd><Type>2</Type><Data>"
                                            "00112233445566778899</Data></InitCmd></EoE></Mailbox>"),
     ""},
    {"ENI-016 cyclic frames without commands, and no frames",
     ENI_HEAD ENI_SLAVE("", "") "<Cyclic/><Cyclic><Frame/></Cyclic><ProcessImage/>" ENI_TAIL, ""},
    {"ENI-014 bits that agree", DATA(BITS("Send", 12) RXPDO(12), ""), ""},
    {"ENI-014 bits that are rounded to bytes", DATA(BITS("Send", 16) RXPDO(12), ""), ""},
    {"ENI-014 other bits", DATA(BITS("Send", 13) RXPDO(12), ""),
     "t.xml:2: slave 1: Send has 13 bits, its assigned PDOs 12\n"},
    {"ENI-014 a PDO that its SyncManager does not list",
     DATA(BITS("Send", 8) "<Sm2><Pdo>#x1601</Pdo></Sm2>" RXPDO(12), ""), ""},
    {"ENI-014 no bits of PDOs that are assigned", DATA(RXPDO(8), ""),
     "t.xml:2: slave 1: Send has 0 bits, its assigned PDOs 8\n"},
    {"ENI-014 a PDO of the first SyncManager", DATA(BITS("Send", 13) RXPDO_OF("0", 1600, 12), ""),
     "t.xml:2: slave 1: Send has 13 bits, its assigned PDOs 12\n"},
    {"ENI-014 a PDO of the last SyncManager", DATA(BITS("Send", 13) RXPDO_OF("15", 1600, 12), ""),
     "t.xml:2: slave 1: Send has 13 bits, its assigned PDOs 12\n"},
    {"ENI-014 a PDO that the last SyncManager lists",
     DATA(BITS("Send", 13) "<Sm15><Pdo>#x1600</Pdo></Sm15>" RXPDO_OF("0", 1600, 12), ""),
     "t.xml:2: slave 1: Send has 13 bits, its assigned PDOs 24\n"},
    {"ENI-014 PDOs of two SyncManagers", DATA(BITS("Send", 24) RXPDO_OF("0", 1600, 12) RXPDO_OF("2", 1601, 12), ""),
     ""},
    {"ENI-014 PDOs of two SyncManagers, each rounded to bytes",
     DATA(BITS("Send", 32) RXPDO_OF("0", 1600, 12) RXPDO_OF("2", 1601, 12), ""), ""},
    {"ENI-014 two PDOs of one SyncManager are rounded together",
     DATA(BITS("Send", 32) RXPDO_OF("2", 1600, 12) RXPDO_OF("2", 1601, 12), ""),
     "t.xml:2: slave 1: Send has 32 bits, its assigned PDOs 24\n"},
    {"ENI-014 bits of outputs are those of RxPDOs", DATA(BITS("Recv", 12) RXPDO(12), ""),
     "t.xml:2: slave 1: Send has 0 bits, its assigned PDOs 12\n"},
    {"ENI-014 bits in two parts", DATA(BITS("Send", 5) BITS("Send", 7) RXPDO(12), ""), ""},
    {"ENI-013 a mailbox for requests at another place", BOXES(4352, WRITE(2048, "80108000260001000011800022000100")),
     "t.xml:2: slave 1: SyncManager 0 is written with 128 bytes at 0x1080; the mailbox has 128 at 0x1000\n"},
    {"ENI-013 a mailbox that is written disabled", BOXES(4352, WRITE(2048, "80108000260000000011800022000100")), ""},
    {"ENI-013 an FMMU of the first byte of the memory",
     DATA(BITS("Recv", 13), WRITE(1536, "00000100020000030010000101000000")),
     "t.xml:2: slave 1: Recv has 13 bits, its FMMUs 12\n"},
    {"ENI-013 an FMMU of the byte below the memory",
     DATA(BITS("Recv", 13), WRITE(1536, "0000010002000003ff0f000101000000")), ""},
    {"ENI-013 an FMMU that agrees", DATA(BITS("Recv", 12), WRITE(1536, "00000100020000030011000101000000")), ""},
    {"ENI-013 an FMMU of other bits", DATA(BITS("Recv", 12), WRITE(1536, "00000100010000030011000101000000")),
     "t.xml:2: slave 1: Recv has 12 bits, its FMMUs 4\n"},
    {"ENI-013 FMMUs in a row, exactly", DATA(BITS("Recv", 20), WRITE(1536, FMMU_12 FMMU_8)), ""},
    {"ENI-013 successive FMMUs, each rounded to bytes", DATA(BITS("Recv", 24), WRITE(1536, FMMU_12 FMMU_8)), ""},
    {"ENI-013 successive FMMUs of other bits", DATA(BITS("Recv", 21), WRITE(1536, FMMU_12 FMMU_8)),
     "t.xml:2: slave 1: Recv has 21 bits, its FMMUs 20\n"},
    {"ENI-013 the last FMMU", DATA(BITS("Recv", 9), WRITE(1776, FMMU_8)),
     "t.xml:2: slave 1: Recv has 9 bits, its FMMUs 8\n"},
    {"ENI-013 beyond the last FMMU", DATA(BITS("Recv", 9), WRITE(1792, FMMU_8)), ""},
    {"ENI-013 an FMMU that is disabled", DATA(BITS("Recv", 9), WRITE(1536, "00000100010000070012000100000000")), ""},
    {"ENI-013 an FMMU that begins within a byte",
     DATA(BITS("Recv", 9), WRITE(1536, "00000100010003070012000101000000")),
     "t.xml:2: slave 1: Recv has 9 bits, its FMMUs 5\n"},
    {"ENI-013 an FMMU of outputs", DATA(BITS("Send", 9), WRITE(1536, "00000100010000070012000201000000")),
     "t.xml:2: slave 1: Send has 9 bits, its FMMUs 8\n"},
    {"ENI-013 an FMMU that ends before it begins",
     DATA(BITS("Recv", 12), WRITE(1536, "00000100010007000011000101000000")),
     "t.xml:2: slave 1: Recv has 12 bits, its FMMUs 0\n"},
    {"ENI-020 an FMMU of a register is not an FMMU of process data",
     DATA(BITS("Recv", 12), WRITE(1536, "0000010002000003001100010100000000000000010000000d08000101000000")), ""},
    {"ENI-013 an FMMU of the register of a SyncManager",
     DATA(BITS("Recv", 29) SM_OF_REGISTER,
          WRITE(1536, FMMU_12 "0000010002000007100900010100000000000000010000072009000101000000")),
     "t.xml:2: slave 1: Recv has 29 bits, its FMMUs 28\n"},
    {"ENI-013 an FMMU of the register of a SyncManager that agrees",
     DATA(BITS("Recv", 16) SM_OF_REGISTER, WRITE(1536, "00000100020000071009000101000000")), ""},
    {"ENI-017 a command inside the image",
     CYCLIC("<Cmd>11</Cmd><Addr>0</Addr><DataLength>4</DataLength><OutputOffs>4</OutputOffs>",
            "<Outputs><ByteSize>8</ByteSize></Outputs>"),
     ""},
    {"ENI-017 a command beyond the outputs",
     CYCLIC("<Cmd>11</Cmd><Addr>0</Addr><DataLength>4</DataLength><OutputOffs>5</OutputOffs>",
            "<Outputs><ByteSize>8</ByteSize></Outputs>"),
     "t.xml:2: the command reaches byte 9 of the outputs, which have 8\n"},
    {"ENI-017 a command beyond the inputs",
     CYCLIC("<Cmd>12</Cmd><Addr>0</Addr><DataLength>4</DataLength><InputOffs>4294967295</InputOffs>",
            "<Inputs><ByteSize>8</ByteSize></Inputs>"),
     "t.xml:2: the command reaches byte 4294967299 of the inputs, which have 8\n"},
    {"ENI-019 copies inside the images",
     CYCLIC("<Cmd>10</Cmd><Addr>0</Addr><DataLength>1</DataLength>" COPY("8", "0", "8"),
            "<Inputs><ByteSize>2</ByteSize></Inputs><Outputs><ByteSize>1</ByteSize></Outputs>"),
     ""},
    {"ENI-019 a copy beyond the inputs",
     CYCLIC("<Cmd>10</Cmd><Addr>0</Addr><DataLength>1</DataLength>" COPY("9", "0", "8"),
            "<Inputs><ByteSize>2</ByteSize></Inputs><Outputs><ByteSize>1</ByteSize></Outputs>"),
     "t.xml:2: the CopyInfo reaches bit 17 of the inputs, which have 2 bytes\n"},
    {"ENI-019 a copy beyond the outputs, of the highest offset",
     CYCLIC("<Cmd>10</Cmd><Addr>0</Addr><DataLength>1</DataLength>" COPY("0", "4294967295", "8"),
            "<Inputs><ByteSize>2</ByteSize></Inputs><Outputs><ByteSize>1</ByteSize></Outputs>"),
     "t.xml:2: the CopyInfo reaches bit 4294967303 of the outputs, which have 1 bytes\n"},
    {"ENI-019 a copy of no bits",
     CYCLIC("<Cmd>10</Cmd><Addr>0</Addr><DataLength>1</DataLength>" COPY("0", "0", "0"), ""),
     "t.xml:2: the CopyInfo copies no bits: BitSize is missing\n"},
    {"ENI-017 variables side by side, in any order",
     CYCLIC("<Cmd>0</Cmd>",
            "<Inputs><ByteSize>2</ByteSize><Variable><BitSize>8</BitSize><BitOffs>8</BitOffs></Variable>"
            "<Variable><BitSize>8</BitSize><BitOffs>0</BitOffs></Variable></Inputs>"),
     ""},
    {"ENI-017 variables that overlap",
     CYCLIC("<Cmd>0</Cmd>",
            "<Inputs><ByteSize>2</ByteSize><Variable><Name>a</Name><BitSize>9</BitSize><BitOffs>0</BitOffs></Variable>"
            "<Variable><Name>b</Name><BitSize>8</BitSize><BitOffs>8</BitOffs></Variable></Inputs>"),
     "t.xml:3: Variable b begins at bit 8, inside another one\n"},
    {"ENI-017 a variable beyond the image",
     CYCLIC("<Cmd>0</Cmd>",
            "<Outputs><ByteSize>1</ByteSize><Variable><Name>a</Name><BitSize>8</BitSize><BitOffs>1</BitOffs></Variable>"
            "</Outputs>"),
     "t.xml:3: Variable a reaches bit 9 of an image of 1 bytes\n"},
};

static void each_contradiction_is_a_line(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char lines[LINES] = "";
        size_t expected = 0;
        ect_eni_t *eni = eni_of(rows[i].title, rows[i].text);
        size_t count = ect_eni_check(eni, collect, lines);
        for (const char *c = rows[i].lines; *c != '\0'; c++)
            expected += *c == '\n';
        if (strcmp(lines, rows[i].lines) != 0 || count != expected)
            fail_msg("%s: expected \"%s\", got %zu, \"%s\"", rows[i].title, rows[i].lines, count, lines);
        ect_eni_close(eni);
    }
}

static void a_file_that_brings_its_bus_to_OP_has_no_contradiction(void **state)
{
    char lines[LINES] = "", why[400] = "";
    (void)state;
    ect_eni_t *eni = ect_eni_open(ENI_FILES "/machine.xml", why, sizeof why);
    assert_non_null(eni);
    assert_int_equal(ect_eni_check(eni, collect, lines), 0);
    assert_string_equal(lines, "");
    ect_eni_close(eni);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_contradiction_is_a_line),
        cmocka_unit_test(a_file_that_brings_its_bus_to_OP_has_no_contradiction),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
