/* SPDX-License-Identifier: MIT */
/* Options of twins, by `ectwin check`: the twins, settings, connections and faults that they lead to. */
#define _GNU_SOURCE
#include "command_lines.h"

#include <inttypes.h>

#include "bus/chain/chain.h"
#include "bus/chain/settings.h"
#include "bus/faults/scenario.h"
#include "bus/faults/table.h"
#include "support/gauge.h"

/* --- functions of the chain, which print their arguments where these differ from the default ---------------------- */

ect_chain_t *__real_ect_chain_new(const ect_twin_config_t *twins, size_t count, uint64_t now_ns);
ect_chain_t *__wrap_ect_chain_new(const ect_twin_config_t *twins, size_t count, uint64_t now_ns);
bool __real_ect_chain_connect(ect_chain_t *chain, const ect_connection_t *list, size_t count);
bool __wrap_ect_chain_connect(ect_chain_t *chain, const ect_connection_t *list, size_t count);
void __real_ect_chain_power_cycle(ect_chain_t *chain, uint64_t now_ns);
void __wrap_ect_chain_power_cycle(ect_chain_t *chain, uint64_t now_ns);
bool __real_ect_settings_apply(ect_chain_t *chain, size_t position, const ect_setting_t *settings, size_t count,
                               uint64_t now_ns, char *message);
bool __wrap_ect_settings_apply(ect_chain_t *chain, size_t position, const ect_setting_t *settings, size_t count,
                               uint64_t now_ns, char *message);
const ect_scenario_step_t *__real_ect_scenario_check(const ect_scenario_t *s, const ect_chain_t *chain, char *message);
const ect_scenario_step_t *__wrap_ect_scenario_check(const ect_scenario_t *s, const ect_chain_t *chain, char *message);

static void print_number(const char *name, uint64_t value, uint64_t expected)
{
    if (value != expected)
        fprintf(stderr, " %s=%" PRIu64, name, value);
}

static void print_range(const char *name, const ect_slow_range_t *range)
{
    if (range->min_ns != 0 || range->max_ns != 0)
        fprintf(stderr, " %s=%" PRIu64 "..%" PRIu64, name, range->min_ns, range->max_ns);
}

ect_chain_t *__wrap_ect_chain_new(const ect_twin_config_t *twins, size_t count, uint64_t now_ns)
{
    for (size_t i = 0; i < count; i++) {
        const ect_twin_config_t *t = &twins[i];
        fprintf(stderr, "%zu %s", i + 1, t->device->name);
        print_number("vendor", t->identity.vendor_id, t->device->identity.vendor_id);
        print_number("product", t->identity.product_code, t->device->identity.product_code);
        print_number("revision", t->identity.revision, t->device->identity.revision);
        print_number("serial", t->identity.serial, i + 1);
        print_number("alias", t->alias, 0);
        print_number("up", t->up + 1, t->up_port != 0 ? SIZE_MAX : 1);
        print_number("port", t->up_port, 0);
        print_number("cable", t->cable_m, 1);
        if (t->drift_ppb != 0)
            fprintf(stderr, " drift=%d", (int)t->drift_ppb);
        print_number("eeprom", t->eeprom_ns, 20000);
        print_range("al", &t->slow.al);
        print_range("mailbox", &t->slow.mailbox);
        print_range("jitter", &t->slow.jitter);
        print_number("receive", t->slow.receive_ns, 0);
        if (t->slow.board)
            fprintf(stderr, " board=%s", t->slow.board->name);
        print_number("cycle", t->slow.cycle_ns, 0);
        print_number("seed", t->slow.seed, i + 1);
        if (t->esc)
            fprintf(stderr, " esc=%s", t->esc);
        print_number("keeps", t->keep_source_mac, false);
        fputc('\n', stderr);
    }
    return __real_ect_chain_new(twins, count, now_ns);
}

bool __wrap_ect_chain_connect(ect_chain_t *chain, const ect_connection_t *list, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const ect_connection_t *c = &list[i];
        fprintf(stderr, "%zu.%s = %zu.%s x %g + %g%s, delay %" PRIu64 "\n", c->to + 1, c->target.name, c->from + 1,
                c->source.name, c->factor, c->offset, c->invert ? ", inverted" : "", c->delay_ns);
    }
    return __real_ect_chain_connect(chain, list, count);
}

void __wrap_ect_chain_power_cycle(ect_chain_t *chain, uint64_t now_ns)
{
    fputs("power cycle\n", stderr);
    __real_ect_chain_power_cycle(chain, now_ns);
}

bool __wrap_ect_settings_apply(ect_chain_t *chain, size_t position, const ect_setting_t *settings, size_t count,
                               uint64_t now_ns, char *message)
{
    for (size_t i = 0; i < count; i++)
        fprintf(stderr, "%zu: %s := %s\n", position + 1, settings[i].name, settings[i].value);
    return __real_ect_settings_apply(chain, position, settings, count, now_ns, message);
}

static void print_table(const ect_table_t *table)
{
    fprintf(stderr, "table of %u, period %" PRIu64 ":", table->slave, table->period_ns);
    for (size_t i = 0; i < table->columns; i++)
        fprintf(stderr, " %s", table->names[i]);
    for (size_t row = 0; row < table->count; row++) {
        fprintf(stderr, "; %" PRIu64, table->rows[row]->due_ns);
        for (size_t i = 0; i < table->columns; i++)
            fprintf(stderr, " %s", table->rows[row]->values[i] ? table->rows[row]->values[i] : "-");
    }
    fputc('\n', stderr);
}

const ect_scenario_step_t *__wrap_ect_scenario_check(const ect_scenario_t *s, const ect_chain_t *chain, char *message)
{
    if (s->seed != 1)
        fprintf(stderr, "seed %u\n", (unsigned int)s->seed);
    for (size_t i = 0; i < s->step_count; i++)
        fprintf(stderr, "step, line %u: %s\n", s->steps[i].line, s->steps[i].text);
    for (const ect_table_t *table = s->tables; table; table = table->next)
        print_table(table);
    return __real_ect_scenario_check(s, chain, message);
}

/* --- runs --------------------------------------------------------------------------------------------------------- */

typedef struct row {
    const char *line;
    int status; /* 0: `text` is what the chain gets, and the line of the command follows */
    const char *text, *table;
} row_t;

static void expect(const row_t *rows, size_t count)
{
    static const ect_product_t products[] = {{&gauge, NULL}};
    for (size_t i = 0; i < count; i++) {
        char line[COMMAND_TEXT], text[COMMAND_TEXT];
        const char *devices = strrchr(rows[i].line, ' ') ? strrchr(rows[i].line, ' ') + 1 : rows[i].line;
        size_t most = 1;
        for (const char *at = rows[i].text; (at = strchr(at, '\n')) != NULL; at++) {
            const size_t number = (size_t)strtoul(at + 1, NULL, 10);
            most = number == most + 1 ? number : most;
        }
        snprintf(line, sizeof line, "check %s", rows[i].line);
        if (rows[i].status == 0)
            snprintf(text, sizeof text, "%s%zu twin%s: %s\n", rows[i].text, most, most == 1 ? "" : "s", devices);
        else
            snprintf(text, sizeof text, "%s", rows[i].text);
        command_expect(&(command_line_t){.line = line, .status = rows[i].status, .text = text, .table = rows[i].table},
                       products, 1);
    }
}

#define EXPECT(rows) expect(rows, sizeof(rows) / sizeof(rows)[0])
#define ONE          "1 fzm1\n"
#define TWO          "1 fzm1\n2 fzm1\n"
#define THREE        "1 fzm1\n2 fzm1\n3 fzm1\n"
#define CHECK        "ectwin check: "

static void identities(void **state)
{
    static const row_t rows[] = {
        {"fzm1", 0, ONE, NULL},
        {"fzm1,gauge", 0, "1 fzm1\n2 gauge\n", NULL},
        {"--vendor-id 4294967295 fzm1*2", 0, "1 fzm1 vendor=4294967295\n2 fzm1 vendor=4294967295\n", NULL},
        {"--vendor-id 2:0 fzm1*2", 0, "1 fzm1\n2 fzm1 vendor=0\n", NULL},
        {"--product-code 7 fzm1*2", 0, "1 fzm1 product=7\n2 fzm1 product=7\n", NULL},
        {"--revision 0x10 fzm1*2", 0, "1 fzm1 revision=16\n2 fzm1 revision=16\n", NULL},
        {"--revision 1:5 fzm1*2", 0, "1 fzm1 revision=5\n2 fzm1\n", NULL},
        {"--serial 10 fzm1*3", 0, "1 fzm1 serial=10\n2 fzm1 serial=11\n3 fzm1 serial=12\n", NULL},
        {"--serial 10 --serial 2:5 fzm1*2", 0, "1 fzm1 serial=10\n2 fzm1 serial=5\n", NULL},
        {"--serial 2:5 --serial 10 fzm1*2", 0, "1 fzm1 serial=10\n2 fzm1 serial=11\n", NULL},
        {"--serial 4294967294 fzm1*2", 0, "1 fzm1 serial=4294967294\n2 fzm1 serial=4294967295\n", NULL},
        {"--serial 4294967294 fzm1*3", 1, CHECK "--serial 4294967294 is too high for 3 twins: it counts up\n", NULL},
        {"--serial 2:4294967295 fzm1*2", 0, "1 fzm1\n2 fzm1 serial=4294967295\n", NULL},
        {"--alias 65534 fzm1*2", 0, "1 fzm1 alias=65534\n2 fzm1 alias=65535\n", NULL},
        {"--alias 65535 fzm1*2", 1, CHECK "--alias 65535 is too high for 2 twins: it counts up\n", NULL},
        {"--alias 1:65535 fzm1*2", 0, "1 fzm1 alias=65535\n2 fzm1\n", NULL},
        {"--alias b:9 a=fzm1,b=fzm1", 0, "1 fzm1\n2 fzm1 alias=9\n", NULL},
        {"--alias c2:9 c=fzm1*2", 0, "1 fzm1\n2 fzm1 alias=9\n", NULL},
        {"--alias 0 fzm1", 1, CHECK "--alias takes a number from 1 to 65535, not '0'\n", NULL},
        {"--alias 65536 fzm1", 1, CHECK "--alias takes a number from 1 to 65535, not '65536'\n", NULL},
        {"--alias 3:1 fzm1*2", 1, CHECK "--alias 3:…: the chain has 2 twins\n", NULL},
        {"--alias 2:1 fzm1", 1, CHECK "--alias 2:…: the chain has 1 twin\n", NULL},
        {"--revision c:1 fzm1", 1, CHECK "N in N:VALUE takes a number from 1 to 65535, not 'c'\n", NULL},
        {"--revision 65536:1 fzm1", 1, CHECK "N in N:VALUE takes a number from 1 to 65535, not '65536'\n", NULL},
        {"--keep-source-mac fzm1*2", 0, "1 fzm1 keeps=1\n2 fzm1 keeps=1\n", NULL},
    };
    (void)state;
    EXPECT(rows);
}

static void names(void **state)
{
#define NAME_31 "abcdefghijklmnopqrstuvwxyz01234"
    static const row_t rows[] = {
        {"fzm1*2,gauge*1", 0, TWO "3 gauge\n", NULL},
        {"--alias " NAME_31 ":7 " NAME_31 "=fzm1", 0, "1 fzm1 alias=7\n", NULL},
        {NAME_31 "x=fzm1", 1,
         CHECK "'" NAME_31 "x=fzm1': a name is a letter a to z, then letters, digits, _ and -, at most 31 characters, "
               "as in gripper=fzm1\n",
         NULL},
        {NAME_31 "=fzm1*2", 1, CHECK "the name '" NAME_31 "1' is longer than 31 characters\n", NULL},
        {"abcdefghijklmnopqrstuvwxyz0123=fzm1*9", 0,
         "1 fzm1\n2 fzm1\n3 fzm1\n4 fzm1\n5 fzm1\n6 fzm1\n7 fzm1\n8 fzm1\n9 fzm1\n", NULL},
        {"abcdefghijklmnopqrstuvwxyz0123=fzm1*10", 1,
         CHECK "the name 'abcdefghijklmnopqrstuvwxyz012310' is longer than 31 characters\n", NULL},
        {"=fzm1", 1,
         CHECK "'=fzm1': a name is a letter a to z, then letters, digits, _ and -, at most 31 characters, as in "
               "gripper=fzm1\n",
         NULL},
        {"a=fzm1,a=fzm1", 1, CHECK "two twins have the name 'a'\n", NULL},
        {"a2=fzm1,a=fzm1*2", 1, CHECK "two twins have the name 'a2'\n", NULL},
        {"fzm1*x", 1, CHECK "'fzm1*...': a count is 1 to 65535 twins in all, as in fzm1*3\n", NULL},
        {"fzm1*", 1, CHECK "'fzm1*...': a count is 1 to 65535 twins in all, as in fzm1*3\n", NULL},
        {"fzm1*65535,gauge", 1, CHECK "'gauge*...': a count is 1 to 65535 twins in all, as in fzm1*3\n", NULL},
    };
    (void)state;
    EXPECT(rows);
}

static void chips_and_times(void **state)
{
    static const row_t rows[] = {
        {"--esc et1100 fzm1*2", 0, "1 fzm1 esc=et1100\n2 fzm1 esc=et1100\n", NULL},
        {"--esc 2:lan9252 --esc 1:np40 fzm1*2", 0, "1 fzm1 esc=np40\n2 fzm1 esc=lan9252\n", NULL},
        {"--esc b:lan9252 a=fzm1,b=fzm1", 0, "1 fzm1\n2 fzm1 esc=lan9252\n", NULL},
        {"--esc 3:np40 fzm1*2", 1, CHECK "3:np40: twins are counted from 1 to 2\n", NULL},
        {"--esc 0:np40 fzm1*2", 1, CHECK "0:np40: twins are counted from 1\n", NULL},
        {"--drift 2:5 fzm1*2", 0, "1 fzm1\n2 fzm1 drift=5000\n", NULL},
        {"--drift 1:-1000 fzm1", 0, "1 fzm1 drift=-1000000\n", NULL},
        {"--drift 1:1000 fzm1", 0, "1 fzm1 drift=1000000\n", NULL},
        {"--drift 1:0.5 fzm1", 0, "1 fzm1 drift=500\n", NULL},
        {"--drift 0 fzm1", 0, "1 fzm1 seed=270369\n", NULL},
        {"--drift 5 fzm1*2", 0, "1 fzm1 drift=-4658 seed=67634689\n2 fzm1 drift=2927 seed=67634690\n", NULL},
        {"--drift 1:1000.5 fzm1", 1, CHECK "--drift takes a number up to 1000, not '1000.5'\n", NULL},
        {"--drift 1:nan fzm1", 1, CHECK "--drift takes a number up to 1000, not 'nan'\n", NULL},
        {"--cable 0 fzm1*2", 0, "1 fzm1 cable=0\n2 fzm1 cable=0\n", NULL},
        {"--cable 2:1000 fzm1*2", 0, "1 fzm1\n2 fzm1 cable=1000\n", NULL},
        {"--cable 1001 fzm1", 1, CHECK "--cable takes a number up to 1000, not '1001'\n", NULL},
        {"--cable 0.5 fzm1", 1, CHECK "--cable takes whole metres from 0 to 1000, not '0.5'\n", NULL},
        {"--cable -1 fzm1", 1, CHECK "--cable takes whole metres from 0 to 1000, not '-1'\n", NULL},
        {"--eeprom-times chip fzm1*2", 0, "1 fzm1 eeprom=2147483647\n2 fzm1 eeprom=2147483647\n", NULL},
        {"--eeprom-times chip --eeprom-times 1:short fzm1*2", 0, "1 fzm1\n2 fzm1 eeprom=2147483647\n", NULL},
        {"--al-delay 3 fzm1*2", 0, "1 fzm1 al=3000000..3000000\n2 fzm1 al=3000000..3000000\n", NULL},
        {"--al-delay 1:0..60000 fzm1*2", 0, "1 fzm1 al=0..60000000000\n2 fzm1\n", NULL},
        {"--al-delay 60001 fzm1", 1,
         CHECK "--al-delay takes MIN or MIN..MAX, whole numbers from 0 to 60000, not '60001'\n", NULL},
        {"--al-delay 2..1 fzm1", 1,
         CHECK "--al-delay takes MIN or MIN..MAX, whole numbers from 0 to 60000, not '2..1'\n", NULL},
        {"--al-delay 2..2 fzm1", 0, "1 fzm1 al=2000000..2000000\n", NULL},
        {"--mailbox-delay 2:1..60000 fzm1*2", 0, "1 fzm1\n2 fzm1 mailbox=1000000..60000000000\n", NULL},
        {"--mailbox-delay 60001 fzm1", 1,
         CHECK "--mailbox-delay takes MIN or MIN..MAX, whole numbers from 0 to 60000, not '60001'\n", NULL},
        {"--jitter 5..1000000 fzm1", 0, "1 fzm1 jitter=5000..1000000000\n", NULL},
        {"--jitter 1000001 fzm1", 1,
         CHECK "--jitter takes MIN or MIN..MAX, whole numbers from 0 to 1000000, not '1000001'\n", NULL},
        {"--jitter 5x fzm1", 1, CHECK "--jitter takes MIN or MIN..MAX, whole numbers from 0 to 1000000, not '5x'\n",
         NULL},
        {"--dc-jitter 100000 fzm1", 0, "1 fzm1 receive=100000\n", NULL},
        {"--dc-jitter 100001 fzm1", 1, CHECK "--dc-jitter takes a number from 0 to 100000, not '100001'\n", NULL},
        {"--like lan9252-spi fzm1*2", 0,
         "1 fzm1 eeprom=2147483647 board=lan9252-spi cycle=3839 esc=lan9252\n2 fzm1 eeprom=2147483647 "
         "board=lan9252-spi cycle=3839 esc=lan9252\n",
         NULL},
        {"--seed 7 fzm1*2", 0, "1 fzm1 seed=7\n2 fzm1 seed=8\nseed 7\n", NULL},
        {"--seed 4294967296 fzm1", 1, CHECK "--seed takes a number from 0 to 4294967295, not '4294967296'\n", NULL},
    };
    (void)state;
    EXPECT(rows);
}

static void wires(void **state)
{
#define WIRE(text) CHECK "--wire takes N:M.PORT, as in 3:1.2 for twin 3 at port 2 of twin 1, not '" text "'\n"
    static const row_t rows[] = {
        {"--wire 2:1.3 fzm1*3", 0, "1 fzm1\n2 fzm1 up=1 port=3\n3 fzm1\n", NULL},
        {"--wire 3:1.2 fzm1*3", 0, "1 fzm1\n2 fzm1\n3 fzm1 up=1 port=2\n", NULL},
        {"--wire 2:1.2 --wire 3:1.1 fzm1*3", 0, "1 fzm1\n2 fzm1 up=1 port=2\n3 fzm1 up=1 port=1\n", NULL},
        {"--wire c:a.2 a=fzm1,b=fzm1,c=fzm1", 0, "1 fzm1\n2 fzm1\n3 fzm1 up=1 port=2\n", NULL},
        {"--wire 1:1.2 fzm1*2", 1, WIRE("1.2"), NULL},
        {"--wire 2:1.0 fzm1*2", 1, WIRE("1.0"), NULL},
        {"--wire 2:1.4 fzm1*2", 1, WIRE("1.4"), NULL},
        {"--wire 2:0.1 fzm1*2", 1, WIRE("0.1"), NULL},
        {"--wire 2:x.1 fzm1*2", 1, WIRE("x.1"), NULL},
        {"--wire 2:1.1x fzm1*2", 1, WIRE("1.1x"), NULL},
        {"--wire 1.1 fzm1*2", 1, CHECK "0:1.1: twins are counted from 1 to 2\n", NULL},
        {"--wire 3:1.1 fzm1*2", 1, CHECK "3:1.1: twins are counted from 1 to 2\n", NULL},
        {"--wire 2:3.1 fzm1*3", 1,
         CHECK "twin 2 cannot be connected to port 1 of twin 3: that twin does not come before it, has no such port, "
               "or another twin is connected there (port 1 is for the next twin, unless --wire moves that)\n",
         NULL},
        {"--wire 3:1.1 fzm1*3", 1,
         CHECK "twin 3 cannot be connected to port 1 of twin 1: that twin does not come before it, has no such port, "
               "or another twin is connected there (port 1 is for the next twin, unless --wire moves that)\n",
         NULL},
    };
    (void)state;
    EXPECT(rows);
}

static void faults(void **state)
{
    static const row_t rows[] = {
        {"--drop 5 fzm1", 0, ONE "step, line 0: drop 5%\n", NULL},
        {"--drop 0 fzm1", 0, ONE, NULL},
        {"--drop 100 fzm1", 0, ONE "step, line 0: drop 100%\n", NULL},
        {"--drop 101 fzm1", 1, CHECK "--drop takes a number from 0 to 100, not '101'\n", NULL},
        {"--delay 1 fzm1", 0, ONE "step, line 0: delay 3000us 1%\n", NULL},
        {"--delay 100 --delay-us 10000000 fzm1", 0, ONE "step, line 0: delay 10000000us 100%\n", NULL},
        {"--delay 101 fzm1", 1, CHECK "--delay takes a number from 0 to 100, not '101'\n", NULL},
        {"--delay-us 10000001 fzm1", 1, CHECK "--delay-us takes a number from 0 to 10000000, not '10000001'\n", NULL},
        {"--fault 'drop every 3' fzm1", 0, ONE "step, line 0: drop every 3\n", NULL},
        {"--fault 'at 1s hang slave 1' fzm1", 0, ONE "step, line 0: at 1s hang slave 1\n", NULL},
        {"--fault 'at 1s hang slave 2' fzm1", 1, CHECK "a fault names slave 2, but the chain has 1\n", NULL},
        {"--fault 'at 1s hang slave 2' fzm1*2", 0, TWO "step, line 0: at 1s hang slave 2\n", NULL},
        {"--fault 'at 1s set data1=x' fzm1", 1,
         ONE "step, line 0: at 1s set data1=x\n" CHECK
             "'at 1s set data1=x': data1 takes -999999999..999999999, not 'x'\n",
         NULL},
        {"--faults t.csv fzm1", 0, ONE "step, line 1: drop 5%\nstep, line 3: at 1s hang slave 1\n",
         "drop 5%\n\nat 1s hang slave 1\n"},
        {"--scenario t.csv fzm1", 0, ONE "step, line 2: at 1s hang slave 1\n", "# x\nat 1s hang slave 1"},
        {"--scenario t.csv --fault 'at 2s hang slave 1' fzm1", 0,
         ONE "step, line 1: at 1s hang slave 1\nstep, line 0: at 2s hang slave 1\n", "at 1s hang slave 1"},
        {"--faults t.csv fzm1", 1,
         CHECK "t.csv line 2: expected drop, damage, delay, duplicate, reorder, truncate, corrupt, counter, off, hang, "
               "resume, reset, identity, lose-event, eeprom, clock, pdi-error, to, init, emergency, al, abort, mail, "
               "pdo-size, not 'x'\n",
         "drop 5%\nx\n"},
        {"--faults nosuch fzm1", 2, CHECK "--faults nosuch: No such file or directory\n", NULL},
        {"--scenario nosuch fzm1", 2, CHECK "--scenario nosuch: No such file or directory\n", NULL},
    };
    (void)state;
    EXPECT(rows);
}

static void tables(void **state)
{
    static const row_t rows[] = {
        {"--play t.csv fzm1", 0, ONE "table of 1, period 0: data1; 0 1; 500000000 2\n", "time,data1\n0,1\n0.5,2\n"},
        {"--play 2:t.csv fzm1*2", 0, TWO "table of 2, period 0: data1 data2; 0 1 -; 500000000 - 2\n",
         "data1,time,data2\n1,0,\n,0.5,2\n"},
        {"--play b:t.csv a=fzm1,b=fzm1", 0, TWO "table of 2, period 0: data1; 0 1\n", "time,data1\n0,1\n"},
        {"--play t.csv,loop fzm1", 0, ONE "table of 1, period 500000000: data1; 0 1; 500000000 2\n",
         "time,data1\n0,1\n0.5,2\n"},
        {"--play t.csv,every=250ms fzm1", 0, ONE "table of 1, period 0: data1; 0 1; 250000000 2; 500000000 3\n",
         "time,data1\n0,1\n0.5,3\n"},
        {"--play t.csv,every=250ms,loop fzm1", 0,
         ONE "table of 1, period 500000000: data1; 0 1; 250000000 2; 500000000 3\n", "time,data1\n0,1\n0.5,3\n"},
        {"--play t.csv,loop,every=250ms fzm1", 0,
         ONE "table of 1, period 500000000: data1; 0 1; 250000000 2; 500000000 3\n", "time,data1\n0,1\n0.5,3\n"},
        {"--play t.csv --play t.csv,loop fzm1", 0,
         ONE "table of 1, period 0: data1; 1000000000 1\ntable of 1, period 1000000000: data1; 1000000000 1\n",
         "time,data1\n1,1\n"},
        {"--play t.csv,loop fzm1", 1,
         CHECK "--play t.csv line 3: a loop has the time of its last line, which must not be 0\n", "time,data1\n0,1\n"},
        {"--play t.csv,x fzm1", 1,
         CHECK "--play t.csv,x: 'x' is neither loop nor every=TIME, as in every=5ms, and there is no such file\n",
         "time,data1\n0,1\n"},
        {"--play t.csv,every=5 fzm1", 1,
         CHECK
         "--play t.csv,every=5: 'every=5' is neither loop nor every=TIME, as in every=5ms, and there is no such file\n",
         "time,data1\n0,1\n"},
        {"--play 0:t.csv fzm1", 2, CHECK "--play 0:t.csv: N is 1 to 65535\n", "time,data1\n0,1\n"},
        {"--play t.csv fzm1", 1, CHECK "--play t.csv line 1: expected a column 'time' and at least one signal\n",
         "time\n0\n"},
        {"--play t.csv fzm1", 1, CHECK "--play t.csv line 1: expected a column 'time' and at least one signal\n",
         "data1,data2\n0,1\n"},
        {"--play t.csv fzm1", 1, CHECK "--play t.csv line 3: its time is before that of the line above\n",
         "time,data1\n1,1\n0.5,2\n"},
        {"--play t.csv fzm1", 1,
         ONE "table of 1, period 0: nosuch; 0 1\n" CHECK
             "--play: slave 1 has no signal 'nosuch': 'ectwin list-signals DEVICE' lists the names\n",
         "time,nosuch\n0,1\n"},
    };
    (void)state;
    EXPECT(rows);
}

static void settings(void **state)
{
#define CYCLE "power cycle\n"
    static const row_t rows[] = {
        {"--set data1=5 fzm1", 0, ONE CYCLE "1: data1 := 5\n", NULL},
        {"--set 2:data1=5 --set data2=1=2 fzm1*2", 1,
         TWO CYCLE "1: data2 := 1=2\n" CHECK "--set: data2 takes -999999999..999999999, not '1=2'\n", NULL},
        {"--set 2:data1=5 --set 1:data2=6 --set data3=7 fzm1*2", 0,
         TWO CYCLE "1: data2 := 6\n1: data3 := 7\n2: data1 := 5\n", NULL},
        {"--set b:data1=5 a=fzm1,b=fzm1", 0, TWO CYCLE "2: data1 := 5\n", NULL},
        {"--set b.data1=5 a=fzm1,b=fzm1", 0, TWO CYCLE "1: b.data1 := 5\n", NULL},
        {"--set node_address=3 --set data1=1 fzm1", 0,
         ONE "1: node_address := 3\n" CYCLE "1: node_address := 3\n1: data1 := 1\n", NULL},
        {"--set 3:data1=5 fzm1*2", 1, TWO CHECK "--set 3:data1=5: twins are counted from 1 to the number of devices\n",
         NULL},
        {"--set 0:data1=5 fzm1*2", 1, TWO CHECK "--set 0:data1=5: twins are counted from 1 to the number of devices\n",
         NULL},
        {"--set data1 fzm1", 1, CHECK "--set takes NAME=VALUE, not 'data1'\n", NULL},
        {"--set nosuch=1 fzm1", 1,
         ONE CYCLE "1: nosuch := 1\n" CHECK
                   "--set: slave 1 has no signal 'nosuch': 'ectwin list-signals DEVICE' lists those of a device\n",
         NULL},
    };
    (void)state;
    EXPECT(rows);
}

static void connections(void **state)
{
#define CONNECT(text) CHECK "--connect " text ": "
    static const row_t rows[] = {
        {"--connect 2.data1=1.data2 fzm1*2", 0, TWO "2.data1 = 1.data2 x 1 + 0, delay 0\n", NULL},
        {"--connect b.data1=a.data2 a=fzm1,b=fzm1", 0, TWO "2.data1 = 1.data2 x 1 + 0, delay 0\n", NULL},
        {"--connect 2.data1=1.data2,factor=-2.5,offset=1e3,delay=10ms,invert fzm1*2", 0,
         TWO "2.data1 = 1.data2 x -2.5 + 1000, inverted, delay 10000000\n", NULL},
        {"--connect 2.data1=1.data2 --connect 2.data2=1.data2 fzm1*2", 0,
         TWO "2.data1 = 1.data2 x 1 + 0, delay 0\n2.data2 = 1.data2 x 1 + 0, delay 0\n", NULL},
        {"--connect 2.data1=1.data2 --connect 1.data2=2.data1 fzm1*2", 1,
         TWO CONNECT("1.data2=2.data1") "closes a loop of connections without a delay: add ,delay=1ms\n", NULL},
        {"--connect 2.data1=1.data2 --connect 1.data2=2.data1,delay=1ms fzm1*2", 0,
         TWO "2.data1 = 1.data2 x 1 + 0, delay 0\n1.data2 = 2.data1 x 1 + 0, delay 1000000\n", NULL},
        {"--connect 2.data1=1.data2,factor= fzm1*2", 1,
         TWO CONNECT("2.data1=1.data2,factor=") "'factor=' is none of factor=NUMBER, offset=NUMBER, delay=TIME (as "
                                                "10ms), invert\n",
         NULL},
        {"--connect 2.data1=1.data2,offset=nan fzm1*2", 1,
         TWO CONNECT("2.data1=1.data2,offset=nan") "'offset=nan' is none of factor=NUMBER, offset=NUMBER, delay=TIME "
                                                   "(as 10ms), invert\n",
         NULL},
        {"--connect 2.data1=1.data2,inverted fzm1*2", 1,
         TWO CONNECT("2.data1=1.data2,inverted") "'inverted' is none of factor=NUMBER, offset=NUMBER, delay=TIME (as "
                                                 "10ms), invert\n",
         NULL},
        {"--connect 2.data1 fzm1*2", 1,
         TWO CONNECT("2.data1") "it takes TARGET=SOURCE, as in 1.channel_1=2.channel_1\n", NULL},
        {"--connect 2.data1=1.nosuch fzm1*2", 1,
         TWO CONNECT("2.data1=1.nosuch") "twin 1 has no signal 'nosuch': 'ectwin list-signals DEVICE' lists them\n",
         NULL},
        {"--connect 2.data1=data2 fzm1*2", 1,
         TWO CONNECT(
             "2.data1=data2") "'data2' is no signal of a twin: write its number or name first, as in 2.position\n",
         NULL},
        {"--connect 2.data1=3.data2 fzm1*2", 1, TWO CONNECT("2.data1=3.data2") "'3.data2': the chain has 2 twins\n",
         NULL},
        {"--connect 2.data1=1.data2 fzm1", 1, ONE CONNECT("2.data1=1.data2") "'2.data1': the chain has 1 twin\n", NULL},
        {"--connect 2.rows=1.data2 fzm1*2", 1,
         TWO CONNECT("2.rows=1.data2") "2.rows cannot be set: write TARGET=SOURCE, as in --set\n", NULL},
        {"--connect 2.data1=1.ecat.run fzm1*2", 1,
         TWO CONNECT("2.data1=1.ecat.run") "2.data1 and 1.ecat.run must both be numbers\n", NULL},
        {"--panel 1,2 fzm1*2", 0, TWO, NULL},
        {"--panel b a=fzm1,b=fzm1", 0, TWO, NULL},
        {"--panel 2,3 fzm1*2", 1,
         TWO CHECK "--panel: '3' is no twin: write names or numbers from 1 to 2, as in camera,axis\n", NULL},
        {"--panel 1, fzm1*2", 1,
         TWO CHECK "--panel: '' is no twin: write names or numbers from 1 to 2, as in camera,axis\n", NULL},
        {"--panel 1x fzm1*2", 1,
         TWO CHECK "--panel: '1x' is no twin: write names or numbers from 1 to 2, as in camera,axis\n", NULL},
        {"--panel 0 fzm1*2", 1,
         TWO CHECK "--panel: '0' is no twin: write names or numbers from 1 to 2, as in camera,axis\n", NULL},
    };
    (void)state;
    EXPECT(rows);
}

/* The slaves of a network file are the last twins, with its aliases and wires. */
static void networks(void **state)
{
#define MACHINE "eni:" ENI_FILES "/machine.xml"
    static const row_t rows[] = {
        {"--quiet " MACHINE, 0, "1 rack-1-io8\n2 drive-2-ax1 serial=7 up=1 port=1\n3 tool-3-io8 alias=17 up=1 port=2\n",
         NULL},
        {"--quiet --alias 2:9 fzm1," MACHINE, 0,
         "1 fzm1\n2 rack-1-io8 alias=9\n3 drive-2-ax1 serial=7 up=2 port=1\n4 tool-3-io8 alias=17 up=2 port=2\n", NULL},
        {MACHINE ",fzm1", 1, CHECK "no device follows behind " MACHINE ", a bus of any length: put that last\n", NULL},
        {MACHINE "*2", 1, CHECK "a count is for one device, and " MACHINE " is a bus: write it once\n", NULL},
        {MACHINE "*1,fzm1", 1, CHECK "no device follows behind " MACHINE ", a bus of any length: put that last\n",
         NULL},
        {"eni:nosuch.xml", 2, CHECK "nosuch.xml: No such file or directory\n", NULL},
    };
    (void)state;
    EXPECT(rows);
}

/* Each option of twins excludes --external, and so does each of wires and networks. */
static void given_options(void **state)
{
    static const char *const options[] = {
        "--vendor-id 1", "--serial 1", "--quiet",  "--drop 0",  "--set a=1",   "--seed 1",   "--fault x",
        "--pcap x",      "--store x",  "--udp 1",  "--esc x",   "--cable 1",   "--eoe echo", "--keep-source-mac",
        "--realtime",    "--files x",  "--name x", "--panel 1", "--connect x", "--busy-poll"};
    (void)state;
    for (size_t i = 0; i < sizeof options / sizeof options[0]; i++) {
        char line[100];
        snprintf(line, sizeof line, "with --external x %s -- true", options[i]);
        command_expect(&(command_line_t){.line = line,
                                         .status = 1,
                                         .text = "ectwin with: --external is a slave of your own: the options of twins "
                                                 "have no effect on it: leave them out\n"},
                       NULL, 0);
    }
}

#define TEST(title, function) {title, function, NULL, NULL, NULL}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        TEST("identities and aliases, of one twin or counted up", identities),
        TEST("names and counts of devices", names),
        TEST("chips, boards, times and deviations", chips_and_times),
        TEST("wires to other ports", wires),
        TEST("faults, of the command line and of files", faults),
        TEST("tables of signals", tables),
        TEST("signals that are set, before and after power-on", settings),
        TEST("signals that are connected, and twins of the panel", connections),
        TEST("slaves of a network file", networks),
        TEST("options of twins exclude --external", given_options),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Options of twins", tests, commands_begin, commands_end);
}
