/* SPDX-License-Identifier: MIT */
/* Modbus requests cut at every byte (bus/modbus/modbus_request.h; MODBUS Application Protocol V1.1b3 clause 6). */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cmocka.h>

#include "bus/modbus/modbus_request.h"

enum { MOST = 16 };

/* Each request lies at the end of a page without a following page, so a read beyond its end is an error. */
static void requests_cut_at_every_byte(void **state)
{
    static const struct {
        uint8_t bytes[MOST];
        size_t length;
    } rows[] = {
        {{1, 0, 0, 0, 1}, 5},
        {{2, 0, 0, 0, 1}, 5},
        {{3, 0, 0, 0, 1}, 5},
        {{4, 0, 0, 0, 1}, 5},
        {{5, 0, 0, 0xFF, 0}, 5},
        {{6, 0, 0, 0x12, 0x34}, 5},
        {{15, 0, 0, 0, 9, 2, 0xFF, 0x01}, 8},
        {{16, 0, 0, 0, 2, 4, 1, 2, 3, 4}, 10},
        {{23, 0, 0, 0, 1, 0, 0, 0, 1, 2, 0x12, 0x34}, 12},
    };
    const size_t page = (size_t)sysconf(_SC_PAGESIZE);
    uint8_t *pages = mmap(NULL, 2 * page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    (void)state;
    assert_true(pages != MAP_FAILED);
    assert_int_equal(mprotect(pages + page, page, PROT_NONE), 0);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        for (size_t length = 0; length <= rows[i].length + 2; length++) {
            ect_modbus_request_t request;
            uint8_t *pdu = pages + page - length;
            memcpy(pdu, rows[i].bytes, length);
            ect_modbus_result_t wanted = length == 0                ? ECT_MODBUS_NO_FUNCTION
                                         : length == rows[i].length ? ECT_MODBUS_DONE
                                                                    : ECT_MODBUS_BAD_VALUE;
            ect_modbus_result_t result = ect_modbus_request(pdu, length, &request);
            if (result != wanted)
                fail_msg("function %u, %zu bytes: expected %d, got %d", rows[i].bytes[0], length, wanted, result);
        }
    }
    assert_int_equal(munmap(pages, 2 * page), 0);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"A request of each function is accepted only with its own length, and no byte after it is read",
         requests_cut_at_every_byte, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Modbus requests", tests, NULL, NULL);
}
