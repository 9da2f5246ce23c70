/* SPDX-License-Identifier: MIT */
/* The search for the instruction that makes a system call. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

/* CMocka needs the headers above. */
#include <cmocka.h>

#include "bus/inprocess/raw_objects.h"

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
        {"A process has a C library and a dynamic linker; the same objects are searched once",
         searches_the_objects_of_a_process, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
