/* SPDX-License-Identifier: MIT */
#include "bus/faults/waves.h"

#include <stdio.h>
#include <string.h>

#include "bus/chain/settings.h"
#include "seams/wave.h"
#include "wire/assert.h"

enum { SHORTEST_NS = 10000000, TEXT = sizeof((ect_wave_t *)NULL)->last };

static const char *const shapes[] = {[ECT_WAVE_SINE] = "sine", [ECT_WAVE_RAMP] = "ramp", [ECT_WAVE_SQUARE] = "square"};

const char *ect_wave_shape_name(ect_wave_shape_t shape)
{
    ECT_ASSERT(shape < ECT_WAVE_SHAPES);
    return shapes[shape];
}

ect_wave_shape_t ect_wave_shape(const char *name)
{
    unsigned int shape = 0;
    while (shape < ECT_WAVE_SHAPES && strcmp(shapes[shape], name) != 0)
        shape++;
    return (ect_wave_shape_t)shape;
}

double ect_wave_value(const ect_wave_t *wave, uint64_t now_ns)
{
    const double part = (double)((now_ns - wave->start_ns) % wave->period_ns) / (double)wave->period_ns;
    const double span = wave->high - wave->low;
    if (wave->shape == ECT_WAVE_SINE)
        return wave->low + span * (1.0 + ect_wave_sine(part)) / 2.0;
    if (wave->shape == ECT_WAVE_RAMP)
        return wave->low + span * part;
    return part < 0.5 ? wave->high : wave->low;
}

static void write_value(const ect_signal_t *signal, double value, char text[TEXT])
{
    const bool real = signal->type == ECT_SIGNAL_REAL || signal->type == ECT_SIGNAL_REAL32;
    snprintf(text, TEXT, real ? "%.9g" : "%.0f", value);
    if (strcmp(text, "-0") == 0)
        strcpy(text, "0");
}

/* @return the number of the wave of a signal; `count`: none */
static size_t find(const ect_waves_t *waves, size_t position, const char *name)
{
    size_t i = 0;
    while (i < waves->count && (waves->all[i].position != position || strcmp(waves->all[i].name, name) != 0))
        i++;
    return i;
}

static bool check(const ect_chain_t *chain, const ect_wave_t *wave, char *message)
{
    const double ends[] = {wave->low, wave->high};
    ect_signal_ref_t ref;
    if (!ect_chain_signal(chain, wave->position, wave->name, &ref) || !ect_signal_is_number(ref.signal)) {
        snprintf(message, ECT_SIGNAL_MESSAGE,
                 "slave %zu has no signal '%.60s' that is a number: 'ectwin list-signals -n %zu' lists them",
                 wave->position + 1, wave->name, wave->position + 1);
        return false;
    }
    for (size_t i = 0; i < 2; i++) {
        char text[TEXT];
        write_value(ref.signal, ends[i], text);
        if (!ect_signal_check(&ref, text, message))
            return false;
    }
    return true;
}

bool ect_waves_set(ect_waves_t *waves, const ect_chain_t *chain, const ect_wave_t *wave, uint64_t now_ns, char *message)
{
    const size_t place = find(waves, wave->position, wave->name);
    if (!(wave->low <= wave->high) || wave->period_ns < SHORTEST_NS) {
        snprintf(message, ECT_SIGNAL_MESSAGE, "a wave needs low <= high, and a period of 0.01 s or more");
        return false;
    }
    if (place == ECT_WAVES) {
        snprintf(message, ECT_SIGNAL_MESSAGE, "%d waves run already: end one of them", ECT_WAVES);
        return false;
    }
    if (!check(chain, wave, message))
        return false;
    waves->count += place == waves->count;
    waves->all[place] = *wave;
    waves->all[place].start_ns = waves->all[place].due_ns = now_ns;
    waves->all[place].last[0] = 0;
    return true;
}

bool ect_waves_end(ect_waves_t *waves, size_t position, const char *name)
{
    const size_t place = name ? find(waves, position, name) : 0;
    if (place >= waves->count)
        return false;
    waves->count = name ? waves->count - 1 : 0;
    waves->all[place] = waves->all[waves->count];
    return true;
}

/* @return the reason of a refusal; NULL: set, or the value is the same */
static const char *play(ect_wave_t *wave, ect_chain_t *chain, uint64_t now_ns, bool *acted, char *message)
{
    char text[TEXT];
    ect_signal_ref_t ref;
    if (!ect_chain_signal(chain, wave->position, wave->name, &ref))
        return "the signal is gone";
    write_value(ref.signal, ect_wave_value(wave, now_ns), text);
    wave->due_ns += (now_ns - wave->due_ns) / ECT_WAVE_STEP_NS * ECT_WAVE_STEP_NS + ECT_WAVE_STEP_NS;
    if (strcmp(text, wave->last) == 0)
        return NULL;
    const ect_setting_t setting = {.name = wave->name, .value = text};
    memcpy(wave->last, text, sizeof text);
    *acted = true;
    return ect_settings_apply(chain, wave->position, &setting, 1, now_ns, message) ? NULL : message;
}

uint64_t ect_waves_run(ect_waves_t *waves, ect_chain_t *chain, uint64_t now_ns, bool *acted,
                       void (*refused)(void *ctx, const char *name, const char *why), void *ctx)
{
    uint64_t next_ns = ECT_NEVER;
    char message[ECT_SIGNAL_MESSAGE];
    for (size_t i = 0; i < waves->count;) {
        ect_wave_t *wave = &waves->all[i];
        const char *why = wave->due_ns <= now_ns ? play(wave, chain, now_ns, acted, message) : NULL;
        if (!why) {
            next_ns = ect_earlier(next_ns, wave->due_ns);
            i++;
            continue;
        }
        if (refused)
            refused(ctx, wave->name, why);
        *wave = waves->all[--waves->count];
    }
    return next_ns;
}
