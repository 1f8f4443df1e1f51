/* The verbs' tables as manual pages and as shell completion. */
#ifndef HL_CLI_MANUAL_H
#define HL_CLI_MANUAL_H

#include "options.h"

/* One line a verb, as `halflight --help` shows it. */
void hl_manual_overview(FILE *out);

/* man(7) of one verb; NULL: of the command as a whole. HL_ERR_MEMORY. */
hl_status hl_manual_page(hl_ctx *ctx, const hl_command *command, FILE *out);

typedef enum hl_shell { HL_SHELL_BASH, HL_SHELL_ZSH } hl_shell;
void hl_manual_completion(hl_shell shell, FILE *out);

#endif
