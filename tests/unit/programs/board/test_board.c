/* SPDX-License-Identifier: MIT */
/* The whole command ectwin-board on a clock of the test: the SPI and GPIO lines that it opens belong to a virtual
 * LAN9252. Each wait of the command is a step of the test, in which the test is the master, the chip's environment, and
 * the sender of the signal to end. */
#define _GNU_SOURCE
#include <aio.h>
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <linux/gpio.h>
#include <linux/spi/spidev.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/signalfd.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "board.h"
#include "bus/chain/catalogue.h"
#include "bus/storage/memory.h"
#include "devices/fzm1/fzm1.h"
#include "ports/virtual/lan9252.h"
#include "sii/fit.h"
#include "sii/sii.h"
#include "slave/slave.h"
#include "support/wire.h"

enum { WORDS = 16, TEXT = 4096, LAMPS = 2, CHANGES = 64, RUN_LINE = 20, ERR_LINE = 21, RESET_LINE = 24, IRQ_LINE = 25 };

#define START_NS UINT64_C(5000000000)
#define RESET    "ectwin-board: the LAN9252 was reset, by the master or by its supply, and has been started again\n"
#define READY    "{\"event\":\"ready\",\"spi\":\"/dev/spidev7.1\",\"device\":\"fzm1\"}\n"

/* --- the machine
 * ------------------------------------------------------------------------------------------------------ */

typedef struct lamp_change {
    uint64_t ms;
    bool lit;
} lamp_change_t;

static struct {
    uint64_t now_ns;
    ect_esc_t esc;
    ect_virtual_lan9252_t chip;
    int spi, gpio, reset, irq[2], lamps[LAMPS];
    /* the step of a test: @return whether the signal to end has arrived */
    bool (*step)(unsigned int number);
    unsigned int reads;      /* of the clock since the last wait */
    unsigned int frame_at;   /* reading at which a request arrives; 0: none */
    uint64_t end_ns;         /* time of the last start of the slave */
    unsigned int waits;      /* number of waits */
    nfds_t fds;              /* of the last wait */
    uint64_t timeout_ns;     /* of the last wait */
    bool spi_fails, silent;  /* transfers fail; reads are 0 */
    uint32_t id;             /* another chip; 0: the LAN9252 */
    unsigned int init_fails; /* times that ect_slave_init fails */
    unsigned int inits;
    unsigned int fails_at; /* number of the allocation that fails; 0: none */
    bool no_signals;       /* signalfd() fails */
    int signal_fd;         /* its descriptor; -1: any */
    uint64_t slow_ns;      /* a reading of the clock takes so long */
    uint32_t zero_line;    /* the line that gets descriptor 0, as without standard input; 0: none */
    uint64_t flags[32];    /* of the GPIO lines taken */
    bool lit[LAMPS];
    lamp_change_t changes[LAMPS][CHANGES];
    size_t change_count[LAMPS];
    bool saves;           /* the signal `save` is set with each start */
    uint8_t address;      /* the signal `node_address` is set to this with each start; 0: it is not set */
    uint16_t switches;    /* of the last start of the slave */
    uint64_t saved_at_ns; /* end of a save */
    bool ending;
    char wrong[200]; /* the first failed expectation of a step: standard output is that of the command */
} m;

/* The command never frees what its slave needs: here the blocks remain known. */
static void *blocks[1024];
static size_t block_count;

void *__real_calloc(size_t count, size_t size);
void *__wrap_calloc(size_t count, size_t size);
int __real_signalfd(int fd, const sigset_t *set, int flags);
int __wrap_signalfd(int fd, const sigset_t *set, int flags);
int __real_open(const char *path, int flags, ...);
int __wrap_open(const char *path, int flags, ...);
int __real_ioctl(int fd, unsigned long request, ...);
int __wrap_ioctl(int fd, unsigned long request, ...);
int __real_clock_gettime(clockid_t clock, struct timespec *time);
int __wrap_clock_gettime(clockid_t clock, struct timespec *time);
int __wrap_nanosleep(const struct timespec *time, struct timespec *left);
int __wrap_ppoll(struct pollfd *fds, nfds_t count, const struct timespec *timeout, const sigset_t *mask);
int __real_ect_slave_init(ect_slave_t *slave, const ect_slave_config_t *config, uint64_t now_ns);
int __wrap_ect_slave_init(ect_slave_t *slave, const ect_slave_config_t *config, uint64_t now_ns);
int __wrap_aio_fsync(int operation, struct aiocb *control);
int __wrap_aio_error(const struct aiocb *control);
int __wrap_aio_suspend(const struct aiocb *const list[], int count, const struct timespec *timeout);
ssize_t __wrap_aio_return(struct aiocb *control);

static void step_expect(const char *what, uint64_t want, uint64_t got)
{
    if (want != got && m.wrong[0] == '\0')
        snprintf(m.wrong, sizeof m.wrong, "wait %u: %s: expected %" PRIu64 ", got %" PRIu64, m.waits, what, want, got);
}

void *__wrap_calloc(size_t count, size_t size)
{
    if (m.fails_at > 0 && --m.fails_at == 0)
        return NULL;
    void *block = __real_calloc(count, size);
    if (m.step)
        blocks[block_count++ % (sizeof blocks / sizeof blocks[0])] = block;
    return block;
}

int __wrap_signalfd(int fd, const sigset_t *set, int flags)
{
    if (m.no_signals) {
        errno = EMFILE;
        return -1;
    }
    step_expect("flags of the signals", SFD_CLOEXEC | SFD_NONBLOCK, (uint64_t)flags);
    return __real_signalfd(m.signal_fd >= 0 ? dup2(__real_signalfd(fd, set, flags), m.signal_fd) : fd, set, flags);
}

/* A frame of the master. @return its working counter */
static uint16_t pass(uint8_t command, uint16_t ado, const void *data, uint16_t length)
{
    wire_t w = {0};
    wire_build(&w, command, 0, ado, data, length);
    (void)ect_esc_process(&m.esc, w.frame, w.frame_length, m.now_ns);
    return ect_load_le16(w.frame + 26 + length);
}

/* The mailbox of an FZM1 on a LAN9252, and a request for PREOP. */
static void request_preop(void)
{
    static const uint8_t mailboxes[] = {0x00, 0x10, 0x80, 0, 0x26, 0, 1, 0, 0x80, 0x10, 0x80, 0, 0x22, 0, 1, 0};
    step_expect("working counter", 1, pass(BWR, ECT_REG_SM, mailboxes, sizeof mailboxes));
    step_expect("working counter", 1, pass(BWR, ECT_REG_AL_CONTROL, "\x02\x00", 2));
}

int __wrap_open(const char *path, int flags, ...)
{
    va_list more;
    va_start(more, flags);
    const int mode = (flags & O_CREAT) != 0 ? va_arg(more, int) : 0;
    va_end(more);
    if (strcmp(path, "/dev/spidev7.1") == 0)
        return m.spi = __real_open("/dev/null", flags);
    if (strcmp(path, "/dev/gpiochip9") == 0)
        return m.gpio = __real_open("/dev/null", flags);
    return __real_open(path, flags, mode);
}

static void follow_line(void)
{
    static const struct gpio_v2_line_event event = {.id = GPIO_V2_LINE_EVENT_RISING_EDGE};
    if (m.irq[1] >= 0 && ect_virtual_lan9252_line(&m.chip))
        (void)!write(m.irq[1], &event, sizeof event);
}

static int take_line(struct gpio_v2_line_request *request)
{
    const uint32_t line = request->offsets[0];
    assert_in_range(line, 0, 31);
    m.flags[line] = request->config.flags;
    request->fd = __real_open("/dev/null", O_RDWR | O_CLOEXEC);
    if (line == m.zero_line) {
        close(request->fd);
        request->fd = 0;
    }
    if (line == RESET_LINE)
        m.reset = request->fd;
    else if (line == RUN_LINE || line == ERR_LINE)
        m.lamps[line - RUN_LINE] = request->fd;
    else if (line == IRQ_LINE) {
        assert_int_equal(pipe2(m.irq, O_NONBLOCK | O_CLOEXEC), 0);
        (void)dup2(m.irq[0], request->fd);
        close(m.irq[0]);
        m.irq[0] = request->fd;
    }
    return 0;
}

static void set_lamp(size_t lamp, bool lit)
{
    if (m.lit[lamp] == lit)
        return;
    assert_true(m.change_count[lamp] < CHANGES);
    m.changes[lamp][m.change_count[lamp]++] = (lamp_change_t){(m.now_ns - START_NS) / MS, lit};
    m.lit[lamp] = lit;
}

static int transfer(const struct spi_ioc_transfer *t)
{
    uint8_t *bytes = (uint8_t *)(uintptr_t)t->rx_buf;
    if (m.spi_fails)
        return -1;
    const bool reads_id = t->len >= 7 && bytes[0] == 3 && bytes[1] == 0 && bytes[2] == 0x50;
    (void)ect_esc_tick(&m.esc, m.now_ns);
    (void)ect_virtual_lan9252_transfer(&m.chip, bytes, (uint16_t)t->len);
    if (m.silent)
        memset(bytes, 0, t->len);
    if (m.id != 0 && reads_id)
        ect_store_le32(bytes + 3, m.id);
    follow_line();
    return (int)t->len;
}

int __wrap_ioctl(int fd, unsigned long request, ...)
{
    va_list more;
    va_start(more, request);
    void *argument = va_arg(more, void *);
    va_end(more);
    struct gpio_v2_line_values *values = argument;
    if (fd == m.spi)
        return request == SPI_IOC_MESSAGE(1) ? transfer(argument) : 0;
    if (request == GPIO_V2_GET_LINE_IOCTL)
        return take_line(argument);
    if (request == GPIO_V2_LINE_GET_VALUES_IOCTL)
        values->bits = ect_virtual_lan9252_line(&m.chip);
    else if (fd == m.reset)
        ect_virtual_lan9252_reset(&m.chip, (values->bits & 1) != 0);
    else
        set_lamp(fd == m.lamps[0] ? 0 : 1, (values->bits & 1) != 0);
    return 0;
}

int __wrap_clock_gettime(clockid_t clock, struct timespec *time)
{
    if (clock != CLOCK_MONOTONIC)
        return __real_clock_gettime(clock, time);
    m.now_ns += m.slow_ns;
    if (++m.reads == m.frame_at)
        request_preop();
    *time = (struct timespec){.tv_sec = (time_t)(m.now_ns / 1000000000), .tv_nsec = (long)(m.now_ns % 1000000000)};
    return 0;
}

static uint64_t ns_of(const struct timespec *time)
{
    return (uint64_t)time->tv_sec * 1000000000 + (uint64_t)time->tv_nsec;
}

int __wrap_nanosleep(const struct timespec *time, struct timespec *left)
{
    (void)left;
    m.now_ns += ns_of(time);
    return 0;
}

/* A wait lasts to its end, unless the interrupt pin is active. */
int __wrap_ppoll(struct pollfd *fds, nfds_t count, const struct timespec *timeout, const sigset_t *mask)
{
    (void)mask;
    m.fds = count;
    m.timeout_ns = ns_of(timeout);
    m.reads = m.frame_at = 0;
    m.ending = m.step(m.waits++) || poll(fds, 1, 0) == 1;
    m.now_ns += m.ending || (count > 1 && ect_virtual_lan9252_line(&m.chip)) ? 0 : m.timeout_ns;
    (void)ect_esc_tick(&m.esc, m.now_ns);
    follow_line();
    fds[0].revents = m.ending ? POLLIN : 0;
    return m.ending ? 1 : 0;
}

static void set_signal(void *instance, const char *name, uint8_t value)
{
    const ect_plant_t *plant = &ect_fzm1_plant;
    const ect_signal_group_t *all = &plant->signal_groups[0];
    for (unsigned int i = 0; i < all->signal_count; i++) {
        if (strcmp(all->signals[i].name, name) != 0)
            continue;
        (void)plant->signal_write(instance, &all->signals[i], 0, &value, m.now_ns);
        if (all->signals[i].type == ECT_SIGNAL_U8)
            ((uint8_t *)instance)[all->signals[i].offset] = value;
    }
}

int __wrap_ect_slave_init(ect_slave_t *slave, const ect_slave_config_t *config, uint64_t now_ns)
{
    m.inits++;
    m.end_ns = now_ns;
    m.switches = config->switches;
    if (m.init_fails > 0 && m.init_fails-- > 0)
        return -1;
    const int result = __real_ect_slave_init(slave, config, now_ns);
    if (m.saves && !m.ending)
        set_signal(config->instance, "save", 1);
    if (m.address > 0)
        set_signal(config->instance, "node_address", m.address);
    for (size_t i = 0; i < config->device->buffer_size; i++) {
        step_expect("byte of the buffer", 0, ((uint8_t *)config->buffer)[i]);
        ((uint8_t *)config->buffer)[i] = 0xA5;
    }
    return result;
}

int __wrap_aio_fsync(int operation, struct aiocb *control)
{
    (void)operation;
    (void)control;
    return 0;
}

int __wrap_aio_error(const struct aiocb *control)
{
    (void)control;
    return m.now_ns < m.saved_at_ns ? EINPROGRESS : 0;
}

int __wrap_aio_suspend(const struct aiocb *const list[], int count, const struct timespec *timeout)
{
    (void)list;
    (void)count;
    (void)timeout;
    m.now_ns = m.saved_at_ns;
    return 0;
}

ssize_t __wrap_aio_return(struct aiocb *control)
{
    (void)control;
    return 0;
}

/* --- a run
 * ------------------------------------------------------------------------------------------------------------ */

/* Switches the machine on: an ESC with the EEPROM of an FZM1. */
static void power_on(bool (*step)(unsigned int number))
{
    static uint8_t memory[ECT_ESC_MEMORY_SIZE(4)], sii[4096];
    static ect_device_t on;
    memset(&m, 0, sizeof m);
    memset(memory, 0, sizeof memory);
    m.now_ns = START_NS;
    m.spi = m.gpio = m.reset = m.irq[0] = m.irq[1] = m.lamps[0] = m.lamps[1] = m.signal_fd = -1;
    m.step = step;
    m.chip.esc = &m.esc;
    assert_true(ect_fit(&ect_fzm1, &ect_fit_lan9252, &on));
    assert_true(on.sii_size <= sizeof sii);
    assert_true(ect_sii_write(&on, &on.identity, 0, sii, on.sii_size) >= 0);
    const ect_esc_config_t config = {
        .personality = ect_esc_personality("lan9252"), .memory = memory, .sii = sii, .sii_size = on.sii_size};
    assert_int_equal(ect_esc_init(&m.esc, &config, m.now_ns), 0);
}

/* Variables of the command that it does not set have bits that are 1. */
__attribute__((noinline)) static void fill_stack(void)
{
    volatile uint8_t room[16384];
    for (size_t i = 0; i < sizeof room; i++)
        room[i] = 0xFF;
}

/* Runs the command. @return its exit status; gets its output: standard error, then standard output */
static int run(const char *line, char text[TEXT])
{
    char copy[TEXT], *words[WORDS] = {NULL}, *rest = copy;
    int count = 0;
    const int errors = memfd_create("errors", MFD_CLOEXEC), outputs = memfd_create("outputs", MFD_CLOEXEC);
    snprintf(copy, sizeof copy, "ectwin-board --spi /dev/spidev7.1 %s", line);
    for (char *word; (word = strsep(&rest, " ")) != NULL;)
        words[count++] = word;
    fflush(NULL);
    const int out = dup(STDOUT_FILENO), err = dup(STDERR_FILENO);
    (void)dup2(errors, STDERR_FILENO);
    (void)dup2(outputs, STDOUT_FILENO);
    fill_stack();
    const int status = ectwin_board_main(count, words);
    fflush(NULL);
    (void)dup2(err, STDERR_FILENO);
    (void)dup2(out, STDOUT_FILENO);
    close(out);
    close(err);
    ssize_t size = pread(errors, text, TEXT - 1, 0);
    size += pread(outputs, text + size, (size_t)(TEXT - 1 - size), 0);
    text[size] = '\0';
    close(errors);
    close(outputs);
    for (size_t i = 0; i < 2; i++) {
        if (m.irq[i] >= 0 && i == 1)
            close(m.irq[i]);
        if (m.lamps[i] >= 0)
            close(m.lamps[i]);
    }
    return status;
}

static void expect(const char *line, int status, const char *text)
{
    char got[TEXT];
    const int ended = run(line, got);
    if (m.wrong[0])
        fail_msg("%s: %s", line, m.wrong);
    if (ended != status || strcmp(got, text) != 0)
        fail_msg("%s: expected %d, '%s', got %d, '%s'", line, status, text, ended, got);
}

static bool end_at_once(unsigned int number)
{
    (void)number;
    return true;
}

/* --- the start
 * -------------------------------------------------------------------------------------------------------- */

static void no_start(void **state)
{
    static const struct {
        const char *text;
        uint32_t id;
        bool spi_fails, silent, never_ready, csr_stuck, no_eeprom;
    } rows[] = {
        {.spi_fails = true,
         .text = "ectwin-board: transfers on the SPI fail, or the chip does not carry out accesses: check wiring and "
                 "--speed\n"},
        {.csr_stuck = true,
         .text = "ectwin-board: transfers on the SPI fail, or the chip does not carry out accesses: check wiring and "
                 "--speed\n"},
        {.silent = true,
         .text = "ectwin-board: no LAN9252 replies on this SPI: check power, wiring, chip select and SPI mode 0, or "
                 "try --speed "
                 "1000000\n"},
        {.id = 0x92510001, .text = "ectwin-board: another chip replies on this SPI: check --spi and chip select\n"},
        {.never_ready = true,
         .text = "ectwin-board: the LAN9252 does not get ready: check its clock and its reset pin\n"},
        {.no_eeprom = true,
         .text = "ectwin-board: the LAN9252 has no good EEPROM: write what --eeprom FILE makes to it, with a "
                 "programmer or from a "
                 "master, and switch it off and on\n"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        power_on(end_at_once);
        m.spi_fails = rows[i].spi_fails;
        m.silent = rows[i].silent;
        m.id = rows[i].id;
        m.chip.never_ready = rows[i].never_ready;
        m.chip.csr_stuck = rows[i].csr_stuck;
        if (rows[i].no_eeprom) {
            ect_esc_config_t config = m.esc.config;
            static uint8_t erased[2048];
            memset(erased, 0xFF, sizeof erased);
            config.sii = erased;
            config.sii_size = sizeof erased;
            assert_int_equal(ect_esc_init(&m.esc, &config, m.now_ns), 0);
        }
        expect("fzm1", 2, rows[i].text);
        assert_int_equal(m.waits, 0);
    }
}

static void slave_that_fails(void **state)
{
    (void)state;
    power_on(end_at_once);
    m.init_fails = 9; /* ten tries */
    expect("fzm1", 0, READY);
    assert_int_equal(m.inits, 11); /* the last one at the end */
    power_on(end_at_once);
    m.init_fails = 10;
    expect(
        "fzm1", 2,
        "ectwin-board: transfers on the SPI fail, or the chip does not carry out accesses: check wiring and --speed\n");
    assert_int_equal(m.inits, 10);
}

static void lines(void **state)
{
    const uint64_t input = GPIO_V2_LINE_FLAG_INPUT | GPIO_V2_LINE_FLAG_EDGE_RISING, output = GPIO_V2_LINE_FLAG_OUTPUT;
    (void)state;
    power_on(end_at_once);
    expect("--irq gpiochip9:25 --reset gpiochip9:24 --run-led gpiochip9:20 --err-led gpiochip9:21 fzm1", 0, READY);
    assert_int_equal(m.flags[IRQ_LINE], input | GPIO_V2_LINE_FLAG_ACTIVE_LOW | GPIO_V2_LINE_FLAG_BIAS_PULL_UP);
    assert_int_equal(m.flags[RESET_LINE], output | GPIO_V2_LINE_FLAG_ACTIVE_LOW);
    assert_int_equal(m.flags[RUN_LINE], output);
    assert_int_equal(m.flags[ERR_LINE], output);
    power_on(end_at_once);
    m.chip.active_high = true;
    expect("--irq gpiochip9:25 --irq-high fzm1", 0, READY);
    assert_int_equal(m.flags[IRQ_LINE], input | GPIO_V2_LINE_FLAG_BIAS_PULL_DOWN);
    static const char *const options[] = {"--irq", "--reset", "--run-led", "--err-led"};
    for (size_t i = 0; i < sizeof options / sizeof options[0]; i++) {
        char line[64];
        power_on(end_at_once);
        snprintf(line, sizeof line, "%s nosuch fzm1", options[i]);
        expect(line, 2, "ectwin-board: 'nosuch' names no GPIO line: CHIP:LINE, e.g. gpiochip0:25\n");
    }
}

/* Without --store no message names a file. */
static void a_start_without_memory(void **state)
{
    static const char none[] = "ectwin-board: not enough memory\n",
                      not_kept[] = "ectwin-board: cannot keep what is saved: not enough memory\n";
    char text[TEXT];
    int status = 2;
    unsigned int n = 0;
    (void)state;
    while (status != 0 && n < 100) {
        power_on(end_at_once);
        m.fails_at = ++n;
        status = run("fzm1", text);
        assert_int_equal(status, m.fails_at == 0 ? 2 : 0);
        if (strcmp(text, READY) != 0 && strcmp(text, none) != 0 && strcmp(text, not_kept) != 0)
            fail_msg("allocation %u: got '%s'", n, text);
    }
    assert_in_range(n, 4, 99);
}

/* A program without standard input may get descriptor 0 for its signals. */
static void a_start_without_signals(void **state)
{
    const int before = dup(STDIN_FILENO);
    (void)state;
    power_on(end_at_once);
    m.no_signals = true;
    expect("fzm1", 2, "ectwin-board: cannot wait for the signals that end it: Too many open files\n");
    power_on(end_at_once);
    m.signal_fd = 0;
    expect("fzm1", 0, READY);
    (void)dup2(before, STDIN_FILENO);
    close(before);
}

static void stores(void **state)
{
    char line[1200];
    (void)state;
    power_on(end_at_once);
    expect("--store /dev/null/x fzm1", 2,
           "ectwin-board: cannot keep what is saved in '/dev/null/x/fzm1-1.0': Not a directory\n");
    power_on(end_at_once);
    const int most = ECT_MEMORY_PATH - 1 - (int)strlen("/tmp//fzm1-1");
    for (int length = most; length <= most + 1; length++) {
        char text[TEXT];
        power_on(end_at_once);
        snprintf(line, sizeof line, "--store /tmp/%0*d fzm1", length, 0);
        assert_int_equal(run(line, text), 2);
        assert_non_null(strstr(text, length == most ? ": File name too long\n"
                                                    : "ectwin-board: the name of the folder is too long\n"));
    }
}

/* A damaged file is kept under another name, and the command runs with an empty one. */
static void a_damaged_store(void **state)
{
    static const char *const names[] = {"fzm1-1.0", "fzm1-1.1", "fzm1-1.0.damaged1"};
    struct stat info;
    char folder[] = "/tmp/ectwin-board-XXXXXX", line[128], text[256];
    (void)state;
    assert_non_null(mkdtemp(folder));
    assert_int_equal(rmdir(folder), 0);
    const mode_t mask = umask(0);
    snprintf(text, sizeof text,
             "ectwin-board: '%s/fzm1-1.0' has no complete record and is kept as 'fzm1-1.0.damaged1'\n" READY, folder);
    for (int times = 0; times < 3; times++) {
        if (times == 1) {
            snprintf(line, sizeof line, "%s/%s", folder, names[0]);
            const int file = open(line, O_WRONLY | O_CLOEXEC);
            assert_int_equal(pwrite(file, "a header?", 9, 32), 9);
            close(file);
        }
        power_on(end_at_once);
        snprintf(line, sizeof line, "--store %s fzm1", folder);
        expect(line, 0, times == 1 ? text : READY);
        assert_int_equal(stat(folder, &info), 0);
        assert_int_equal(info.st_mode & 07777, 0700); /* of its own making */
    }
    (void)umask(mask);
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        snprintf(line, sizeof line, "%s/%s", folder, names[i]);
        assert_int_equal(unlink(line), 0);
    }
    assert_int_equal(rmdir(folder), 0);
}

static bool end_without_alias(unsigned int number)
{
    step_expect("station alias", 0, ect_load_le16(m.esc.memory + 0x0012));
    return number == 20;
}

/* Without a plant a device has neither surroundings nor switches, and no save that the end waits for. */
static void a_device_without_plant(void **state)
{
    ect_device_t bare = ect_fzm1;
    const ect_product_t product = {&bare, NULL};
    (void)state;
    bare.name = "bare";
    ect_catalogue_add(&product, 1);
    power_on(end_without_alias);
    expect("bare", 0, "{\"event\":\"ready\",\"spi\":\"/dev/spidev7.1\",\"device\":\"bare\"}\n");
    assert_int_equal(m.waits, 21);
    ect_catalogue_add(NULL, 0);
}

static void a_device_that_does_not_fit(void **state)
{
    ect_device_t large = ect_fzm1;
    const ect_product_t product = {&large, NULL};
    (void)state;
    large.name = "large";
    large.sm_count = 5; /* the chip has four */
    ect_catalogue_add(&product, 1);
    power_on(end_at_once);
    char text[TEXT];
    assert_int_equal(run("large", text), 2);
    assert_string_equal(text, "ectwin-board: large does not fit into a LAN9252\n");
    ect_catalogue_add(NULL, 0);
}

/* Without a run, the command frees its memory. */
static void eeprom_image(void **state)
{
    char path[] = "/tmp/ectwin-board-XXXXXX", line[64];
    uint8_t got[4096];
    (void)state;
    close(mkstemp(path));
    power_on(NULL);
    snprintf(line, sizeof line, "--eeprom %s fzm1", path);
    expect(line, 0, "");
    const int file = open(path, O_RDONLY | O_CLOEXEC);
    assert_int_equal(read(file, got, sizeof got), m.esc.config.sii_size);
    assert_memory_equal(got, m.esc.config.sii, m.esc.config.sii_size);
    close(file);
    unlink(path);
    expect("--eeprom /nosuch/file fzm1", 2, "ectwin-board: cannot write '/nosuch/file': No such file or directory\n");
}

/* --- waits
 * ------------------------------------------------------------------------------------------------------------ */

static uint64_t expected_ns;
static nfds_t expected_fds;

static bool expect_waits(unsigned int number)
{
    if (number > 0) {
        step_expect("timeout in ns", expected_ns, m.timeout_ns);
        step_expect("descriptors", expected_fds, m.fds);
    }
    return number == 6;
}

/* Without an interrupt pin the command polls; with the pin it sleeps until the next check of the chip. */
static void intervals(void **state)
{
    static const struct {
        const char *line;
        uint64_t ns;
        nfds_t fds;
        uint64_t slow_ns;
        uint32_t zero_line;
    } rows[] = {{"fzm1", 250000, 1, 0, 0},
                {"--poll 50 fzm1", 50000, 1, 0, 0},
                {"--poll 10000 fzm1", 10000000, 1, 0, 0},
                {"--irq gpiochip9:25 fzm1", 50000000, 2, 0, 0},
                {"--irq gpiochip9:25 fzm1", 50000000, 2, 0, IRQ_LINE},
                {"--irq gpiochip9:25 fzm1", 0, 2, 60 * MS, 0}}; /* the time of the next check is over */
    const int before = dup(STDIN_FILENO);
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        power_on(expect_waits);
        m.slow_ns = rows[i].slow_ns;
        m.zero_line = rows[i].zero_line;
        expected_ns = rows[i].ns;
        expected_fds = rows[i].fds;
        expect(rows[i].line, 0, READY);
        assert_int_equal(m.waits, 7);
    }
    (void)dup2(before, STDIN_FILENO);
    close(before);
}

/* A request arrives after the slave was polled: the pin is active before the wait begins. */
static bool request_between(unsigned int number)
{
    if (number == 3)
        m.frame_at = 3;
    if (number == 4)
        step_expect("timeout in ns", 0, m.timeout_ns);
    if (number == 20)
        step_expect("AL status", 2, m.esc.memory[ECT_REG_AL_STATUS]);
    return number == 20;
}

static void an_active_pin(void **state)
{
    const int before = dup(STDIN_FILENO);
    (void)state;
    power_on(request_between);
    expect("--irq gpiochip9:25 fzm1", 0, READY);
    power_on(request_between);
    m.zero_line = IRQ_LINE;
    expect("--irq gpiochip9:25 fzm1", 0, READY);
    (void)dup2(before, STDIN_FILENO);
    close(before);
}

/* --- the chip goes
 * ---------------------------------------------------------------------------------------------------- */

static bool master_resets(unsigned int number)
{
    for (unsigned int i = 0; number == 3 && i < 3; i++)
        (void)pass(BWR, ECT_REG_RESET_ECAT, &"RES"[i], 1);
    return number == 1000;
}

static void reset_by_the_master(void **state)
{
    (void)state;
    power_on(master_resets);
    expect("fzm1", 0, RESET READY);
    assert_int_equal(m.inits, 3);
}

/* The plant, and the memory of a device, after a reset: switches are read again, the memory is empty. */
static void switches_and_buffer(void **state)
{
    ect_device_t other = ect_fzm1;
    const ect_product_t product = {&other, &ect_fzm1_plant};
    (void)state;
    other.name = "other";
    other.buffer_size = 64;
    ect_catalogue_add(&product, 1);
    power_on(master_resets);
    m.address = 7;
    expect("other", 0, RESET "{\"event\":\"ready\",\"spi\":\"/dev/spidev7.1\",\"device\":\"other\"}\n");
    assert_int_equal(m.inits, 3);
    assert_int_equal(m.switches, 7);
    assert_int_equal(ect_load_le16(m.esc.memory + 0x0012), 7);
    ect_catalogue_add(NULL, 0);
}

static bool reset_while_it_waits(unsigned int number)
{
    static unsigned int inits;
    if (number > 0 && m.inits > inits)
        step_expect("timeout in ns", 0, m.timeout_ns);
    else if (number > 1)
        step_expect("timeout in ns", 50 * MS, m.timeout_ns);
    inits = m.inits;
    for (unsigned int i = 0; number == 5 && i < 3; i++)
        (void)pass(BWR, ECT_REG_RESET_ECAT, &"RES"[i], 1);
    return number == 10;
}

/* The slave is polled at once after its restart, and then sleeps behind the pin. */
static void polled_after_a_reset(void **state)
{
    (void)state;
    power_on(reset_while_it_waits);
    expect("--irq gpiochip9:25 fzm1", 0, RESET READY);
    assert_int_equal(m.inits, 3);
}

/* The chip is silent, then another one replies, then the chip is back. */
static bool chip_is_away(unsigned int number)
{
    const uint64_t ms = (m.now_ns - START_NS) / MS;
    m.silent = ms >= 200 && ms < 900;
    if (ms >= 200 && ms < 201)
        m.chip.irq_cfg = 0; /* as after a drop of the supply */
    m.id = ms >= 900 && ms < 2500 ? 0x92510001 : 0;
    (void)number;
    return ms >= 6000;
}

static void chip_that_comes_back(void **state)
{
    (void)state;
    power_on(chip_is_away);
    expect("fzm1", 0,
           "ectwin-board: no LAN9252 replies on this SPI: check power, wiring, chip select and SPI mode 0, or try "
           "--speed 1000000\n"
           "ectwin-board: another chip replies on this SPI: check --spi and chip select\n" RESET READY);
}

static uint64_t retry_ns;

static bool chip_stays_away(unsigned int number)
{
    m.silent = m.now_ns - START_NS >= 200 * MS;
    if (m.silent && m.timeout_ns > retry_ns)
        retry_ns = m.timeout_ns;
    (void)number;
    return m.now_ns - START_NS >= 5000 * MS;
}

static void chip_that_stays_away(void **state)
{
    (void)state;
    power_on(chip_stays_away);
    retry_ns = 0;
    expect("--irq gpiochip9:25 fzm1", 3,
           "ectwin-board: no LAN9252 replies on this SPI: check power, wiring, chip select and SPI mode 0, or try "
           "--speed 1000000\n" READY);
    assert_int_equal(retry_ns, 100 * MS); /* between two tries */
}

/* --- lamps
 * ------------------------------------------------------------------------------------------------------------ */

static bool preop_then_error(unsigned int number)
{
    const uint64_t ms = (m.now_ns - START_NS) / MS;
    static bool asked;
    asked &= number > 0;
    if (number == 3)
        request_preop();
    if (ms >= 1000 && !asked) {
        asked = true;
        (void)pass(BWR, ECT_REG_AL_CONTROL, "\x08\x00", 2); /* from PREOP to OP */
    }
    return ms >= 2000;
}

/* RUN blinks in PREOP, 200 ms on and off; ERR blinks for a refused request. */
static void lamps(void **state)
{
    (void)state;
    power_on(preop_then_error);
    expect("--run-led gpiochip9:20 --err-led gpiochip9:21 fzm1", 0, READY);
    assert_in_range(m.change_count[0], 8, 11);
    assert_in_range(m.change_count[1], 4, 6);
    for (size_t lamp = 0; lamp < LAMPS; lamp++) {
        for (size_t i = 1; i < m.change_count[lamp]; i++) {
            const uint64_t ms = m.changes[lamp][i].ms - m.changes[lamp][i - 1].ms;
            if (ms < 199 || ms > 201)
                fail_msg("lamp %zu: change %zu: expected 200 ms, got %" PRIu64, lamp, i, ms);
        }
    }
    assert_in_range(m.changes[1][0].ms, 1000, 1001);
    power_on(preop_then_error);
    expect("--err-led gpiochip9:21 fzm1", 0, READY);
    assert_int_equal(m.change_count[0], 0);
    assert_in_range(m.change_count[1], 4, 6);
}

/* Between two checks of the chip. */
static bool spi_fails_for_20_ms(unsigned int number)
{
    const uint64_t ms = (m.now_ns - START_NS) / MS;
    m.spi_fails = ms >= 505 && ms < 525;
    (void)number;
    return ms >= 600;
}

static void lamp_of_failures(void **state)
{
    (void)state;
    power_on(spi_fails_for_20_ms);
    expect("--err-led gpiochip9:21 fzm1", 0, READY);
    assert_int_equal(m.inits, 2); /* no restart */
    assert_int_equal(m.change_count[1], 2);
    assert_in_range(m.changes[1][0].ms, 505, 506);
    assert_in_range(m.changes[1][1].ms, 525, 526);
}

/* A program without standard input gets descriptor 0 for one of its lines. */
static void descriptor_0(void **state)
{
    static const char *const options[] = {"--run-led gpiochip9:20", "--err-led gpiochip9:21", "--irq gpiochip9:25",
                                          "--reset gpiochip9:24"};
    static const uint32_t lines[] = {RUN_LINE, ERR_LINE, IRQ_LINE, RESET_LINE};
    (void)state;
    for (size_t i = 0; i < 4; i++) {
        char line[64];
        const int before = dup(STDIN_FILENO);
        power_on(preop_then_error);
        m.zero_line = lines[i];
        snprintf(line, sizeof line, "%s fzm1", options[i]);
        expect(line, 0, READY);
        assert_int_equal(m.change_count[0] > 0, i == 0);
        assert_int_equal(m.change_count[1] > 0, i == 1);
        assert_int_equal(m.fds, i == 2 ? 2 : 1);
        (void)dup2(before, STDIN_FILENO);
        close(before);
    }
}

/* --- the end
 * ---------------------------------------------------------------------------------------------------------- */

static int sent;

static bool send_signal(unsigned int number)
{
    if (number == 3)
        (void)kill(getpid(), sent);
    return number == 9;
}

/* A shell ignores SIGINT in the background, and nohup SIGHUP. */
static void signals_that_end(void **state)
{
    static const struct {
        int number;
        bool ignored, ends;
    } rows[] = {{SIGINT, false, true}, {SIGTERM, false, true}, {SIGHUP, false, true},
                {SIGINT, true, true},  {SIGTERM, true, true},  {SIGHUP, true, false}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        sigset_t set;
        sigemptyset(&set);
        sigaddset(&set, rows[i].number);
        sigprocmask(SIG_UNBLOCK, &set, NULL);
        signal(rows[i].number, rows[i].ignored ? SIG_IGN : SIG_DFL);
        sent = rows[i].number;
        power_on(send_signal);
        expect("fzm1", 0, READY);
        assert_int_equal(sigprocmask(SIG_BLOCK, NULL, &set), 0);
        assert_false(sigismember(&set, SIGUSR2)); /* no other one is held back */
        sigemptyset(&set);
        sigaddset(&set, rows[i].number);
        if (m.waits != (rows[i].ends ? 4 : 10))
            fail_msg("row %zu: expected the end %s, got %u waits", i, rows[i].ends ? "by the signal" : "later",
                     m.waits);
        (void)sigtimedwait(&set, NULL, &(const struct timespec){0});
        signal(rows[i].number, SIG_DFL);
    }
}

static bool end_in_preop(unsigned int number)
{
    if (number == 3)
        request_preop();
    if (number == 40)
        step_expect("AL status", 2, m.esc.memory[ECT_REG_AL_STATUS]);
    return number == 40;
}

static void init_at_the_end(void **state)
{
    (void)state;
    power_on(end_in_preop);
    expect("fzm1", 0, READY);
    assert_int_equal(m.esc.memory[ECT_REG_AL_STATUS], 1);
}

static bool end_after_100_ms(unsigned int number)
{
    (void)number;
    return m.now_ns - START_NS >= 100 * MS;
}

/* The end waits for a save, up to two seconds. */
static void a_save_under_way(void **state)
{
    static const struct {
        uint64_t saved_ms, end_ms;
    } rows[] = {{50, 100}, {1500, 1500}, {2099, 2099}, {9000, 2100}};
    char folder[] = "/tmp/ectwin-board-XXXXXX", line[64];
    (void)state;
    assert_non_null(mkdtemp(folder));
    snprintf(line, sizeof line, "--store %s fzm1", folder);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        power_on(end_after_100_ms);
        m.saves = true;
        m.saved_at_ns = START_NS + rows[i].saved_ms * MS;
        expect(line, 0, READY);
        const uint64_t ms = (m.end_ns - START_NS) / MS;
        if (ms < rows[i].end_ms || ms > rows[i].end_ms + 1)
            fail_msg("row %zu: expected the end at %" PRIu64 " ms, got %" PRIu64, i, rows[i].end_ms, ms);
    }
    for (char n = '0'; n <= '1'; n++) {
        snprintf(line, sizeof line, "%s/fzm1-1.%c", folder, n);
        (void)unlink(line);
    }
    assert_int_equal(rmdir(folder), 0);
}

#define TEST(title, function) {title, function, NULL, NULL, NULL}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        TEST("a chip that does not start ends the command with its cause", no_start),
        TEST("the slave has ten tries to start", slave_that_fails),
        TEST("each GPIO line has its direction, level and pull", lines),
        TEST("without memory the command ends", a_start_without_memory),
        TEST("without signals the command ends", a_start_without_signals),
        TEST("a folder for saved parameters that cannot be used ends the command", stores),
        TEST("a damaged file of saved parameters is kept aside, with a line", a_damaged_store),
        TEST("a device without a plant runs", a_device_without_plant),
        TEST("a device that does not fit into the chip ends the command", a_device_that_does_not_fit),
        TEST("--eeprom writes the image of the chip", eeprom_image),
        TEST("the command waits for the interval of --poll, or for the pin until the next check", intervals),
        TEST("while the pin is active, the command does not wait", an_active_pin),
        TEST("after a reset by the master the slave starts again", reset_by_the_master),
        TEST("after a reset the switches are read again, and the memory of the device is empty", switches_and_buffer),
        TEST("after such a reset the slave is polled at once", polled_after_a_reset),
        TEST("a chip may be away for any time; each new cause is printed once", chip_that_comes_back),
        TEST("a signal ends the command while the chip is away, as a failure", chip_that_stays_away),
        TEST("the lamps show state and errors", lamps),
        TEST("the ERR lamp is on as long as accesses to the chip fail", lamp_of_failures),
        TEST("a line may have descriptor 0", descriptor_0),
        TEST("SIGINT, SIGTERM and SIGHUP end the command, SIGHUP unless it is ignored", signals_that_end),
        TEST("the slave is in INIT at the end", init_at_the_end),
        TEST("a save under way is done before the end", a_save_under_way),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("ectwin-board", tests, NULL, NULL);
}
