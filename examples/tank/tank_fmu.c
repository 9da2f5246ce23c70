/* SPDX-License-Identifier: MIT */
/*
 * The water of tank.py as a model for co-simulation: FMI 2.0 by default, FMI 3.0 with -DFMI=3. tank_fmu.py builds the
 * FMU.
 *
 * The model has the functions that a co-simulation of numbers calls; the other functions of the standard fail.
 */
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#ifndef FMI
#define FMI 2
#endif

#define EXPORT __attribute__((visibility("default")))

typedef enum status { OK = 0, FAILED = 3 } status_t;

/* Value references, as in tank_fmu.py. */
enum { VALVES, LEVEL, FILL, DRAIN, HEIGHT };
enum { INLET = 1, OUTLET = 2 }; /* bits of the valves */

typedef struct tank {
    int valves;
    double level;  /* mm */
    double fill;   /* mm/s with an open inlet */
    double drain;  /* mm/s for each root of a mm of water with an open outlet */
    double height; /* mm */
} tank_t;

static tank_t *tank_new(void)
{
    tank_t *tank = calloc(1, sizeof *tank);
    if (tank)
        *tank = (tank_t){.fill = 100, .drain = 2, .height = 1000};
    return tank;
}

static double *real_of(tank_t *tank, uint32_t reference)
{
    switch (reference) {
    case LEVEL:
        return &tank->level;
    case FILL:
        return &tank->fill;
    case DRAIN:
        return &tank->drain;
    case HEIGHT:
        return &tank->height;
    default:
        return NULL;
    }
}

static status_t get_reals(tank_t *tank, const uint32_t *references, size_t count, double *values)
{
    for (size_t i = 0; i < count; i++) {
        const double *real = real_of(tank, references[i]);
        if (!real)
            return FAILED;
        values[i] = *real;
    }
    return OK;
}

static status_t set_reals(tank_t *tank, const uint32_t *references, size_t count, const double *values)
{
    for (size_t i = 0; i < count; i++) {
        double *real = real_of(tank, references[i]);
        if (!real || references[i] == LEVEL)
            return FAILED;
        *real = values[i];
    }
    return OK;
}

/* One step of a tank with vertical walls; water flows out by Torricelli's law. */
static status_t run(tank_t *tank, double seconds)
{
    if (!(tank->height > 0))
        return FAILED;
    const double flow_in = tank->valves & INLET ? tank->fill : 0;
    const double flow_out = tank->valves & OUTLET ? tank->drain * sqrt(tank->level) : 0;
    tank->level = fmin(fmax(tank->level + (flow_in - flow_out) * seconds, 0), tank->height);
    return OK;
}

/* Functions of the standard that this model does not have. */
#define WITHOUT(name)                                                                                                  \
    EXPORT status_t name(void);                                                                                        \
    status_t name(void)                                                                                                \
    {                                                                                                                  \
        return FAILED;                                                                                                 \
    }
/* A function of the standard. */
#define FUNCTION(result, name, ...)                                                                                    \
    EXPORT result name(__VA_ARGS__);                                                                                   \
    result name(__VA_ARGS__)

#if FMI == 2

FUNCTION(tank_t *, fmi2Instantiate, const char *name, int kind, const char *guid, const char *resources,
         const void *functions, int visible, int logging)
{
    (void)name, (void)kind, (void)guid, (void)resources, (void)functions, (void)visible, (void)logging;
    return tank_new();
}

FUNCTION(void, fmi2FreeInstance, tank_t *tank)
{
    free(tank);
}

FUNCTION(status_t, fmi2SetupExperiment, tank_t *tank, int has_tolerance, double tolerance, double start, int has_stop,
         double stop)
{
    (void)tank, (void)has_tolerance, (void)tolerance, (void)start, (void)has_stop, (void)stop;
    return OK;
}

FUNCTION(status_t, fmi2EnterInitializationMode, tank_t *tank)
{
    (void)tank;
    return OK;
}

FUNCTION(status_t, fmi2ExitInitializationMode, tank_t *tank)
{
    (void)tank;
    return OK;
}

FUNCTION(status_t, fmi2Terminate, tank_t *tank)
{
    (void)tank;
    return OK;
}

FUNCTION(status_t, fmi2GetReal, tank_t *tank, const uint32_t *references, size_t count, double *values)
{
    return get_reals(tank, references, count, values);
}

FUNCTION(status_t, fmi2SetReal, tank_t *tank, const uint32_t *references, size_t count, const double *values)
{
    return set_reals(tank, references, count, values);
}

FUNCTION(status_t, fmi2SetInteger, tank_t *tank, const uint32_t *references, size_t count, const int *values)
{
    for (size_t i = 0; i < count; i++) {
        if (references[i] != VALVES)
            return FAILED;
        tank->valves = values[i];
    }
    return OK;
}

FUNCTION(status_t, fmi2DoStep, tank_t *tank, double time, double seconds, int discards)
{
    (void)time, (void)discards;
    return run(tank, seconds);
}

FUNCTION(const char *, fmi2GetVersion, void)
{
    return "2.0";
}

FUNCTION(const char *, fmi2GetTypesPlatform, void)
{
    return "default";
}

WITHOUT(fmi2SetDebugLogging)
WITHOUT(fmi2Reset)
WITHOUT(fmi2GetInteger)
WITHOUT(fmi2GetBoolean)
WITHOUT(fmi2GetString)
WITHOUT(fmi2SetBoolean)
WITHOUT(fmi2SetString)
WITHOUT(fmi2GetFMUstate)
WITHOUT(fmi2SetFMUstate)
WITHOUT(fmi2FreeFMUstate)
WITHOUT(fmi2SerializedFMUstateSize)
WITHOUT(fmi2SerializeFMUstate)
WITHOUT(fmi2DeSerializeFMUstate)
WITHOUT(fmi2GetDirectionalDerivative)
WITHOUT(fmi2SetRealInputDerivatives)
WITHOUT(fmi2GetRealOutputDerivatives)
WITHOUT(fmi2CancelStep)
WITHOUT(fmi2GetStatus)
WITHOUT(fmi2GetRealStatus)
WITHOUT(fmi2GetIntegerStatus)
WITHOUT(fmi2GetBooleanStatus)
WITHOUT(fmi2GetStringStatus)

#else

FUNCTION(tank_t *, fmi3InstantiateCoSimulation, const char *name, const char *token, const char *resources,
         bool visible, bool logging, bool events, bool early, const uint32_t *intermediate, size_t count,
         void *environment, void *log, void *update)
{
    (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)events, (void)early;
    (void)intermediate, (void)count, (void)environment, (void)log, (void)update;
    return tank_new();
}

FUNCTION(void, fmi3FreeInstance, tank_t *tank)
{
    free(tank);
}

FUNCTION(status_t, fmi3EnterInitializationMode, tank_t *tank, bool has_tolerance, double tolerance, double start,
         bool has_stop, double stop)
{
    (void)tank, (void)has_tolerance, (void)tolerance, (void)start, (void)has_stop, (void)stop;
    return OK;
}

FUNCTION(status_t, fmi3ExitInitializationMode, tank_t *tank)
{
    (void)tank;
    return OK;
}

FUNCTION(status_t, fmi3Terminate, tank_t *tank)
{
    (void)tank;
    return OK;
}

FUNCTION(status_t, fmi3GetFloat64, tank_t *tank, const uint32_t *references, size_t count, double *values,
         size_t value_count)
{
    return count == value_count ? get_reals(tank, references, count, values) : FAILED;
}

FUNCTION(status_t, fmi3SetFloat64, tank_t *tank, const uint32_t *references, size_t count, const double *values,
         size_t value_count)
{
    return count == value_count ? set_reals(tank, references, count, values) : FAILED;
}

FUNCTION(status_t, fmi3SetUInt8, tank_t *tank, const uint32_t *references, size_t count, const uint8_t *values,
         size_t value_count)
{
    for (size_t i = 0; i < count; i++) {
        if (references[i] != VALVES || count != value_count)
            return FAILED;
        tank->valves = values[i];
    }
    return OK;
}

FUNCTION(status_t, fmi3DoStep, tank_t *tank, double time, double seconds, bool discards, bool *event, bool *terminate,
         bool *early, double *reached)
{
    (void)discards;
    *event = *terminate = *early = false;
    *reached = time + seconds;
    return run(tank, seconds);
}

FUNCTION(const char *, fmi3GetVersion, void)
{
    return "3.0";
}

WITHOUT(fmi3SetDebugLogging)
WITHOUT(fmi3InstantiateModelExchange)
WITHOUT(fmi3InstantiateScheduledExecution)
WITHOUT(fmi3EnterEventMode)
WITHOUT(fmi3Reset)
WITHOUT(fmi3GetFloat32)
WITHOUT(fmi3GetInt8)
WITHOUT(fmi3GetUInt8)
WITHOUT(fmi3GetInt16)
WITHOUT(fmi3GetUInt16)
WITHOUT(fmi3GetInt32)
WITHOUT(fmi3GetUInt32)
WITHOUT(fmi3GetInt64)
WITHOUT(fmi3GetUInt64)
WITHOUT(fmi3GetBoolean)
WITHOUT(fmi3GetString)
WITHOUT(fmi3GetBinary)
WITHOUT(fmi3GetClock)
WITHOUT(fmi3SetFloat32)
WITHOUT(fmi3SetInt8)
WITHOUT(fmi3SetInt16)
WITHOUT(fmi3SetUInt16)
WITHOUT(fmi3SetInt32)
WITHOUT(fmi3SetUInt32)
WITHOUT(fmi3SetInt64)
WITHOUT(fmi3SetUInt64)
WITHOUT(fmi3SetBoolean)
WITHOUT(fmi3SetString)
WITHOUT(fmi3SetBinary)
WITHOUT(fmi3SetClock)
WITHOUT(fmi3GetNumberOfVariableDependencies)
WITHOUT(fmi3GetVariableDependencies)
WITHOUT(fmi3GetFMUState)
WITHOUT(fmi3SetFMUState)
WITHOUT(fmi3FreeFMUState)
WITHOUT(fmi3SerializedFMUStateSize)
WITHOUT(fmi3SerializeFMUState)
WITHOUT(fmi3DeserializeFMUState)
WITHOUT(fmi3GetDirectionalDerivative)
WITHOUT(fmi3GetAdjointDerivative)
WITHOUT(fmi3EnterConfigurationMode)
WITHOUT(fmi3ExitConfigurationMode)
WITHOUT(fmi3GetIntervalDecimal)
WITHOUT(fmi3GetIntervalFraction)
WITHOUT(fmi3GetShiftDecimal)
WITHOUT(fmi3GetShiftFraction)
WITHOUT(fmi3SetIntervalDecimal)
WITHOUT(fmi3SetIntervalFraction)
WITHOUT(fmi3SetShiftDecimal)
WITHOUT(fmi3SetShiftFraction)
WITHOUT(fmi3EvaluateDiscreteStates)
WITHOUT(fmi3UpdateDiscreteStates)
WITHOUT(fmi3EnterContinuousTimeMode)
WITHOUT(fmi3CompletedIntegratorStep)
WITHOUT(fmi3SetTime)
WITHOUT(fmi3SetContinuousStates)
WITHOUT(fmi3GetContinuousStateDerivatives)
WITHOUT(fmi3GetEventIndicators)
WITHOUT(fmi3GetContinuousStates)
WITHOUT(fmi3GetNominalsOfContinuousStates)
WITHOUT(fmi3GetNumberOfEventIndicators)
WITHOUT(fmi3GetNumberOfContinuousStates)
WITHOUT(fmi3EnterStepMode)
WITHOUT(fmi3GetOutputDerivatives)
WITHOUT(fmi3ActivateModelPartition)

#endif
