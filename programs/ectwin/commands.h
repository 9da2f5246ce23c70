/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The subcommands of `ectwin`, and their common parts. Each takes the arguments from its own name on.
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

/** Exit codes: a contract (README). */
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

/** Room of a reason why twins cannot be powered on. */
enum { TWIN_MESSAGE = 1280 };

/** "[N:]VALUE" of an identity option. */
typedef struct identity_setting {
    int key;     /**< of the option */
    size_t twin; /**< from 1; 0: all */
    uint32_t value;
} identity_setting_t;

/** The module in a slot of a modular twin; `twin` counts from 1. */
typedef struct twin_module {
    size_t twin;
    ect_module_choice_t choice;
} twin_module_t;

/** The behaviour of a twin from a file; `twin` counts from 1, 0: all of files. */
typedef struct twin_behaviour {
    size_t twin;
    ect_behaviour_t behaviour;
} twin_behaviour_t;

/** An option that may name a twin, until the names are known. */
typedef struct twin_later {
    int key;
    const char *text;
} twin_later_t;

/** The twins that a command line asks for: devices and the options that shape them. */
typedef struct twin_args {
    ect_twin_config_t *twins;
    size_t count;
    ect_names_t *names; /* of the twins */
    twin_later_t *later;
    size_t later_count;
    bool given; /* an option of theirs was, those of the wiring aside */
    identity_setting_t *identities;
    size_t identity_count;
    bool keep_source_mac;
    bool kinds; /* not twins in a chain but kinds of devices: their serial numbers do not count up */
    wiring_args_t wiring;
    eoe_args_t eoe;
    uint8_t drop_percent, delay_percent;
    uint32_t delay_us;
    ect_scenario_t scenario; /* --fault, --faults, --drop, --delay; those that users set later */
    defect_t defect;         /* --break */
    ect_filter_t filter;
    int realtime;        /* priority, 0: as any process */
    bool busy_poll;      /* never rests */
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
    char *const *words; /* the command line, as a record needs it */
    int word_count;
    char *joined; /* the same behind their folder, for the control socket */
    uint64_t power_on_ns;
    content_t content;     /* of --store and --files at the start, for a record or of one */
    bool replayed;         /* by a replay: --store is not opened, its content is that of the record */
    bool in_process;       /* one of the buses of a command: each adds a section to the capture */
    bool own_clock;        /* times are not those of CLOCK_MONOTONIC: a capture has them as they are */
    const char **settings; /* "[N:]NAME=VALUE" */
    size_t setting_count;
    twin_module_t *modules;
    size_t module_count;
    const char **connections; /* --connect */
    size_t connection_count;
    twin_behaviour_t *behaviours;
    size_t behaviour_count;
    ect_files_t **opened;    /* the folder, one a twin, where there is one */
    ect_eeprom_t **eeproms;  /* one a twin, where there is a store */
    ect_memory_t **memories; /* one a twin, once they are powered on */
    char *message;           /* of TWIN_MESSAGE: gets the reason of a failed power-on; NULL: standard error does */
} twin_args_t;

/** Argp parser for the options of twins; its input is a twin_args_t. */
extern const struct argp twin_argp;

/** Reports why there is no chain: a line on standard error, or the caller's message. */
void twin_args_report(const twin_args_t *args, const char *who, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/** Takes "[NAME=]DEVICE[*N][,...]"; an unknown name ends the program with a line that lists the known ones. */
void twin_args_devices(twin_args_t *args, const struct argp_state *state, const char *list);
/** Whether the command line has options for twins. */
bool twin_args_given(const twin_args_t *args);
/**
 * Powers the twins on, with their memories and the signals that the command line sets. On failure prints why.
 * @param[out] chain  the caller's to free, before twin_args_free; NULL on failure
 * @return EXIT_CLEAN, or what to exit with
 */
int twin_args_power_on(twin_args_t *args, const char *who, uint64_t now_ns, ect_chain_t **chain);
/**
 * Opens the capture and the record that the command line asks for; call it after ::twin_args_power_on. On failure
 * prints why.
 * @param[out] trace  NULL: none is wanted, or failure
 * @return EXIT_CLEAN, or what to exit with
 */
int twin_args_trace(twin_args_t *args, const char *who, ect_trace_t **trace);
/** Puts the folder of this process and the words into `about`, for 'ectwin save-bus'. Without memory there are none. */
void twin_args_describe(twin_args_t *args);
/** Closes a trace; a file that lacks its end is reported. @return whether the files are complete. NULL: no effect
 */
bool twin_args_end_trace(const twin_args_t *args, const char *who, ect_trace_t *trace, uint64_t now_ns);
void twin_args_free(twin_args_t *args);

/**
 * The ready line (README) on a stream.
 * @param ifaces  NULL: nothing is plugged in there
 * @param modbus  where the Modbus server listens; NULL: there is none
 * @param udp     where EtherCAT in UDP is received; NULL: it is not
 * @return false: it could not be written; the reason is printed, and the program must end
 */
bool print_ready(FILE *stream, char *const ifaces[ECT_ENDS], size_t slaves, const char *modbus, const char *udp);

/**
 * Opens the control socket.
 * @param about         must outlive it
 * @param[out] control  NULL: the reason is printed, and the twins run without it
 * @return EXIT_CLEAN; EXIT_OPEN: a running twin has the name already; the reason is printed
 */
int open_control(const char *who, const ect_about_t *about, ect_control_t **control);

/**
 * Blocks the signals that end a run (and SIGCHLD) for this process and returns a signalfd for them, or -1. SIGINT and
 * SIGTERM end it even where they were inherited as ignored; SIGHUP that was ignored (nohup) stays so.
 */
int open_signals(void);

/** Twins at work: what `run` and `with` have in common. */
typedef struct session {
    const char *who; /**< "ectwin run": each line for the user begins with it */
    twin_args_t *twins;
    ect_packet_t ports[ECT_ENDS];
    ect_udp_t udp;
    ect_runner_t runner; /**< `control` and `signal_fd` are the command's to open; ::session_close closes them */
    bool (*on_signal)(void *ctx, int signal_number, bool from_terminal);
    void *ctx;
} session_t;

/** Nothing is open yet. `who` and `twins` must outlive the session. */
void session_init(session_t *s, const char *who, twin_args_t *twins);
/**
 * Opens the interfaces. @param ifaces  by ::ect_end; NULL: nothing is plugged in there
 * @return EXIT_CLEAN; EXIT_OPEN with the reason printed
 */
int session_open(session_t *s, const char *const ifaces[ECT_ENDS]);
/**
 * Opens the Modbus server that the command line asks for, in the network of this moment; without one there is nothing
 * to do. @return EXIT_CLEAN; EXIT_USAGE or EXIT_OPEN with the reason printed
 */
int session_open_modbus(session_t *s);
/**
 * Opens the networks behind twins that the command line asks for, in the network of this moment; without one there is
 * nothing to do. @return EXIT_CLEAN; EXIT_OPEN with the reason printed
 */
int session_open_hosts(session_t *s);
/** The address of the Modbus server; NULL: none. */
const char *session_modbus(const session_t *s);
/**
 * Opens the port for EtherCAT in UDP that the command line asks for, in the network of this moment; without one there
 * is nothing to do. @return EXIT_CLEAN; EXIT_USAGE or EXIT_OPEN with the reason printed
 */
int session_open_udp(session_t *s);
/** The address of EtherCAT in UDP; NULL: none. */
const char *session_udp(const session_t *s);
/**
 * Opens the control socket. @param ifaces  that masters use, or the twins answer on
 * @return EXIT_CLEAN; EXIT_OPEN with the reason printed
 */
int session_open_control(session_t *s, char *const ifaces[ECT_ENDS]);
/** Keeps only the rights that running twins need (and, with `children`, a command beside them). */
void session_drop_rights(session_t *s, bool children);
/**
 * Powers the twins on; they run before others if the command line has them, so call it while the rights for that are
 * still there. @return EXIT_CLEAN, or what to exit with, with the reason printed
 */
int session_power_on(session_t *s);
/** Answers until `on_end` (as ect_runner_t::on_signal) stops it. @return EXIT_CLEAN; EXIT_RUN, with the reason printed
 */
int session_run(session_t *s, bool (*on_end)(void *ctx, int signal_number, bool from_terminal), void *ctx);
/**
 * Ends the scenario and prints its verdict, if it has expectations.
 * @return EXIT_RUN for EXIT_CLEAN when one has failed, else `status`
 */
int session_verdict(session_t *s, int status);
/** Closes everything, the twins' arguments too. */
void session_close(session_t *s);

#endif
