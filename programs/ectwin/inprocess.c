/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "inprocess.h"

#include <elf.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <link.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "bus/inprocess/bus.h"
#include "net_folder.h"

enum { SEPARATOR = 0x1F, MARK_PATH = 80 };

/* Folders of the library: that of the program, as in a build, or lib/ectwin beside it, as installed. */
static const char *const places[] = {"", "../lib/ectwin/", "../" ECTWIN_LIBDIR "/ectwin/"};

static bool find_library(const char *name, char path[PATH_MAX])
{
    char self[PATH_MAX];
    ssize_t length = readlink("/proc/self/exe", self, sizeof self - 1);
    if (length <= 0)
        return false;
    self[length] = 0;
    char *slash = strrchr(self, '/');
    for (size_t i = 0; slash && i < sizeof places / sizeof *places; i++) {
        char candidate[2 * PATH_MAX];
        snprintf(candidate, sizeof candidate, "%.*s/%s%s", (int)(slash - self), self, places[i], name);
        if (realpath(candidate, path))
            return true;
    }
    return false;
}

/* Finds CMD as execvp() does: an empty element of PATH is the working directory. @return false: not found; starting CMD
 * reports this */
static bool find_command(const char *name, char path[PATH_MAX])
{
    if (strchr(name, '/'))
        return snprintf(path, PATH_MAX, "%s", name) < PATH_MAX;
    const char *folders = getenv("PATH");
    while (folders) {
        size_t length = strcspn(folders, ":");
        snprintf(path, PATH_MAX, "%.*s%s%s", (int)length, folders, length > 0 ? "/" : "", name);
        if (access(path, X_OK) == 0)
            return true;
        folders = folders[length] == ':' ? folders + length + 1 : NULL;
    }
    return false;
}

/* The kind of a program: a program can load the library if word size, processor and dynamic linker are the same. */
typedef struct kind {
    unsigned char word_size;
    ElfW(Half) processor;
    char linker[256]; /* name without the folder; "": a static program */
} kind_t;

static void read_linker(int fd, const ElfW(Ehdr) * header, kind_t *kind)
{
    ElfW(Phdr) part;
    char path[sizeof kind->linker] = "";
    for (ElfW(Half) i = 0; i < header->e_phnum; i++) {
        off_t at = (off_t)(header->e_phoff + (ElfW(Off))i * sizeof part);
        if (pread(fd, &part, sizeof part, at) != (ssize_t)sizeof part || part.p_type != PT_INTERP)
            continue;
        size_t length = part.p_filesz < sizeof path ? part.p_filesz : sizeof path - 1;
        if (pread(fd, path, length, (off_t)part.p_offset) != (ssize_t)length)
            path[0] = 0;
    }
    const char *slash = strrchr(path, '/');
    snprintf(kind->linker, sizeof kind->linker, "%s", slash ? slash + 1 : path);
}

/* @return whether the file is an ELF program */
static bool read_kind(const char *path, kind_t *kind)
{
    ElfW(Ehdr) header;
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    bool whole = fd >= 0 && read(fd, &header, sizeof header) == (ssize_t)sizeof header &&
                 memcmp(header.e_ident, ELFMAG, SELFMAG) == 0;
    *kind = (kind_t){0};
    if (whole) {
        kind->word_size = header.e_ident[EI_CLASS];
        kind->processor = header.e_machine;
    }
    if (whole && header.e_phentsize == sizeof(ElfW(Phdr)))
        read_linker(fd, &header, kind);
    if (fd >= 0)
        close(fd);
    return whole;
}

static bool fits(const char *command, char *message)
{
    char path[PATH_MAX];
    kind_t its, ours;
    if (!find_command(command, path) || !read_kind(path, &its) || !read_kind("/proc/self/exe", &ours))
        return true;
    if (its.word_size != ours.word_size || its.processor != ours.processor) {
        snprintf(message, INPROCESS_MESSAGE,
                 "'%s' is a program of another processor or word size than ectwin: run it without --in-process",
                 command);
        return false;
    }
    /* A static program is accepted: it may start dynamic ones. */
    if (!*its.linker || !*ours.linker || strcmp(its.linker, ours.linker) == 0)
        return true;
    snprintf(message, INPROCESS_MESSAGE,
             "'%.200s' uses another C library (%.100s) than ectwin (%.100s): run it without --in-process", command,
             its.linker, ours.linker);
    return false;
}

static bool set_words(const in_process_t *p)
{
    size_t room = 1;
    for (int i = 0; i < p->word_count; i++)
        room += strlen(p->words[i]) + 1;
    char *all = calloc(1, room);
    size_t used = 0;
    for (int i = 0; all && i < p->word_count; i++) {
        size_t length = strlen(p->words[i]);
        if (i > 0)
            all[used++] = SEPARATOR;
        memcpy(all + used, p->words[i], length);
        used += length;
    }
    bool done = all && setenv("ECTWIN_INPROCESS", all, 1) == 0;
    free(all);
    return done;
}

/* The runtime library of a sanitizer must be the first one. */
static bool set_preload(const char *library)
{
    const char *before = getenv("LD_PRELOAD");
    char *all = NULL;
    bool more = before && *before;
    if (asprintf(&all, "%s%s%s%s", ECTWIN_PRELOAD_FIRST, library, more ? ":" : "", more ? before : "") < 0)
        return false;
    bool done = setenv("LD_PRELOAD", all, 1) == 0;
    free(all);
    return done;
}

static bool make_folder(in_process_t *p)
{
    const char *parent = getenv("TMPDIR");
    if (!parent || strlen(parent) > sizeof p->folder / 2)
        parent = "/tmp";
    snprintf(p->folder, sizeof p->folder, "%s/ectwin-XXXXXX", parent);
    return mkdtemp(p->folder) && chmod(p->folder, 0755) == 0;
}

static void mark_of(const in_process_t *p, char path[MARK_PATH])
{
    snprintf(path, MARK_PATH, "%s/mark", p->folder);
}

static bool make_mark(const in_process_t *p)
{
    char path[MARK_PATH];
    mark_of(p, path);
    int fd = open(path, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    if (fd < 0)
        return false;
    close(fd);
    return setenv("ECTWIN_INPROCESS_MARK", path, 1) == 0;
}

static bool make_files(in_process_t *p)
{
    return make_folder(p) && make_mark(p) && net_folder_make(p->folder, p->interfaces, p->interface_count) &&
           setenv("ECTWIN_INPROCESS_NET", p->folder, 1) == 0;
}

bool in_process_prepare(in_process_t *p, char *message)
{
    char path[PATH_MAX];
    char here[PATH_MAX];
    const char *name = p->virtual_time ? "libectwin-virtual.so" : "libectwin-real.so";
    if (!fits(p->command, message))
        return false;
    if (!find_library(name, path)) {
        snprintf(message, INPROCESS_MESSAGE, "%s is not where ectwin is installed: install ectwin again", name);
        return false;
    }
    if (set_words(p) && set_preload(path) && make_files(p) && getcwd(here, sizeof here) &&
        setenv("ECTWIN_INPROCESS_CWD", here, 1) == 0)
        return true;
    snprintf(message, INPROCESS_MESSAGE, "the environment of CMD cannot be made: %s", strerror(errno));
    net_folder_remove(p->folder);
    return false;
}

bool in_process_finish(in_process_t *p, bool *met)
{
    char marks[4096];
    char path[MARK_PATH];
    mark_of(p, path);
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    ssize_t length;
    size_t opened = 0, good = 0;
    while (fd >= 0 && (length = read(fd, marks, sizeof marks)) > 0) {
        for (ssize_t i = 0; i < length; i++) {
            opened += marks[i] == ECT_BUS_MARK_OPENED;
            good += marks[i] == ECT_BUS_MARK_MET;
        }
    }
    if (fd >= 0)
        close(fd);
    net_folder_remove(p->folder);
    *met = *met || (opened > 0 && good == opened);
    return opened > 0;
}
