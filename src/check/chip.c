/* SPDX-License-Identifier: MIT */
/* Checks of the ESC, its SyncManagers and FMMUs. */
#include <stdio.h>
#include <string.h>

#include "check/internal.h"
#include "esc/personality.h"
#include "seams/layout.h"
#include "wire/assert.h"

enum { SHORTEST_MAILBOX = 16, SHORTEST_WITH_INFO = 34, LONGEST_DATAGRAM = 1486 };

static bool has_mailbox(const report_t *r)
{
    return r->device->mailbox_protocols != 0;
}

/* SDOs and emergencies need 16 bytes; SDO information needs 34 bytes for all replies. */
static unsigned int shortest_mailbox(const report_t *r)
{
    return (r->device->coe_details & ECT_COE_SDO_INFO) != 0 ? SHORTEST_WITH_INFO : SHORTEST_MAILBOX;
}

static bool is_mailbox(const ect_sm_t *sm)
{
    return sm->type == ECT_SM_MAILBOX_OUT || sm->type == ECT_SM_MAILBOX_IN;
}

static bool roles_good(const report_t *r, unsigned int n)
{
    static const uint8_t mailboxes[] = {ECT_SM_MAILBOX_OUT, ECT_SM_MAILBOX_IN};
    const ect_sm_t *sm = &r->device->sm[n];
    if (sm->type > ECT_SM_INPUTS)
        return wrong(r, "SM%u: there is no type %u", n, sm->type);
    if (ect_sm_role(sm) > ECT_SM_INPUTS)
        return wrong(r, "SM%u: there is no role %u", n, ect_sm_role(sm));
    if ((sm->flags & ECT_SM_FLAG_VIRTUAL) != 0 && sm->type != ECT_SM_UNUSED)
        return wrong(r, "SM%u: it is virtual, so its type is %u, not %u; `role` has its role", n, ECT_SM_UNUSED,
                     sm->type);
    if (has_mailbox(r) && n < 2 && sm->type != mailboxes[n])
        return wrong(r, "SM%u: with a mailbox its type is %u, not %u", n, mailboxes[n], sm->type);
    if (is_mailbox(sm) && (!has_mailbox(r) || n >= 2))
        return wrong(r, "SM%u: a mailbox is in SM0 and SM1, and only with mailbox_protocols", n);
    return true;
}

static bool control_good(const report_t *r, unsigned int n)
{
    const ect_sm_t *sm = &r->device->sm[n];
    bool writes = (sm->control & ECT_SM_CONTROL_DIRECTION) == ECT_SM_CONTROL_ECAT_WRITES;
    bool reads = (sm->control & ECT_SM_CONTROL_DIRECTION) == 0;
    uint8_t mode = sm->control & ECT_SM_CONTROL_MODE;
    if (sm->type == ECT_SM_MAILBOX_OUT || sm->type == ECT_SM_OUTPUTS ? !writes : !reads)
        return wrong(r, "SM%u: control %02Xh has the opposite direction", n, sm->control);
    if (is_mailbox(sm) ? mode != ECT_SM_CONTROL_MAILBOX : mode != 0 && mode != ECT_SM_CONTROL_MAILBOX)
        return wrong(r, "SM%u: control %02Xh has the wrong mode", n, sm->control);
    return true;
}

static bool mailbox_length_good(const report_t *r, unsigned int n)
{
    const ect_sm_t *sm = &r->device->sm[n];
    if (sm->minimum > sm->length || (sm->maximum != 0 && sm->maximum < sm->length))
        return wrong(r, "SM%u: its length %u is not from its minimum %u to its maximum %u", n, sm->length, sm->minimum,
                     sm->maximum);
    unsigned int shortest = ect_sm_shortest_mailbox(sm);
    if (shortest < shortest_mailbox(r) || ect_layout_room(r->device, n) > LONGEST_DATAGRAM)
        return wrong(r, "SM%u: a mailbox has %u to %d bytes, not %u to %u", n, shortest_mailbox(r), LONGEST_DATAGRAM,
                     shortest, ect_layout_room(r->device, n));
    return true;
}

static bool lengths_good(const report_t *r, unsigned int n)
{
    const ect_sm_t *sm = &r->device->sm[n];
    if (is_mailbox(sm))
        return mailbox_length_good(r, n);
    if (sm->length != 0 || sm->minimum != 0)
        return wrong(r, "SM%u: length and minimum are a mailbox's; those of process data follow from their PDOs", n);
    if (ect_layout_room(r->device, n) > LONGEST_DATAGRAM)
        return wrong(r, "SM%u: %u bytes are more than a datagram holds, %d", n, ect_layout_room(r->device, n),
                     LONGEST_DATAGRAM);
    return true;
}

static bool in_memory(const report_t *r, unsigned int kilobytes, const char *what, unsigned int n, unsigned int start,
                      unsigned int bytes)
{
    unsigned int end = ECT_RAM + 1024u * kilobytes;
    if (bytes == 0 || (start >= ECT_RAM && start + bytes <= end))
        return true;
    return wrong(r, "%s%u: %04Xh to %04Xh are not in the memory of the ESC '%s', 1000h to %04Xh", what, n, start,
                 start + bytes - 1, r->device->esc, end - 1);
}

static bool apart(const report_t *r, unsigned int n)
{
    const ect_sm_t *sm = r->device->sm;
    unsigned int bytes = ect_layout_memory(r->device, n);
    for (unsigned int m = 0; m < n; m++) {
        unsigned int others = ect_layout_memory(r->device, m);
        if (bytes > 0 && others > 0 && sm[n].start < sm[m].start + others && sm[m].start < sm[n].start + bytes)
            return wrong(r, "SM%u: it overlaps SM%u (process data in three buffers take three times their length)", n,
                         m);
    }
    return true;
}

static bool sm_good(const report_t *r, unsigned int n, unsigned int kilobytes)
{
    if (!roles_good(r, n))
        return false;
    if (r->device->sm[n].type == ECT_SM_UNUSED)
        return true;
    bool placed = ect_layout_in_registers(r->device, n) ||
                  in_memory(r, kilobytes, "SM", n, r->device->sm[n].start, ect_layout_memory(r->device, n));
    return placed && control_good(r, n) && lengths_good(r, n) && apart(r, n);
}

static bool is_mailbox_length(const report_t *r, unsigned int length)
{
    return length >= shortest_mailbox(r) && length <= LONGEST_DATAGRAM;
}

static bool boot_good(const report_t *r, unsigned int kilobytes)
{
    const ect_boot_mailbox_t *out = &r->device->boot_out, *in = &r->device->boot_in;
    if (out->length == 0 && in->length == 0)
        return true;
    if (!has_mailbox(r))
        return wrong(r, "BOOT: without a mailbox there is no mailbox of the BOOT state");
    if (!is_mailbox_length(r, out->length) || !is_mailbox_length(r, in->length))
        return wrong(r, "BOOT: its mailboxes have %u to %d bytes both, not %u and %u", shortest_mailbox(r),
                     LONGEST_DATAGRAM, out->length, in->length);
    if (out->start < in->start + in->length && in->start < out->start + out->length)
        return wrong(r, "BOOT: its two mailboxes overlap");
    return in_memory(r, kilobytes, "BOOT mailbox SM", 0, out->start, out->length) &&
           in_memory(r, kilobytes, "BOOT mailbox SM", 1, in->start, in->length);
}

static bool counts_good(const report_t *r, const ect_esc_personality_t *esc)
{
    const ect_device_t *d = r->device;
    unsigned int sms = esc->sm_count < ECT_SMS ? esc->sm_count : ECT_SMS;
    unsigned int fmmus = esc->fmmu_count < ECT_FMMUS ? esc->fmmu_count : ECT_FMMUS;
    if (d->sm_count > sms)
        return wrong(r, "sm_count: %u SyncManagers are more than the ESC '%s' has, %u", d->sm_count, d->esc, sms);
    if (d->fmmu_count > fmmus)
        return wrong(r, "fmmu_count: %u FMMUs are more than the ESC '%s' has, %u", d->fmmu_count, d->esc, fmmus);
    if (has_mailbox(r) && d->sm_count < 2)
        return wrong(r, "sm_count: a mailbox needs SM0 and SM1");
    for (unsigned int n = 0; n < d->fmmu_count; n++) {
        if (d->fmmu[n] > ECT_FMMU_MAILBOX_STATE)
            return wrong(r, "FMMU%u: there is no role %u", n, d->fmmu[n]);
    }
    return true;
}

static bool unknown_esc(const report_t *r)
{
    char known[100] = "";
    for (size_t i = 0; ect_esc_personality_at(i); i++) {
        size_t used = strlen(known);
        (void)snprintf(known + used, sizeof known - used, "%s%s", i > 0 ? ", " : "", ect_esc_personality_at(i)->name);
    }
    return wrong(r, "esc: there is no ESC '%.40s'; there are: %s", r->device->esc ? r->device->esc : "", known);
}

bool check_esc(const report_t *r)
{
    const ect_device_t *d = r->device;
    const ect_esc_personality_t *esc = d->esc ? ect_esc_personality(d->esc) : NULL;
    if (!esc)
        return unknown_esc(r);
    if (!d->physics || strlen(d->physics) > 4 || strspn(d->physics, "YKH ") != strlen(d->physics))
        return wrong(r,
                     "physics: one letter for each port, Y (MII), K (E-bus), H (fast hot connect) or space, at most 4");
    return counts_good(r, esc);
}

bool check_layout(const report_t *r)
{
    ECT_ASSERT(ect_esc_personality(r->device->esc) != NULL); /* check_esc */
    ECT_ASSERT(r->device->sm_count <= ECT_SMS);
    unsigned int kilobytes = ect_esc_personality(r->device->esc)->ram_kb;
    for (unsigned int n = 0; n < r->device->sm_count; n++) {
        if (!sm_good(r, n, kilobytes))
            return false;
    }
    return boot_good(r, kilobytes);
}
