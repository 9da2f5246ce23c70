/* SPDX-License-Identifier: MIT */
/* The search for the instruction that makes a system call. */
#define _GNU_SOURCE
#include <link.h>

#include "bus/inprocess/raw_objects.h"
#include "fakes.h"

typedef struct text {
    const char *what;
    const char *bytes;
    size_t length;
    bool has_call;
} text_t;

#define BYTES(s) s, sizeof(s) - 1

static void finds_calls(void **state)
{
    static const text_t texts[] = {
        {"nothing", BYTES(""), false},
        {"one byte", BYTES("\x0F"), false},
        {"no number", BYTES("\x90\x90\x0F\x05\xC3\x90"), false},
        {"mov $1,%eax", BYTES("\xB8\x01\0\0\0\x0F\x05\xC3\x90"), true},
        {"mov $281,%eax, arguments between", BYTES("\xB8\x19\x01\0\0\x48\x89\xE6\x31\xD2\x0F\x05\x48\x3D"), true},
        {"mov $0x12345,%eax is no number", BYTES("\xB8\x45\x23\x01\0\x0F\x05\xC3\x90"), false},
        {"xor %eax,%eax", BYTES("\x31\xC0\x0F\x05\xC3\x90"), true},
        {"push $39; pop %rax", BYTES("\x6A\x27\x58\x0F\x05\xC3\x90"), true},
        {"mov %rdi,%rax", BYTES("\x48\x89\xF8\x0F\x05\xC3\x90"), true},
        {"mov 8(%rsp),%rax, as without optimization", BYTES("\x48\x8B\x44\x24\x08\x0F\x05\xC3\x90"), true},
        {"movslq %edi,%rax", BYTES("\x48\x63\xC7\x0F\x05\xC3\x90"), true},
        {"an offset of 0x50F", BYTES("\x31\xC0\x48\x8D\x05\x0F\x05\0\0\xC3"), false},
        {"an offset of -0xFAF1", BYTES("\x31\xC0\x48\x8D\x05\x0F\x05\xFF\xFF\xC3"), false},
        {"mov $15,%rax, the return from a handler", BYTES("\x31\xC0\x48\xC7\xC0\x0F\0\0\0\x0F\x05\xC3\x90"), false},
        {"the offset of a call", BYTES("\x31\xC0\xE8\x0F\x05\xE8\xFF\x90"), false},
        {"the offset of a jump", BYTES("\x31\xC0\xE9\x0F\x05\x12\0\x90"), false},
        {"the second byte alone", BYTES("\x31\xC0\x05\x05\x05\x05\xC3\x90"), false},
        {"the last bytes of a text", BYTES("\x31\xC0\x0F\x05"), false},
        {"mov $0x2FF,%eax is the highest number", BYTES("\xB8\xFF\x02\0\0\x0F\x05\xC3\x90"), true},
        {"mov $0x300,%eax is no number", BYTES("\xB8\0\x03\0\0\x0F\x05\xC3\x90"), false},
        {"mov $0x10001,%eax is no number", BYTES("\xB8\x01\0\x01\0\x0F\x05\xC3\x90"), false},
        {"mov $0x1000001,%eax is no number", BYTES("\xB8\x01\0\0\x01\x0F\x05\xC3\x90"), false},
        {"xor %ecx,%ecx", BYTES("\x31\xC9\x0F\x05\xC3\x90"), false},
        {"push $39; pop %rcx", BYTES("\x6A\x27\x59\x0F\x05\xC3\x90"), false},
        {"mov %rdi,%rcx", BYTES("\x48\x89\xF9\x0F\x05\xC3\x90"), false},
        {"mov %rdi,(%rax)", BYTES("\x48\x89\x38\x0F\x05\xC3\x90"), false},
        {"mov 8(%rsp),%rcx", BYTES("\x48\x8B\x4C\x24\x08\x0F\x05\xC3\x90"), false},
        {"mov %rax,%rax as a load", BYTES("\x48\x8B\xC0\x0F\x05\xC3\x90"), false},
        {"mov 0(%rdi),%rax, the last form of memory", BYTES("\x48\x8B\x87\x08\x0F\x05\xC3\x90"), true},
        {"movslq %edi,%rcx", BYTES("\x48\x63\xCF\x0F\x05\xC3\x90"), false},
        {"movslq %eax,%rax", BYTES("\x48\x63\xC0\x0F\x05\xC3\x90"), true},
        {"an offset that ends with FF and another byte", BYTES("\x31\xC0\x0F\x05\xFF\xC3\x90"), true},
        {"two bytes behind a call", BYTES("\x31\xC0\x0F\x05\xC3\x90"), true},
        {"one byte behind a call", BYTES("\x31\xC0\x0F\x05\xC3"), false},
        {"a jump by a positive offset", BYTES("\x31\xC0\xE9\x0F\x05\x12\xFF\x90"), false},
        {"the byte of a jump before a call", BYTES("\x31\xC0\xE8\x0F\x05\xC3\x90\x90"), true},
        {"the first bytes of a text", BYTES("\x0F\x05\x31\xC0\x0F\x05\xC3\x90"), true},
        {"behind such bytes", BYTES("\x31\xC0\x0F\x05\0\0\x90\x0F\x05\xC3\x90"), true},
    };
    (void)state;
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        if (ect_text_has_call((const uint8_t *)texts[i].bytes, texts[i].length) != texts[i].has_call)
            fail_msg("%s", texts[i].what);
    }
}

static void the_number_is_near(void **state)
{
    enum { SIZE = 256, NEAR = 60, FAR = 80 };
    uint8_t text[SIZE];
    (void)state;
    for (unsigned int distance = NEAR; distance <= FAR; distance += FAR - NEAR) {
        memset(text, 0x90, sizeof text);
        memcpy(text + 8, "\x31\xC0", 2);
        memcpy(text + 8 + distance, "\x0F\x05", 2);
        assert_int_equal(ect_text_has_call(text, sizeof text), distance == NEAR);
    }
}

/* --- objects
 * ------------------------------------------------------------------------------------------------------------ */

typedef struct object {
    const char *name;
    const uint8_t *text;
    size_t length;
    unsigned int flags, type;
} object_t;

static const object_t *loaded; /* NULL: those of this process */
static size_t loaded_count;
static unsigned long long loads;

int fake_dl_iterate_phdr(int (*use)(struct dl_phdr_info *info, size_t size, void *ctx), void *ctx)
{
    int result = 0;
    if (!loaded)
        return dl_iterate_phdr(use, ctx);
    for (size_t i = 0; i < loaded_count && result == 0; i++) {
        const ElfW(Phdr) parts[] = {{.p_type = PT_DYNAMIC, .p_flags = PF_R | PF_X},
                                    {.p_type = loaded[i].type,
                                     .p_flags = loaded[i].flags,
                                     .p_vaddr = 4,
                                     .p_filesz = loaded[i].length,
                                     .p_memsz = loaded[i].length + 1}};
        struct dl_phdr_info info = {.dlpi_addr = (uintptr_t)loaded[i].text - 4,
                                    .dlpi_name = loaded[i].name,
                                    .dlpi_phdr = parts,
                                    .dlpi_phnum = 2,
                                    .dlpi_adds = loads};
        result = use(&info, sizeof info, ctx);
    }
    return result;
}

static const uint8_t call[] = {0x31, 0xC0, 0x0F, 0x05, 0xC3, 0x90};
static const uint8_t no_call[] = {0x31, 0xC0, 0x90, 0x90, 0xC3, 0x90};

static ect_objects_t search(const object_t *objects, size_t count)
{
    ect_objects_t its = {0};
    loaded = objects;
    loaded_count = count;
    loads = 7;
    ect_objects_search(&its);
    loaded = NULL;
    return its;
}

#define OBJECT(name, text, flags) {name, text, sizeof(text), flags, PT_LOAD}
enum { TEXT = PF_R | PF_X };

static void knows_objects_by_name(void **state)
{
    static const struct {
        object_t object;
        bool is_library, passes, has_calls;
    } rows[] = {
        {OBJECT("/lib/libc.so.6", call, TEXT), true, false, false},
        {OBJECT("/lib64/ld-linux-x86-64.so.2", call, TEXT), false, true, false},
        {OBJECT("linux-vdso.so.1", call, TEXT), false, true, false},
        {OBJECT("/lib/libasan.so.8", call, TEXT), false, true, false},
        {OBJECT("/lib/libtsan.so.2", call, TEXT), false, true, false},
        {OBJECT("/lib/liblsan.so.0", call, TEXT), false, true, false},
        {OBJECT("/lib/libubsan.so.1", call, TEXT), false, true, false},
        {OBJECT("/lib/libectwin-virtual.so", call, TEXT), false, false, false},
        {OBJECT("", call, TEXT), false, false, true},
        {OBJECT("/lib/libc.so.6/program", call, TEXT), false, false, true},
        {OBJECT("/bin/program", no_call, TEXT), false, false, false},
        {OBJECT("/bin/program", call, PF_R), false, false, false},
        {OBJECT("/bin/program", call, PF_X), false, false, false},
        {{"/bin/program", call, sizeof call, TEXT, PT_NOTE}, false, false, false},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const uintptr_t at = (uintptr_t)rows[i].object.text;
        const ect_objects_t its = search(&rows[i].object, 1);
        assert_int_equal(its.adds, 7);
        assert_int_equal(its.c_library.begin == at && its.c_library.end == at + sizeof call, rows[i].is_library);
        assert_int_equal(its.passed_count, rows[i].passes);
        if (rows[i].passes)
            assert_true(its.passed[0].begin == at && its.passed[0].end == at + sizeof call);
        assert_int_equal(its.has_calls, rows[i].has_calls);
    }
}

static void keeps_the_calls_that_it_found(void **state)
{
    static const object_t objects[] = {OBJECT("a", no_call, TEXT), OBJECT("b", call, TEXT), OBJECT("c", no_call, TEXT)};
    (void)state;
    ect_objects_t its = search(objects, 3);
    assert_true(its.has_calls);
    loaded = objects;
    loaded_count = 1;
    loads = 8;
    ect_objects_search(&its);
    loaded = NULL;
    assert_true(its.has_calls);
    assert_int_equal(its.adds, 8);
}

static void passes_up_to_sixteen_texts(void **state)
{
    static object_t objects[ECT_TEXTS_MOST + 2];
    (void)state;
    for (size_t i = 0; i < ECT_TEXTS_MOST + 2; i++)
        objects[i] = (object_t)OBJECT("ld-linux", call, TEXT);
    const ect_objects_t its = search(objects, ECT_TEXTS_MOST + 2);
    assert_int_equal(its.passed_count, ECT_TEXTS_MOST);
    assert_false(its.has_calls);
}

/* This program, its C library and the dynamic linker. */
static void searches_the_objects_of_a_process(void **state)
{
    ect_objects_t objects = {0};
    (void)state;
    ect_objects_search(&objects);
    assert_true(objects.c_library.end > objects.c_library.begin);
    assert_true(objects.passed_count >= 1);
    assert_true(ect_objects_pass(&objects, (const void *)objects.passed[0].begin));
    assert_false(ect_objects_pass(&objects, (const void *)objects.c_library.begin));
    unsigned long long adds = objects.adds;
    objects.passed_count = 0;
    ect_objects_search(&objects); /* nothing new: nothing is searched */
    assert_int_equal(objects.passed_count, 0);
    assert_int_equal(objects.adds, adds);
}

/* The address behind a call is that of its return: the end of a text is one. */
static void calls_of_each_text_pass(void **state)
{
    static const ect_objects_t objects = {.passed = {{100, 200}, {300, 400}, {500, 600}}, .passed_count = 2};
    static const struct {
        uintptr_t address;
        bool passes;
    } rows[] = {{99, false}, {100, true}, {200, true},  {201, false}, {299, false},
                {300, true}, {400, true}, {401, false}, {550, false}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        if (ect_objects_pass(&objects, (const void *)rows[i].address) != rows[i].passes)
            fail_msg("address %u", (unsigned int)rows[i].address);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"A system call is an instruction behind one that loads its number", finds_calls, NULL, NULL, NULL},
        {"The number is loaded at most 64 bytes before the call", the_number_is_near, NULL, NULL, NULL},
        {"A call passes whose address is in a text of the system, or just behind it", calls_of_each_text_pass, NULL,
         NULL, NULL},
        {"An object is known by the begin of its name; only a text that can be read is searched", knows_objects_by_name,
         NULL, NULL, NULL},
        {"A process has calls for ever", keeps_the_calls_that_it_found, NULL, NULL, NULL},
        {"Up to 16 texts pass", passes_up_to_sixteen_texts, NULL, NULL, NULL},
        {"A process has a C library and a dynamic linker; the same objects are searched once",
         searches_the_objects_of_a_process, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
