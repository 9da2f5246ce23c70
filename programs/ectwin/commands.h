/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The subcommands of `ectwin`, and their common parts. Each subcommand gets the arguments from its own name on.
 */
#ifndef ECTWIN_COMMANDS_H
#define ECTWIN_COMMANDS_H

#include <argp.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "bus/chain/chain.h"
#include "bus/control/control.h"
#include "bus/runner.h"
#include "bus/storage/eeprom.h"
#include "bus/storage/files.h"
#include "bus/storage/memory.h"
#include "content.h"
#include "defects.h"
#include "eoe_args.h"
#include "esi/twin.h"
#include "wiring_args.h"

/** Exit codes, stable for scripts (docs/COMMAND.md). */
enum { EXIT_CLEAN = 0, EXIT_USAGE = 1, EXIT_OPEN = 2, EXIT_RUN = 3 };

int command_list(int argc, char **argv);
int command_run(int argc, char **argv);
int command_with(int argc, char **argv);
int command_sii(int argc, char **argv);
int command_verify(int argc, char **argv);
int command_lint(int argc, char **argv);
int command_clone(int argc, char **argv);
int command_check(int argc, char **argv);
int command_save_bus(int argc, char **argv);
int command_esi(int argc, char **argv);
int command_new(int argc, char **argv);
int command_eni(int argc, char **argv);
int command_doc(int argc, char **argv);
int command_objects(int argc, char **argv);
int command_ps(int argc, char **argv);
int command_enter(int argc, char **argv);
int command_wait(int argc, char **argv);
int command_veth(int argc, char **argv);
int command_complete(int argc, char **argv);
int command_replay(int argc, char **argv);
int command_stats(int argc, char **argv);
int command_get(int argc, char **argv);
int command_set(int argc, char **argv);
int command_watch(int argc, char **argv);
int command_list_signals(int argc, char **argv);
int command_command(int argc, char **argv);
int command_periodic(int argc, char **argv);
int command_fault(int argc, char **argv);
int command_unplug(int argc, char **argv);
int command_plug(int argc, char **argv);
int command_cut(int argc, char **argv);
int command_mend(int argc, char **argv);
int command_panel(int argc, char **argv);

/** Room for the reason of a failed power-on. */
enum { TWIN_MESSAGE = 1280 };

/** "[N:]VALUE" of an identity option. */
typedef struct identity_setting {
    int key;          /**< of the option */
    const char *text; /**< its argument */
    size_t twin;      /**< from 1; 0: all */
    uint32_t value;
} identity_setting_t;

/** The module in a slot of a modular twin; `twin` counts from 1. */
typedef struct twin_module {
    size_t twin;
    ect_module_choice_t choice;
    const char *text; /**< argument of the option */
} twin_module_t;

/** The behaviour of a twin from a file. `twin` counts from 1; 0: all twins from files. */
typedef struct twin_behaviour {
    size_t twin;
    ect_behaviour_t behaviour;
    const char *text; /**< argument of the option */
} twin_behaviour_t;

/** An option with the name of a twin, kept until the list of devices has been read. */
typedef struct twin_later {
    int key;
    const char *text;
    size_t steps; /**< of the scenario, with its own */
} twin_later_t;

/** The twins of a command line: devices and their options. */
typedef struct twin_args {
    ect_twin_config_t *twins;
    size_t count;
    ect_names_t *names; /* of the twins */
    twin_later_t *later;
    size_t later_count;
    bool given; /* an option for twins was given; options in `wiring` and `eoe` do not count */
    identity_setting_t *identities;
    size_t identity_count;
    bool keep_source_mac;
    bool kinds; /* the devices are single devices, not a chain: serial numbers do not count up */
    wiring_args_t wiring;
    eoe_args_t eoe;
    uint8_t drop_percent, delay_percent;
    uint32_t delay_us;
    ect_scenario_t scenario; /* --fault, --faults, --drop, --delay, and faults set at run time */
    const char *farthest;    /* the fault with the highest slave number */
    defect_t defect;         /* --break */
    ect_filter_t filter;
    int realtime;        /* real-time priority; 0: normal scheduling */
    bool busy_poll;      /* polls the interfaces continuously */
    bool in_kernel;      /* replies in the kernel to frames with a plan */
    bool quiet;          /* no notes on standard error */
    ect_about_t about;   /* name and devices, as given */
    const char *modbus;  /* [ADDRESS:]PORT of a Modbus TCP server, NULL: none */
    const char *udp;     /* [ADDRESS:]PORT of EtherCAT in UDP, NULL: none */
    const char *store;   /* folder of the twins' non-volatile memory, NULL: none */
    const char *files;   /* folder that a master reads and writes by FoE, NULL: none */
    const char *esi_dir; /* folder of ESI files for the slaves of an ENI, NULL: none */
    uint32_t files_password;
    const char *pcap;   /* capture file, NULL: none */
    uint64_t pcap_size; /* 0: no limit */
    const char *record; /* file for a replay, NULL: none */
    char *const *words; /* the command line, for a record */
    int word_count;
    char *joined; /* the working directory and `words`, for the control socket */
    uint64_t power_on_ns;
    content_t content;     /* of --store and --files at power-on: written to a record, or read from one */
    bool replayed;         /* this is a replay: the content comes from the record, --store is not opened */
    bool in_process;       /* one of several buses of a command: each appends a section to the capture */
    bool own_clock;        /* times are not those of CLOCK_MONOTONIC: a capture keeps them unchanged */
    const char **settings; /* "[N:]NAME=VALUE" */
    size_t setting_count;
    twin_module_t *modules;
    size_t module_count;
    const char **connections; /* --connect */
    size_t connection_count;
    twin_behaviour_t *behaviours;
    size_t behaviour_count;
    ect_files_t **opened;    /* the folder of --files, one for each twin; NULL without --files */
    ect_eeprom_t **eeproms;  /* one for each twin; NULL elements without --store */
    ect_memory_t **memories; /* one for each twin, from power-on */
    char *message;           /* TWIN_MESSAGE bytes for the reason of a failed power-on; NULL: standard error */
} twin_args_t;

/** Argp parser for the options of twins; its input is a twin_args_t. */
extern const struct argp twin_argp;

/** Reports the reason of a failed power-on to args->message, or as a line to standard error. */
void twin_args_report(const twin_args_t *args, const char *who, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/** The same for an option. @param option  its argument; of a bus file, the line begins with its place. NULL: no place
 */
void twin_args_report_option(const twin_args_t *args, const char *who, const char *option, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

/** Parses "[NAME=]DEVICE[*N][,...]". An unknown device ends the program with a line that lists the known ones. */
void twin_args_devices(twin_args_t *args, const struct argp_state *state, const char *list);
/** Whether the command line has options for twins. */
bool twin_args_given(const twin_args_t *args);
/**
 * Powers the twins on, with their memories and with the signals that the command line sets.
 * @param[out] chain  to be freed with ::ect_chain_free before ::twin_args_free; NULL on failure
 * @return EXIT_CLEAN; another exit status: failure, with the reason reported by ::twin_args_report
 */
int twin_args_power_on(twin_args_t *args, const char *who, uint64_t now_ns, ect_chain_t **chain);
/**
 * Opens the capture and the record of the command line. Call it after ::twin_args_power_on.
 * @param[out] trace  NULL: the command line names neither, or failure
 * @return EXIT_CLEAN; another exit status: failure, with the reason reported by ::twin_args_report
 */
int twin_args_trace(twin_args_t *args, const char *who, ect_trace_t **trace);
/** Sets the command line in `about`, for 'ectwin save-bus'; out of memory, `about` has none. */
void twin_args_describe(twin_args_t *args);
/** Closes a trace, and prints a line for each incomplete file. @param trace  NULL: no effect @return true: complete */
bool twin_args_end_trace(const twin_args_t *args, const char *who, ect_trace_t *trace, uint64_t now_ns);
void twin_args_free(twin_args_t *args);

/**
 * Writes the ready line, one line of JSON, to a stream.
 * @param ifaces  names by ::ect_end; NULL: no interface at this end
 * @param modbus  address of the Modbus server; NULL: none
 * @param udp     address of EtherCAT in UDP; NULL: none
 * @return false: the stream cannot be written; the reason is printed, and the program must end
 */
bool print_ready(FILE *stream, char *const ifaces[ECT_ENDS], size_t slaves, const char *modbus, const char *udp);

/**
 * Opens the control socket.
 * @param about         must outlive the control socket
 * @param[out] control  NULL: the reason is printed, and the twins run without it
 * @return EXIT_CLEAN; EXIT_OPEN: the name belongs to a running twin; the reason is printed
 */
int open_control(const char *who, const ect_about_t *about, ect_control_t **control);

/**
 * Blocks SIGCHLD and the signals that end a run, in this process. An inherited SIG_IGN is kept for SIGHUP (nohup), and
 * removed for SIGINT and SIGTERM.
 * @return a signalfd for these signals; -1 (errno)
 */
int open_signals(void);

/** Running twins: the common part of `run` and `with`. */
typedef struct session {
    const char *who; /**< "ectwin run": prefix of each line for the user */
    twin_args_t *twins;
    ect_packet_t ports[ECT_ENDS];
    ect_udp_t udp;
    ect_runner_t runner; /**< the command sets `signal_fd`; ::session_close closes it */
    bool (*on_signal)(void *ctx, int signal_number, bool from_terminal);
    void *ctx;
} session_t;

/** Initialises a session and opens nothing. `who` and `twins` must outlive the session. */
void session_init(session_t *s, const char *who, twin_args_t *twins);
/**
 * Opens the interfaces. @param ifaces  names by ::ect_end; NULL: no interface at this end
 * @return EXIT_CLEAN; EXIT_OPEN with the reason printed
 */
int session_open(session_t *s, const char *const ifaces[ECT_ENDS]);
/**
 * Opens the Modbus server of the command line, in the present network namespace. Without --modbus: no effect.
 * @return EXIT_CLEAN; EXIT_USAGE or EXIT_OPEN with the reason printed
 */
int session_open_modbus(session_t *s);
/**
 * Opens the TAPs and sockets of --eoe, in the present network namespace. Without --eoe: no effect.
 * @return EXIT_CLEAN; EXIT_OPEN with the reason printed
 */
int session_open_hosts(session_t *s);
/**
 * Replies in the kernel from now on, on the interface of the input. Without --in-kernel: no effect.
 * @return EXIT_CLEAN; EXIT_OPEN with the reason printed
 */
int session_attach(session_t *s);
/** The address of the Modbus server; NULL: none. */
const char *session_modbus(const session_t *s);
/**
 * Opens the socket for EtherCAT in UDP, in the present network namespace. Without --udp: no effect.
 * @return EXIT_CLEAN; EXIT_USAGE or EXIT_OPEN with the reason printed
 */
int session_open_udp(session_t *s);
/** The address of EtherCAT in UDP; NULL: none. */
const char *session_udp(const session_t *s);
/**
 * Opens the control socket.
 * @param ifaces  names of the master's interfaces, for `ectwin ps`; none: the address of EtherCAT in UDP
 * @return EXIT_CLEAN; EXIT_OPEN with the reason printed
 */
int session_open_control(session_t *s, char *const ifaces[ECT_ENDS]);
/** Drops all rights except those of running twins and, with `children`, of the user's command. */
void session_drop_rights(session_t *s, bool children);
/**
 * Powers the twins on, sets the real-time priority of --realtime, and loads the program of --in-kernel. Call it before
 * ::session_drop_rights, and outside user namespaces.
 * @return EXIT_CLEAN; another exit status, with the reason printed
 */
int session_power_on(session_t *s);
/**
 * Replies to frames until `on_end`, called as ect_runner_t::on_signal, returns false.
 * @return EXIT_CLEAN; EXIT_RUN, with the reason printed
 */
int session_run(session_t *s, bool (*on_end)(void *ctx, int signal_number, bool from_terminal), void *ctx);
/**
 * Ends the scenario. Prints the verdict if the scenario has expectations.
 * @return EXIT_RUN: `status` is EXIT_CLEAN, and an expectation is not met; else `status`
 */
int session_verdict(session_t *s, int status);
/** Closes the session, and frees its arguments of twins. */
void session_close(session_t *s);

#endif
