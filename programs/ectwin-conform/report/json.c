/* SPDX-License-Identifier: MIT */
/* The report for programs: all results and facts, and each frame of the evidence byte for byte. */
#include <stdlib.h>

#include "report/report.h"

enum { LINE = 4096 };

static cJSON *hex(const cf_item_t *item)
{
    char text[2 * 2048 + 1] = "";
    for (uint32_t i = 0; i < item->length; i++)
        snprintf(text + 2 * (size_t)i, 3, "%02X", item->bytes[i]);
    return cJSON_CreateString(text);
}

static double whole_us(uint64_t ns)
{
    uint64_t us = ns / 1000;
    return (double)us;
}

static cJSON *evidence(const cf_run_t *run, const cf_evidence_t *e)
{
    static const char *const kinds[] = {"step", "sent", "received"};
    cJSON *list = cJSON_CreateArray();
    for (size_t i = 0; i < e->count; i++) {
        const cf_item_t *item = &e->items[i];
        char text[LINE];
        cJSON *one = cJSON_CreateObject();
        cf_decode(&run->c, item, text, sizeof text);
        cf_clean(text);
        cJSON_AddStringToObject(one, "kind", kinds[item->kind]);
        cJSON_AddStringToObject(one, "text", text);
        if (item->folded > 0)
            cJSON_AddNumberToObject(one, "folded", item->folded);
        if (item->kind != CF_ITEM_STEP) {
            cJSON_AddNumberToObject(one, "frame", item->frame);
            cJSON_AddNumberToObject(one, "time_us", whole_us(item->time_ns));
            cJSON_AddItemToObject(one, "bytes", hex(item));
        }
        cJSON_AddItemToArray(list, one);
    }
    return list;
}

/* Adds a text that may contain bytes from the slave. */
static void add_clean(cJSON *to, const char *name, const char *text)
{
    char copy[LINE];
    snprintf(copy, sizeof copy, "%s", text);
    cf_clean(copy);
    cJSON_AddStringToObject(to, name, copy);
}

static cJSON *slave(const cf_run_t *run)
{
    const cf_facts_t *f = &run->c.facts;
    cJSON *o = cJSON_CreateObject();
    add_clean(o, "name", f->name);
    cJSON_AddNumberToObject(o, "number", f->position + 1);
    cJSON_AddNumberToObject(o, "of", f->slaves);
    cJSON_AddNumberToObject(o, "vendor", f->vendor);
    cJSON_AddNumberToObject(o, "product", f->product);
    cJSON_AddNumberToObject(o, "revision", f->revision_no);
    cJSON_AddNumberToObject(o, "serial", f->serial);
    cJSON_AddNumberToObject(o, "esc_type", f->type);
    cJSON_AddNumberToObject(o, "esc_features", f->features);
    cJSON_AddNumberToObject(o, "output_bytes", f->output_bytes);
    cJSON_AddNumberToObject(o, "input_bytes", f->input_bytes);
    return o;
}

static cJSON *result(const cf_run_t *run, const cf_result_t *r)
{
    const char class[2] = {r->entry->class, 0}, letter[2] = {r->section->letter, 0};
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "id", r->entry->id);
    cJSON_AddStringToObject(o, "title", r->entry->title);
    cJSON_AddStringToObject(o, "section", letter);
    cJSON_AddStringToObject(o, "class", class);
    cJSON_AddStringToObject(o, "verdict", cf_verdict_name(r->verdict));
    add_clean(o, "reason", r->reason);
    add_clean(o, "step", r->verdict == CF_FAIL ? r->step : "");
    cJSON_AddNumberToObject(o, "frame", r->frame);
    cJSON_AddNumberToObject(o, "first_frame", r->evidence.first_frame);
    cJSON_AddNumberToObject(o, "last_frame", r->evidence.last_frame);
    cJSON_AddNumberToObject(o, "duration_us", whole_us(r->duration_ns));
    cJSON_AddItemToObject(o, "evidence", evidence(run, &r->evidence));
    return o;
}

/* @param text  NULL: the JSON value null */
static void add_text(cJSON *to, const char *name, const char *text)
{
    cJSON_AddItemToObject(to, name, text ? cJSON_CreateString(text) : cJSON_CreateNull());
}

void cf_report_json(FILE *to, const cf_run_t *run)
{
    cf_counts_t n = cf_count(run, NULL);
    cJSON *report = cJSON_CreateObject();
    cJSON_AddStringToObject(report, "tool", "ectwin-conform");
    cJSON_AddStringToObject(report, "version", run->version);
    cJSON_AddStringToObject(report, "command", run->command);
    add_text(report, "operator", run->operator_);
    add_text(report, "firmware", run->firmware);
    cJSON_AddStringToObject(report, "interface", run->iface);
    cJSON_AddStringToObject(report, "started", run->started);
    cJSON_AddNumberToObject(report, "duration_us", whole_us(run->duration_ns));
    cJSON_AddItemToObject(report, "slave", slave(run));
    add_text(report, "esi", run->esi);
    add_text(report, "esi_sha256", run->esi_hash[0] != 0 ? run->esi_hash : NULL);
    cJSON *summary = cJSON_AddObjectToObject(report, "summary");
    for (int v = 0; v <= CF_INTERRUPTED; v++)
        cJSON_AddNumberToObject(summary, cf_verdict_name((cf_verdict_t)v), (double)n.of[v]);
    cJSON *cases = cJSON_AddArrayToObject(report, "cases");
    for (size_t i = 0; i < run->count; i++)
        cJSON_AddItemToArray(cases, result(run, &run->results[i]));
    cf_timing_json(report, run);
    char *text = cJSON_Print(report);
    fprintf(to, "%s\n", text ? text : "{}");
    free(text);
    cJSON_Delete(report);
}
