/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The instance of an optoNCDT 2300.
 *
 * Each file includes only those below it; `optoncdt2300.c`, the description, reaches them through its tables:
 *
 *   signals.c   the plant: the user's side
 *   settings.c  SDO writes: user level, selection of measurements, measuring rate
 *   samples.c   selection of the records of an exchange
 *   sensor.c    time: a record at each period of the measuring rate, or at each SYNC0
 *   keep.c      the selected values of the last records
 *   record.c    the values of a record
 *   target.c    the model of the target
 *
 * All times are nanoseconds of the caller's clock.
 */
#ifndef ECT_DEVICES_OPTONCDT2300_INSTANCE_H
#define ECT_DEVICES_OPTONCDT2300_INSTANCE_H

#include <stdbool.h>

#include "seams/fields.h"
#include "seams/services.h"
#include "seams/standard.h"

/** Errors in place of a distance (manual §9.2). */
enum {
    OPTO_LASER_OFF = 0x7FFFFFF5,
    OPTO_TOO_WIDE = 0x7FFFFFF6,
    OPTO_NOT_EVALUATED = 0x7FFFFFF7,
    OPTO_NOT_CALCULATED = 0x7FFFFFF8,
    OPTO_BEHIND_RANGE = 0x7FFFFFF9,
    OPTO_BEFORE_RANGE = 0x7FFFFFFA,
    OPTO_NO_PEAK = 0x7FFFFFFB,
    OPTO_ERRORS = OPTO_LASER_OFF, /* above all distances */
};

/** Measurements in the order of 1A00h (A 7.3.2.8); 21B0h:4 is the first one. */
enum {
    OPTO_EXPOSURE,  /* 12.5 ns */
    OPTO_COUNTER,   /* 24 bits */
    OPTO_TIMESTAMP, /* us */
    OPTO_TEMPERATURE,
    OPTO_INTENSITY_1,
    OPTO_DISTANCE_1, /* nm, or an error */
    OPTO_INTENSITY_2,
    OPTO_DISTANCE_2,
    OPTO_STATE,
    OPTO_DIFFERENCE,
    OPTO_MINIMUM, /* of distance 1 */
    OPTO_MAXIMUM,
    OPTO_PEAK_TO_PEAK,
    OPTO_VALUES,
};
enum { OPTO_FIRST_CHOICE = 4 };
enum { OPTO_SURFACES = 2, OPTO_RATES = 7 };
enum { OPTO_SAMPLES = 100 /* limit of an exchange: 1A00h to 1A63h (A 7.6) */ };
enum { OPTO_LONGEST = 1144 /* bytes of process data: 22 complete records; three buffers fit into any controller */ };
enum { OPTO_ROOM = 3 * OPTO_LONGEST / 4 /* kept measurements: those of three exchanges */ };

/**
 * Limits of memory and time, smaller in a firmware for a board (ECT_SMALL). OPTO_TABLE: rows of the plant's table.
 * OPTO_MOST_RECORDS: records taken by one call, the last ones after a longer pause.
 */
#ifdef ECT_SMALL
enum { OPTO_TABLE = 1, OPTO_MOST_RECORDS = 100 };
#else
enum { OPTO_TABLE = 1024, OPTO_MOST_RECORDS = 4096 };
#endif

enum { OPTO_USER = 0, OPTO_EXPERT = 1 };
enum { OPTO_PASSWORD = 31 };
enum { OPTO_FULL_POWER = 0, OPTO_REDUCED_POWER = 1, OPTO_NO_POWER = 2 };

/** Movement of a surface, added to its distance; TABLE replaces the distance. */
enum { OPTO_SOURCE_FIXED, OPTO_SOURCE_RAMP, OPTO_SOURCE_SINE, OPTO_SOURCE_TABLE };

enum { OPTO_ERROR_TEXT = 60 };

/** A record: one value of each measurement, as in 6065h. */
typedef struct opto_record {
    int32_t value[OPTO_VALUES];
} opto_record_t;

/** Settings of one surface. */
typedef struct opto_surface {
    uint8_t present;
    double distance; /* mm, from the start of the measuring range */
    uint8_t source;
    double amplitude;   /* mm */
    uint32_t period_us; /* of ramp and sine */
    double noise;       /* mm, standard deviation */
    double intensity;   /* % */
    uint8_t fault;      /* 0 none, or the last digit of the error: 6, 7, 8 */
    uint64_t origin_ns; /* begin of ramp, sine and table */
} opto_surface_t;

typedef struct opto_row {
    double distance[OPTO_SURFACES];
    uint8_t present;
} opto_row_t;

/** Surroundings, and the settings that outlast a power cycle. */
typedef struct opto_plant {
    bool known;
    opto_surface_t surface[OPTO_SURFACES];
    double range;       /* mm */
    double exposure;    /* us */
    double temperature; /* degC */
    uint8_t laser;
    uint32_t seed, random;
    opto_row_t row; /* the next row to be added */
    uint16_t rows;
    uint32_t row_time_us;
    opto_row_t table[OPTO_TABLE];
    uint8_t default_user;
    char password[OPTO_PASSWORD + 1];
} opto_plant_t;

typedef struct opto {
    ect_standard_t standard;
    ect_sync_data_t sync;

    /* dictionary */
    uint8_t mapped;
    uint32_t mapping[OPTO_VALUES];
    uint8_t assigned;
    uint16_t assignment[OPTO_SAMPLES];
    uint8_t chosen[OPTO_VALUES];
    uint32_t rate_hz;
    uint8_t laser_power;
    float range;
    uint16_t error_number;
    char error_text[OPTO_ERROR_TEXT + 1];
    opto_record_t record; /* the last one */

    const ect_host_t *host;
    uint64_t start_ns;
    uint64_t next_ns; /* time of the next record */
    uint8_t al_state;
    bool synchronised;
    int32_t kept[OPTO_ROOM]; /* see keep.c */
    uint64_t oldest;         /* number of the last record */
    uint64_t taken;          /* records, including those beyond the size of an exchange */
    uint64_t sent;           /* records read by the master */
    uint64_t shown;          /* records up to those in the process data */
    bool statistic;          /* minimum and maximum are valid */
    int32_t minimum, maximum;

    uint8_t user;
    uint8_t logout;
    char login[OPTO_PASSWORD + 1]; /* written value, until the check */
    char password_old[OPTO_PASSWORD + 1], password_new[OPTO_PASSWORD + 1], password_repeat[OPTO_PASSWORD + 1];

    /* as signals */
    uint8_t synchronised_level, restart, statistic_reset, row_add, row_clear;
    char why[OPTO_SURFACES][OPTO_ERROR_TEXT + 1];

    opto_plant_t plant; /* outlasts power: see ect_plant_t */
} opto_t;

/* settings.c */
void opto_choose(opto_t *u); /* updates 1A00h and the kept records, from the last one on, by the selection in 21B0h */
bool opto_is_rate(uint32_t hz);
ect_reason_t opto_sdo_write(void *instance, uint16_t index, uint8_t subindex, const void *data, uint16_t size);
void opto_sdo_written(void *instance, uint16_t index, uint8_t subindex, uint64_t now_ns);

/* samples.c: functions called by the stack */
void opto_inputs(void *instance, uint64_t now_ns);
void opto_inputs_packed(void *instance, unsigned int sm, uint8_t *image, uint16_t size);
void opto_inputs_read(void *instance, uint64_t now_ns);

/* sensor.c: functions called by the stack */
void opto_init(void *instance, const ect_host_t *host, uint64_t now_ns);
uint16_t opto_state_change(void *instance, uint8_t from, uint8_t to, uint64_t now_ns);
uint64_t opto_tick(void *instance, uint64_t now_ns);
/* Takes all due records. */
void opto_advance(opto_t *u, uint64_t now_ns);
void opto_new_rate(opto_t *u, uint64_t now_ns); /* the next record is due after a period */

/* keep.c */
void opto_keep(opto_t *u);      /* adds u->record */
void opto_keep_last(opto_t *u); /* after a new selection: keeps only the last record */
/* @return the selected values of a record, or of the oldest one if that record is lost */
const int32_t *opto_kept(opto_t *u, uint64_t number);

/* record.c */
void opto_take_record(opto_t *u, uint64_t at_ns, uint64_t period_ns); /* becomes u->record */
void opto_reset_statistic(opto_t *u);

/* target.c */
typedef struct opto_peak {
    int32_t distance; /* nm, or an error */
    int32_t intensity;
} opto_peak_t;
opto_peak_t opto_find_peak(opto_t *u, unsigned int n, uint64_t at_ns);
void opto_default_plant(opto_plant_t *p);

/* fields.c */
extern const ect_field_t opto_fields[]; /* for the plant */

#endif
