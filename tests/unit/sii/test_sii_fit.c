/* SPDX-License-Identifier: MIT */
/* A device on another controller: the layout of its SyncManagers, its EEPROM, and devices that do not fit. */
#include <stdlib.h>
#include <string.h>

#include "bus/chain/catalogue.h"
#include "check/check.h"
#include "esc/personality.h"
#include "seams/services.h"
#include "sii/fit.h"
#include "sii/sii.h"
#include "support/confdev.h"
#include "support/wire.h"

/* SyncManagers in process RAM neither overlap nor exceed it. */
static void check_layout(const ect_device_t *on)
{
    uint32_t end = ECT_RAM;
    for (unsigned int n = 0; n < on->sm_count; n++) {
        uint32_t bytes =
            ect_device_sm_bytes(on, n) > on->sm[n].maximum ? ect_device_sm_bytes(on, n) : on->sm[n].maximum;
        if (on->sm[n].type == ECT_SM_UNUSED) {
            assert_int_equal(on->sm[n].start, 0); /* with an address, a master would regard it as process data */
            continue;
        }
        assert_true(on->sm[n].start >= end && on->sm[n].start % 4 == 0);
        end = on->sm[n].start + bytes * (ect_device_sm_is_process(on, n) ? 3 : 1);
    }
    assert_true(end <= ECT_RAM + 4096);
}

static void products(void **state)
{
    const ect_product_t *product;
    (void)state;
    for (size_t i = 0; (product = ect_catalogue_at(i)); i++) {
        ect_device_t on;
        char line[ECT_CHECK_TEXT];
        if (!ect_fit(product->device, &ect_fit_lan9252, &on))
            fail_msg("%s does not fit into a LAN9252", product->device->name);
        check_layout(&on);
        assert_string_equal(on.esc, "lan9252");
        assert_int_equal(on.esc_config[0], 0x80);
        assert_int_equal(on.esc_config[1] & 1, 0); /* the stack sets AL status */
        if ((on.sync.supported & (1u << ECT_SYNC_DC_SYNC0)) != 0)
            assert_int_equal(on.esc_config[3] & 0x08, 0x08); /* SYNC0 is an AL event */
        if (!ect_device_check(&on, line, sizeof line))
            fail_msg("%s on a LAN9252: %s", product->device->name, line);
    }
}

/* The adapted device works: SDO, process data in both directions. */
static void products_to_op(void **state)
{
    const ect_product_t *product;
    (void)state;
    for (size_t i = 0; (product = ect_catalogue_at(i)); i++) {
        static ect_device_t on;
        wire_t w;
        assert_true(ect_fit(product->device, &ect_fit_lan9252, &on));
        wire_open_one(&w, &on);
        wire_go(&w, 0, ECT_STATE_OP);
        assert_int_equal(wire_outputs(&w, 0, 0), 1);
        assert_int_equal(wire_read8(&w, 0, ECT_REG_TYPE), 0xC0);
        assert_int_equal(wire_read8(&w, 0, ECT_REG_PDI_CONTROL), 0x80);
        wire_close(&w);
    }
}

static void too_large(void **state)
{
    ect_device_t on, device = confdev;
    (void)state;
    ect_fit_t chip = ect_fit_lan9252;
    assert_true(ect_fit(&device, &chip, &on));
    uint32_t needed = 0;
    for (uint16_t ram = 4; ram <= 4096; ram = (uint16_t)(ram + 4)) {
        chip.ram_bytes = ram;
        if (ect_fit(&device, &chip, &on)) {
            needed = ram;
            break;
        }
    }
    assert_true(needed > 0 && on.sm[3].start < ECT_RAM + needed);
    chip = ect_fit_lan9252;
    chip.sm_count = (uint8_t)(device.sm_count - 1);
    assert_false(ect_fit(&device, &chip, &on));
    chip = ect_fit_lan9252;
    chip.fmmu_count = (uint8_t)(device.fmmu_count - 1);
    assert_false(ect_fit(&device, &chip, &on));
    device.sm[0].maximum = 1486;
    device.sm[1].maximum = 1486;
    device.sm[2].maximum = 500;
    assert_false(ect_fit(&device, &ect_fit_lan9252, &on));
}

/* The memory of each SyncManager, in whole words: one buffer of a single byte, three buffers of more. SyncManagers
 * over the registers of the digital outputs remain there. */
static void laid_out(void **state)
{
    static const ect_device_t device = {
        .sm_count = 4,
        .sm = {{.start = 0x1800, .maximum = 1, .control = 0x64, .type = ECT_SM_OUTPUTS},
               {.start = 0x0F00, .maximum = 4, .control = 0x44, .type = ECT_SM_OUTPUTS},
               {.start = 0x1000, .maximum = 5, .control = 0x20, .type = ECT_SM_INPUTS},
               {.start = 0x1900, .maximum = 8, .control = 0x20, .type = ECT_SM_INPUTS}},
        .boot_out = {.start = 0x1800},
        .boot_in = {.start = 0x0F80},
    };
    static const uint16_t starts[] = {0x1000, 0x0F00, 0x1004, 0x1014};
    ect_device_t on;
    (void)state;
    assert_true(ect_fit(&device, &ect_fit_lan9252, &on));
    for (unsigned int n = 0; n < device.sm_count; n++) {
        if (on.sm[n].start != starts[n])
            fail_msg("SM%u: expected it at %04Xh, got %04Xh", n, starts[n], on.sm[n].start);
    }
    assert_int_equal(on.boot_out.start, starts[0]); /* the same SyncManager in BOOT */
    assert_int_equal(on.boot_in.start, starts[1]);
}

/* A mailbox gets the longer of its lengths in BOOT and elsewhere; other SyncManagers ignore the lengths of BOOT. */
static void boot_lengths(void **state)
{
    static const struct {
        uint16_t out, boot_out, in, boot_in, starts[4];
    } rows[] = {{64, 0, 128, 0, {0x1000, 0x1040, 0x10C0, 0x10C0}},
                {64, 62, 128, 100, {0x1000, 0x1040, 0x10C0, 0x10C0}},
                {64, 65, 128, 130, {0x1000, 0x1044, 0x10C8, 0x10C8}},
                {64, 200, 64, 0, {0x1000, 0x10C8, 0x1108, 0x1108}},
                {61, 64, 63, 256, {0x1000, 0x1040, 0x1140, 0x1140}}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const ect_device_t device = {
            .sm_count = 4,
            .sm = {{.start = 0x1800, .length = rows[i].out, .control = 0x26, .type = ECT_SM_MAILBOX_OUT},
                   {.start = 0x1900, .length = rows[i].in, .control = 0x22, .type = ECT_SM_MAILBOX_IN},
                   {.start = 0x1A00, .control = 0x64, .type = ECT_SM_OUTPUTS}, /* empty */
                   {.start = 0x1B00, .maximum = 2, .control = 0x20, .type = ECT_SM_INPUTS}},
            .boot_out = {.start = 0x1800, .length = rows[i].boot_out},
            .boot_in = {.start = 0x1900, .length = rows[i].boot_in},
        };
        ect_device_t on;
        assert_true(ect_fit(&device, &ect_fit_lan9252, &on));
        for (unsigned int n = 0; n < device.sm_count; n++) {
            if (on.sm[n].start != rows[i].starts[n])
                fail_msg("row %zu, SM%u: expected it at %04Xh, got %04Xh", i, n, rows[i].starts[n], on.sm[n].start);
        }
    }
}

/* The process RAM may be filled to its last byte, and only the SyncManagers of the device count. */
static void exact_fit(void **state)
{
    static const ect_device_t device = {
        .sm_count = 1,
        .sm = {{.start = 0x1800, .maximum = 8, .control = 0x64, .type = ECT_SM_OUTPUTS},
               {.start = 0x1900, .maximum = 8, .control = 0x20, .type = ECT_SM_INPUTS}},
    };
    ect_fit_t chip = ect_fit_lan9252;
    ect_device_t on;
    (void)state;
    chip.ram_bytes = 24;
    assert_true(ect_fit(&device, &chip, &on));
    assert_int_equal(on.sm[0].start, 0x1000);
    assert_int_equal(on.sm[1].start, 0x1900);
    chip.ram_bytes = 23;
    assert_false(ect_fit(&device, &chip, &on));
}

/* The first words of the EEPROM: those of the controller, with the device's own settings. */
static void first_words(void **state)
{
    static const ect_fit_t chip = {.esc = "chip", .ram_bytes = 64, .pdi_control = 0xA1, .pdi_config = 0xA2};
    static const uint8_t want[14] = {0xA1, 1, 0xA2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13}, content[2] = {0};
    ect_device_t on, device = {.esc = "other", .sii = content};
    (void)state;
    for (uint8_t i = 0; i < sizeof want; i++)
        device.esc_config[i] = i;
    assert_true(ect_fit(&device, &chip, &on));
    assert_memory_equal(on.esc_config, want, sizeof want);
    assert_string_equal(on.esc, "chip");
    assert_null(on.sii); /* the content was for the other controller */
}

static void sync0_event(void **state)
{
    static const struct {
        uint16_t supported;
        uint8_t given, want;
    } rows[] = {{0x00, 0x00, 0x00}, {0x03, 0x00, 0x00}, {0x03, 0x40, 0x40}, {0x04, 0x00, 0x0C}, {0x07, 0x41, 0x4D}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const ect_device_t device = {.sync.supported = rows[i].supported, .esc_config = {0, 0, 0, rows[i].given}};
        ect_device_t on;
        assert_true(ect_fit(&device, &ect_fit_lan9252, &on));
        if (on.esc_config[3] != rows[i].want)
            fail_msg("synchronisation %02Xh, byte 3 %02Xh: expected %02Xh, got %02Xh", rows[i].supported, rows[i].given,
                     rows[i].want, on.esc_config[3]);
    }
}

/* A firmware has no table of chips: its constants must equal those of the table. */
static void figures(void **state)
{
    static const ect_fit_t *const controllers[] = {&ect_fit_lan9252, &ect_fit_et1100};
    (void)state;
    for (size_t i = 0; i < sizeof controllers / sizeof controllers[0]; i++) {
        const ect_esc_personality_t *chip = ect_esc_personality(controllers[i]->esc);
        assert_non_null(chip);
        assert_int_equal(controllers[i]->ram_bytes, 1024 * chip->ram_kb);
        assert_int_equal(controllers[i]->sm_count, chip->sm_count);
        assert_int_equal(controllers[i]->fmmu_count, chip->fmmu_count);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"every product fits into a LAN9252, and is a description without a fault there", products, NULL, NULL, NULL},
        {"every product goes to OP on one", products_to_op, NULL, NULL, NULL},
        {"each SyncManager gets the memory that it needs, and registers keep their addresses", laid_out, NULL, NULL,
         NULL},
        {"CF-089: SYNC0 is an AL event, and the pin SYNC0's, exactly for a device that goes by it", sync0_event, NULL,
         NULL, NULL},
        {"a mailbox gets the longer of its lengths in BOOT and elsewhere", boot_lengths, NULL, NULL, NULL},
        {"the process RAM may be filled to its last byte", exact_fit, NULL, NULL, NULL},
        {"the first words of the EEPROM are those of the controller", first_words, NULL, NULL, NULL},
        {"The figures of a LAN9252 are those of the table of chips", figures, NULL, NULL, NULL},
        {"SyncManagers, FMMUs and process RAM beyond the chip's are refused", too_large, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests_name("sii_fit", tests, NULL, NULL);
}
