/* SPDX-License-Identifier: MIT */
/* On a Cortex-M: the bytes that firmware/on_ectwin/device.c takes for each device, its buffer excluded. Prints NAME
 * BYTES. */
#include <stddef.h>

#include "cpu.h"
#include "devices/eclink/eclink.h"
#include "devices/fzm1/fzm1.h"
#include "devices/optoncdt2300/optoncdt2300.h"
#include "devices/pmctendo/pmctendo.h"
#include "semihosting.h"
#include "slave/slave.h"

static max_align_t memory[4096];
static size_t used;

static void *take(void *ctx, size_t bytes)
{
    void *taken = &memory[used];
    (void)ctx;
    used += (bytes + sizeof memory[0] - 1) / sizeof memory[0];
    return taken;
}

static void print(const char *name, size_t number)
{
    char digits[12] = {0};
    char *at = &digits[sizeof digits - 1];
    *--at = '\n';
    do
        *--at = (char)('0' + number % 10);
    while ((number /= 10) > 0);
    semihosting_write(name);
    semihosting_write(" ");
    semihosting_write(at);
}

int main(void)
{
    static const ect_device_t *const devices[] = {&ect_eclink_map1,     &ect_eclink_map3, &ect_eclink_map7,
                                                  &ect_eclink_multiarm, &ect_fzm1,        &ect_optoncdt2300,
                                                  &ect_pmctendo_dd5};
    for (size_t n = 0; n < sizeof devices / sizeof devices[0]; n++) {
        ect_slave_config_t config = {.device = devices[n]};
        used = 0;
        (void)ect_slave_take(&config, take, NULL);
        print(devices[n]->name, used * sizeof memory[0]);
    }
    semihosting_end(true);
}
