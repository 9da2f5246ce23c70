/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Waves for models of a device's surroundings. Pure; without libm, which a bare board lacks.
 */
#ifndef ECT_SEAMS_WAVE_H
#define ECT_SEAMS_WAVE_H

/** @return sin(2 pi x), by its series around 0; the error is below 1e-9. @param x  0 to 1, 1 excluded */
static inline double ect_wave_sine(double x)
{
    double sign = x >= 0.5 ? -1.0 : 1.0;
    x -= x >= 0.5 ? 0.5 : 0.0;
    x = x > 0.25 ? 0.5 - x : x;
    double angle = 6.283185307179586 * x;
    double term = angle, sum = angle;
    for (unsigned int n = 1; n <= 7; n++) {
        term *= -angle * angle / (double)(2 * n * (2 * n + 1));
        sum += term;
    }
    return sign * sum;
}

#endif
