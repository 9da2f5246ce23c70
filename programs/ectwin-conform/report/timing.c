/* SPDX-License-Identifier: MIT */
/* Histograms. Class limits are 1, 2, 5, 10 ..., so that microseconds and seconds fit one histogram. */
#include <stdlib.h>
#include <string.h>

#include "report/report.h"

enum { CLASSES = 22, BAR = 40, WIDTH = 640, ROW = 16, LABEL = 90 };

/* Upper end of a class in nanoseconds: 1 us, 2 us, 5 us ... */
static uint64_t upper(unsigned int n)
{
    static const unsigned int steps[] = {1, 2, 5};
    uint64_t value = steps[n % 3] * UINT64_C(1000);
    for (unsigned int decade = 0; decade < n / 3; decade++)
        value *= 10;
    return value;
}

static int by_value(const void *a, const void *b)
{
    const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

typedef struct histogram {
    const char *name;
    uint32_t count, most; /* number of values; highest number in a class */
    uint32_t classes[CLASSES];
    unsigned int first, last; /* the first and the last non-empty class */
    uint64_t minimum, median, p99, maximum;
} histogram_t;

static histogram_t sum_up(const cf_series_t *s)
{
    histogram_t h = {.name = s->name, .count = s->count};
    qsort(s->values_ns, s->count, sizeof s->values_ns[0], by_value);
    for (uint32_t i = 0; i < s->count; i++) {
        unsigned int n = 0;
        while (n < CLASSES - 1 && s->values_ns[i] > upper(n))
            n++;
        h.classes[n]++;
        h.most = h.classes[n] > h.most ? h.classes[n] : h.most;
        h.first = i == 0 ? n : h.first;
        h.last = n;
    }
    h.minimum = s->values_ns[0];
    h.median = s->values_ns[s->count / 2];
    h.p99 = s->values_ns[(uint64_t)s->count * 99 / 100];
    h.maximum = s->values_ns[s->count - 1];
    return h;
}

static double us(uint64_t ns)
{
    return (double)ns / 1000.0;
}

static const char *class_name(unsigned int n, char text[24])
{
    uint64_t ns = upper(n);
    if (ns >= 1000000000)
        snprintf(text, 24, "%u s", (unsigned int)(ns / 1000000000));
    else if (ns >= 1000000)
        snprintf(text, 24, "%u ms", (unsigned int)(ns / 1000000));
    else
        snprintf(text, 24, "%u us", (unsigned int)(ns / 1000));
    return text;
}

void cf_timing_text(FILE *to, const cf_run_t *run)
{
    for (size_t i = 0; i < run->engine.series_count; i++) {
        const histogram_t h = sum_up(&run->engine.series[i]);
        char name[24];
        fprintf(to, "\n%s: %u times, %.1f us at least, %.1f median, %.1f for 99 %%, %.1f at most\n", h.name, h.count,
                us(h.minimum), us(h.median), us(h.p99), us(h.maximum));
        for (unsigned int n = h.first; n <= h.last; n++) {
            int length = (int)((uint64_t)h.classes[n] * BAR / h.most);
            fprintf(to, "  to %6s %6u %.*s\n", class_name(n, name), h.classes[n], length,
                    "########################################");
        }
    }
}

void cf_timing_json(cJSON *report, const cf_run_t *run)
{
    if (run->engine.series_count == 0)
        return;
    cJSON *list = cJSON_AddArrayToObject(report, "timings");
    for (size_t i = 0; i < run->engine.series_count; i++) {
        const histogram_t h = sum_up(&run->engine.series[i]);
        cJSON *one = cJSON_CreateObject();
        cJSON_AddStringToObject(one, "name", h.name);
        cJSON_AddNumberToObject(one, "count", h.count);
        cJSON_AddNumberToObject(one, "minimum_us", us(h.minimum));
        cJSON_AddNumberToObject(one, "median_us", us(h.median));
        cJSON_AddNumberToObject(one, "p99_us", us(h.p99));
        cJSON_AddNumberToObject(one, "maximum_us", us(h.maximum));
        cJSON *classes = cJSON_AddArrayToObject(one, "classes");
        for (unsigned int n = h.first; n <= h.last; n++) {
            cJSON *class = cJSON_CreateObject();
            cJSON_AddNumberToObject(class, "to_us", us(upper(n)));
            cJSON_AddNumberToObject(class, "count", h.classes[n]);
            cJSON_AddItemToArray(classes, class);
        }
        cJSON_AddItemToArray(list, one);
    }
}

static void picture(FILE *to, const histogram_t *h)
{
    char name[24];
    fprintf(to, "<svg role=\"img\" viewBox=\"0 0 %d %u\" width=\"%d\" style=\"max-width:100%%\">", WIDTH,
            (h->last - h->first + 1) * ROW, WIDTH);
    for (unsigned int n = h->first; n <= h->last; n++) {
        unsigned int y = (n - h->first) * ROW;
        unsigned int width = (unsigned int)((uint64_t)h->classes[n] * (WIDTH - LABEL - 60) / h->most);
        fprintf(to,
                "<text x=\"%d\" y=\"%u\" font-size=\"11\" text-anchor=\"end\">to %s</text>"
                "<rect x=\"%d\" y=\"%u\" width=\"%u\" height=\"%d\"/>"
                "<text x=\"%u\" y=\"%u\" font-size=\"11\">%u</text>",
                LABEL - 6, y + 12, class_name(n, name), LABEL, y + 2, width, ROW - 4, LABEL + width + 6, y + 12,
                h->classes[n]);
    }
    fputs("</svg>\n", to);
}

void cf_timing_html(FILE *to, const cf_run_t *run)
{
    if (run->engine.series_count > 0)
        fputs("<h2>Times, measured by the PC</h2>\n", to);
    for (size_t i = 0; i < run->engine.series_count; i++) {
        const histogram_t h = sum_up(&run->engine.series[i]);
        fputs("<div class=\"case\"><p><b>", to);
        cf_put_escaped(to, h.name);
        fprintf(to,
                "</b>: %u times, %.1f&thinsp;&micro;s at least, %.1f median, %.1f for 99&thinsp;%%, %.1f at most</p>\n",
                h.count, us(h.minimum), us(h.median), us(h.p99), us(h.maximum));
        picture(to, &h);
        fputs("</div>\n", to);
    }
}
