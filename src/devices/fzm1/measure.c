/* SPDX-License-Identifier: MIT */
/* STEP, READY and BUSY (Q179 §4-4): images are taken in succession and measured in the same order, independent of the
 * data output. */
#include <string.h>

#include "devices/fzm1/instance.h"

/* Limit of waiting images; the 5 million pixel camera has no multiple image input. */
static unsigned int image_room(const fzm1_t *u)
{
    static const uint8_t rooms[] = {16, 4, 1};
    return rooms[u->plant.camera];
}

fzm1_why_t fzm1_not_ready(const fzm1_t *u)
{
    if (u->starting != 0)
        return FZM1_WHY_UNREADY_RESTARTING;
    if (!u->run)
        return FZM1_WHY_UNREADY_NO_RUN;
    if (u->continuous)
        return FZM1_WHY_UNREADY_CONTINUOUS;
    if (u->switching || u->switched_due_ns != ECT_NEVER)
        return FZM1_WHY_UNREADY_SWITCHING;
    if (u->image_due_ns != ECT_NEVER)
        return FZM1_WHY_UNREADY_IMAGE;
    return u->image_count < image_room(u) ? FZM1_DONE : FZM1_WHY_UNREADY_IMAGES;
}

bool fzm1_busy(const fzm1_t *u)
{
    return u->switching || u->switched_due_ns != ECT_NEVER || u->continuous || u->image_due_ns != ECT_NEVER ||
           u->image_count > 0;
}

static void start_image(fzm1_t *u)
{
    u->exposures++;
    u->image_due_ns = u->time_ns + fzm1_image_input_ns(u);
}

static void start_processing(fzm1_t *u)
{
    u->processing_due_ns = u->time_ns + fzm1_processing_ns(u, &u->images[u->first_image]);
}

void fzm1_step(fzm1_t *u)
{
    start_image(u);
}

void fzm1_start_continuous(fzm1_t *u)
{
    u->continuous = true;
    start_image(u);
}

static void image_taken(fzm1_t *u)
{
    u->image_due_ns = ECT_NEVER;
    fzm1_take_image(u, &u->images[(u->first_image + u->image_count) % FZM1_IMAGES]);
    u->image_count++;
    if (u->image_count == 1)
        start_processing(u);
}

static void complete(fzm1_t *u)
{
    u->processing_due_ns = ECT_NEVER;
    u->last = u->images[u->first_image];
    u->measurements++;
    u->overall_ng = u->last.overall < 0;
    u->first_image = (uint8_t)((u->first_image + 1) % FZM1_IMAGES);
    u->image_count--;
    fzm1_output_put(u, u->last.data);
    if (u->image_count > 0)
        start_processing(u);
    else if (u->continuous && u->image_due_ns == ECT_NEVER)
        start_image(u);
}

void fzm1_measure_due(fzm1_t *u)
{
    if (u->image_due_ns <= u->time_ns)
        image_taken(u);
    if (u->processing_due_ns <= u->time_ns)
        complete(u);
}

void fzm1_measure_put_off(fzm1_t *u, uint64_t ns)
{
    if (u->image_due_ns != ECT_NEVER)
        u->image_due_ns += ns;
    if (u->processing_due_ns != ECT_NEVER)
        u->processing_due_ns += ns;
}

/* OR and the output area are unchanged (as in the FZ3). */
void fzm1_clear(fzm1_t *u)
{
    memset(&u->last, 0, sizeof u->last);
}
