/* SPDX-License-Identifier: MIT */
/* A scene: the factory's, and the limits of its values. */
#include <stddef.h>

#include "devices/fzm1/instance.h"

void fzm1_default_scene(fzm1_scene_t *scene)
{
    static const fzm1_scene_t factory = {
        .judgement = {1, 1, 1, 1, 1, 1, 1, 1}, .units = 4, .output_unit = 3, .format = FZM1_FIXED_POINT};
    *scene = factory;
}

static fzm1_why_t value_fault(const fzm1_scene_t *scene)
{
    static const fzm1_result_t any;
    double value;
    for (unsigned int n = 0; n < FZM1_DATA; n++) {
        bool number = scene->data[n] >= -FZM1_LARGEST && scene->data[n] <= FZM1_LARGEST;
        if (!number)
            return FZM1_WHY_DATA_RANGE;
        if (scene->expression[n][0] && !fzm1_expression(scene->expression[n], &any, &value))
            return FZM1_WHY_NO_EXPRESSION;
    }
    return FZM1_DONE;
}

fzm1_why_t fzm1_scene_fault(const fzm1_scene_t *scene)
{
    for (unsigned int n = 0; n < FZM1_UNITS; n++) {
        if (scene->judgement[n] != 1 && scene->judgement[n] != -1)
            return FZM1_WHY_JUDGEMENTS;
    }
    if (scene->units < 1 || scene->units > FZM1_UNITS)
        return FZM1_WHY_UNITS;
    if (scene->output_unit >= scene->units)
        return FZM1_WHY_OUTPUT_UNIT;
    if (scene->format > FZM1_FLOATING)
        return FZM1_WHY_FORMATS;
    return value_fault(scene);
}
