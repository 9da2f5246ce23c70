/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "ports/soes_hal/hal.h"

#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "bus/net/packet.h"
#include "esc/esc.h"
#include "sii/sii.h"
#include "wire/bytes.h"
#include "wire/registers.h"

enum { EXIT_USAGE = 1, EXIT_OPEN = 2 };
enum { WAIT_NS = 1000000, FRAMES_FIRST = 8, FRAME_ROOM = ECT_ESC_MAX_FRAME + 48, LARGEST_SII = 65536 };

static struct {
    const char *iface, *sii_file;
    bool open;
    ect_packet_t port;
    ect_esc_config_t config;
    ect_esc_t esc;
    uint32_t seen; /* AL events reported to the application */
} hal;
static volatile sig_atomic_t ended;

__attribute__((format(printf, 2, 3), noreturn)) static void give_up(int status, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fprintf(stderr, "%s: ", program_invocation_short_name);
    (void)vfprintf(stderr, format, arguments);
    fputc('\n', stderr);
    va_end(arguments);
    exit(status);
}

/* --- options ------------------------------------------------------------------------------------------------------ */

/* @return the value of an option at argv[*n], in the same or the next argument; NULL: another option; "": the value is
 * missing */
static char *value_of(const char *name, int argc, char **argv, int *n)
{
    size_t length = strlen(name);
    if (strncmp(argv[*n], name, length) != 0)
        return NULL;
    char *rest = argv[*n] + length;
    if (*rest == '\0')
        return *n + 1 < argc ? argv[++*n] : rest;
    return *rest == '=' && name[1] == '-' ? rest + 1 : NULL;
}

static bool take_option(int argc, char **argv, int *n)
{
    const char *iface = value_of("-i", argc, argv, n);
    const char *sii = iface ? NULL : value_of("--sii", argc, argv, n);
    hal.iface = iface && *iface ? iface : hal.iface;
    hal.sii_file = sii && *sii ? sii : hal.sii_file;
    return (iface && *iface) || (sii && *sii);
}

bool ect_soes_hal_arguments(int argc, char **argv)
{
    for (int n = 1; n < argc; n++) {
        if (!take_option(argc, argv, &n)) {
            fprintf(stderr, "usage: %s -i IFACE [--sii FILE]\n", program_invocation_short_name);
            return false;
        }
    }
    return true;
}

/* Reads the options from the command line of the process, because main may not pass them. Other arguments belong to the
 * application. */
static void read_command_line(void)
{
    enum { ROOM = 4096, ARGUMENTS = 64 };
    static char text[ROOM];
    char *argv[ARGUMENTS];
    int argc = 0;
    FILE *file = fopen("/proc/self/cmdline", "re");
    size_t length = file ? fread(text, 1, sizeof text - 1, file) : 0;
    if (file)
        fclose(file);
    for (char *next = text; next < text + length && argc < ARGUMENTS; next += strlen(next) + 1)
        argv[argc++] = next;
    for (int n = 1; n < argc; n++)
        (void)take_option(argc, argv, &n);
}

/* --- the EEPROM --------------------------------------------------------------------------------------------------- */

static uint8_t *load_sii(uint32_t *size)
{
    uint8_t *image = calloc(1, LARGEST_SII);
    FILE *file = fopen(hal.sii_file, "rbe");
    if (!image || !file)
        give_up(EXIT_OPEN, "cannot open the EEPROM's content '%s': %s", hal.sii_file, strerror(errno));
    size_t length = fread(image, 1, LARGEST_SII, file);
    fclose(file);
    if (length < ECT_SII_CATEGORIES || length % 2 != 0 || image[14] != ect_sii_checksum(image))
        give_up(EXIT_OPEN,
                "'%s' is not the content of an EEPROM: its first 16 bytes have no valid check value, and the firmware "
                "would wait endlessly",
                hal.sii_file);
    *size = (uint32_t)length;
    return image;
}

/* Warns of a difference, because the firmware compares the SyncManagers with its ecat_options.h and refuses others. */
static void compare(const ect_device_t *device, const uint8_t *image, size_t size)
{
    size_t length = 0;
    const uint8_t *sm = ect_sii_category(image, size, ECT_SII_SYNCM, &length);
    for (unsigned int n = 0; sm && n < device->sm_count && 8u * (n + 1) <= length; n++, sm += 8) {
        if (ect_load_le16(sm) != device->sm[n].start || sm[4] != device->sm[n].control)
            fprintf(stderr,
                    "%s: '%s' has SyncManager %u at 0x%04X with control 0x%02X, ecat_options.h at 0x%04X with 0x%02X: "
                    "the firmware will refuse the master's settings\n",
                    program_invocation_short_name, hal.sii_file, n, ect_load_le16(sm), sm[4], device->sm[n].start,
                    device->sm[n].control);
    }
}

static uint8_t *make_sii(const ect_device_t *device, uint32_t *size)
{
    uint8_t *image = calloc(1, device->sii_size);
    if (!image || ect_sii_write(device, NULL, 0, image, device->sii_size) < 0)
        give_up(EXIT_OPEN, "the object list does not fit into an EEPROM of %u bytes: name its content with --sii FILE",
                device->sii_size);
    *size = device->sii_size;
    return image;
}

/* --- the chip ----------------------------------------------------------------------------------------------------- */

static void power_on(void)
{
    if (ect_esc_init(&hal.esc, &hal.config, ect_packet_now()) != 0)
        give_up(EXIT_OPEN, "the software ESC cannot be made");
    hal.seen = 0;
}

static void end(int signal_number)
{
    (void)signal_number;
    ended = 1;
}

/* Writes the ready line to the descriptor of a parent that waits for it, else to standard output. */
static void report_ready(void)
{
    const char *waiting = getenv("ECTWIN_READY_FD");
    FILE *file = waiting ? fdopen((int)strtol(waiting, NULL, 10), "w") : stdout;
    if (!file)
        return;
    fprintf(file, "{\"event\":\"ready\",\"iface\":\"%s\",\"slaves\":1}\n", hal.port.iface);
    if (waiting)
        fclose(file);
    else
        fflush(file);
}

static void open_interface(void)
{
    char message[ECT_PACKET_MESSAGE];
    const struct sigaction action = {.sa_handler = end};
    read_command_line();
    hal.iface = hal.iface ? hal.iface : getenv("ECTWIN_SOES_IFACE");
    hal.sii_file = hal.sii_file ? hal.sii_file : getenv("ECTWIN_SOES_SII");
    if (!hal.iface)
        give_up(EXIT_USAGE, "the interface is missing: -i IFACE, or $ECTWIN_SOES_IFACE");
    if (ect_packet_open(&hal.port, hal.iface, message) < 0)
        give_up(EXIT_OPEN, "%s", message);
    (void)sigaction(SIGINT, &action, NULL);
    (void)sigaction(SIGTERM, &action, NULL);
    (void)sigaction(SIGHUP, &action, NULL);
}

void ect_soes_hal_init(const ect_device_t *device)
{
    const ect_esc_personality_t *personality = ect_esc_personality(device->esc);
    if (hal.open) {
        power_on();
        return;
    }
    open_interface();
    hal.config.personality = personality;
    hal.config.memory = personality ? calloc(1, ECT_ESC_MEMORY_SIZE(personality->ram_kb)) : NULL;
    hal.config.sii = hal.sii_file ? load_sii(&hal.config.sii_size) : make_sii(device, &hal.config.sii_size);
    if (hal.sii_file)
        compare(device, hal.config.sii, hal.config.sii_size);
    power_on();
    hal.open = true;
    report_ready();
}

void ect_soes_hal_reset(void)
{
    if (hal.open)
        power_on();
}

/* --- frames ------------------------------------------------------------------------------------------------------- */

static void close_all(void)
{
    ect_packet_close(&hal.port);
    free(hal.config.memory);
    free(hal.config.sii);
    exit(EXIT_SUCCESS);
}

/* @return whether an event has not yet been reported to the application */
static bool has_new_events(void)
{
    return (ect_esc_al_event(&hal.esc) & ~hal.seen) != 0;
}

/* Waits for a frame, a signal, or the chip's next deadline; does not wait while an event is unreported. */
static void wait_for_frame(void)
{
    struct pollfd fds[] = {{.fd = hal.port.fd, .events = POLLIN}, {.fd = hal.port.tagged_fd, .events = POLLIN}};
    uint64_t now = ect_packet_now();
    uint64_t next = ect_esc_tick(&hal.esc, now);
    uint64_t wait = next - now < WAIT_NS ? next - now : WAIT_NS;
    const struct timespec timeout = {.tv_nsec = has_new_events() || next <= now ? 0 : (long)wait};
    (void)ppoll(fds, 2, &timeout, NULL);
}

/* @return whether there was one */
static bool answer(void)
{
    uint8_t frame[FRAME_ROOM];
    ect_packet_time_t time;
    ssize_t length = ect_packet_receive(&hal.port, false, frame, sizeof frame, &time);
    if (length == ECT_PACKET_GONE)
        give_up(EXIT_OPEN, "stopped on '%s': %s", hal.port.iface, strerror(errno));
    if (length == ECT_PACKET_NONE)
        return false;
    if (length != ECT_PACKET_STALE &&
        ect_esc_process(&hal.esc, frame, (size_t)length, time.now_ns) == ECT_FRAME_FORWARD)
        ect_packet_send(&hal.port, frame, (size_t)length);
    return true;
}

/* Passes frames until an event occurs, so that the application handles the event before the next frame, like a fast
 * processor. */
static void serve(void)
{
    unsigned int frames = 0;
    wait_for_frame();
    while (frames < FRAMES_FIRST && answer() && !has_new_events())
        frames++;
    (void)ect_esc_tick(&hal.esc, ect_packet_now());
    if (ended)
        close_all();
    hal.seen = ect_esc_al_event(&hal.esc);
}

/* @return the AL events. An event cleared by the access counts as unreported when it occurs again */
static uint32_t event(void)
{
    uint32_t now = ect_esc_al_event(&hal.esc);
    hal.seen &= now;
    return now;
}

/* Permits reads of 0 bytes: SOES reads as many bytes as the header of a mail states. */
uint32_t ect_soes_hal_read(uint16_t address, void *buffer, uint16_t length)
{
    if (address == ECT_REG_DC_SYSTEM_TIME || address == ECT_REG_DL_STATUS)
        serve();
    if (length > 0)
        (void)ect_esc_pdi_read(&hal.esc, address, buffer, length);
    return event();
}

uint32_t ect_soes_hal_write(uint16_t address, const void *buffer, uint16_t length)
{
    if (length > 0)
        (void)ect_esc_pdi_write(&hal.esc, address, buffer, length);
    return event();
}
