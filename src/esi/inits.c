/* SPDX-License-Identifier: MIT */
/* The start-up commands of a file as those of the description. */
#include <string.h>

#include "esi/internal.h"

/* @return those transitions of a command that are valid for a mailbox; "": none */
static const char *known_transitions(ect_build_t *build, const char *transitions, int line)
{
    static const char known[] = "IP PS SO SP OP OS";
    const char *kept = "";
    bool all = true;
    for (const char *word = transitions; *word != '\0'; word += strspn(word, " ")) {
        size_t length = strcspn(word, " ");
        char name[3] = {word[0], word[1], '\0'};
        bool good = length == 2 && strstr(known, name) != NULL;
        if (good)
            kept = ect_arena_print(build->arena, "%s%s%s", kept, *kept != '\0' ? " " : "", name);
        all &= good;
        word += length;
    }
    if (!all)
        ect_build_note(build, "line %d: a start-up command has the transitions \"%s\", not all of them of %s", line,
                       transitions, known);
    return kept;
}

static void set_init_commands(ect_build_t *build, ect_device_t *device)
{
    const ect_esi_mailbox_t *mailbox = &build->model->mailbox;
    size_t count = mailbox->init_count < UINT8_MAX ? mailbox->init_count : UINT8_MAX;
    ect_init_command_t *commands = ect_arena_alloc(build->arena, (count + 1) * sizeof *commands);
    device->init_commands = commands;
    for (size_t i = 0; i < count; i++) {
        const ect_esi_init_t *init = &mailbox->inits[i];
        const char *transitions = known_transitions(build, init->transitions, init->line);
        if (*transitions == '\0' || (init->data.length == 0 && !init->upload) || init->data.length > UINT16_MAX)
            continue;
        commands[device->init_command_count++] = (ect_init_command_t){
            .transitions = transitions,
            .index = init->index,
            .subindex = init->subindex,
            .complete = init->complete,
            .adapts = init->adapts,
            .size = (uint16_t)init->data.length,
            .data = init->data.bytes,
            .comment = *init->comment != '\0' ? init->comment : NULL,
            .disabled = init->disabled,
            .upload = init->upload,
        };
    }
}

static void set_init_mails(ect_build_t *build, ect_device_t *device)
{
    const ect_esi_mailbox_t *mailbox = &build->model->mailbox;
    size_t count = mailbox->mail_count < UINT8_MAX ? mailbox->mail_count : UINT8_MAX;
    ect_init_mail_t *mails = ect_arena_alloc(build->arena, (count + 1) * sizeof *mails);
    device->init_mails = mails;
    for (size_t i = 0; i < count; i++) {
        const ect_esi_mail_t *mail = &mailbox->mails[i];
        const char *transitions = known_transitions(build, mail->transitions, mail->line);
        if (*transitions == '\0' || mail->data.length > UINT16_MAX)
            continue;
        mails[device->init_mail_count++] = (ect_init_mail_t){
            .transitions = transitions,
            .comment = *mail->comment != '\0' ? mail->comment : NULL,
            .protocol = mail->protocol,
            .type = mail->type,
            .drive = mail->drive,
            .elements = mail->elements,
            .idn = mail->idn,
            .disabled = mail->disabled,
            .size = (uint16_t)mail->data.length,
            .data = mail->data.bytes,
        };
    }
}

void ect_esi_inits_set(ect_build_t *build, ect_device_t *device)
{
    set_init_commands(build, device);
    set_init_mails(build, device);
}
