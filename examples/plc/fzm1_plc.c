/* SPDX-License-Identifier: MIT */
#include "fzm1_plc.h"

enum { OUT_CODE = 4, OUT_PARAMETER = 8, IN_RESULT = 8, IN_RESPONSE = 12, IN_DATA = 16 };

static uint32_t load(const uint8_t *b)
{
    return (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

static void store(uint8_t *b, uint32_t value)
{
    for (unsigned int i = 0; i < 4; i++)
        b[i] = (uint8_t)(value >> (8 * i));
}

void fzm1_plc_start(fzm1_plc_t *p)
{
    p->signals = p->before = 0;
    p->step = p->step_wanted = p->dsa = p->done = false;
    p->exe = PLC_EXE_IDLE;
}

bool fzm1_plc_measure(fzm1_plc_t *p)
{
    if (p->step || p->step_wanted || p->exe != PLC_EXE_IDLE || (p->signals & PLC_READY) == 0)
        return false;
    p->step_wanted = true;
    return true;
}

static bool always_taken(uint32_t code) /* with or without BUSY */
{
    return code == PLC_CLEAR || code == PLC_END_CONTINUOUS || code == PLC_RESTART;
}

bool fzm1_plc_command(fzm1_plc_t *p, uint32_t code, int32_t p1, int32_t p2, int32_t p3)
{
    bool always = always_taken(code);
    if (p->exe != PLC_EXE_IDLE || p->step || p->step_wanted || (p->signals & PLC_FLG) != 0 ||
        ((p->signals & PLC_BUSY) != 0 && !always))
        return false;
    p->code = code;
    p->parameter[0] = p1;
    p->parameter[1] = p2;
    p->parameter[2] = p3;
    p->done = false;
    p->exe = PLC_EXE_WANTED;
    return true;
}

static void do_step(fzm1_plc_t *p, uint64_t now_ns)
{
    if (p->step && ((p->signals & PLC_READY) == 0 || now_ns >= p->step_until_ns))
        p->step = false;
    else if (p->step_wanted && (p->signals & PLC_READY) != 0) {
        p->step = true;
        p->step_wanted = false;
        p->step_until_ns = now_ns + p->step_hold_ns;
    }
}

static void do_command(fzm1_plc_t *p, const uint8_t *in, uint8_t *out, uint64_t now_ns)
{
    bool flg = (p->signals & PLC_FLG) != 0;
    bool busy = (p->signals & PLC_BUSY) != 0;
    switch (p->exe) {
    case PLC_EXE_IDLE:
        return;
    case PLC_EXE_WANTED: /* code and parameters reach the sensor a cycle before EXE */
        store(out + OUT_CODE, p->code);
        for (unsigned int i = 0; i < 3; i++)
            store(out + OUT_PARAMETER + 4 * i, (uint32_t)p->parameter[i]);
        p->exe = PLC_EXE_PREPARED;
        return;
    case PLC_EXE_PREPARED:
        if (flg || (busy && !always_taken(p->code)))
            return;
        p->exe = PLC_EXE_ON;
        p->exe_until_ns = now_ns + p->exe_retry_ns;
        return;
    case PLC_EXE_ON:
        if (busy)
            p->exe_until_ns = now_ns + p->exe_retry_ns; /* a scene is being switched */
        if (!flg && now_ns >= p->exe_until_ns && p->code != PLC_RESTART)
            p->exe = PLC_EXE_PREPARED;
        if (!flg)
            return;
        p->result = load(in + IN_RESULT);
        p->data = (int32_t)load(in + IN_RESPONSE);
        p->exe = PLC_EXE_OFF;
        return;
    case PLC_EXE_OFF:
        if (flg)
            return;
        p->exe = PLC_EXE_IDLE;
        p->done = true;
        return;
    }
}

static void take_data(const fzm1_plc_t *p, const uint8_t *in)
{
    int32_t data[FZM1_PLC_DATA];
    for (unsigned int i = 0; i < FZM1_PLC_DATA; i++)
        data[i] = (int32_t)load(in + IN_DATA + 4 * i);
    if (p->on_data)
        p->on_data(p->ctx, data);
}

static void do_data(fzm1_plc_t *p, const uint8_t *in)
{
    bool gate = (p->signals & PLC_GATE) != 0;
    bool rose = gate && (p->before & PLC_GATE) == 0;
    if (!p->handshaking) {
        if (rose)
            take_data(p, in);
        return;
    }
    bool given_up = (p->signals & ~p->before & PLC_ERR) != 0;
    if (p->dsa && !gate && given_up) {
        p->dsa = false;
    } else if (p->dsa && gate) {
        take_data(p, in);
        p->dsa = false;
    } else if (!p->dsa && !gate) {
        p->dsa = true;
    }
}

void fzm1_plc_cycle(fzm1_plc_t *p, const uint8_t in[FZM1_PLC_IN], uint8_t out[FZM1_PLC_OUT], uint64_t now_ns)
{
    p->before = p->signals;
    p->signals = load(in);
    do_step(p, now_ns);
    do_command(p, in, out, now_ns);
    do_data(p, in);
    store(out, (p->exe == PLC_EXE_ON ? (uint32_t)PLC_EXE : 0) | (p->step ? (uint32_t)PLC_STEP : 0) |
                   (p->dsa ? (uint32_t)PLC_DSA : 0));
}
