/* SPDX-License-Identifier: MIT */
/*
 * The whole command ectwin-board, on a Linux of its own: the SPI and GPIO lines that it opens belong to a virtual
 * LAN9252, whose ESC is at a network interface. usage: board_of_tests IFACE ARGUMENT... (the device is the last one)
 *
 * Environment: LATE=BYTES until the chip is ready, CSR_LASTS=BYTES, WORD_LASTS=BYTES (ports/virtual/lan9252.h);
 * FAULTS_MS: for so long after the start one bit in 100000 flips, and the chip hangs for 0.2 s of each second. SAVE:
 * the signal `save` starts a save of the device, and the disk is so slow that the save is active when the signal to end
 * arrives; "saving" on standard error reports that it is.
 */
#define _GNU_SOURCE
#include <aio.h>
#include <errno.h>
#include <fcntl.h>
#include <linux/gpio.h>
#include <linux/spi/spidev.h>
#include <poll.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "board.h"
#include "bus/chain/catalogue.h"
#include "bus/net/packet.h"
#include "ports/virtual/lan9252.h"
#include "sii/fit.h"
#include "sii/sii.h"
#include "slave/slave.h"

/* --- the chip, at the interface ----------------------------------------------------------------------------------- */

static ect_esc_t esc;
static ect_virtual_lan9252_t chip = {.esc = &esc};
static ect_packet_t port;
static int spi_fd = -1, chip_fd = -1, reset_fd = -1;
static int irq[2] = {-1, -1}; /* the descriptor returned for the line, and the end to which its edges are written */
static bool irq_level;
static bool ending; /* the command has its signal to end */

static uint64_t now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (uint64_t)t.tv_sec * 1000000000ull + (uint64_t)t.tv_nsec;
}

/* Reports an edge to the reader of the line. */
static void follow_line(void)
{
    static const struct gpio_v2_line_event event = {.id = GPIO_V2_LINE_EVENT_RISING_EDGE};
    bool level = ect_virtual_lan9252_line(&chip);
    if (level && !irq_level && irq[1] >= 0 && write(irq[1], &event, sizeof event) < 0)
        abort();
    irq_level = level;
}

/* Processes all frames that have arrived, however late: a frame that a busy machine drops is one more disturbance for
 * the master, and not under test. */
static void answer(void)
{
    uint8_t frame[2100];
    ssize_t length;
    (void)ect_esc_tick(&esc, now());
    while ((length = recv(port.fd, frame, sizeof frame, MSG_DONTWAIT)) > 0) {
        if (ect_esc_process(&esc, frame, (size_t)length, now()) == ECT_FRAME_FORWARD)
            ect_packet_send(&port, frame, (size_t)length);
    }
    follow_line();
}

static uint32_t from_environment(const char *name)
{
    const char *text = getenv(name);
    return text ? (uint32_t)strtoul(text, NULL, 0) : 0;
}

/* Faults of the chip in its first FAULTS_MS; after that it works. */
static void apply_fault(void)
{
    static uint64_t start_ns, end_ns;
    if (start_ns == 0) {
        start_ns = now();
        end_ns = start_ns + from_environment("FAULTS_MS") * 1000000ull;
    }
    bool young = now() < end_ns;
    chip.flip_one_in = young ? 100000 : 0;
    chip.csr_stuck = young && (now() - start_ns) / 1000000 % 1000 >= 800;
    if (!chip.csr_stuck && chip.csr_left > chip.csr_lasts)
        chip.csr_left = 0;
}

static bool power_on(const char *iface, const char *device)
{
    static uint8_t memory[ECT_ESC_MEMORY_SIZE(4)];
    static ect_device_t on;
    const ect_product_t *product = ect_catalogue_find(device);
    char message[ECT_PACKET_MESSAGE];
    if (!product || !ect_fit(product->device, &ect_fit_lan9252, &on))
        return true; /* the command itself reports that */
    uint8_t *sii = calloc(1, on.sii_size);
    ect_esc_config_t config = {
        .personality = ect_esc_personality("lan9252"), .memory = memory, .sii = sii, .sii_size = on.sii_size};
    if (!sii || ect_sii_write(&on, &on.identity, 0, sii, on.sii_size) < 0 || ect_esc_init(&esc, &config, now()) != 0)
        return false;
    chip.starting = chip.ready_after = from_environment("LATE");
    chip.csr_lasts = from_environment("CSR_LASTS");
    chip.word_lasts = from_environment("WORD_LASTS");
    if (ect_packet_open(&port, iface, message) == 0)
        return true;
    fprintf(stderr, "%s\n", message);
    return false;
}

/* --- the calls of ports/linux
 * ----------------------------------------------------------------------------------------- */

int __real_open(const char *path, int flags, ...);
int __wrap_open(const char *path, int flags, ...);
int __real_ioctl(int fd, unsigned long request, ...);
int __wrap_ioctl(int fd, unsigned long request, ...);

int __wrap_open(const char *path, int flags, ...)
{
    va_list more;
    va_start(more, flags);
    int mode = (flags & O_CREAT) != 0 ? va_arg(more, int) : 0;
    va_end(more);
    if (strcmp(path, "/dev/spidev7.1") == 0)
        return spi_fd = __real_open("/dev/null", flags);
    if (strcmp(path, "/dev/gpiochip9") == 0)
        return chip_fd = __real_open("/dev/null", flags);
    return __real_open(path, flags, mode);
}

/* As the kernel: a line is a descriptor of its own. 25 is the interrupt, 24 the reset. */
static int take_line(struct gpio_v2_line_request *request)
{
    const uint64_t low = GPIO_V2_LINE_FLAG_ACTIVE_LOW | GPIO_V2_LINE_FLAG_BIAS_PULL_UP;
    const uint64_t high = GPIO_V2_LINE_FLAG_BIAS_PULL_DOWN;
    int ends[2];
    if (request->offsets[0] == 24 && (request->config.flags & GPIO_V2_LINE_FLAG_OUTPUT) != 0) {
        request->fd = reset_fd = __real_open("/dev/null", O_RDWR);
        return 0;
    }
    if (request->offsets[0] != 25 || (request->config.flags & GPIO_V2_LINE_FLAG_EDGE_RISING) == 0 ||
        (request->config.flags & (low | high)) != (chip.active_high ? high : low) || pipe(ends) < 0)
        return -1;
    irq[0] = request->fd = ends[0];
    irq[1] = ends[1];
    return 0;
}

static int set_values(const struct gpio_v2_line_values *values)
{
    ect_virtual_lan9252_reset(&chip, (values->bits & 1) != 0);
    return 0;
}

static int transfer(const struct spi_ioc_transfer *t)
{
    if (t->tx_buf != t->rx_buf || t->bits_per_word != 8 || t->speed_hz > 30000000)
        return -1;
    apply_fault();
    answer();
    (void)ect_virtual_lan9252_transfer(&chip, (uint8_t *)(uintptr_t)t->rx_buf, (uint16_t)t->len);
    follow_line();
    if (chip.mistakes != 0 && from_environment("FAULTS_MS") == 0) {
        fprintf(stderr, "a mistake of the driver: %s\n", chip.mistake);
        abort();
    }
    return (int)t->len;
}

static int ours(int fd, unsigned long request, void *argument)
{
    if (fd == chip_fd && request == GPIO_V2_GET_LINE_IOCTL)
        return take_line(argument);
    if (fd == irq[0] && request == GPIO_V2_LINE_GET_VALUES_IOCTL) {
        ((struct gpio_v2_line_values *)argument)->bits = ect_virtual_lan9252_line(&chip);
        return 0;
    }
    if (fd == reset_fd && request == GPIO_V2_LINE_SET_VALUES_IOCTL)
        return set_values(argument);
    if (request == SPI_IOC_MESSAGE(1))
        return transfer(argument);
    return request == SPI_IOC_WR_MODE || request == SPI_IOC_WR_MAX_SPEED_HZ ? 0 : -1;
}

int __wrap_ioctl(int fd, unsigned long request, ...)
{
    va_list more;
    va_start(more, request);
    void *argument = va_arg(more, void *);
    va_end(more);
    if (fd < 0 || (fd != spi_fd && fd != chip_fd && fd != irq[0] && fd != reset_fd))
        return __real_ioctl(fd, request, argument);
    return ours(fd, request, argument);
}

/* --- a save, and a disk that takes until the command has its signal to end ---------------------------------------- */

int __real_ect_slave_init(ect_slave_t *slave, const ect_slave_config_t *config, uint64_t now_ns);
int __wrap_ect_slave_init(ect_slave_t *slave, const ect_slave_config_t *config, uint64_t now_ns);
int __real_aio_fsync(int operation, struct aiocb *control);
int __wrap_aio_fsync(int operation, struct aiocb *control);
int __real_aio_error(const struct aiocb *control);
int __wrap_aio_error(const struct aiocb *control);
ssize_t __real_aio_return(struct aiocb *control);
ssize_t __wrap_aio_return(struct aiocb *control);

static void press_save(void *instance, const ect_plant_t *plant)
{
    const ect_signal_group_t *all = &plant->signal_groups[0];
    const uint8_t pressed = 1;
    for (unsigned int i = 0; i < all->signal_count; i++) {
        if (strcmp(all->signals[i].name, "save") == 0)
            (void)plant->signal_write(instance, &all->signals[i], 0, &pressed, now());
    }
}

int __wrap_ect_slave_init(ect_slave_t *slave, const ect_slave_config_t *config, uint64_t now_ns)
{
    int result = __real_ect_slave_init(slave, config, now_ns);
    if (getenv("SAVE") && !ending)
        press_save(config->instance, ect_catalogue_find(config->device->name)->plant);
    return result;
}

int __wrap_aio_fsync(int operation, struct aiocb *control)
{
    if (!getenv("SAVE"))
        return __real_aio_fsync(operation, control);
    if (!ending)
        fputs("saving\n", stderr);
    return 0;
}

int __wrap_aio_error(const struct aiocb *control)
{
    if (!getenv("SAVE"))
        return __real_aio_error(control);
    return ending ? 0 : EINPROGRESS;
}

ssize_t __wrap_aio_return(struct aiocb *control)
{
    return getenv("SAVE") ? 0 : __real_aio_return(control);
}

/* While the command waits, the ESC runs: frames get their replies, and an edge of the line ends the wait. */
int __real_ppoll(struct pollfd *fds, nfds_t count, const struct timespec *timeout, const sigset_t *mask);
int __wrap_ppoll(struct pollfd *fds, nfds_t count, const struct timespec *timeout, const sigset_t *mask);

int __wrap_ppoll(struct pollfd *fds, nfds_t count, const struct timespec *timeout, const sigset_t *mask)
{
    struct pollfd all[4] = {{.fd = port.fd, .events = POLLIN}};
    uint64_t end_ns = now() + (uint64_t)timeout->tv_sec * 1000000000ull + (uint64_t)timeout->tv_nsec;
    int ready = 0;
    if (count > 3)
        abort();
    memcpy(all + 1, fds, count * sizeof fds[0]);
    do {
        uint64_t left_ns = end_ns > now() ? end_ns - now() : 0;
        const struct timespec most = {.tv_nsec = (long)(left_ns < 1000000 ? left_ns : 1000000)};
        (void)__real_ppoll(all, count + 1, &most, mask);
        answer();
        ready = __real_ppoll(fds, count, &(const struct timespec){0}, mask);
    } while (ready == 0 && now() < end_ns);
    ending |= fds[0].revents != 0;
    return ready;
}

int main(int argc, char **argv)
{
    if (argc < 3 || !power_on(argv[1], argv[argc - 1]))
        return 9;
    argv[1] = argv[0];
    for (int n = 2; n < argc; n++)
        chip.active_high |= strcmp(argv[n], "--irq-high") == 0;
    return ectwin_board_main(argc - 1, argv + 1);
}
