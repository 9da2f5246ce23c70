/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "board.h"

#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/signalfd.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "arguments.h"
#include "bus/storage/memory.h"
#include "ports/lan9252/lan9252.h"
#include "ports/linux/spidev.h"
#include "sii/fit.h"
#include "sii/sii.h"
#include "slave/indicator.h"

enum { CLEAN = 0, CANNOT_OPEN = 2, FAILED = 3, TRIES = 10 };
#define NS_PER_S 1000000000ull
#define RETRY_NS 100000000ull

typedef struct board {
    arguments_t args;
    ect_device_t device; /* as it is on this chip */
    ect_identity_t identity;
    ect_spidev_t bus;
    int run_led, err_led, signal_fd;
    ect_leds_t leds;
    ect_spi_t spi;
    ect_lan9252_t chip;
    ect_pdi_t pdi;
    ect_memory_t *memory;
    ect_slave_config_t config;
    ect_slave_t slave;
    uint32_t errors_seen; /* PDI accesses that failed until the last poll */
} board_t;

static uint64_t now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (uint64_t)t.tv_sec * NS_PER_S + (uint64_t)t.tv_nsec;
}

static int say(const char *message)
{
    fprintf(stderr, "ectwin-board: %s\n", message);
    return CANNOT_OPEN;
}

/* --- what is opened ----------------------------------------------------------------------------------------------- */

static void set_run(void *ctx, bool lit)
{
    ect_gpio_set(((const board_t *)ctx)->run_led, lit);
}

static void set_err(void *ctx, bool lit)
{
    ect_gpio_set(((const board_t *)ctx)->err_led, lit);
}

static bool open_line(const char *name, unsigned int use, int *line, char *message)
{
    *line = name ? ect_gpio_open(name, use, message) : -1;
    return !name || *line >= 0;
}

static bool open_lines(board_t *b, char *message)
{
    const arguments_t *a = &b->args;
    unsigned int level = a->interrupt_high ? ECT_GPIO_PULL_DOWN : ECT_GPIO_LOW | ECT_GPIO_PULL_UP;
    return open_line(a->interrupt, ECT_GPIO_INPUT | level, &b->bus.line, message) &&
           open_line(a->reset, ECT_GPIO_OUTPUT | ECT_GPIO_LOW, &b->bus.reset, message) &&
           open_line(a->run_led, ECT_GPIO_OUTPUT, &b->run_led, message) &&
           open_line(a->err_led, ECT_GPIO_OUTPUT, &b->err_led, message);
}

static bool open_memory(board_t *b, char *message)
{
    const arguments_t *a = &b->args;
    char path[ECT_MEMORY_PATH];
    if (a->store)
        (void)mkdir(a->store, 0700); /* an existing one is fine, and another failure is reported below */
    int length = snprintf(path, sizeof path, "%s/%s-1", a->store ? a->store : "", b->device.name);
    if (length >= (int)sizeof path) {
        snprintf(message, ECT_MEMORY_MESSAGE, "the name of the folder is too long");
        return false;
    }
    b->memory = ect_memory_open(a->store ? path : NULL, message);
    if (b->memory && message[0] != 0)
        (void)say(message);
    return b->memory != NULL;
}

/* Nothing of it is given back before the process ends. */
static void *take(void *ctx, size_t bytes)
{
    (void)ctx;
    return calloc(1, bytes);
}

static bool make_config(board_t *b, char *message)
{
    const ect_plant_t *plant = b->args.product->plant;
    size_t buffer = b->device.buffer_size;
    b->config = (ect_slave_config_t){
        .device = &b->device,
        .pdi = &b->pdi,
        .identity = &b->identity,
        .storage = ect_memory_storage(b->memory),
        .buffer = buffer > 0 ? take(b, buffer) : NULL,
        .outside_offset = plant ? plant->outside_offset : 0,
        .outside_size = plant ? plant->outside_size : 0,
        .device_id = b->args.alias,
    };
    if (ect_slave_take(&b->config, take, b) && (buffer == 0 || b->config.buffer))
        return true;
    snprintf(message, ECT_MEMORY_MESSAGE, "not enough memory");
    return false;
}

/* The signals end the command even if a shell ignores them in the background, because a blocked signal is queued all
 * the same; SIGHUP that nohup ignores does not. */
static bool open_signals(board_t *b, char *message)
{
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, SIGINT);
    sigaddset(&set, SIGTERM);
    if (signal(SIGHUP, SIG_DFL) == SIG_IGN)
        signal(SIGHUP, SIG_IGN);
    else
        sigaddset(&set, SIGHUP);
    sigprocmask(SIG_BLOCK, &set, NULL);
    b->signal_fd = signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK);
    if (b->signal_fd < 0)
        snprintf(message, ECT_MEMORY_MESSAGE, "cannot wait for the signals that end it: %s", strerror(errno));
    return b->signal_fd >= 0;
}

static int open_board(board_t *b)
{
    char message[ECT_MEMORY_MESSAGE];
    _Static_assert((int)ECT_MEMORY_MESSAGE >= (int)ECT_LINUX_MESSAGE, "room for either");
    if (!open_signals(b, message) || !ect_spidev_open(&b->bus, b->args.spi, b->args.speed_hz, message) ||
        !open_lines(b, message) || !open_memory(b, message) || !make_config(b, message))
        return say(message);
    b->spi = ect_spidev_spi(&b->bus);
    b->chip = (ect_lan9252_t){.spi = &b->spi, .interrupt_high = b->args.interrupt_high};
    b->pdi = ect_lan9252_pdi(&b->chip);
    b->leds = (ect_leds_t){.ctx = b, .run = b->run_led >= 0 ? set_run : NULL, .err = b->err_led >= 0 ? set_err : NULL};
    return CLEAN;
}

/* --- the slave ---------------------------------------------------------------------------------------------------- */

static const char *reason(int result)
{
    switch (result) {
    case ECT_LAN9252_SPI:
        return "transfers on the SPI fail, or the chip does not carry out accesses: check wiring and --speed";
    case ECT_LAN9252_SILENT:
        return "no LAN9252 replies on this SPI: check power, wiring, chip select and SPI mode 0, or try --speed "
               "1000000";
    case ECT_LAN9252_STRANGER:
        return "another chip replies on this SPI: check --spi and chip select";
    case ECT_LAN9252_NOT_READY:
        return "the LAN9252 does not get ready: check its clock and its reset pin";
    default:
        return "the LAN9252 has no good EEPROM: write what --eeprom FILE makes to it, with a programmer or from a "
               "master, "
               "and switch it off and on";
    }
}

/* Each start of the device gets a zeroed buffer. @return as ect_slave_init */
static int init_slave(board_t *b)
{
    if (b->config.buffer)
        memset(b->config.buffer, 0, b->device.buffer_size);
    return ect_slave_init(&b->slave, &b->config, now());
}

/* @return a result of ect_lan9252_start */
static int start(board_t *b)
{
    const ect_plant_t *plant = b->args.product->plant;
    int result = ect_lan9252_start(&b->chip);
    if (result != ECT_LAN9252_READY)
        return result;
    b->config.switches = plant && plant->station_alias ? plant->station_alias(b->config.instance) : 0;
    for (unsigned int n = 0; n < TRIES; n++) {
        if (init_slave(b) == 0)
            return ECT_LAN9252_READY;
    }
    return ECT_LAN9252_SPI;
}

/* Until the time has come, the chip has something, or a signal ends us. @return whether none did */
static bool wait_until(const board_t *b, uint64_t deadline_ns)
{
    struct pollfd fds[] = {{.fd = b->signal_fd, .events = POLLIN}, {.fd = b->bus.line, .events = POLLIN}};
    uint64_t now_ns = now();
    uint64_t most_ns = b->bus.line >= 0 ? NS_PER_S : b->args.poll_us * 1000ull;
    uint64_t wait_ns = deadline_ns > now_ns ? deadline_ns - now_ns : 0;
    if (b->bus.line >= 0) {
        ect_gpio_seen(b->bus.line); /* then the level: an edge that comes now is not lost */
        if (ect_gpio_get(b->bus.line))
            wait_ns = 0;
    }
    wait_ns = wait_ns < most_ns ? wait_ns : most_ns;
    const struct timespec timeout = {.tv_sec = (time_t)(wait_ns / NS_PER_S), .tv_nsec = (long)(wait_ns % NS_PER_S)};
    (void)ppoll(fds, b->bus.line >= 0 ? 2 : 1, &timeout, NULL);
    return (fds[0].revents & POLLIN) == 0;
}

static uint64_t turn(board_t *b)
{
    uint64_t now_ns = now();
    uint64_t slave_ns = ect_slave_poll(&b->slave, now_ns);
    bool failing = b->slave.pdi_errors != b->errors_seen;
    b->errors_seen = b->slave.pdi_errors;
    uint64_t leds_ns = ect_indicator_drive(&b->slave, &b->leds, failing, now_ns);
    return slave_ns < leds_ns ? slave_ns : leds_ns;
}

/* A save that is under way is complete before the process ends. */
static void finish(board_t *b)
{
    const struct timespec pause = {.tv_nsec = 100000};
    const ect_plant_t *plant = b->args.product->plant;
    uint64_t end_ns = now() + 2 * NS_PER_S;
    while (plant && plant->unfinished && plant->unfinished(b->config.instance) && now() < end_ns) {
        (void)nanosleep(&pause, NULL);
        (void)turn(b);
    }
}

/* The chip may stay away, e.g. without power, for any time. @return whether it is back before a signal ends the process
 */
static bool restart(board_t *b)
{
    int before = ECT_LAN9252_READY;
    for (int result; (result = start(b)) != ECT_LAN9252_READY; before = result) {
        if (result != before)
            (void)say(reason(result));
        if (!wait_until(b, now() + RETRY_NS))
            return false;
    }
    return true;
}

/* @return false: a signal ends the process */
static bool serve(board_t *b)
{
    uint64_t next_ns = turn(b);
    bool reset = b->slave.restart && ect_lan9252_reset(&b->chip);
    bool lost = !reset && !ect_lan9252_check(&b->chip, now());
    if ((reset || lost) && !restart(b))
        return false;
    if (lost)
        (void)say("the LAN9252 was reset, by the master or by its supply, and has been started again");
    if (reset || lost)
        next_ns = 0;
    return wait_until(b, next_ns < b->chip.check_ns ? next_ns : b->chip.check_ns);
}

static int run(board_t *b)
{
    int result = start(b);
    if (result != ECT_LAN9252_READY)
        return say(reason(result));
    printf("{\"event\":\"ready\",\"spi\":\"%s\",\"device\":\"%s\"}\n", b->args.spi, b->device.name);
    if (fflush(stdout) != 0)
        return say(strerror(errno));
    while (serve(b)) {
    }
    finish(b);
    return init_slave(b) == 0 ? CLEAN : FAILED; /* INIT, all buffers off */
}

static int write_eeprom(const board_t *b)
{
    uint8_t *image = calloc(1, b->device.sii_size);
    FILE *file = image ? fopen(b->args.eeprom, "wb") : NULL;
    bool done = file && ect_sii_write(&b->device, &b->identity, b->args.alias, image, b->device.sii_size) >= 0 &&
                fwrite(image, 1, b->device.sii_size, file) == b->device.sii_size;
    done = (!file || fclose(file) == 0) && done;
    if (!done)
        fprintf(stderr, "ectwin-board: cannot write '%s': %s\n", b->args.eeprom, strerror(errno));
    free(image);
    return done ? CLEAN : CANNOT_OPEN;
}

int ectwin_board_main(int argc, char **argv)
{
    static board_t b;
    b = (board_t){
        .args = read_arguments(argc, argv), .bus = {.fd = -1, .reset = -1, .line = -1}, .run_led = -1, .err_led = -1};
    if (!ect_fit(b.args.product->device, &ect_fit_lan9252, &b.device)) {
        fprintf(stderr, "ectwin-board: %s does not fit into a LAN9252\n", b.args.product->device->name);
        return CANNOT_OPEN;
    }
    b.identity = b.device.identity;
    if (b.args.serial != 0)
        b.identity.serial = b.args.serial;
    if (b.args.eeprom)
        return write_eeprom(&b);
    int status = open_board(&b);
    if (status == CLEAN)
        status = run(&b);
    ect_memory_close(b.memory);
    ect_spidev_close(&b.bus);
    return status;
}
