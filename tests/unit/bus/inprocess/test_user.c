/* SPDX-License-Identifier: MIT */
/* Copies that end at a bad address, with real faults. */
#define _GNU_SOURCE
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <sys/mman.h>
#include <ucontext.h>
#include <unistd.h>

#include <cmocka.h>

#include "bus/inprocess/actions.h"
#include "bus/inprocess/user.h"

/* Of user.c. */
extern const char ect_user_copy[], ect_user_failed[];

static ect_action_t *handlers[2]; /* of SIGSEGV, SIGBUS */
static struct {
    unsigned int count;
    int number, code;
} own; /* signals of the program */
static sigjmp_buf after_own;

/* --- the rest of the room, before main() -----------------------------------------------------------------------------
 */

static int install(int number, ect_action_t *handler)
{
    const struct sigaction action = {.sa_sigaction = handler, .sa_flags = SA_SIGINFO};
    return sigaction(number, &action, NULL);
}

int ect_action_take(int number, ect_action_t *handler, ect_manner_t manner)
{
    bool known = manner == ECT_AS_PROGRAM && (number == SIGSEGV || number == SIGBUS);
    if (known)
        handlers[number == SIGBUS] = handler;
    return known ? 0 : -1;
}

void ect_action_run(int number, siginfo_t *info, void *context)
{
    own.count += context != NULL;
    own.number = number;
    own.code = info->si_code;
    if (info->si_code > 0)
        siglongjmp(after_own, 1);
}

/* --- tests
 * ------------------------------------------------------------------------------------------------------------
 */

/* CMocka sets handlers of its own before each test. */
static void take_signals(void)
{
    memset(&own, 0, sizeof own);
    assert_int_equal(install(SIGSEGV, handlers[0]) + install(SIGBUS, handlers[1]), 0);
}

enum { LONGEST = 200, PAGES = 2 };

/* @return the end of accessible memory */
static uint8_t *map_end(int protection)
{
    const size_t page = (size_t)sysconf(_SC_PAGESIZE);
    uint8_t *pages = mmap(NULL, PAGES * page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    assert_true(pages != MAP_FAILED);
    for (size_t i = 0; i < page; i++)
        pages[i] = (uint8_t)(i * 7 + 1);
    assert_int_equal(mprotect(pages + page, page, protection), 0);
    return pages + page;
}

static void reads_up_to_the_end_of_memory(void **state)
{
    uint8_t got[LONGEST + 1];
    const uint8_t *end = map_end(PROT_NONE);
    (void)state;
    take_signals();
    for (size_t length = 0; length <= LONGEST; length++) {
        for (size_t missing = 0; missing <= length; missing++) {
            const uint8_t *from = end - length + missing;
            memset(got, 0xEE, sizeof got);
            assert_int_equal(ect_user_read(got, from, length), missing == 0);
            if (missing == 0)
                assert_memory_equal(got, from, length);
            assert_int_equal(got[length], 0xEE);
        }
    }
    assert_int_equal(own.count, 0);
}

static void writes_up_to_the_end_of_memory(void **state)
{
    static const int protections[] = {PROT_NONE, PROT_READ};
    uint8_t given[LONGEST];
    (void)state;
    take_signals();
    for (size_t i = 0; i < LONGEST; i++)
        given[i] = (uint8_t)(i * 3 + 2);
    for (size_t i = 0; i < 2; i++) {
        uint8_t *end = map_end(protections[i]);
        for (size_t length = 0; length <= LONGEST; length++) {
            for (size_t missing = 0; missing <= length; missing++) {
                uint8_t *to = end - length + missing;
                to[-1] = 0xEE;
                assert_int_equal(ect_user_write(to, given, length), missing == 0);
                if (missing == 0)
                    assert_memory_equal(to, given, length);
                assert_int_equal(to[-1], 0xEE);
            }
        }
    }
    assert_int_equal(own.count, 0);
}

static void refuses_addresses_of_every_kind(void **state)
{
    int file = memfd_create("empty", 0);
    uint8_t *behind = mmap(NULL, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    void *const addresses[] = {NULL, (void *)16, (void *)(uintptr_t)0x4141414141414141ull, (void *)UINTPTR_MAX, behind};
    uint8_t word[8] = {0};
    (void)state;
    take_signals();
    assert_true(behind != MAP_FAILED);
    for (size_t i = 0; i < sizeof addresses / sizeof addresses[0]; i++) {
        void *volatile at = addresses[i];
        assert_false(ect_user_read(word, at, sizeof word));
        assert_false(ect_user_write(at, word, sizeof word));
        assert_true(ect_user_read(word, at, 0));
        assert_true(ect_user_write(at, word, 0));
    }
    assert_int_equal(own.count, 0);
    close(file);
}

static void reads_strings(void **state)
{
    char got[8];
    char *end = (char *)map_end(PROT_NONE);
    (void)state;
    take_signals();
    memcpy(end - 5, "text", 5);
    assert_true(ect_user_string(got, end - 5, sizeof got));
    assert_string_equal(got, "text");
    assert_true(ect_user_string(got, end - 5, 5));
    assert_false(ect_user_string(got, end - 5, 4)); /* no room for its end */
    end[-1] = 't';
    assert_false(ect_user_string(got, end - 5, sizeof got)); /* no end in the memory */
}

static void leaves_other_faults_to_the_program(void **state)
{
    const uint8_t *end = map_end(PROT_NONE);
    (void)state;
    take_signals();
    if (sigsetjmp(after_own, 1) == 0)
        (void)*(const volatile uint8_t *)end;
    assert_int_equal(own.count, 1);
    assert_int_equal(own.number, SIGSEGV);
    assert_int_equal(own.code, SEGV_ACCERR);
    assert_int_equal(raise(SIGBUS), 0);
    assert_int_equal(own.count, 2);
    assert_int_equal(own.number, SIGBUS);
    assert_int_equal(own.code, SI_TKILL);
}

#if defined __x86_64__
#define PLACE(context) ((context)->uc_mcontext.gregs[REG_RIP])
#else
#define PLACE(context) ((context)->uc_mcontext.pc)
#endif

static void handle(siginfo_t *info, ucontext_t *context)
{
    if (sigsetjmp(after_own, 1) == 0)
        handlers[0](SIGSEGV, info, context);
}

/* Only the kernel ends a copy: a signal that is sent meanwhile is the program's. */
static void ends_a_copy_at_its_instructions(void **state)
{
    const uintptr_t begin_of = (uintptr_t)ect_user_copy, end = (uintptr_t)ect_user_failed;
    const struct {
        uintptr_t place;
        int code;
        bool ends;
    } rows[] = {{begin_of, SEGV_MAPERR, true}, {end - 1, SEGV_ACCERR, true},   {begin_of - 1, SEGV_MAPERR, false},
                {end, SEGV_MAPERR, false},     {begin_of, SI_USER, false},     {begin_of + 4, SI_QUEUE, false},
                {begin_of, SI_KERNEL, true},   {begin_of + 4, SI_TKILL, false}};
    (void)state;
    take_signals();
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ucontext_t context;
        siginfo_t info = {.si_code = rows[i].code};
        memset(&context, 0, sizeof context);
        memset(&own, 0, sizeof own);
        PLACE(&context) = (__typeof__(PLACE(&context)))rows[i].place;
        handle(&info, &context);
        assert_int_equal(own.count, !rows[i].ends);
        assert_int_equal((uintptr_t)PLACE(&context), rows[i].ends ? end : rows[i].place);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"A read ends at the first byte that is not there", reads_up_to_the_end_of_memory, NULL, NULL, NULL},
        {"A write ends at the first byte that is not there, or read-only", writes_up_to_the_end_of_memory, NULL, NULL,
         NULL},
        {"A bad address of any kind is refused, except for a length of 0", refuses_addresses_of_every_kind, NULL, NULL,
         NULL},
        {"A string has an end, in the memory and in the room", reads_strings, NULL, NULL, NULL},
        {"Another fault, and a signal that was sent, are the program's", leaves_other_faults_to_the_program, NULL, NULL,
         NULL},
        {"A fault of the copying instructions ends the copy", ends_a_copy_at_its_instructions, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
