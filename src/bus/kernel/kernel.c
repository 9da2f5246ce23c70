/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/kernel/kernel.h"

#include <bpf/bpf.h>
#include <bpf/libbpf.h>
#include <errno.h>
#include <linux/bpf.h>
#include <linux/ethtool.h>
#include <linux/if_link.h>
#include <linux/sockios.h>
#include <net/if.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include <answer.skel.h>

/* A frame that has not arrived after this time counts as lost on its way to the socket. */
enum { LOST_NS = 20000000 };

struct ect_kernel {
    struct answer *program;
    int link_fd;        /* 0: attached by netlink, or not attached */
    uint32_t mode;      /* of the attached program: XDP_FLAGS_DRV_MODE or XDP_FLAGS_SKB_MODE; 0: not attached */
    unsigned int index; /* of the interface, if attached by netlink; else 0 */
    ect_shared_t *shared;
    ect_held_t *held;
    struct ring_buffer *bell;
    ect_planner_t planner;
    ect_chain_t *chain; /* observed; NULL: none yet */
    uint64_t next;      /* of the held frames */
    uint64_t got;       /* frames that the socket has returned */
    uint64_t short_ns;  /* frames have been on their way since this time; 0: none */
    uint64_t still_ns;  /* outputs count as changing until this time */
    bool given;         /* the kernel has the turn */
    unsigned int plans;
};

static int no_message(enum libbpf_print_level level, const char *format, va_list arguments)
{
    (void)level;
    (void)format;
    (void)arguments;
    return 0;
}

static int ignore(void *ctx, void *data, size_t size)
{
    (void)ctx;
    (void)data;
    (void)size;
    return 0;
}

static size_t plans_size(void)
{
    return sizeof(ect_plan_table_t);
}

static size_t held_size(void)
{
    return (size_t)ECT_HELD_FRAMES * sizeof(ect_held_t);
}

/* Maps the memory shared with the kernel. @return NULL: failed */
static void *map(const struct bpf_map *map, size_t size)
{
    void *memory = mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_SHARED, bpf_map__fd(map), 0);
    return memory == MAP_FAILED ? NULL : memory;
}

static bool map_all(ect_kernel_t *k)
{
    k->shared = map(k->program->maps.shared, sizeof *k->shared);
    k->planner.table = map(k->program->maps.plans, plans_size());
    k->held = map(k->program->maps.held, held_size());
    k->bell = ring_buffer__new(bpf_map__fd(k->program->maps.bell), ignore, NULL, NULL);
    return k->shared && k->planner.table && k->held && k->bell;
}

static void explain(int error, char *message)
{
    const char *cure = "its kernel must be Linux 5.18 or newer with BPF; leave the option out elsewhere";
    if (error == EPERM || error == EACCES)
        cure = "it needs the rights CAP_BPF and CAP_NET_ADMIN: run it with sudo, outside a user namespace";
    snprintf(message, ECT_KERNEL_MESSAGE, "--in-kernel: loading the program into the kernel failed (%s); %s",
             strerror(error), cure);
}

ect_kernel_t *ect_kernel_load(char *message)
{
    ect_kernel_t *k = calloc(1, sizeof *k);
    (void)libbpf_set_print(no_message);
    errno = ENOMEM;
    if (k)
        k->program = answer__open_and_load();
    if (k && k->program && map_all(k)) {
        ect_turn_take(&k->shared->turn);
        return k;
    }
    explain(errno, message);
    ect_kernel_close(k);
    return NULL;
}

/* Queries the driver. @return whether the driver supports the query */
static bool ask_driver(unsigned int index, void *question)
{
    struct ifreq request = {.ifr_data = question};
    int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    bool done = fd >= 0 && if_indextoname(index, request.ifr_name) && ioctl(fd, SIOCETHTOOL, &request) == 0;
    if (fd >= 0)
        close(fd);
    return done;
}

/*
 * @return whether the hook in the driver is usable. A driver that removes VLAN tags hides them from this hook, so the
 * reply would have no tag. A veth transmits from its native hook only if its peer has a program too.
 */
static bool may_be_native(unsigned int index)
{
    struct ethtool_value flags = {.cmd = ETHTOOL_GFLAGS};
    struct ethtool_drvinfo driver = {.cmd = ETHTOOL_GDRVINFO};
    return ask_driver(index, &flags) && (flags.data & ETH_FLAG_RXVLAN) == 0 && ask_driver(index, &driver) &&
           strcmp(driver.driver, "veth") != 0;
}

/* Attaches by a link, which ends with the process; else by netlink: a process in a user namespace may not create a
 * link, but its interface ends with the namespace. @return 0, or a negative error */
static int attach(ect_kernel_t *k, unsigned int index, uint32_t mode)
{
    const int program = bpf_program__fd(k->program->progs.answer);
    LIBBPF_OPTS(bpf_link_create_opts, options, .flags = mode);
    int link = bpf_link_create(program, (int)index, BPF_XDP, &options);
    int error = link >= 0 ? 0 : bpf_xdp_attach((int)index, program, mode | XDP_FLAGS_UPDATE_IF_NOEXIST, NULL);
    if (error != 0)
        return error;
    k->mode = mode;
    if (link >= 0)
        k->link_fd = link;
    else
        k->index = index;
    return 0;
}

int ect_kernel_attach(ect_kernel_t *k, unsigned int index, char *message)
{
    if (may_be_native(index) && attach(k, index, XDP_FLAGS_DRV_MODE) == 0)
        return 0;
    int error = attach(k, index, XDP_FLAGS_SKB_MODE);
    if (error == 0)
        return 0;
    const bool taken = error == -EBUSY || error == -EEXIST;
    snprintf(message, ECT_KERNEL_MESSAGE, "--in-kernel: the interface does not take the program (%s)%s",
             strerror(-error), taken ? "; another one is attached: 'ip link set dev IFACE xdp off' removes it" : "");
    return -1;
}

const char *ect_kernel_hook(const ect_kernel_t *k)
{
    return k->mode == 0 ? NULL : k->mode == XDP_FLAGS_DRV_MODE ? "native" : "generic";
}

void ect_kernel_close(ect_kernel_t *k)
{
    if (!k)
        return;
    if (k->chain)
        ect_chain_observe(k->chain, ECT_CHAIN_PLANS, NULL, NULL);
    free(k->planner.places);
    if (k->link_fd > 0)
        close(k->link_fd);
    if (k->index != 0)
        (void)bpf_xdp_detach((int)k->index, k->mode, NULL);
    ring_buffer__free(k->bell);
    if (k->shared)
        (void)munmap(k->shared, sizeof *k->shared);
    if (k->planner.table)
        (void)munmap(k->planner.table, plans_size());
    if (k->held)
        (void)munmap(k->held, held_size());
    answer__destroy(k->program);
    free(k);
}

int ect_kernel_fd(const ect_kernel_t *k)
{
    return bpf_map__fd(k->program->maps.bell);
}

void ect_kernel_see(ect_kernel_t *k, const uint8_t *frame, size_t length)
{
    ect_planner_see(&k->planner, frame, length);
}

void ect_kernel_got(ect_kernel_t *k)
{
    k->got++;
    k->short_ns = 0;
}

/* Frames lost in a full socket, or taken by another program, never arrive. */
static void await_frames(ect_kernel_t *k, uint64_t now_ns)
{
    uint64_t left = ect_turn_left(&k->shared->turn);
    if (left == k->got) {
        k->short_ns = 0;
    } else if (k->short_ns == 0) {
        k->short_ns = now_ns;
    } else if (now_ns - k->short_ns > LOST_NS) {
        k->got = left;
        k->short_ns = 0;
    }
}

/* Called with the turn. */
static void set_pace(ect_kernel_t *k, uint64_t now_ns)
{
    if (k->planner.outputs_changed)
        k->still_ns = now_ns + ECT_PACE_REACTING_NS;
    k->planner.outputs_changed = false;
    k->shared->reacting = now_ns < k->still_ns;
}

static void slave_ran(void *kernel, size_t position, uint64_t now_ns)
{
    ect_kernel_t *k = kernel;
    (void)now_ns;
    ect_planner_ran(&k->planner, position);
}

/* Without memory, images are copied later. */
static void observe(ect_kernel_t *k, ect_chain_t *chain)
{
    k->planner.places = calloc(ect_chain_count(chain), sizeof *k->planner.places);
    if (!k->planner.places)
        return;
    k->chain = chain;
    ect_chain_observe(chain, ECT_CHAIN_PLANS, slave_ran, k);
}

unsigned int ect_kernel_give(ect_kernel_t *k, ect_chain_t *chain, uint64_t now_ns)
{
    if (k->given)
        return k->plans;
    await_frames(k, now_ns);
    if (k->short_ns != 0)
        return k->plans;
    if (!k->planner.places)
        observe(k, chain);
    k->plans = ect_planner_make(&k->planner, chain);
    if (k->plans == 0)
        return 0;
    set_pace(k, now_ns);
    k->given = ect_turn_give(&k->shared->turn, k->got);
    return k->plans;
}

void ect_kernel_take(ect_kernel_t *k)
{
    if (!k->given)
        return;
    k->given = false;
    ect_turn_take(&k->shared->turn);
    (void)ring_buffer__consume(k->bell);
    ect_planner_void(&k->planner);
}

ect_held_t *ect_kernel_next(ect_kernel_t *k)
{
    if (k->given)
        return NULL;
    if (k->next < k->shared->held) {
        ect_held_t *held = &k->held[k->next++];
        ect_planner_see(&k->planner, held->frame, held->length);
        return held;
    }
    k->next = k->shared->held = 0;
    return NULL;
}

bool ect_kernel_try(ect_kernel_t *k, uint8_t *frame, size_t length)
{
    LIBBPF_OPTS(bpf_test_run_opts, run, .data_in = frame, .data_size_in = (uint32_t)length, .data_out = frame,
                .data_size_out = (uint32_t)length, .repeat = 1);
    return bpf_prog_test_run_opts(bpf_program__fd(k->program->progs.answer), &run) == 0 && run.retval == XDP_TX;
}
