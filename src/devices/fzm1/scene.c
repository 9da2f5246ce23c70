/* SPDX-License-Identifier: MIT */
/* A scene: as it is from the factory, and what may stand in one. */
#include <stddef.h>

#include "devices/fzm1/instance.h"

void fzm1_default_scene(fzm1_scene_t *scene)
{
    static const fzm1_scene_t factory = {
        .judgement = {1, 1, 1, 1, 1, 1, 1, 1}, .units = 4, .output_unit = 3, .format = FZM1_FIXED_POINT};
    *scene = factory;
}

static const char *value_fault(const fzm1_scene_t *scene)
{
    static const fzm1_result_t any;
    double value;
    for (unsigned int n = 0; n < FZM1_DATA; n++) {
        bool number = scene->data[n] >= -FZM1_LARGEST && scene->data[n] <= FZM1_LARGEST;
        if (!number)
            return "data go from -999999999.9999 to 999999999.9999";
        if (scene->expression[n][0] && !fzm1_expression(scene->expression[n], &any, &value))
            return "no expression: D1 to D8, JG, JG0 to JG7, numbers, + - * / ( )";
    }
    return NULL;
}

const char *fzm1_scene_fault(const fzm1_scene_t *scene)
{
    for (unsigned int n = 0; n < FZM1_UNITS; n++) {
        if (scene->judgement[n] != 1 && scene->judgement[n] != -1)
            return "a unit finds 1 (OK) or -1 (NG)";
    }
    if (scene->units < 1 || scene->units > FZM1_UNITS)
        return "a flow has 1 to 8 units";
    if (scene->output_unit >= scene->units)
        return "'output_unit' has to be one of the flow's: the number of 'units' is one more than the last one's";
    if (scene->format > FZM1_FLOATING)
        return "the output format is 0 or 1";
    return value_fault(scene);
}
