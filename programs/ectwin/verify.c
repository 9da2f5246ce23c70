/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include <errno.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/wait.h>
#include <unistd.h>

#include "bus/chain/catalogue.h"
#include "commands.h"
#include "facts/facts.h"
#include "products.h"
#include "sii_file.h"

/* As of cmp: a difference is not trouble. */
enum { SAME = 0, DIFFERENT = 1, TROUBLE = 2 };
enum { SETS_MOST = 64 };

typedef struct verify {
    ect_arena_t arena; /* names of sources */
    ect_facts_t sets[SETS_MOST];
    size_t count;
    char message[PRODUCT_MESSAGE];
} verify_t;

static ect_facts_t *new_set(verify_t *v, const char *operand, const char *part)
{
    ect_facts_t *set = &v->sets[v->count++];
    *set = (ect_facts_t){.source = ect_arena_print(&v->arena, "%s%s", operand, part)};
    return set;
}

/* --- sources ----------------------------------------------------------------------------------------------------- */

static bool add_image(verify_t *v, const char *operand, const char *part, const char *path)
{
    uint8_t *image = malloc(SII_FILE_MOST);
    long size = image != NULL ? sii_file_read(path, image, v->message, sizeof v->message) : -1;
    if (size >= 0)
        ect_facts_of_sii(new_set(v, operand, part), image, (size_t)size);
    free(image);
    return size >= 0;
}

static bool add_written_image(verify_t *v, const char *operand, const ect_device_t *device)
{
    uint8_t *image = sii_file_make(device, NULL, 0, v->message, sizeof v->message);
    if (image == NULL)
        return false;
    ect_facts_of_sii(new_set(v, operand, " EEPROM"), image, device->sii_size);
    free(image);
    return true;
}

/* A description, and the EEPROM of it; that of a file only if it carries one. */
static bool add_device(verify_t *v, const char *operand, const char *name, bool only_said)
{
    const ect_product_t *product = product_find(name, NULL, 0, v->message);
    if (product == NULL)
        return false;
    const ect_esi_twin_t *twin = product_twin(product);
    ect_facts_t *set = new_set(v, operand, "");
    if (twin != NULL)
        ect_facts_of_esi(set, product->device, ect_esi_twin_model(twin));
    else
        ect_facts_of_device(set, product->device);
    return (only_said && product->device->sii == NULL) || add_written_image(v, operand, product->device);
}

/* --- a slave on the wire ----------------------------------------------------------------------------------------- */

/* Beside this program, else in PATH. */
static const char *probe_path(ect_arena_t *arena)
{
    char self[4096];
    ssize_t length = readlink("/proc/self/exe", self, sizeof self - 1);
    while (length > 0 && self[length - 1] != '/')
        length--;
    const char *beside = ect_arena_print(arena, "%.*sectwin-probe", length > 0 ? (int)length : 0, self);
    return length > 0 && access(beside, X_OK) == 0 ? beside : "ectwin-probe";
}

static bool run_probe(verify_t *v, const char *iface, const char *number, const char *sii, const char *od)
{
    char *arguments[] = {
        "ectwin-probe",         "-i",   (char *)(uintptr_t)iface, "-n", (char *)(uintptr_t)number, "--sii",
        (char *)(uintptr_t)sii, "--od", (char *)(uintptr_t)od,    NULL};
    pid_t child;
    int status = 0;
    int error = posix_spawnp(&child, probe_path(&v->arena), NULL, NULL, arguments, environ);
    if (error != 0) {
        (void)snprintf(v->message, sizeof v->message,
                       "slaves are read by ectwin-probe, which is neither beside this program nor in PATH: %s",
                       strerror(error));
        return false;
    }
    while (waitpid(child, &status, 0) < 0 && errno == EINTR)
        continue;
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0)
        return true;
    (void)snprintf(v->message, sizeof v->message, "slave:%s:%s could not be read", iface, number);
    return false;
}

static bool add_dictionary(verify_t *v, const char *operand, const char *path)
{
    FILE *file = fopen(path, "rb");
    char *json = NULL;
    size_t room = 0;
    bool fine = file != NULL && getdelim(&json, &room, '\0', file) > 0 &&
                ect_facts_of_dictionary(new_set(v, operand, " dictionary"), json);
    if (!fine)
        (void)snprintf(v->message, sizeof v->message, "%s: its dictionary is not what ectwin-probe writes", operand);
    free(json);
    if (file != NULL)
        (void)fclose(file);
    return fine;
}

static bool add_slave(verify_t *v, const char *operand)
{
    const char *rest = strchr(operand, ':') + 1;
    const char *colon = strchr(rest, ':');
    const char *iface = colon != NULL ? ect_arena_copy(&v->arena, rest, (size_t)(colon - rest)) : rest;
    const char *parent = getenv("TMPDIR");
    char *folder = ect_arena_print(&v->arena, "%s/ectwin-XXXXXX", parent != NULL && *parent != '\0' ? parent : "/tmp");
    if (mkdtemp(folder) == NULL) {
        (void)snprintf(v->message, sizeof v->message, "cannot make a folder '%s': %s", folder, strerror(errno));
        return false;
    }
    const char *sii = ect_arena_print(&v->arena, "%s/sii.bin", folder);
    const char *od = ect_arena_print(&v->arena, "%s/od.json", folder);
    bool fine = run_probe(v, iface, colon != NULL ? colon + 1 : "1", sii, od) &&
                add_image(v, operand, " EEPROM", sii) && add_dictionary(v, operand, od);
    (void)unlink(sii);
    (void)unlink(od);
    (void)rmdir(folder);
    return fine;
}

/* --- the command ------------------------------------------------------------------------------------------------- */

static bool ends_with(const char *text, const char *end)
{
    size_t length = strlen(text);
    return length >= strlen(end) && strcasecmp(text + length - strlen(end), end) == 0;
}

static bool is_esi(const char *operand)
{
    const char *hash = strrchr(operand, '#'), *suffix = strcasestr(operand, ".xml");
    return ends_with(operand, ".xml") || (hash != NULL && suffix != NULL && suffix < hash);
}

static bool add(verify_t *v, const char *operand)
{
    if (v->count + 2 > SETS_MOST) {
        (void)snprintf(v->message, sizeof v->message, "more than %d sources at once", SETS_MOST / 2);
        return false;
    }
    if (strncmp(operand, "slave:", 6) == 0)
        return add_slave(v, operand);
    if (product_file(operand) != NULL)
        return add_device(v, operand, operand, false);
    if (is_esi(operand))
        return add_device(v, operand, ect_arena_print(&v->arena, "esi:%s", operand), true);
    if (ends_with(operand, ".bin") || ends_with(operand, ".hex") ||
        (ect_catalogue_find(operand) == NULL && access(operand, F_OK) == 0))
        return add_image(v, operand, "", operand);
    return add_device(v, operand, operand, false);
}

typedef struct operands {
    const char **names;
    size_t count;
} operands_t;

static error_t parse(int key, char *text, struct argp_state *state)
{
    operands_t *operands = state->input;
    if (key == ARGP_KEY_ARG) {
        operands->names[operands->count++] = text;
        return 0;
    }
    if (key == ARGP_KEY_NO_ARGS)
        argp_error(state, "name what to compare: FILE.xml[#TYPE], FILE.bin, FILE.hex, DEVICE, slave:IFACE[:N]");
    return ARGP_ERR_UNKNOWN;
}

static int compare(verify_t *v)
{
    ect_facts_t known = {.source = v->sets[0].source};
    size_t lines = 0;
    for (size_t i = 0; i < v->count; i++)
        lines += ect_facts_compare(&known, &v->sets[i], stdout);
    ect_facts_free(&known);
    return lines > 0 ? DIFFERENT : SAME;
}

int command_verify(int argc, char **argv)
{
    static const struct argp argp = {
        .parser = parse,
        .args_doc = "A [B...]",
        .doc = "Compares what is said of a device: by an ESI file (FILE.xml[#TYPE]), an EEPROM image (FILE.bin, "
               "FILE.hex), a DEVICE ('ectwin list' or esi:FILE.xml#TYPE) with the EEPROM that it has, a slave on the "
               "wire (slave:IFACE[:N]) with its EEPROM and its dictionary. The first is the expectation; what it does "
               "not say, the next do. One line a difference.\v"
               "Exits with 0 when there is no difference, 1 when there is one, 2 when something could not be read. "
               "Serial number and alias, which are each slave's own, are not compared.",
    };
    operands_t operands = {.names = calloc((size_t)argc + 1, sizeof *operands.names)};
    verify_t *v = calloc(1, sizeof *v);
    if (operands.names == NULL || v == NULL)
        return TROUBLE;
    argp_err_exit_status = TROUBLE;
    argp_parse(&argp, argc, argv, 0, NULL, &operands);
    int status = SAME;
    for (size_t i = 0; i < operands.count && status == SAME; i++) {
        if (!add(v, operands.names[i]))
            status = TROUBLE;
    }
    if (status == SAME && v->count < 2) {
        (void)snprintf(v->message, sizeof v->message, "'%s' is one thing alone: name what to compare it with",
                       operands.names[0]);
        status = TROUBLE;
    }
    if (status == SAME)
        status = compare(v);
    else
        fprintf(stderr, "ectwin verify: %s\n", v->message);
    for (size_t i = 0; i < v->count; i++)
        ect_facts_free(&v->sets[i]);
    ect_arena_free(&v->arena);
    free(operands.names);
    free(v);
    return status;
}
