/* SPDX-License-Identifier: MIT */
/* PHY management, 0x0510 to 0x0515: the link as the PHYs report it, errors, write enable, busy; and the PDI error
 * counter. */
#include "support/chip.h"

enum { CONTROL = 0x0510, PHY = 0x0512, NUMBER = 0x0513, DATA = 0x0514, BUSY = 0x8000, READ = 0x0100, WRITE = 0x0200 };
enum { READ_ERROR = 0x2000, COMMAND_ERROR = 0x4000, FRAME_NS = 25600 };

/* A command in one datagram with its address. @return 0x0510 afterwards */
static unsigned int command(chip_t *c, unsigned int control, unsigned int phy, unsigned int number)
{
    assert_int_equal(chip_write(c, CONTROL, control | phy << 16 | number << 24, 4), 1);
    chip_advance(c, FRAME_NS);
    return (unsigned int)chip_read(c, CONTROL, 2);
}

static void links(void **state)
{
    static const struct {
        unsigned int phy, number, linked, unlinked;
    } rows[] = {
        {0, 0, 0x3100, 0x3100}, {1, 1, 0x782D, 0x7809}, {1, 2, 0, 0}, {1, 4, 0x01E1, 0x01E1}, {1, 5, 0x41E1, 0}};
    chip_t *c = *state;
    for (unsigned int link = 0; link < 2; link++) {
        ect_esc_set_link(&c->esc, 1, link != 0);
        for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
            bool up = link != 0 || rows[i].phy == 0;
            assert_int_equal(command(c, READ, rows[i].phy, rows[i].number), 0);
            assert_int_equal(chip_read(c, DATA, 2), up ? rows[i].linked : rows[i].unlinked);
        }
    }
}

static void no_phy(void **state)
{
    chip_t *c = *state;
    assert_int_equal(command(c, READ, 0, 1), 0);
    for (unsigned int phy = 2; phy < 32; phy += 29) {
        assert_int_equal(command(c, READ, phy, 1), READ_ERROR);
        assert_int_equal(chip_read(c, DATA, 2), 0x782D);
        assert_int_equal(command(c, 0, 0, 0), 0);
    }
}

static void write_enable(void **state)
{
    chip_t *c = *state;
    assert_int_equal(command(c, WRITE, 0, 0), COMMAND_ERROR);
    assert_int_equal(command(c, READ, 0, 0), 0);
    assert_int_equal(command(c, WRITE | 1, 0, 0), 0);
    assert_int_equal(command(c, 0x0300, 0, 0), COMMAND_ERROR);
    assert_int_equal(chip_write(c, CONTROL, 1, 1), 1); /* valid for its own frame */
    assert_int_equal(command(c, WRITE, 0, 0), COMMAND_ERROR);
    wire_build(&c->w, APWR, 0, CONTROL, "\1", 1);
    wire_append(&c->w, APWR, 0, CONTROL + 1, "\2", 1);
    chip_transmit(c);
    assert_int_equal(chip_read(c, CONTROL, 2), BUSY | WRITE);
    chip_advance(c, FRAME_NS);
    assert_int_equal(command(c, READ, 0, 0), 0);
    assert_int_equal(chip_read(c, DATA, 2), 0x3100); /* a PHY of the model ignores writes */
}

static void busy(void **state)
{
    chip_t *c = *state;
    assert_int_equal(chip_write(c, PHY, 1 | 1 << 8, 2), 1);
    assert_int_equal(chip_read(c, PHY, 2), 0x0101);
    assert_int_equal(chip_write(c, CONTROL + 1, READ >> 8, 1), 1);
    chip_advance(c, FRAME_NS - 1);
    assert_int_equal(chip_read(c, CONTROL, 2), BUSY | READ);
    assert_int_equal(chip_write(c, NUMBER, 0, 1), 0);
    assert_int_equal(chip_read(c, DATA, 2), 0);
    chip_advance(c, 1);
    assert_int_equal(chip_read(c, CONTROL, 2), 0);
    assert_int_equal(chip_read(c, DATA, 2), 0x782D);
    assert_int_equal(chip_write(c, DATA, 0x1234, 2), 1);
    assert_int_equal(chip_read(c, DATA, 2), 0x1234);
    chip_pdi_write(c, DATA, 0, 2);
    assert_int_equal(chip_read(c, DATA, 2), 0x1234);
    assert_int_equal(chip_read(c, 0x0516, 6), 0);
}

static void pdi_errors(void **state)
{
    chip_t *c = *state;
    for (unsigned int n = 1; n <= 300; n++) {
        ect_esc_pdi_error(&c->esc, 5);
        assert_int_equal(chip_read(c, 0x030D, 2), 0x0500 | (n < 255 ? n : 255));
    }
    assert_int_equal(chip_write(c, 0x030C, 0, 1), 1);
    assert_int_equal(chip_read(c, 0x030D, 2), 0x05FF);
    assert_int_equal(chip_write(c, 0x030D, 0, 1), 1);
    assert_int_equal(chip_read(c, 0x030D, 2), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"PHYs report their ports' links", links, chip_setup, chip_teardown, NULL},
        {"a read of an absent PHY ends with bit 13 and leaves the data", no_phy, chip_setup, chip_teardown, NULL},
        {"a write needs the write enable in its frame, else it ends with bit 14", write_enable, chip_setup,
         chip_teardown, NULL},
        {"a command is busy for 25.6 us, in which no write is accepted; the PDI has no access", busy, chip_setup,
         chip_teardown, NULL},
        {"0x030D counts errors of the PDI up to 255, 0x030E has the code; a write clears both", pdi_errors, chip_setup,
         chip_teardown, NULL},
    };
    return cmocka_run_group_tests_name("PHY management", tests, NULL, NULL);
}
