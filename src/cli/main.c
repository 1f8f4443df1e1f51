/* The command: one table of verbs, one line on stderr for a failure, exit status by hl_status. */
#include <stdlib.h>
#include <string.h>

#include "commands.h"
#include "halflight/info.h"
#include "manual.h"
#include "outputs.h"

static hl_status run(hl_ctx *ctx, const hl_command *command, int n, char *const *words)
{
  for (int i = 0; i < n && strcmp(words[i], "--") != 0; i++)
    if (strcmp(words[i], "--help") == 0 || strcmp(words[i], "-h") == 0)
      return hl_options_help(ctx, command, stdout);
  void *args = hl_options_defaults(ctx, command);
  if (!args)
    return HL_ERR_MEMORY;
  hl_status st = hl_options_parse(ctx, command, n, words, args);
  if (st == HL_OK)
    st = command->run(ctx, args);
  hl_options_release(command, args);
  free(args);
  return st;
}

int main(int argc, char **argv)
{
  hl_ctx ctx = {0};
  if (argc < 2) {
    fprintf(stderr, "halflight: no verb given; 'halflight --help' lists them\n");
    return hl_status_exit(HL_ERR_ARG);
  }
  const bool help = strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0;
  if (help || strcmp(argv[1], "--version") == 0) {
    if (help)
      hl_manual_overview(stdout);
    else
      printf("halflight %s\n", hl_version());
    const hl_status st = hl_outputs_print(&ctx);
    if (st != HL_OK)
      fprintf(stderr, "halflight: %s\n", ctx.msg);
    return hl_status_exit(st);
  }
  const hl_command *command = hl_commands_find(argv[1]);
  if (!command) {
    const hl_status st = hl_commands_unknown(&ctx, argv[1]);
    fprintf(stderr, "halflight: %s\n", ctx.msg);
    return hl_status_exit(st);
  }
  hl_status st = run(&ctx, command, argc - 2, argv + 2);
  /* an untrusted answer is printed too; a lost one outranks its verdict */
  hl_ctx lost = {0};
  if (st != HL_ERR_IO && hl_outputs_print(&lost) != HL_OK) {
    ctx = lost;
    st = lost.status;
  }
  if (st != HL_OK)
    fprintf(stderr, "halflight: %s: %s\n", command->name, ctx.msg);
  return hl_status_exit(st);
}
