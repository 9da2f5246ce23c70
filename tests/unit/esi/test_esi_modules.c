/* SPDX-License-Identifier: MIT */
/* Slots of a modular device and the modules that they accept (src/esi/modules.c). */
#include "from_text.h"

#include "esi/modules.h"

/* A slot for two idents with a preset, two places for a class of which one must be filled, one slot for nothing known.
 */
static const char rack[] =
    ESI_HEAD "\n<Device Physics='YY'><Type ProductCode='#x1' RevisionNo='#x2'>RACK</Type><Name>A rack</Name>"
             "<Slots><Slot MinInstances='1' MaxInstances='1'><Name>A</Name><ModuleIdent Default='1'>1</ModuleIdent>"
             "<ModuleIdent>2</ModuleIdent></Slot>"
             "<Slot MinInstances='2' MaxInstances='3'><Name>B</Name><ModuleClass><Class>X</Class></ModuleClass>"
             "<ModuleIdent Default='1'>2</ModuleIdent></Slot>"
             "<Slot MinInstances='0' MaxInstances='1'><Name>C</Name><ModuleIdent>9</ModuleIdent></Slot>"
             "</Slots></Device></Devices><Modules>"
             "<Module><Type ModuleIdent='1' ModuleClass='X'>M</Type><Name>M</Name></Module>"
             "<Module><Type ModuleIdent='2' ModuleClass='Y'>N</Type><Name>N</Name></Module>"
             "</Modules></Descriptions></EtherCATInfo>";

static void places(void **state)
{
    static const struct {
        const char *slot; /* NULL: no such place */
        unsigned int instance;
        bool takes_1, takes_2, takes_9;
        uint32_t preset;
    } rows[] = {{"A", 0, true, true, false, 1}, {"B", 0, true, true, false, 2},   {"B", 1, true, true, false, 2},
                {"B", 2, true, true, false, 0}, {"C", 0, false, false, false, 0}, {NULL, 0, false, false, false, 0}};
    made_t m = try_text(rack);
    (void)state;
    assert_non_null(m.model);
    assert_int_equal(ect_esi_places(m.model), 5);
    for (unsigned int n = 0; n < sizeof rows / sizeof rows[0]; n++) {
        unsigned int instance = 0;
        const ect_esi_slot_t *slot = ect_esi_slot_at(m.model, n, &instance);
        if ((slot == NULL) != (rows[n].slot == NULL) ||
            (slot != NULL && (strcmp(slot->name, rows[n].slot) != 0 || instance != rows[n].instance ||
                              ect_esi_preset(m.model, n) != rows[n].preset)) ||
            ect_esi_place_takes(m.model, n, 1) != rows[n].takes_1 ||
            ect_esi_place_takes(m.model, n, 2) != rows[n].takes_2 ||
            ect_esi_place_takes(m.model, n, 9) != rows[n].takes_9)
            fail_msg("place %u: slot %s, instance %u", n, slot != NULL ? slot->name : "none", instance);
    }
    free_made(&m);
}

static void idents(void **state)
{
    made_t m = try_text(rack);
    (void)state;
    assert_string_equal(ect_esi_module(m.model, 2)->type, "N");
    assert_null(ect_esi_module(m.model, 3));
    free_made(&m);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"MDP-015 MDP-021: each place has its slot, its preset and the modules that it takes by ident or class", places,
         NULL, NULL, NULL},
        {"MDP-021: a module is found by its ident", idents, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("ESI: modules and slots", tests, NULL, NULL);
}
