/* help: the overview, a verb's options, manual pages and shell completion, all from one table. */
#include <stdio.h>
#include <string.h>

#include "commands.h"
#include "manual.h"

typedef struct help_args {
  const char *verb, *completion;
  bool man;
} help_args;

#define AT(member) offsetof(help_args, member)

static const hl_operand operands[] = {
    {"VERB", "the verb to explain", AT(verb), HL_OPERAND_OPTIONAL},
};

static const hl_option options[] = {
    {"man", NULL, "Form", "print a manual page, in man(7)", AT(man), 0, 0},
    {"completion", "bash|zsh", NULL, "print completion for that shell", AT(completion), 0, 0},
};

static hl_status print_completion(hl_ctx *ctx, const help_args *a)
{
  const bool is_bash = strcmp(a->completion, "bash") == 0;
  if (!is_bash && strcmp(a->completion, "zsh") != 0)
    return hl_fail(ctx, HL_ERR_ARG, "--completion '%.40s': bash or zsh would be accepted",
                   a->completion);
  if (a->verb || a->man)
    return hl_fail(ctx, HL_ERR_ARG, "--completion and %s contradict; it covers all verbs",
                   a->man ? "--man" : "a verb");
  hl_manual_completion(is_bash ? HL_SHELL_BASH : HL_SHELL_ZSH, stdout);
  return HL_OK;
}

static hl_status run(hl_ctx *ctx, const void *args)
{
  const help_args *a = args;
  if (a->completion)
    return print_completion(ctx, a);
  const hl_command *command = a->verb ? hl_commands_find(a->verb) : NULL;
  if (a->verb && !command)
    return hl_commands_unknown(ctx, a->verb);
  if (a->man)
    return hl_manual_page(ctx, command, stdout);
  if (command)
    return hl_options_help(ctx, command, stdout);
  hl_manual_overview(stdout);
  return HL_OK;
}

const hl_command hl_command_help = {
    .name = "help",
    .sentence = "Explain a verb; print manual pages and shell completion.",
    .operands = operands,
    .n_operands = sizeof operands / sizeof *operands,
    .options = options,
    .n_options = sizeof options / sizeof *options,
    .example = "  $ halflight help info --man > halflight-info.1",
    .size = sizeof(help_args),
    .run = run,
};
