/* SPDX-License-Identifier: MIT */
#include "bus/chain/settings.h"

#include <stdio.h>
#include <stdlib.h>

typedef struct step {
    ect_signal_ref_t ref;
    const char *value;
    bool waits; /* refused so far, because of another perhaps */
} step_t;

/* What can be said before anything is changed: names, rights, ranges. */
static bool prepare(const ect_chain_t *chain, size_t position, const ect_setting_t *settings, size_t count,
                    step_t *steps, char *message)
{
    for (size_t i = 0; i < count; i++) {
        if (!ect_chain_signal(chain, position, settings[i].name, &steps[i].ref)) {
            snprintf(
                message, ECT_SIGNAL_MESSAGE,
                "slave %zu has no signal '%.60s': 'ectwin list-signals -n %zu' names them all; -n chooses the slave",
                position + 1, settings[i].name, position + 1);
            return false;
        }
        if (!ect_signal_check(&steps[i].ref, settings[i].value, message))
            return false;
        steps[i].value = settings[i].value;
    }
    return true;
}

/* Those before `end` that wait, until no more of them is taken. @return how many still wait */
static size_t try_again(step_t *steps, size_t end, uint64_t now_ns)
{
    char message[ECT_SIGNAL_MESSAGE];
    size_t waiting = 0;
    for (size_t i = 0; i < end; i++) {
        if (!steps[i].waits)
            continue;
        steps[i].waits = !ect_signal_write(&steps[i].ref, steps[i].value, now_ns, message);
        waiting += steps[i].waits;
        if (!steps[i].waits && waiting > 0)
            return try_again(steps, end, now_ns); /* it may have been what an earlier one waits for */
    }
    return waiting;
}

static bool write_all(step_t *steps, size_t count, uint64_t now_ns, char *message)
{
    char other[ECT_SIGNAL_MESSAGE];
    size_t waiting = 0;
    for (size_t i = 0; i < count; i++) {
        steps[i].waits = !ect_signal_write(&steps[i].ref, steps[i].value, now_ns, waiting == 0 ? message : other);
        if (steps[i].waits)
            waiting++;
        else if (waiting > 0)
            waiting = try_again(steps, i, now_ns);
    }
    return waiting == 0;
}

bool ect_settings_apply(ect_chain_t *chain, size_t position, const ect_setting_t *settings, size_t count,
                        uint64_t now_ns, char *message)
{
    step_t *steps = calloc(count > 0 ? count : 1, sizeof *steps);
    bool kept = steps && (count <= 1 || ect_chain_keep(chain, position));
    bool done = false;
    snprintf(message, ECT_SIGNAL_MESSAGE, "not enough memory");
    if (kept && prepare(chain, position, settings, count, steps, message)) {
        done = write_all(steps, count, now_ns, message);
        if (done)
            ect_chain_wake(chain, position);
        else if (count > 1)
            ect_chain_put_back(chain, position);
    }
    free(steps);
    return done;
}
