/* SPDX-License-Identifier: MIT */
/*
 * The process's side of replies in the kernel (bus/kernel/kernel.h), without a kernel: libbpf, the driver and the
 * shared memory are the test's. test_kernel runs the program itself.
 */
#define _GNU_SOURCE
#include "bus/kernel/kernel.h"

#include <bpf/bpf.h>
#include <bpf/libbpf.h>
#include <errno.h>
#include <limits.h>
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

#include "support/testdev.h"
#include "support/wire.h"

enum { SHARED, PLANS, HELD, BELL, MAPS };
enum { FIRST_FD = 1000, PROGRAM_FD = 1010, LINK_FD = 1020, SOCKET_FD = 1030, INDEX = 7 };

static const char *const map_names[MAPS] = {"shared", "plans", "held", "bell"};

/* The results of the fakes, and the calls that they have got. */
static struct {
    int open_error, load_error; /* of the program */
    int bad_map;                /* the one that cannot be mapped or made a ring; MAPS: none */
    unsigned int callocs_left;
    const char *driver; /* NULL: ioctl() fails */
    uint32_t flags;     /* of the driver */
    bool bad_socket, bad_name;
    int native, generic, netlink; /* results of attaching */
    unsigned int consumed, links, linked_by_netlink, closed_links, closed_sockets, detached;
    uint32_t flags_of_netlink, mode_of_detach;
    void *memory[MAPS];
    int test_run, verdict;
} fake;

static void reset(void)
{
    memset(&fake, 0, sizeof fake);
    fake.bad_map = MAPS;
    fake.callocs_left = UINT_MAX;
    fake.native = fake.generic = LINK_FD;
    fake.driver = "virtual";
}

/* --- the fakes ---------------------------------------------------------------------------------------------------- */

/* A map is the number of its descriptor. */
static int map_fds[MAPS] = {FIRST_FD, FIRST_FD + 1, FIRST_FD + 2, FIRST_FD + 3};

int __wrap_bpf_object__open_skeleton(struct bpf_object_skeleton *s, const struct bpf_object_open_opts *opts);
int __wrap_bpf_object__load_skeleton(struct bpf_object_skeleton *s);
void __wrap_bpf_object__destroy_skeleton(struct bpf_object_skeleton *s);
int __wrap_bpf_map__fd(const struct bpf_map *map);
int __wrap_bpf_program__fd(const struct bpf_program *program);
struct ring_buffer *__wrap_ring_buffer__new(int fd, ring_buffer_sample_fn sample, void *ctx,
                                            const struct ring_buffer_opts *opts);
int __wrap_ring_buffer__consume(struct ring_buffer *ring);
void __wrap_ring_buffer__free(struct ring_buffer *ring);
int __wrap_bpf_link_create(int program, int target, enum bpf_attach_type type, const struct bpf_link_create_opts *opts);
int __wrap_bpf_xdp_attach(int index, int program, uint32_t flags, const struct bpf_xdp_attach_opts *opts);
int __wrap_bpf_xdp_detach(int index, uint32_t flags, const struct bpf_xdp_attach_opts *opts);
int __wrap_bpf_prog_test_run_opts(int program, struct bpf_test_run_opts *opts);
void *__real_mmap(void *at, size_t size, int protection, int flags, int fd, off_t offset);
void *__wrap_mmap(void *at, size_t size, int protection, int flags, int fd, off_t offset);
int __real_munmap(void *at, size_t size);
int __wrap_munmap(void *at, size_t size);
int __real_socket(int domain, int type, int protocol);
int __wrap_socket(int domain, int type, int protocol);
int __wrap_ioctl(int fd, unsigned long request, ...);
char *__wrap_if_indextoname(unsigned int index, char *name);
int __real_close(int fd);
int __wrap_close(int fd);
void *__real_calloc(size_t count, size_t size);
void *__wrap_calloc(size_t count, size_t size);

void *__wrap_calloc(size_t count, size_t size)
{
    return fake.callocs_left == 0 || fake.callocs_left-- == 0 ? NULL : __real_calloc(count, size);
}

int __wrap_bpf_object__open_skeleton(struct bpf_object_skeleton *s, const struct bpf_object_open_opts *opts)
{
    (void)opts;
    for (int i = 0; i < s->map_cnt; i++) {
        char *at = (char *)s->maps + (size_t)i * (size_t)s->map_skel_sz;
        const struct bpf_map_skeleton *map = (const struct bpf_map_skeleton *)(const void *)at;
        for (unsigned int m = 0; m < MAPS; m++) {
            if (strcmp(map->name, map_names[m]) == 0)
                *map->map = (struct bpf_map *)(void *)&map_fds[m];
        }
    }
    return fake.open_error;
}

int __wrap_bpf_object__load_skeleton(struct bpf_object_skeleton *s)
{
    (void)s;
    return fake.load_error;
}

void __wrap_bpf_object__destroy_skeleton(struct bpf_object_skeleton *s)
{
    if (!s)
        return;
    free(s->maps);
    free(s->progs);
    free(s);
}

int __wrap_bpf_map__fd(const struct bpf_map *map)
{
    return *(const int *)(const void *)map;
}

int __wrap_bpf_program__fd(const struct bpf_program *program)
{
    (void)program;
    return PROGRAM_FD;
}

struct ring_buffer *__wrap_ring_buffer__new(int fd, ring_buffer_sample_fn sample, void *ctx,
                                            const struct ring_buffer_opts *opts)
{
    (void)ctx;
    (void)opts;
    assert_int_equal(fd, FIRST_FD + BELL);
    assert_int_equal(sample(NULL, NULL, 0), 0); /* another value would end the consumption */
    if (fake.bad_map == BELL)
        errno = EINVAL;
    return fake.bad_map == BELL ? NULL : malloc(1);
}

int __wrap_ring_buffer__consume(struct ring_buffer *ring)
{
    assert_non_null(ring);
    fake.consumed++;
    return 0;
}

void __wrap_ring_buffer__free(struct ring_buffer *ring)
{
    free(ring);
}

void *__wrap_mmap(void *at, size_t size, int protection, int flags, int fd, off_t offset)
{
    if (fd < FIRST_FD || fd >= FIRST_FD + MAPS)
        return __real_mmap(at, size, protection, flags, fd, offset);
    assert_int_equal(protection, PROT_READ | PROT_WRITE);
    assert_int_equal(flags, MAP_SHARED);
    assert_int_equal(offset, 0);
    if (fd == FIRST_FD + fake.bad_map) {
        errno = EINVAL;
        return MAP_FAILED;
    }
    fake.memory[fd - FIRST_FD] = __real_calloc(1, size);
    return fake.memory[fd - FIRST_FD];
}

int __wrap_munmap(void *at, size_t size)
{
    static const size_t sizes[MAPS] = {sizeof(ect_shared_t), sizeof(ect_plan_table_t),
                                       ECT_HELD_FRAMES * sizeof(ect_held_t), 0};
    for (unsigned int i = 0; i < MAPS; i++) {
        if (at == fake.memory[i]) {
            assert_int_equal(size, sizes[i]);
            fake.memory[i] = NULL;
            free(at);
            return 0;
        }
    }
    return __real_munmap(at, size);
}

int __wrap_socket(int domain, int type, int protocol)
{
    (void)domain;
    (void)type;
    (void)protocol;
    return fake.bad_socket ? -1 : SOCKET_FD;
}

char *__wrap_if_indextoname(unsigned int index, char *name)
{
    assert_int_equal(index, INDEX);
    return fake.bad_name ? NULL : strcpy(name, "eth7");
}

int __wrap_ioctl(int fd, unsigned long request, ...)
{
    va_list arguments;
    va_start(arguments, request);
    struct ifreq *of = va_arg(arguments, struct ifreq *);
    va_end(arguments);
    void *data = of->ifr_data;
    assert_int_equal(fd, SOCKET_FD);
    assert_int_equal(request, SIOCETHTOOL);
    assert_string_equal(of->ifr_name, "eth7");
    if (!fake.driver)
        return -1;
    if (*(const uint32_t *)data == ETHTOOL_GFLAGS)
        ((struct ethtool_value *)data)->data = fake.flags;
    else
        strcpy(((struct ethtool_drvinfo *)data)->driver, fake.driver);
    return 0;
}

int __wrap_close(int fd)
{
    assert_int_not_equal(fd, 0); /* standard input: no link, no socket */
    fake.closed_sockets += fd == SOCKET_FD;
    fake.closed_links += fd == LINK_FD;
    return fd == SOCKET_FD || fd == LINK_FD ? 0 : __real_close(fd);
}

int __wrap_bpf_link_create(int program, int target, enum bpf_attach_type type, const struct bpf_link_create_opts *opts)
{
    assert_int_equal(program, PROGRAM_FD);
    assert_int_equal(target, INDEX);
    assert_int_equal(type, BPF_XDP);
    fake.links++;
    return opts->flags == XDP_FLAGS_DRV_MODE ? fake.native : fake.generic;
}

int __wrap_bpf_xdp_attach(int index, int program, uint32_t flags, const struct bpf_xdp_attach_opts *opts)
{
    (void)opts;
    assert_int_equal(index, INDEX);
    assert_int_equal(program, PROGRAM_FD);
    fake.linked_by_netlink++;
    fake.flags_of_netlink = flags;
    return fake.netlink;
}

int __wrap_bpf_xdp_detach(int index, uint32_t flags, const struct bpf_xdp_attach_opts *opts)
{
    (void)opts;
    assert_int_equal(index, INDEX);
    fake.detached++;
    fake.mode_of_detach = flags;
    return 0;
}

int __wrap_bpf_prog_test_run_opts(int program, struct bpf_test_run_opts *opts)
{
    assert_int_equal(program, PROGRAM_FD);
    assert_ptr_equal(opts->data_in, opts->data_out);
    assert_int_equal(opts->data_size_in, opts->data_size_out);
    ((uint8_t *)opts->data_out)[0] = (uint8_t)opts->data_size_in;
    opts->retval = (uint32_t)fake.verdict;
    return fake.test_run;
}

/* --- load --------------------------------------------------------------------------------------------------------- */

static ect_kernel_t *load(void)
{
    char message[ECT_KERNEL_MESSAGE];
    ect_kernel_t *k = ect_kernel_load(message);
    if (!k)
        fail_msg("%s", message);
    return k;
}

static ect_shared_t *shared(void)
{
    return fake.memory[SHARED];
}

static ect_held_t *held(void)
{
    return fake.memory[HELD];
}

static void a_loaded_program_has_its_maps_and_leaves_the_turn_to_the_process(void **state)
{
    (void)state;
    reset();
    ect_kernel_t *k = load();
    assert_int_equal(ect_kernel_fd(k), FIRST_FD + BELL);
    assert_int_equal(shared()->turn.word, ECT_TURN_PROGRAM);
    assert_null(ect_kernel_hook(k));
    ect_kernel_close(k);
    for (unsigned int i = 0; i < MAPS; i++)
        assert_null(fake.memory[i]);
    assert_int_equal(fake.closed_links + fake.detached, 0);
}

/* A sanitizer reports what a failure leaves behind. */
static void a_failure_to_load_names_its_cause_and_the_cure(void **state)
{
    static const char rights[] =
        "it needs the rights CAP_BPF and CAP_NET_ADMIN: run it with sudo, outside a user namespace";
    static const char version[] = "its kernel must be Linux 5.18 or newer with BPF; leave the option out elsewhere";
    static const struct {
        int open_error, load_error, bad_map;
        int cause;
        const char *cure;
    } rows[] = {
        {-ENOENT, 0, MAPS, ENOENT, version}, {0, -EPERM, MAPS, EPERM, rights}, {0, -EACCES, MAPS, EACCES, rights},
        {0, -EINVAL, MAPS, EINVAL, version}, {0, 0, SHARED, EINVAL, version},  {0, 0, PLANS, EINVAL, version},
        {0, 0, HELD, EINVAL, version},       {0, 0, BELL, EINVAL, version},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char message[ECT_KERNEL_MESSAGE], want[ECT_KERNEL_MESSAGE];
        reset();
        fake.open_error = rows[i].open_error;
        fake.load_error = rows[i].load_error;
        fake.bad_map = rows[i].bad_map;
        snprintf(want, sizeof want, "--in-kernel: loading the program into the kernel failed (%s); %s",
                 strerror(rows[i].cause), rows[i].cure);
        assert_null(ect_kernel_load(message));
        assert_string_equal(message, want);
        for (unsigned int m = 0; m < MAPS; m++)
            assert_null(fake.memory[m]);
    }
    ect_kernel_close(NULL);
}

static void a_lack_of_memory_is_a_failure_to_load(void **state)
{
    unsigned int failed = 0;
    ect_kernel_t *k = NULL;
    (void)state;
    for (unsigned int left = 0; !k; left++) {
        char message[ECT_KERNEL_MESSAGE] = "";
        reset();
        fake.callocs_left = left;
        k = ect_kernel_load(message);
        failed += !k;
        assert_int_equal(strstr(message, strerror(ENOMEM)) != NULL, !k);
    }
    assert_true(failed >= 2); /* the instance and the program, at least */
    ect_kernel_close(k);
}

/* --- attach ------------------------------------------------------------------------------------------------------- */

static void the_hook_is_in_the_driver_if_it_leaves_tags_and_replies_alone(void **state)
{
    static const struct {
        const char *title, *driver;
        uint32_t flags;
        bool bad_socket, bad_name;
        int native, generic, netlink;
        const char *hook; /* NULL: not attached */
        unsigned int links, by_netlink;
    } rows[] = {
        {"a driver with a hook", "e1000e", 0, false, false, LINK_FD, -1, -1, "native", 1, 0},
        {"other flags", "e1000e", ETH_FLAG_TXVLAN, false, false, LINK_FD, -1, -1, "native", 1, 0},
        {"a driver that takes tags", "e1000e", ETH_FLAG_RXVLAN, false, false, -1, LINK_FD, -1, "generic", 1, 0},
        {"a veth", "veth", 0, false, false, -1, LINK_FD, -1, "generic", 1, 0},
        {"no reply of the driver", NULL, 0, false, false, -1, LINK_FD, -1, "generic", 1, 0},
        {"no socket", "e1000e", 0, true, false, -1, LINK_FD, -1, "generic", 1, 0},
        {"no such interface", "e1000e", 0, false, true, -1, LINK_FD, -1, "generic", 1, 0},
        {"a driver without a hook", "e1000e", 0, false, false, -EOPNOTSUPP, LINK_FD, -1, "generic", 2, 1},
        {"no link, in a user namespace", "veth", 0, false, false, -1, -EPERM, 0, "generic", 1, 1},
        {"no link at a hook in the driver", "e1000e", 0, false, false, -EPERM, -1, 0, "native", 1, 1},
        {"descriptor 0 is a link", "veth", 0, false, false, -1, 0, -1, "generic", 1, 0},
        {"nothing is attached", "veth", 0, false, false, -1, -EPERM, -EPERM, NULL, 1, 1},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char message[ECT_KERNEL_MESSAGE] = "";
        reset();
        fake.driver = rows[i].driver;
        fake.flags = rows[i].flags;
        fake.bad_socket = rows[i].bad_socket;
        fake.bad_name = rows[i].bad_name;
        fake.native = rows[i].native;
        fake.generic = rows[i].generic;
        fake.netlink = rows[i].netlink;
        ect_kernel_t *k = load();
        print_message("%s\n", rows[i].title);
        assert_int_equal(ect_kernel_attach(k, INDEX, message), rows[i].hook ? 0 : -1);
        const char *hook = ect_kernel_hook(k);
        assert_string_equal(hook ? hook : "none", rows[i].hook ? rows[i].hook : "none");
        assert_int_equal(fake.links, rows[i].links);
        assert_int_equal(fake.linked_by_netlink, rows[i].by_netlink);
        const uint32_t mode = hook && strcmp(hook, "native") == 0 ? XDP_FLAGS_DRV_MODE : XDP_FLAGS_SKB_MODE;
        const bool by_netlink = hook && fake.linked_by_netlink == fake.links;
        if (by_netlink)
            assert_int_equal(fake.flags_of_netlink, mode | XDP_FLAGS_UPDATE_IF_NOEXIST);
        assert_int_equal(fake.closed_links, 0);
        ect_kernel_close(k);
        assert_int_equal(fake.closed_sockets, rows[i].bad_socket                       ? 0
                                              : rows[i].bad_name || !rows[i].driver    ? 1
                                              : (rows[i].flags & ETH_FLAG_RXVLAN) != 0 ? 1
                                                                                       : 2);
        assert_int_equal(fake.detached, by_netlink);
        assert_int_equal(fake.mode_of_detach, by_netlink ? mode : 0);
        assert_int_equal(fake.closed_links, hook && !by_netlink && rows[i].generic != 0);
    }
}

static void a_program_in_the_way_is_named_with_the_cure(void **state)
{
    static const char cure[] = "; another one is attached: 'ip link set dev IFACE xdp off' removes it";
    static const struct {
        int error;
        const char *cure;
    } rows[] = {{-EBUSY, cure}, {-EEXIST, cure}, {-ENODEV, ""}, {-EPERM, ""}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char message[ECT_KERNEL_MESSAGE], want[ECT_KERNEL_MESSAGE];
        reset();
        fake.native = fake.generic = -EINVAL;
        fake.netlink = rows[i].error;
        ect_kernel_t *k = load();
        assert_int_equal(ect_kernel_attach(k, INDEX, message), -1);
        snprintf(want, sizeof want, "--in-kernel: the interface does not take the program (%s)%s",
                 strerror(-rows[i].error), rows[i].cure);
        assert_string_equal(message, want);
        assert_null(ect_kernel_hook(k));
        ect_kernel_close(k);
    }
}

/* --- the turn ----------------------------------------------------------------------------------------------------- */

typedef struct rig {
    wire_t w;
    ect_kernel_t *kernel;
} rig_t;

static void open_rig(rig_t *r)
{
    uint8_t status[2] = {0};
    memset(r, 0, sizeof *r);
    reset();
    wire_open_one(&r->w, &testdev);
    wire_go(&r->w, 0, 8);
    wire_set_fmmu(&r->w, 0, 0, 0x100, 3, 0, 7, 0x1200, 0, 2);
    wire_set_fmmu(&r->w, 0, 1, 0x103, 3, 0, 7, 0x1300, 0, 1);
    (void)wire_read16(&r->w, 0, ECT_REG_AL_STATUS);
    (void)wire_send(&r->w, BRD, 0, ECT_REG_AL_STATUS, status, 2);
    r->w.manual_poll = true;
    r->kernel = load();
}

static void close_rig(rig_t *r)
{
    ect_kernel_close(r->kernel);
    wire_close(&r->w);
}

static void build_outputs(rig_t *r, uint8_t output)
{
    const uint8_t data[6] = {output};
    wire_build(&r->w, LRW, 0x100, 0, data, sizeof data);
}

static void see_outputs(rig_t *r, uint8_t output)
{
    build_outputs(r, output);
    ect_kernel_see(r->kernel, r->w.frame, r->w.frame_length);
}

/* Gives the turn, which the process has got if frames are missing. @return whether the kernel has it */
static bool gives(rig_t *r, uint64_t now_ns)
{
    (void)ect_kernel_give(r->kernel, r->w.chain, now_ns);
    return (shared()->turn.word & ECT_TURN_MASK) == ECT_TURN_FREE;
}

/* The kernel leaves a frame to the process. */
static void leave_frame(void)
{
    if (ect_turn_begin(&shared()->turn))
        ect_turn_end(&shared()->turn, true);
}

static void the_kernel_has_the_turn_from_give_to_take(void **state)
{
    static rig_t r;
    (void)state;
    open_rig(&r);
    assert_int_equal(ect_kernel_give(r.kernel, r.w.chain, r.w.now_ns), 0); /* without a plan the process keeps it */
    assert_int_equal(shared()->turn.word, ECT_TURN_PROGRAM);
    see_outputs(&r, 0);
    ect_kernel_take(r.kernel); /* no effect with the turn */
    assert_int_equal(fake.consumed, 0);
    for (unsigned int n = 0; n < 2; n++) { /* the second time without an effect */
        assert_int_equal(ect_kernel_give(r.kernel, r.w.chain, r.w.now_ns), 1);
        assert_int_equal(shared()->turn.word, ECT_TURN_FREE);
    }
    uint8_t frame[64];
    memcpy(frame, r.w.frame, r.w.frame_length);
    assert_true(ect_plan_reply(fake.memory[PLANS], frame, r.w.frame_length, 0));
    shared()->held = 1;
    assert_null(ect_kernel_next(r.kernel)); /* the held frames are the kernel's */
    ect_kernel_take(r.kernel);
    assert_int_equal(shared()->turn.word, ECT_TURN_PROGRAM);
    assert_int_equal(fake.consumed, 1);
    memcpy(frame, r.w.frame, r.w.frame_length);
    assert_false(ect_plan_reply(fake.memory[PLANS], frame, r.w.frame_length, 0));
    close_rig(&r);
}

/* Times of calls, in steps of a fifth of the time after which a frame counts as lost. */
static void a_frame_on_its_way_keeps_the_turn_until_it_comes_or_is_lost(void **state)
{
    enum { STEP_NS = 4 * MS, NONE = 0, GET = 1, LEAVE = 2 };
    typedef struct call {
        uint64_t at_ns;
        unsigned int first; /* NONE, GET: a frame arrives before it, LEAVE: the kernel leaves another one */
        bool given;
    } call_t;
    static const struct {
        const char *title;
        unsigned int left;
        call_t calls[6];
    } rows[] = {
        {"no frame", 0, {{0, NONE, true}}},
        {"it arrives", 1, {{0, NONE, false}, {1, GET, true}}},
        {"it is lost after 20 ms", 1, {{0, NONE, false}, {5 * STEP_NS, NONE, false}, {5 * STEP_NS + 1, NONE, true}}},
        {"the time begins at the first call",
         1,
         {{9, NONE, false}, {9 + 5 * STEP_NS, NONE, false}, {10 + 5 * STEP_NS, NONE, true}}},
        {"each arrival starts the time again",
         2,
         {{0, NONE, false},
          {3 * STEP_NS, GET, false},
          {6 * STEP_NS, NONE, false},
          {8 * STEP_NS, NONE, false},
          {8 * STEP_NS + 1, NONE, true}}},
        {"the last of two arrives", 2, {{0, NONE, false}, {1, GET, false}, {2, GET, true}}},
    };
    static rig_t r;
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        open_rig(&r);
        see_outputs(&r, 0);
        assert_true(gives(&r, r.w.now_ns));
        for (unsigned int n = 0; n < rows[i].left; n++)
            leave_frame();
        ect_kernel_take(r.kernel);
        const uint64_t start_ns = r.w.now_ns + 1000 * MS;
        for (size_t c = 0; c < 6 && (c == 0 || rows[i].calls[c].at_ns != 0); c++) {
            const call_t *call = &rows[i].calls[c];
            if (call->first == GET)
                ect_kernel_got(r.kernel);
            if (gives(&r, start_ns + call->at_ns) != call->given)
                fail_msg("%s, call %zu: expected %s", rows[i].title, c, call->given ? "given" : "kept");
            if (call->given) { /* all is well again: the next frame is awaited as the first one */
                ect_kernel_take(r.kernel);
                assert_true(gives(&r, start_ns + call->at_ns));
                leave_frame();
                ect_kernel_take(r.kernel);
                assert_false(gives(&r, start_ns + 100 * STEP_NS));
                assert_false(gives(&r, start_ns + 105 * STEP_NS));
                assert_true(gives(&r, start_ns + 105 * STEP_NS + 1));
                ect_kernel_take(r.kernel);
                assert_true(gives(&r, start_ns + 105 * STEP_NS + 1));
                break;
            }
        }
        close_rig(&r);
    }
}

static void outputs_count_as_changing_for_a_while(void **state)
{
    static const struct {
        uint8_t output;
        uint64_t after_ns; /* of the last change */
        bool reacting;
    } rows[] = {
        {0, 0, false},
        {0, 1, false},
        {1, 0, true},
        {1, 1, true},
        {1, ECT_PACE_REACTING_NS - 1, true},
        {1, ECT_PACE_REACTING_NS, false},
        {1, ECT_PACE_REACTING_NS + 1, false},
        {2, 0, true},
        {2, ECT_PACE_REACTING_NS, false},
    };
    static rig_t r;
    uint64_t changed_ns = 0;
    (void)state;
    open_rig(&r);
    changed_ns = r.w.now_ns;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        if (rows[i].after_ns == 0)
            changed_ns += 10ull * ECT_PACE_REACTING_NS;
        see_outputs(&r, rows[i].output);
        assert_true(gives(&r, changed_ns + rows[i].after_ns));
        if (shared()->reacting != rows[i].reacting)
            fail_msg("row %zu: expected %d", i, rows[i].reacting);
        ect_kernel_take(r.kernel);
    }
    close_rig(&r);
}

static void held_frames_come_in_their_order_and_may_get_plans(void **state)
{
    static rig_t r;
    (void)state;
    open_rig(&r);
    build_outputs(&r, 0);
    for (unsigned int round = 0; round < 2; round++) {
        shared()->held = 3;
        for (unsigned int n = 0; n < 3; n++) {
            held()[n].time_ns = 10 * round + n;
            held()[n].length = (uint32_t)r.w.frame_length;
            memcpy(held()[n].frame, r.w.frame, r.w.frame_length);
        }
        for (unsigned int n = 0; n < 3; n++) {
            const ect_held_t *next = ect_kernel_next(r.kernel);
            assert_ptr_equal(next, &held()[n]);
            assert_int_equal(next->time_ns, 10 * round + n);
        }
        assert_null(ect_kernel_next(r.kernel));
        assert_int_equal(shared()->held, 0);
    }
    assert_int_equal(ect_kernel_give(r.kernel, r.w.chain, r.w.now_ns), 1);
    close_rig(&r);
}

static void a_frame_of_a_test_has_its_reply_if_it_is_transmitted(void **state)
{
    static const struct {
        int test_run, verdict;
        bool replied;
    } rows[] = {{0, XDP_TX, true}, {0, XDP_PASS, false}, {0, XDP_DROP, false}, {-EPERM, XDP_TX, false}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t frame[60] = {0};
        reset();
        fake.test_run = rows[i].test_run;
        fake.verdict = rows[i].verdict;
        ect_kernel_t *k = load();
        assert_int_equal(ect_kernel_try(k, frame, sizeof frame), rows[i].replied);
        assert_int_equal(frame[0], sizeof frame);
        ect_kernel_close(k);
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_loaded_program_has_its_maps_and_leaves_the_turn_to_the_process),
        cmocka_unit_test(a_failure_to_load_names_its_cause_and_the_cure),
        cmocka_unit_test(a_lack_of_memory_is_a_failure_to_load),
        cmocka_unit_test(the_hook_is_in_the_driver_if_it_leaves_tags_and_replies_alone),
        cmocka_unit_test(a_program_in_the_way_is_named_with_the_cure),
        cmocka_unit_test(the_kernel_has_the_turn_from_give_to_take),
        cmocka_unit_test(a_frame_on_its_way_keeps_the_turn_until_it_comes_or_is_lost),
        cmocka_unit_test(outputs_count_as_changing_for_a_while),
        cmocka_unit_test(held_frames_come_in_their_order_and_may_get_plans),
        cmocka_unit_test(a_frame_of_a_test_has_its_reply_if_it_is_transmitted),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("the process's side of replies in the kernel", tests, NULL, NULL);
}
