/* SPDX-License-Identifier: MIT */
/* The state machine's decision over its whole input space (ETG.1000.6 §6.4.1). */
#include "slave/al.h"

#include "slave/slave.h"
#include "support/wire.h"

/* The decision about a request in each state: rows and columns 1 INIT, 2 PREOP, 3 BOOT, 4 SAFEOP, 8 OP. '=' stay, '+'
 * up, '-' down, 'x' refused with 0x0011. Transcribed from spec C.2. */
static const struct {
    uint8_t from;
    const char *to; /* INIT PREOP BOOT SAFEOP OP */
} table[] = {
    {ECT_STATE_INIT, "=++xx"},   {ECT_STATE_PREOP, "-=x+x"}, {ECT_STATE_BOOT, "-x=xx"},
    {ECT_STATE_SAFEOP, "--x=+"}, {ECT_STATE_OP, "--x-="},
};
static const uint8_t columns[] = {ECT_STATE_INIT, ECT_STATE_PREOP, ECT_STATE_BOOT, ECT_STATE_SAFEOP, ECT_STATE_OP};

static char symbol(ect_al_decision_t d)
{
    switch (d.action) {
    case ECT_AL_IGNORE:
        return '.';
    case ECT_AL_STAY:
        return '=';
    case ECT_AL_UP:
        return '+';
    case ECT_AL_DOWN:
        return '-';
    case ECT_AL_REFUSE:
        return d.code == ECT_AL_INVALID_CHANGE  ? 'x'
               : d.code == ECT_AL_UNKNOWN_STATE ? '?'
               : d.code == ECT_AL_NO_BOOT       ? 'b'
                                                : '!';
    }
    return '!';
}

static char expected(uint8_t from, bool error, uint16_t request, bool has_boot)
{
    uint8_t target = request & 0x0F;
    if (error && (request & 0x10) == 0 && target != ECT_STATE_INIT)
        return '.';
    for (size_t row = 0; row < sizeof table / sizeof table[0]; row++) {
        for (size_t column = 0; column < sizeof columns; column++) {
            if (table[row].from != from || columns[column] != target)
                continue;
            bool boot_missing = from == ECT_STATE_INIT && target == ECT_STATE_BOOT && !has_boot;
            return boot_missing ? 'b' : table[row].to[column];
        }
    }
    return '?';
}

static void whole_input_space(void **state)
{
    (void)state;
    unsigned int cases = 0;
    for (size_t row = 0; row < sizeof table / sizeof table[0]; row++) {
        for (unsigned int bits = 0; bits < 4u * 0x10000u; bits++) {
            bool error = (bits & 0x10000) != 0;
            bool has_boot = (bits & 0x20000) != 0;
            uint16_t request = (uint16_t)bits;
            ect_al_decision_t d = ect_al_decide(table[row].from, error, request, has_boot);
            char want = expected(table[row].from, error, request, has_boot);
            bool moves = want == '+' || want == '-';
            uint8_t target = moves ? request & 0x0F : table[row].from;
            if (symbol(d) != want || d.target != target || d.clear_error != (error && want != '.'))
                fail_msg("state %u, error %d, request 0x%04X, boot %d: expected '%c' to %u, got '%c' to %u",
                         table[row].from, error, request, has_boot, want, target, symbol(d), d.target);
            cases++;
        }
    }
    assert_int_equal(cases, 5 * 4 * 0x10000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"CF-033 CF-034 CF-035 CF-038 CF-039 CF-041: every state, error flag and request has the standard's decision",
         whole_input_space, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests_name("AL decision", tests, NULL, NULL);
}
