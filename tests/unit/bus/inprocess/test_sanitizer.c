/* SPDX-License-Identifier: MIT */
/* The code of a sanitizer among the loaded objects, which are the test's. */
#define _GNU_SOURCE
#include <link.h>
#include <sys/wait.h>
#include <unistd.h>

#include "bus/inprocess/sanitizer.h"
#include "fakes.h"

static const char *name; /* of the second object */
static unsigned int searches;

int fake_dl_iterate_phdr(int (*use)(struct dl_phdr_info *info, size_t size, void *ctx), void *ctx)
{
    static const ElfW(Phdr) parts[] = {{.p_type = PT_LOAD, .p_flags = PF_R, .p_vaddr = 0, .p_memsz = 100},
                                       {.p_type = PT_LOAD, .p_flags = PF_R | PF_X, .p_vaddr = 200, .p_memsz = 50},
                                       {.p_type = PT_DYNAMIC, .p_flags = PF_X, .p_vaddr = 300, .p_memsz = 50},
                                       {.p_type = PT_LOAD, .p_flags = PF_R, .p_vaddr = 400, .p_memsz = 50}};
    const char *names[] = {"/lib/libc.so.6", name, "/lib/libm.so.6"};
    searches++;
    for (size_t i = 0; i < 3; i++) {
        struct dl_phdr_info info = {.dlpi_addr = 1000 * i, .dlpi_name = names[i], .dlpi_phdr = parts, .dlpi_phnum = 4};
        int result = use(&info, sizeof info, ctx);
        if (result != 0)
            return result;
    }
    return 0;
}

/* Runs in a child, because a process searches its objects only once. */
static bool is_found(const char *its)
{
    int status = -1;
    pid_t child = fork();
    if (child == 0) {
        name = its;
        bool good = ect_sanitizer_is_loaded() && ect_sanitizer_is_loaded() && searches == 1 &&
                    !ect_sanitizer_has((const void *)1199) && ect_sanitizer_has((const void *)1200) &&
                    ect_sanitizer_has((const void *)1249) && !ect_sanitizer_has((const void *)1250);
        _exit(good ? 0 : 1);
    }
    assert_int_equal(waitpid(child, &status, 0), child);
    return status == 0;
}

static void finds_sanitizers(void **state)
{
    (void)state;
    assert_true(is_found("/usr/lib/libasan.so.8"));
    assert_true(is_found("/usr/lib/libtsan.so.2"));
    assert_true(is_found("/usr/lib/liblsan.so.0"));
    assert_false(is_found("/usr/lib/libubsan.so.1"));
}

static void finds_none(void **state)
{
    (void)state;
    name = "/lib/libz.so.1";
    assert_false(ect_sanitizer_is_loaded());
    assert_false(ect_sanitizer_has((const void *)1200));
    assert_false(ect_sanitizer_has(NULL));
    assert_int_equal(searches, 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST("The code of a sanitizer is its executable part", finds_sanitizers),
        TEST("A process without a sanitizer has no such code", finds_none),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
