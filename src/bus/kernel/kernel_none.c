/* SPDX-License-Identifier: MIT */
/* For a build without libbpf, clang or bpftool. */
#include <stdio.h>

#include "bus/kernel/kernel.h"

ect_kernel_t *ect_kernel_load(char *message)
{
    snprintf(
        message, ECT_KERNEL_MESSAGE,
        "--in-kernel is not in this build: 'tools/bootstrap.sh kernel' installs what it needs, then build again; or "
        "leave the option out");
    return NULL;
}

int ect_kernel_attach(ect_kernel_t *kernel, unsigned int index, char *message)
{
    (void)kernel;
    (void)index;
    (void)message;
    return -1;
}

const char *ect_kernel_hook(const ect_kernel_t *kernel)
{
    (void)kernel;
    return NULL;
}

void ect_kernel_close(ect_kernel_t *kernel)
{
    (void)kernel;
}

int ect_kernel_fd(const ect_kernel_t *kernel)
{
    (void)kernel;
    return -1;
}

void ect_kernel_see(ect_kernel_t *kernel, const uint8_t *frame, size_t length)
{
    (void)kernel;
    (void)frame;
    (void)length;
}

void ect_kernel_got(ect_kernel_t *kernel)
{
    (void)kernel;
}

unsigned int ect_kernel_give(ect_kernel_t *kernel, ect_chain_t *chain, uint64_t now_ns)
{
    (void)kernel;
    (void)chain;
    (void)now_ns;
    return 0;
}

void ect_kernel_take(ect_kernel_t *kernel)
{
    (void)kernel;
}

ect_held_t *ect_kernel_next(ect_kernel_t *kernel)
{
    (void)kernel;
    return NULL;
}

bool ect_kernel_try(ect_kernel_t *kernel, uint8_t *frame, size_t length)
{
    (void)kernel;
    (void)frame;
    (void)length;
    return false;
}
