/* SPDX-License-Identifier: MIT */
/* Documents of YAML: the files that are read, refusals with their lines, and the nodes of a document. The calls
 * that fail for lack of memory are the test's. */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#include "yaml/document.h"

#define COUNT(table) (sizeof(table) / sizeof((table)[0]))

enum { TEXT = 400 };

static char why[TEXT];

/* --- calls that fail ---------------------------------------------------------------------------------------------- */

static bool read_fails;
static unsigned int fails_at; /* the call of yaml_parser_initialize that fails, from 1; 0: none */
static bool parse_fails, load_fails;

ssize_t __real_read(int fd, void *buffer, size_t size);
ssize_t __wrap_read(int fd, void *buffer, size_t size);
int __real_yaml_parser_initialize(yaml_parser_t *parser);
int __wrap_yaml_parser_initialize(yaml_parser_t *parser);
int __real_yaml_parser_parse(yaml_parser_t *parser, yaml_event_t *event);
int __wrap_yaml_parser_parse(yaml_parser_t *parser, yaml_event_t *event);
int __real_yaml_parser_load(yaml_parser_t *parser, yaml_document_t *document);
int __wrap_yaml_parser_load(yaml_parser_t *parser, yaml_document_t *document);

ssize_t __wrap_read(int fd, void *buffer, size_t size)
{
    if (read_fails) {
        errno = EIO;
        return -1;
    }
    return __real_read(fd, buffer, size);
}

int __wrap_yaml_parser_initialize(yaml_parser_t *parser)
{
    return fails_at > 0 && --fails_at == 0 ? 0 : __real_yaml_parser_initialize(parser);
}

int __wrap_yaml_parser_parse(yaml_parser_t *parser, yaml_event_t *event)
{
    return parse_fails ? 0 : __real_yaml_parser_parse(parser, event);
}

int __wrap_yaml_parser_load(yaml_parser_t *parser, yaml_document_t *document)
{
    return load_fails ? 0 : __real_yaml_parser_load(parser, document);
}

/* --- files -------------------------------------------------------------------------------------------------------- */

static char folder[] = "/tmp/ectwin-yaml-XXXXXX";
static char path[sizeof folder + 8];

static int make_folder(void **state)
{
    (void)state;
    if (!mkdtemp(folder))
        return -1;
    (void)snprintf(path, sizeof path, "%s/file", folder);
    return 0;
}

static int remove_folder(void **state)
{
    (void)state;
    (void)unlink(path);
    return rmdir(folder);
}

static void write_file(const char *bytes, size_t length)
{
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, length, file), length);
    assert_int_equal(fclose(file), 0);
}

/* The number that the next opened file gets: greater when one was left open. */
static int next_number(void)
{
    int fd = open("/dev/null", O_RDONLY);
    assert_true(fd >= 0);
    (void)close(fd);
    return fd;
}

static void a_file_is_read_up_to_the_length_that_is_allowed(void **state)
{
    static const struct {
        const char *bytes;
        size_t length, most;
        bool taken;
    } rows[] = {
        {"abc", 3, 4, true}, {"abc", 3, 3, true},   {"abc", 3, 2, false},
        {"", 0, 1, true},    {"a\0b", 3, 10, true}, {"abcdefgh", 8, 7, false},
    };
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        size_t length = 99;
        char error[TEXT] = "", expected[TEXT];
        const int number = next_number();
        write_file(rows[i].bytes, rows[i].length);
        char *data = ect_yaml_load(path, rows[i].most, &length, error, sizeof error);
        (void)snprintf(expected, sizeof expected, "%s: not a file of at most %zu bytes", path, rows[i].most);
        assert_string_equal(error, rows[i].taken ? "" : expected);
        assert_int_equal(length, rows[i].taken ? rows[i].length : 99);
        if (rows[i].taken) {
            assert_non_null(data);
            assert_memory_equal(data, rows[i].bytes, rows[i].length);
        } else {
            assert_null(data);
        }
        assert_int_equal(next_number(), number);
        free(data);
        assert_int_equal(unlink(path), 0);
    }
}

static void a_path_that_is_no_readable_file_is_refused_with_the_cause(void **state)
{
    size_t length = 99;
    char error[TEXT], expected[TEXT];
    (void)state;
    (void)snprintf(expected, sizeof expected, "%s: %s", path, strerror(ENOENT));
    assert_null(ect_yaml_load(path, 10, &length, error, sizeof error));
    assert_string_equal(error, expected);

    (void)snprintf(expected, sizeof expected, "%s: not a file of at most 100000 bytes", folder);
    assert_null(ect_yaml_load(folder, 100000, &length, error, sizeof error));
    assert_string_equal(error, expected);

    /* A pipe without a writer would hold the command up. */
    const int number = next_number();
    assert_int_equal(mkfifo(path, 0600), 0);
    (void)snprintf(expected, sizeof expected, "%s: not a file of at most 10 bytes", path);
    assert_null(ect_yaml_load(path, 10, &length, error, sizeof error));
    assert_string_equal(error, expected);
    assert_int_equal(unlink(path), 0);

    write_file("abc", 3);
    read_fails = true;
    (void)snprintf(expected, sizeof expected, "%s: %s", path, strerror(EIO));
    char *data = ect_yaml_load(path, 10, &length, error, sizeof error);
    read_fails = false;
    assert_null(data);
    assert_string_equal(error, expected);
    assert_int_equal(length, 99);
    assert_int_equal(next_number(), number);
    assert_int_equal(unlink(path), 0);
}

static void a_file_is_read_by_a_process_without_standard_input(void **state)
{
    size_t length = 0;
    char error[TEXT] = "";
    (void)state;
    write_file("abc", 3);
    const int input = fcntl(0, F_DUPFD_CLOEXEC, 3);
    (void)close(0);
    char *data = ect_yaml_load(path, 10, &length, error, sizeof error);
    const int after = fcntl(0, F_GETFD);
    if (input >= 0) {
        (void)dup2(input, 0);
        (void)close(input);
    } else {
        (void)close(0);
    }
    assert_int_equal(unlink(path), 0);
    assert_string_equal(error, "");
    assert_non_null(data);
    assert_memory_equal(data, "abc", 3);
    assert_int_equal(length, 3);
    assert_int_equal(after, -1);
    free(data);
}

/* --- documents ---------------------------------------------------------------------------------------------------- */

static ect_mistake_t mistake;
static ect_yaml_t yaml;

static bool open_bytes(const char *text, size_t length)
{
    mistake = (ect_mistake_t){.path = "f.yaml", .text = why, .room = sizeof why};
    why[0] = '\0';
    return ect_yaml_open(&yaml, "test file", &mistake, text, length);
}

static const yaml_node_t *root_of(const char *text)
{
    if (!open_bytes(text, strlen(text)))
        fail_msg("'%s': %s", text, why);
    return ect_yaml_root(&yaml);
}

static void a_document_is_refused_at_the_line_of_its_first_mistake(void **state)
{
    static const struct {
        const char *text, *why;
    } rows[] = {
        {"a: 1\nb: *c\n", "f.yaml:2: an alias of YAML: test files have none"},
        {"a: &c 1\n", "f.yaml:1: an anchor of YAML: test files have none"},
        {"a:\n- 1\n- &c [1]\n", "f.yaml:3: an anchor of YAML: test files have none"},
        {"\n\na: &c {b: 1}\n", "f.yaml:3: an anchor of YAML: test files have none"},
        {"a: !!str 1\n", "f.yaml:1: a tag of YAML: test files have none"},
        {"a:\n  !!seq [1]\n", "f.yaml:2: a tag of YAML: test files have none"},
        {"a:\n  !x {b: 1}\n", "f.yaml:2: a tag of YAML: test files have none"},
        {"a: 1\n---\nb: 1\n", "f.yaml:2: a second document: a test file has one"},
        {"[[[[[[[[\n[1]]]]]]]]]\n", "f.yaml:2: lists within lists: a test file has no such depth"},
        {"{a: {a: {a: {a: [{a: {a: {a:\n {}}}}]}}}}\n", "f.yaml:2: lists within lists: a test file has no such depth"},
        {"a: 1\n\n b: 2\n", "f.yaml:3: no YAML: mapping values are not allowed in this context"},
        {"a: [1, 2\n", "f.yaml:2: no YAML: did not find expected ',' or ']'"},
    };
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        assert_false(open_bytes(rows[i].text, strlen(rows[i].text)));
        assert_string_equal(why, rows[i].why);
    }
}

static void a_document_may_be_as_deep_as_it_is_allowed(void **state)
{
    static const char *const texts[] = {
        "[[[[[[[[1]]]]]]]]\n",
        "{a: {a: {a: {a: {a: {a: {a: {a: 1}}}}}}}}\n",
        "[[], [], [], [], [], [], [], [], [], []]\n",
        "[{}, {}, {}, {}, {}, {}, {}, {}, {}, {}]\n",
        "---\na: 1\n...\n",
        "{\"json\": [1, null, \"text\"]}\n",
    };
    (void)state;
    for (size_t i = 0; i < COUNT(texts); i++) {
        assert_non_null(root_of(texts[i]));
        assert_string_equal(why, "");
        ect_yaml_close(&yaml);
    }
}

static void only_the_bytes_of_the_length_are_read(void **state)
{
    static const char text[] = "a: 1\nb: *c\n";
    (void)state;
    assert_true(open_bytes(text, 5));
    assert_non_null(ect_yaml_find(&yaml, ect_yaml_root(&yaml), "a"));
    assert_null(ect_yaml_find(&yaml, ect_yaml_root(&yaml), "b"));
    ect_yaml_close(&yaml);
}

static void an_empty_document_has_no_root(void **state)
{
    static const char *const texts[] = {"", "\n\n", "# nothing\n"};
    (void)state;
    for (size_t i = 0; i < COUNT(texts); i++) {
        assert_null(root_of(texts[i]));
        ect_yaml_close(&yaml);
    }
}

static void a_lack_of_memory_is_a_mistake(void **state)
{
    (void)state;
    for (unsigned int at = 1; at <= 2; at++) {
        fails_at = at;
        assert_false(open_bytes("a: 1\n", 5));
        assert_int_equal(fails_at, 0);
        assert_string_equal(why, "f.yaml:1: no memory left");
    }
    parse_fails = true;
    assert_false(open_bytes("a: 1\n", 5));
    parse_fails = false;
    assert_string_equal(why, "f.yaml:1: no YAML: no memory left");
    load_fails = true;
    assert_false(open_bytes("a: 1\n", 5));
    load_fails = false;
    assert_string_equal(why, "f.yaml:1: no YAML: no memory left");
}

/* --- nodes -------------------------------------------------------------------------------------------------------- */

static void a_line_counts_from_one(void **state)
{
    (void)state;
    const yaml_node_t *root = root_of("\na: 1\nb:\n- 2\n");
    assert_int_equal(ect_yaml_line(NULL), 1);
    assert_int_equal(ect_yaml_line(root), 2);
    assert_int_equal(ect_yaml_line(ect_yaml_find(&yaml, root, "a")), 2);
    assert_int_equal(ect_yaml_line(ect_yaml_find(&yaml, root, "b")), 4);
    ect_yaml_fail(&yaml, ect_yaml_find(&yaml, root, "b"), "the first, %d", 7);
    ect_yaml_fail(&yaml, NULL, "the second");
    assert_string_equal(why, "f.yaml:4: the first, 7");
    ect_yaml_close(&yaml);

    (void)root_of("\na: 1\n");
    ect_yaml_fail(&yaml, NULL, "anywhere");
    assert_string_equal(why, "f.yaml:1: anywhere");
    ect_yaml_close(&yaml);
}

static void a_scalar_is_one_text_without_a_zero(void **state)
{
    static const struct {
        const char *text, *value, *why;
    } rows[] = {
        {"text\n", "text", ""},
        {"''\n", "", ""},
        {"\"a b\"\n", "a b", ""},
        {"\n[1]\n", "", "f.yaml:2: 'key' takes one value"},
        {"{a: 1}\n", "", "f.yaml:1: 'key' takes one value"},
        {"\n\n\"a\\0b\"\n", "a", "f.yaml:3: 'key' has a character 0"},
    };
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        const yaml_node_t *root = root_of(rows[i].text);
        assert_string_equal(ect_yaml_scalar(&yaml, root, "key"), rows[i].value);
        assert_string_equal(why, rows[i].why);
        assert_int_equal(mistake.failed, rows[i].why[0] != '\0');
        ect_yaml_close(&yaml);
    }
}

static void a_key_is_found_by_its_whole_name_and_the_first_counts(void **state)
{
    (void)state;
    const yaml_node_t *root = root_of("? [x]\n: list\nname: 1\nnames: 2\nx: 3\nx: 4\n");
    assert_string_equal(ect_yaml_scalar(&yaml, ect_yaml_find(&yaml, root, "name"), ""), "1");
    assert_string_equal(ect_yaml_scalar(&yaml, ect_yaml_find(&yaml, root, "names"), ""), "2");
    assert_string_equal(ect_yaml_scalar(&yaml, ect_yaml_find(&yaml, root, "x"), ""), "3");
    assert_null(ect_yaml_find(&yaml, root, "nam"));
    assert_null(ect_yaml_find(&yaml, root, "Name"));
    assert_string_equal(why, "");
    ect_yaml_close(&yaml);

    root = root_of("{}\n");
    assert_null(ect_yaml_find(&yaml, root, "name"));
    ect_yaml_close(&yaml);
}

static void a_node_is_found_by_its_number(void **state)
{
    (void)state;
    const yaml_node_t *root = root_of("[first, second]\n");
    const yaml_node_item_t *items = root->data.sequence.items.start;
    assert_string_equal(ect_yaml_scalar(&yaml, ect_yaml_node(&yaml, items[0]), ""), "first");
    assert_string_equal(ect_yaml_scalar(&yaml, ect_yaml_node(&yaml, items[1]), ""), "second");
    ect_yaml_close(&yaml);
}

/* --- pairs -------------------------------------------------------------------------------------------------------- */

/* Writes "KEY@LINE=VALUE " for each pair, and reports a mistake at the key "stop". */
static void take(void *ctx, const char *key, const yaml_node_t *name, const yaml_node_t *value)
{
    char *text = ctx;
    const size_t used = strlen(text);
    (void)snprintf(text + used, TEXT - used, "%s@%zu=%s ", key, ect_yaml_line(name),
                   value->type == YAML_SCALAR_NODE ? (const char *)value->data.scalar.value : "?");
    if (strcmp(key, "stop") == 0)
        ect_yaml_fail(&yaml, name, "stopped");
}

static void the_pairs_of_a_mapping_are_taken_in_order_until_a_mistake(void **state)
{
    static const struct {
        const char *text;
        bool unique;
        const char *taken, *why;
    } rows[] = {
        {"a: 1\nb: 2\n", true, "a@1=1 b@2=2 ", ""},
        {"b: 1\na: [2]\n", false, "b@1=1 a@2=? ", ""},
        {"{}\n", true, "", ""},
        {"a: 1\na: 2\n", false, "a@1=1 a@2=2 ", ""},
        {"a: 1\nb: 2\na: 3\nc: 4\n", true, "a@1=1 b@2=2 ", "f.yaml:3: 'a' occurs twice"},
        {"a: 1\nstop: 2\nb: 3\n", true, "a@1=1 stop@2=2 ", "f.yaml:2: stopped"},
        {"a: 1\n? [k]\n: 2\nb: 3\n", true, "a@1=1 ", "f.yaml:2: 'a thing' takes one value"},
        {"a: 1\n? [k]\n: 2\nb: 3\n", false, "a@1=1 ", "f.yaml:2: 'a thing' takes one value"},
        {"\ntext\n", true, "", "f.yaml:2: a thing: 'key: value' lines are missing"},
        {"- a\n", true, "", "f.yaml:1: a thing: 'key: value' lines are missing"},
    };
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        char taken[TEXT] = "";
        ect_yaml_each(&yaml, root_of(rows[i].text), "a thing", rows[i].unique, take, taken);
        assert_string_equal(taken, rows[i].taken);
        assert_string_equal(why, rows[i].why);
        ect_yaml_close(&yaml);
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_file_is_read_up_to_the_length_that_is_allowed),
        cmocka_unit_test(a_path_that_is_no_readable_file_is_refused_with_the_cause),
        cmocka_unit_test(a_file_is_read_by_a_process_without_standard_input),
        cmocka_unit_test(a_document_is_refused_at_the_line_of_its_first_mistake),
        cmocka_unit_test(a_document_may_be_as_deep_as_it_is_allowed),
        cmocka_unit_test(only_the_bytes_of_the_length_are_read),
        cmocka_unit_test(an_empty_document_has_no_root),
        cmocka_unit_test(a_lack_of_memory_is_a_mistake),
        cmocka_unit_test(a_line_counts_from_one),
        cmocka_unit_test(a_scalar_is_one_text_without_a_zero),
        cmocka_unit_test(a_key_is_found_by_its_whole_name_and_the_first_counts),
        cmocka_unit_test(a_node_is_found_by_its_number),
        cmocka_unit_test(the_pairs_of_a_mapping_are_taken_in_order_until_a_mistake),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
