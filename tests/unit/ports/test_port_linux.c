/* SPDX-License-Identifier: MIT */
/* GPIO lines and SPI of Linux (src/ports/linux), with a kernel that is the test's. The whole board is in
 * tests/integration/lan9252.sh. */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <linux/gpio.h>
#include <linux/spi/spidev.h>
#include <poll.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <sys/ioctl.h>
#include <time.h>
#include <unistd.h>

#include <cmocka.h>

#include "ports/linux/gpio.h"
#include "ports/linux/spidev.h"

/* Descriptors of the test. 0 is a valid one: a process may start without its standard input. */
enum { DEVICE = 0, LINE = 60, RESET = 61, NO_FD = -1, FDS = 64 };

static struct kernel {
    bool active;         /* the calls below are the test's */
    const char *path;    /* that exists */
    int error;           /* of open(); 0: the path opens */
    unsigned long fails; /* the request of ioctl() that fails */
    int fails_with;
    int done; /* bytes that a transfer reports; negative: it fails */
    unsigned int opened[FDS];
    struct gpio_v2_line_request line;
    uint64_t bits, mask; /* of a line */
    int line_used;       /* by the last request for its values */
    uint8_t mode;
    uint32_t speed_hz;
    struct spi_ioc_transfer transfer;
    const short *polls; /* revents of each poll(); 0: nothing, negative: a signal interrupts */
    const ssize_t *reads;
    size_t polled, read;
    struct timespec slept;
} kernel;

int __real_open(const char *path, int flags, ...);
int __wrap_open(const char *path, int flags, ...);
int __real_close(int fd);
int __wrap_close(int fd);
int __wrap_ioctl(int fd, unsigned long request, ...);
int __real_poll(struct pollfd *fds, nfds_t count, int timeout_ms);
int __wrap_poll(struct pollfd *fds, nfds_t count, int timeout_ms);
ssize_t __real_read(int fd, void *data, size_t size);
ssize_t __wrap_read(int fd, void *data, size_t size);
int __wrap_nanosleep(const struct timespec *time, struct timespec *left);

int __wrap_open(const char *path, int flags, ...)
{
    va_list arguments;
    va_start(arguments, flags);
    mode_t mode = (flags & O_CREAT) != 0 ? va_arg(arguments, mode_t) : 0;
    va_end(arguments);
    if (!kernel.active)
        return __real_open(path, flags, mode);
    assert_int_equal(flags, O_RDWR | O_CLOEXEC);
    assert_string_equal(path, kernel.path);
    if (kernel.error != 0) {
        errno = kernel.error;
        return -1;
    }
    kernel.opened[DEVICE]++;
    return DEVICE;
}

int __wrap_close(int fd)
{
    if (!kernel.active)
        return __real_close(fd);
    assert_in_range(fd, 0, FDS - 1);
    if (kernel.opened[fd] != 1)
        fail_msg("descriptor %d is closed, and is open %u times", fd, kernel.opened[fd]);
    kernel.opened[fd] = 0;
    return 0;
}

static int control(unsigned long request, void *argument)
{
    if (request == GPIO_V2_GET_LINE_IOCTL) {
        struct gpio_v2_line_request *line = argument;
        kernel.line = *line;
        kernel.opened[LINE]++;
        line->fd = LINE;
    } else if (request == GPIO_V2_LINE_GET_VALUES_IOCTL) {
        struct gpio_v2_line_values *values = argument;
        kernel.mask = values->mask;
        values->bits = kernel.bits;
    } else if (request == GPIO_V2_LINE_SET_VALUES_IOCTL) {
        const struct gpio_v2_line_values *values = argument;
        kernel.mask = values->mask;
        kernel.bits = values->bits;
    } else if (request == SPI_IOC_WR_MODE) {
        kernel.mode = *(const uint8_t *)argument;
    } else if (request == SPI_IOC_WR_MAX_SPEED_HZ) {
        kernel.speed_hz = *(const uint32_t *)argument;
    } else if (request == SPI_IOC_MESSAGE(1)) {
        kernel.transfer = *(const struct spi_ioc_transfer *)argument;
        return kernel.done;
    } else {
        fail_msg("unknown request %#lx", request);
    }
    return 0;
}

int __wrap_ioctl(int fd, unsigned long request, ...)
{
    va_list arguments;
    va_start(arguments, request);
    void *argument = va_arg(arguments, void *);
    va_end(arguments);
    bool of_line = request == GPIO_V2_LINE_GET_VALUES_IOCTL || request == GPIO_V2_LINE_SET_VALUES_IOCTL;
    if (of_line)
        kernel.line_used = fd;
    else
        assert_int_equal(fd, DEVICE);
    if (request == kernel.fails) {
        errno = kernel.fails_with;
        return -1;
    }
    return control(request, argument);
}

int __wrap_poll(struct pollfd *fds, nfds_t count, int timeout_ms)
{
    if (!kernel.active)
        return __real_poll(fds, count, timeout_ms);
    assert_int_equal(count, 1);
    assert_int_equal(timeout_ms, 0);
    assert_int_equal(fds->fd, LINE);
    assert_int_equal(fds->events, POLLIN);
    short revents = kernel.polls[kernel.polled++];
    if (revents < 0) {
        errno = EINTR;
        return -1;
    }
    fds->revents = revents;
    return revents != 0;
}

/* The kernel keeps up to 16 edges of a line for its reader: all of them fit into one read. */
ssize_t __wrap_read(int fd, void *data, size_t size)
{
    if (!kernel.active)
        return __real_read(fd, data, size);
    assert_int_equal(fd, LINE);
    assert_int_equal(size, 16 * sizeof(struct gpio_v2_line_event));
    memset(data, 0x5A, size);
    return kernel.reads[kernel.read++];
}

int __wrap_nanosleep(const struct timespec *time, struct timespec *left)
{
    assert_null(left);
    kernel.slept = *time;
    return 0;
}

static void begin(const char *path)
{
    kernel = (struct kernel){.active = true, .path = path, .line_used = NO_FD, .mode = 0xFF};
}

static int end(void **state)
{
    (void)state;
    kernel.active = false;
    return 0;
}

static unsigned int open_descriptors(void)
{
    unsigned int count = 0;
    for (unsigned int fd = 0; fd < FDS; fd++)
        count += kernel.opened[fd];
    return count;
}

/* --- GPIO --------------------------------------------------------------------------------------------------------- */

#define CHARS_50 "12345678901234567890123456789012345678901234567890"
#define NONE     "' names no GPIO line: CHIP:LINE, e.g. gpiochip0:25"

static void names(void **state)
{
    static const struct {
        const char *name;
        const char *path; /* NULL: refused */
        unsigned int offset;
    } rows[] = {
        {"gpiochip0:25", "/dev/gpiochip0", 25},
        {"gpiochip0:0", "/dev/gpiochip0", 0},
        {"gpiochip12:9", "/dev/gpiochip12", 9},
        {"gpiochip0:007", "/dev/gpiochip0", 7},
        {"gpiochip0:1023", "/dev/gpiochip0", 1023},
        {"/tmp/a:b:3", "/tmp/a:b", 3},
        {"c:1", "/dev/c", 1},
        {CHARS_50 "12345678:1", "/dev/" CHARS_50 "12345678", 1},
        {CHARS_50 "123456789:1", NULL, 0}, /* a path of 64 characters */
        {"gpiochip0:1024", NULL, 0},
        {"gpiochip0:18446744073709551617", NULL, 0},
        {"gpiochip0", NULL, 0},
        {"gpiochip0:", NULL, 0},
        {":25", NULL, 0},
        {"", NULL, 0},
        {"gpiochip0:+5", NULL, 0},
        {"gpiochip0: 5", NULL, 0},
        {"gpiochip0:-1", NULL, 0},
        {"gpiochip0:x", NULL, 0},
        {"gpiochip0:5x", NULL, 0},
        {"gpiochip0:0x5", NULL, 0},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char message[ECT_LINUX_MESSAGE] = "";
        begin(rows[i].path);
        int fd = ect_gpio_open(rows[i].name, ECT_GPIO_INPUT, message);
        int want = rows[i].path ? LINE : -1;
        if (fd != want || kernel.line.offsets[0] != rows[i].offset || (*message == 0) != (rows[i].path != NULL))
            fail_msg("'%s': expected %d, line %u; got %d, line %u, '%s'", rows[i].name, want, rows[i].offset, fd,
                     kernel.line.offsets[0], message);
        assert_true(rows[i].path || strstr(message, NONE));
        assert_int_equal(open_descriptors(), rows[i].path ? 1 : 0); /* that of the line, without that of its chip */
    }
}

static void uses(void **state)
{
    enum {
        INPUT = GPIO_V2_LINE_FLAG_INPUT | GPIO_V2_LINE_FLAG_EDGE_RISING,
        OUTPUT = GPIO_V2_LINE_FLAG_OUTPUT,
        LOW = GPIO_V2_LINE_FLAG_ACTIVE_LOW,
        UP = GPIO_V2_LINE_FLAG_BIAS_PULL_UP,
        DOWN = GPIO_V2_LINE_FLAG_BIAS_PULL_DOWN,
    };
    static const struct {
        unsigned int use;
        uint64_t flags;
    } rows[] = {
        {ECT_GPIO_INPUT, INPUT},
        {ECT_GPIO_OUTPUT, OUTPUT},
        {ECT_GPIO_INPUT | ECT_GPIO_LOW, INPUT | LOW},
        {ECT_GPIO_OUTPUT | ECT_GPIO_LOW, OUTPUT | LOW},
        {ECT_GPIO_INPUT | ECT_GPIO_PULL_UP, INPUT | UP},
        {ECT_GPIO_INPUT | ECT_GPIO_PULL_DOWN, INPUT | DOWN},
        {ECT_GPIO_INPUT | ECT_GPIO_LOW | ECT_GPIO_PULL_UP, INPUT | LOW | UP},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char message[ECT_LINUX_MESSAGE];
        begin("/dev/gpiochip0");
        assert_int_equal(ect_gpio_open("gpiochip0:25", rows[i].use, message), LINE);
        if (kernel.line.config.flags != rows[i].flags)
            fail_msg("use %u: expected the flags %#llx, got %#llx", rows[i].use, (unsigned long long)rows[i].flags,
                     (unsigned long long)kernel.line.config.flags);
        assert_int_equal(kernel.line.num_lines, 1);
        assert_string_equal(kernel.line.consumer, "ectwin");
    }
}

static void lines_that_cannot_be_taken(void **state)
{
    static const struct {
        int of_open, of_line;
        const char *message;
    } rows[] = {
        {ENOENT, 0, "cannot take line 25 of '/dev/gpiochip0': No such file or directory"},
        {EACCES, 0,
         "cannot take line 25 of '/dev/gpiochip0': Permission denied; on a Raspberry Pi the group gpio has access"},
        {0, EBUSY, "cannot take line 25 of '/dev/gpiochip0': Device or resource busy"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char message[ECT_LINUX_MESSAGE] = "";
        begin("/dev/gpiochip0");
        kernel.error = rows[i].of_open;
        kernel.fails = rows[i].of_line != 0 ? GPIO_V2_GET_LINE_IOCTL : 0;
        kernel.fails_with = rows[i].of_line;
        assert_int_equal(ect_gpio_open("gpiochip0:25", ECT_GPIO_INPUT, message), -1);
        assert_string_equal(message, rows[i].message);
        assert_int_equal(open_descriptors(), 0);
    }
}

static void levels(void **state)
{
    static const struct {
        uint64_t bits;
        unsigned long fails;
        bool active;
    } rows[] = {
        {0, 0, false}, {1, 0, true},
        {2, 0, false}, /* of another line */
        {3, 0, true},  {0, GPIO_V2_LINE_GET_VALUES_IOCTL, true},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        begin(NULL);
        kernel.bits = rows[i].bits;
        kernel.fails = rows[i].fails;
        kernel.mask = 1;
        if (ect_gpio_get(LINE) != rows[i].active)
            fail_msg("bits %u: expected %d, got %d", (unsigned int)rows[i].bits, rows[i].active, !rows[i].active);
        assert_int_equal(kernel.mask, 1);
        assert_int_equal(kernel.line_used, LINE);
    }
    for (unsigned int active = 0; active < 2; active++) {
        begin(NULL);
        kernel.bits = 7;
        ect_gpio_set(RESET, active != 0);
        assert_int_equal(kernel.bits, active);
        assert_int_equal(kernel.mask, 1);
        assert_int_equal(kernel.line_used, RESET);
    }
}

static void edges(void **state)
{
    enum { EVENT = sizeof(struct gpio_v2_line_event) };
    static const struct {
        const char *title;
        short polls[4];
        ssize_t reads[4];
        size_t polled, read;
    } rows[] = {
        {"no edge", {0}, {0}, 1, 0},
        {"one", {POLLIN, 0}, {EVENT}, 2, 1},
        {"more than one read takes", {POLLIN, POLLIN, 0}, {16 * (ssize_t)EVENT, EVENT}, 3, 2},
        {"an interface that is gone", {POLLERR}, {0}, 1, 0},
        {"a signal, after an edge", {POLLIN, -1}, {EVENT}, 2, 1},
        {"an end", {POLLIN}, {0}, 1, 1},
        {"a failure", {POLLIN}, {-1}, 1, 1},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        begin(NULL);
        kernel.polls = rows[i].polls;
        kernel.reads = rows[i].reads;
        ect_gpio_seen(LINE);
        if (kernel.polled != rows[i].polled || kernel.read != rows[i].read)
            fail_msg("%s: expected %zu polls and %zu reads, got %zu and %zu", rows[i].title, rows[i].polled,
                     rows[i].read, kernel.polled, kernel.read);
    }
}

/* --- SPI ---------------------------------------------------------------------------------------------------------- */

static void opens(void **state)
{
    static const struct {
        int of_open;
        unsigned long fails;
        int fails_with;
        const char *message; /* NULL: it opens */
    } rows[] = {
        {0, 0, 0, NULL},
        {ENOENT, 0, 0,
         "cannot use '/dev/spidev0.0': No such file or directory; on a Raspberry Pi: dtparam=spi=on in config.txt"},
        {EACCES, 0, 0, "cannot use '/dev/spidev0.0': Permission denied; on a Raspberry Pi the group spi has access"},
        {0, SPI_IOC_WR_MODE, ENOTTY,
         "cannot use '/dev/spidev0.0': Inappropriate ioctl for device; it is no SPI device"},
        {0, SPI_IOC_WR_MAX_SPEED_HZ, EINVAL, "cannot use '/dev/spidev0.0': Invalid argument"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char message[ECT_LINUX_MESSAGE] = "";
        ect_spidev_t bus;
        memset(&bus, 0x11, sizeof bus);
        begin("/dev/spidev0.0");
        kernel.error = rows[i].of_open;
        kernel.fails = rows[i].fails;
        kernel.fails_with = rows[i].fails_with;
        bool open = ect_spidev_open(&bus, "/dev/spidev0.0", 20000000, message);
        if (open != !rows[i].message || strcmp(message, open ? "" : rows[i].message) != 0)
            fail_msg("expected '%s', got %d '%s'", rows[i].message, open, message);
        assert_int_equal(open_descriptors(), open);
        assert_int_equal(bus.fd, open ? DEVICE : -1);
        assert_int_equal(bus.reset, -1);
        assert_int_equal(bus.line, -1);
        if (!open)
            continue;
        assert_int_equal(kernel.mode, SPI_MODE_0);
        assert_int_equal(kernel.speed_hz, 20000000);
    }
}

static void closes(void **state)
{
    ect_spidev_t bus = {.fd = DEVICE, .reset = RESET, .line = LINE};
    (void)state;
    begin(NULL);
    kernel.opened[DEVICE] = kernel.opened[RESET] = kernel.opened[LINE] = 1;
    ect_spidev_close(&bus);
    assert_int_equal(open_descriptors(), 0);
    ect_spidev_close(&bus); /* again: no effect */
    bus = (ect_spidev_t){.fd = -1, .reset = -1, .line = DEVICE};
    kernel.opened[DEVICE] = 1;
    ect_spidev_close(&bus);
    assert_int_equal(open_descriptors(), 0);
}

static void transfers(void **state)
{
    static const struct {
        int done, result;
    } rows[] = {{5, 0}, {4, -1}, {6, -1}, {0, -1}, {-1, -1}};
    ect_spidev_t bus = {.fd = DEVICE, .speed_hz = 12000000, .reset = -1, .line = -1};
    const ect_spi_t spi = ect_spidev_spi(&bus);
    uint8_t bytes[5] = {0};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        begin(NULL);
        kernel.done = rows[i].done;
        int result = spi.transfer(spi.ctx, bytes, sizeof bytes);
        if (result != rows[i].result)
            fail_msg("%d of 5 bytes: expected %d, got %d", rows[i].done, rows[i].result, result);
        assert_true(kernel.transfer.tx_buf == (uintptr_t)bytes && kernel.transfer.rx_buf == (uintptr_t)bytes);
        assert_int_equal(kernel.transfer.len, sizeof bytes);
        assert_int_equal(kernel.transfer.speed_hz, 12000000);
        assert_int_equal(kernel.transfer.bits_per_word, 8);
        assert_int_equal(kernel.transfer.cs_change, 0);
    }
}

static void wired_lines(void **state)
{
    static const struct {
        int reset, line;
    } rows[] = {{-1, -1}, {RESET, -1}, {-1, LINE}, {0, 1}, {1, 0}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_spidev_t bus = {.fd = DEVICE, .reset = rows[i].reset, .line = rows[i].line};
        const ect_spi_t spi = ect_spidev_spi(&bus);
        begin(NULL);
        if ((spi.reset != NULL) != (rows[i].reset >= 0) || (spi.line != NULL) != (rows[i].line >= 0))
            fail_msg("reset %d, line %d: got %d, %d", rows[i].reset, rows[i].line, spi.reset != NULL, spi.line != NULL);
        if (spi.reset) {
            spi.reset(spi.ctx, true);
            assert_int_equal(kernel.bits, 1);
            spi.reset(spi.ctx, false);
            assert_int_equal(kernel.bits, 0);
            assert_int_equal(kernel.line_used, rows[i].reset);
        }
        if (spi.line) {
            assert_false(spi.line(spi.ctx));
            kernel.bits = 1;
            assert_true(spi.line(spi.ctx));
            assert_int_equal(kernel.line_used, rows[i].line);
        }
    }
}

static void pauses(void **state)
{
    static const struct {
        uint32_t us;
        time_t s;
        long ns;
    } rows[] = {{0, 0, 0}, {1, 0, 1000}, {999999, 0, 999999000}, {1000000, 1, 0}, {2500001, 2, 500001000}};
    ect_spidev_t bus = {.fd = DEVICE, .reset = -1, .line = -1};
    const ect_spi_t spi = ect_spidev_spi(&bus);
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        begin(NULL);
        spi.pause(spi.ctx, rows[i].us);
        if (kernel.slept.tv_sec != rows[i].s || kernel.slept.tv_nsec != rows[i].ns)
            fail_msg("%u us: expected %ld s and %ld ns, got %ld and %ld", (unsigned int)rows[i].us, (long)rows[i].s,
                     rows[i].ns, (long)kernel.slept.tv_sec, kernel.slept.tv_nsec);
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"A GPIO line is named CHIP:LINE, the chip below /dev or by its path", names, NULL, end, NULL},
        {"The use of a GPIO line becomes the kernel's flags", uses, NULL, end, NULL},
        {"A GPIO line that cannot be taken: one line for the user, and no open descriptor", lines_that_cannot_be_taken,
         NULL, end, NULL},
        {"A GPIO line is read and set alone; a line that cannot be read counts as active", levels, NULL, end, NULL},
        {"All edges of a GPIO line are read, and a failure ends the loop", edges, NULL, end, NULL},
        {"An SPI device opens in mode 0 at its speed; each failure has a reason and a cure", opens, NULL, end, NULL},
        {"An SPI device closes with its lines, once", closes, NULL, end, NULL},
        {"An SPI transfer is one request of 8-bit words, complete or failed", transfers, NULL, end, NULL},
        {"Reset and interrupt exist where their lines are wired", wired_lines, NULL, end, NULL},
        {"A pause is split into seconds and nanoseconds", pauses, NULL, end, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("The port to Linux", tests, NULL, NULL);
}
