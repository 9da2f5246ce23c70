/* SPDX-License-Identifier: MIT */
/* ENI files as tests write them. */
#ifndef TESTS_UNIT_ENI_FROM_TEXT_H
#define TESTS_UNIT_ENI_FROM_TEXT_H

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "eni/read.h"

#define ENI_HEAD "<EtherCATConfig><Config><Master/>"
#define ENI_TAIL "</Config></EtherCATConfig>"
#define ENI_INFO(more)                                                                                                 \
    "<Info><VendorId>#xE57</VendorId><ProductCode>1</ProductCode><RevisionNo>2</RevisionNo>" more "</Info>"
#define ENI_SLAVE(info, body) "<Slave>" ENI_INFO(info) body "</Slave>"
/* One slave, on line 2. */
#define ENI_ONE(info, body) ENI_HEAD "\n" ENI_SLAVE(info, body) ENI_TAIL
#define ENI_COMMAND(body)   ENI_ONE("", "<InitCmds><InitCmd>" body "</InitCmd></InitCmds>")
#define ENI_COE(body)       ENI_ONE("", "<Mailbox><CoE><InitCmds><InitCmd>" body "</InitCmd></InitCmds></CoE></Mailbox>")

static inline ect_eni_t *eni_of(const char *what, const char *text)
{
    char why[400] = "";
    ect_eni_t *eni = ect_eni_parse("t.xml", text, strlen(text), why, sizeof why);
    if (eni == NULL)
        fail_msg("%s: expected a network, got: %s", what, why);
    return eni;
}

static inline const ect_eni_slave_t *slave_of(const ect_eni_t *eni, size_t i)
{
    return &ect_eni_network(eni)->slaves[i];
}

#endif
