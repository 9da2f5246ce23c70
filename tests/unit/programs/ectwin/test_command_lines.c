/* SPDX-License-Identifier: MIT */
/* Commands beside a twin, with the requests that they send and the text that they print for each reply. */
#define _GNU_SOURCE
#include "command_lines.h"

#define OK "{\"ok\":true}\n"

static void get(void **state)
{
    static const command_line_t rows[] = {
        {.line = "get -s ./c.sock",
         .text = "a=1\n",
         .replies = {"{\"name\":\"a\",\"slave\":1,\"value\":1}\n" OK},
         .requests = "{\"op\":\"get\",\"slave\":1,\"pattern\":\"*\"}\n"},
    };
    (void)state;
    COMMANDS_EXPECT(rows);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(get),
    };
    char folder[] = "/tmp/ectwin-command-XXXXXX";
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    if (!mkdtemp(folder) || chdir(folder) != 0)
        return 1;
    const int failed = cmocka_run_group_tests_name("Commands beside a twin", tests, NULL, NULL);
    (void)unlink("c.sock");
    return rmdir(folder) == 0 ? failed : 1;
}
