/* SPDX-License-Identifier: MIT */
#include "bus/control/change.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "bus/chain/settings.h"
#include "bus/control/endpoint.h"
#include "bus/control/objects.h"
#include "text/number.h"

const char *ect_change_op(const cJSON *request)
{
    const char *op = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(request, "op"));
    return op ? op : "";
}

bool ect_change_is(const char *op)
{
    return strcmp(op, "set") == 0 || strcmp(op, "fault") == 0 || strcmp(op, "write") == 0 || strcmp(op, "wave") == 0;
}

/* @return the slave with the alias of alias:N, from 1; 0: none */
static size_t by_alias(const ect_chain_t *chain, const char *name)
{
    static const char prefix[] = "alias:";
    uint64_t alias = 0;
    const bool given =
        strncmp(name, prefix, sizeof prefix - 1) == 0 && ect_number(name + sizeof prefix - 1, 1, UINT16_MAX, &alias);
    return given ? ect_chain_find_alias(chain, (uint16_t)alias) : 0;
}

long ect_change_slave(const cJSON *request, const ect_chain_t *chain)
{
    const cJSON *number = cJSON_GetObjectItemCaseSensitive(request, "slave");
    const char *name = cJSON_GetStringValue(number);
    if (name) {
        const size_t named = ect_names_find(ect_chain_names(chain), name, strlen(name));
        const size_t found = named > 0 ? named : by_alias(chain, name);
        return found > 0 ? (long)found : -1;
    }
    double slave = !number ? 1 : cJSON_IsNumber(number) ? number->valuedouble : -1;
    bool exists = slave >= 0 && slave <= (double)ect_chain_count(chain) && (double)(long)slave == slave;
    return exists ? (long)slave : -1;
}

/* A value may be a string, a number or a boolean. @param text  room for the last two @return the text; NULL: another
 * type */
static const char *value_of(const cJSON *json, char text[32])
{
    if (cJSON_IsString(json))
        return cJSON_GetStringValue(json);
    if (cJSON_IsBool(json))
        return cJSON_IsTrue(json) ? "1" : "0";
    if (!cJSON_IsNumber(json) || !isfinite(json->valuedouble))
        return NULL;
    snprintf(text, 32, "%.15g", json->valuedouble);
    return text;
}

/* Sets {"name":N,"value":V}, or several: {"values":{N:V,...}}. @return the reason of a refusal; NULL: all are set */
static const char *set(ect_chain_t *chain, size_t slave, const cJSON *request, uint64_t now_ns,
                       char message[ECT_SIGNAL_MESSAGE])
{
    ect_setting_t settings[ECT_ENDPOINT_VALUES];
    char texts[ECT_ENDPOINT_VALUES][32];
    size_t count = 0;
    const cJSON *values = cJSON_GetObjectItemCaseSensitive(request, "values");
    if (cJSON_IsObject(values)) {
        for (const cJSON *one = values->child; one; one = one->next, count++) {
            if (count == ECT_ENDPOINT_VALUES)
                return "a request sets at most 128 signals";
            settings[count] = (ect_setting_t){.name = one->string, .value = value_of(one, texts[count])};
        }
    } else {
        const char *name = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(request, "name"));
        const cJSON *value = cJSON_GetObjectItemCaseSensitive(request, "value");
        if (name)
            settings[count++] = (ect_setting_t){.name = name, .value = value_of(value, texts[0])};
    }
    if (count == 0)
        return "\"set\" takes {\"name\":...,\"value\":...} or {\"values\":{NAME:VALUE,...}}";
    for (size_t i = 0; i < count; i++) {
        if (!settings[i].value)
            return "a value is a text, a number, true or false";
    }
    return ect_settings_apply(chain, slave - 1, settings, count, now_ns, message) ? NULL : message;
}

/* Sets or executes a fault. @return the reason of a refusal; NULL: done */
static const char *set_fault(ect_scenario_t *scenario, ect_chain_t *chain, const cJSON *request, uint64_t now_ns,
                             char message[ECT_SIGNAL_MESSAGE])
{
    _Static_assert((int)ECT_FAULT_MESSAGE <= (int)ECT_SIGNAL_MESSAGE, "the room includes a message of a fault");
    const cJSON *text = cJSON_GetObjectItemCaseSensitive(request, "fault");
    ect_fault_t fault;
    if (!scenario)
        return "no faults can be set here";
    if (!cJSON_IsString(text))
        return "\"fault\" is a text, as in {\"op\":\"fault\",\"fault\":\"drop 5%\"}";
    bool done = ect_fault_parse_named(text->valuestring, ect_chain_names(chain), &fault, message) &&
                ect_scenario_set(scenario, chain, &fault, now_ns, message);
    return done ? NULL : message;
}

/* Ends the wave of a signal, or all. */
static const char *end_wave(ect_waves_t *waves, size_t position, const char *name, char *message)
{
    if (ect_waves_end(waves, position, name) || !name)
        return NULL;
    snprintf(message, ECT_SIGNAL_MESSAGE, "no wave sets '%.60s': {\"op\":\"waves\"} lists them", name);
    return message;
}

/* Begins or ends a wave. @return the reason of a refusal; NULL: done */
static const char *set_wave(ect_scenario_t *scenario, const ect_chain_t *chain, size_t slave, const cJSON *request,
                            uint64_t now_ns, char message[ECT_SIGNAL_MESSAGE])
{
    static const char usage[] = "\"wave\" takes \"name\", \"shape\": sine, ramp, square or off, \"low\", \"high\", and "
                                "\"period\" in seconds";
    const char *name = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(request, "name"));
    const char *shape = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(request, "shape"));
    const double period_s = cJSON_GetNumberValue(cJSON_GetObjectItemCaseSensitive(request, "period"));
    ect_wave_t wave = {.position = slave - 1,
                       .low = cJSON_GetNumberValue(cJSON_GetObjectItemCaseSensitive(request, "low")),
                       .high = cJSON_GetNumberValue(cJSON_GetObjectItemCaseSensitive(request, "high"))};
    if (!scenario)
        return "no waves can be set here";
    if (name)
        (void)ect_chain_resolve(chain, &wave.position, &name);
    if (shape && strcmp(shape, "off") == 0)
        return end_wave(&scenario->waves, wave.position, name, message);
    wave.shape = shape ? ect_wave_shape(shape) : ECT_WAVE_SHAPES;
    if (!name || wave.shape == ECT_WAVE_SHAPES || strlen(name) >= sizeof wave.name || !isfinite(wave.low) ||
        !isfinite(wave.high) || !(period_s >= 0 && period_s <= 1e6))
        return usage;
    memcpy(wave.name, name, strlen(name) + 1);
    wave.period_ns = (uint64_t)(period_s * 1e9 + 0.5);
    return ect_waves_set(&scenario->waves, chain, &wave, now_ns, message) ? NULL : message;
}

const char *ect_change_apply(ect_chain_t *chain, ect_scenario_t *scenario, const cJSON *request, uint64_t now_ns,
                             char *message)
{
    long slave = ect_change_slave(request, chain);
    if (slave <= 0)
        return "there is no such slave in this chain";
    if (strcmp(ect_change_op(request), "write") == 0)
        return ect_object_write(chain, (size_t)slave, request, message);
    if (strcmp(ect_change_op(request), "wave") == 0)
        return set_wave(scenario, chain, (size_t)slave, request, now_ns, message);
    return strcmp(ect_change_op(request), "set") == 0 ? set(chain, (size_t)slave, request, now_ns, message)
                                                      : set_fault(scenario, chain, request, now_ns, message);
}

const char *ect_change_check(const ect_chain_t *chain, size_t slave, const cJSON *request, char *message)
{
    const cJSON *values = cJSON_GetObjectItemCaseSensitive(request, "values");
    const cJSON *one = cJSON_IsObject(values) ? values->child : cJSON_GetObjectItemCaseSensitive(request, "name");
    if (!one)
        return "\"set\" takes {\"name\":...,\"value\":...} or {\"values\":{NAME:VALUE,...}}";
    for (; one; one = cJSON_IsObject(values) ? one->next : NULL) {
        ect_signal_ref_t ref;
        const char *name = cJSON_IsObject(values) ? one->string : cJSON_GetStringValue(one);
        if (name && ect_chain_signal(chain, slave - 1, name, &ref) && ref.signal->access == ECT_SIGNAL_WRITE)
            continue;
        snprintf(message, ECT_SIGNAL_MESSAGE,
                 "slave %zu has no signal '%.60s' that can be set: 'ectwin list-signals -n %zu' lists them", slave,
                 name ? name : "", slave);
        return message;
    }
    return NULL;
}
