#include "commands.h"

#include <string.h>

enum { HL_COMMANDS_MAX = 64 }; /* that a word is compared with */

const hl_command *const hl_commands[] = {
    &hl_command_estimate,  &hl_command_locate,  &hl_command_position, &hl_command_fit,
    &hl_command_relight,   &hl_command_brdf,    &hl_command_render,   &hl_command_target,
    &hl_command_calibrate, &hl_command_capture, &hl_command_replay,   &hl_command_drift,
    &hl_command_report,    &hl_command_convert, &hl_command_bench,    &hl_command_info,
    &hl_command_help,
};

const int hl_commands_count = sizeof hl_commands / sizeof hl_commands[0];

const hl_command *hl_commands_find(const char *name)
{
  for (int i = 0; i < hl_commands_count; i++)
    if (strcmp(name, hl_commands[i]->name) == 0)
      return hl_commands[i];
  return NULL;
}

hl_status hl_commands_unknown(hl_ctx *ctx, const char *name)
{
  const char *names[HL_COMMANDS_MAX] = {"--help", "--version"};
  int n = 2;
  for (int i = 0; i < hl_commands_count && n < HL_COMMANDS_MAX; i++)
    names[n++] = hl_commands[i]->name;
  const char *near = hl_options_nearest(name, names, n);
  if (near)
    return hl_fail(ctx, HL_ERR_ARG, "unknown verb '%.40s'; did you mean '%s'?", name, near);
  return hl_fail(ctx, HL_ERR_ARG, "unknown verb '%.40s'; 'halflight --help' lists them", name);
}
