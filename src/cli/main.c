/* The command: one table of verbs, one line on stderr for a failure, exit status by hl_status. */
#include <stdlib.h>
#include <string.h>

#include "halflight/info.h"
#include "options.h"
#include "outputs.h"

static const hl_command *const commands[] = {
    &hl_command_estimate, &hl_command_locate,  &hl_command_fit,    &hl_command_relight,
    &hl_command_brdf,     &hl_command_render,  &hl_command_target, &hl_command_calibrate,
    &hl_command_drift,    &hl_command_convert, &hl_command_info,
};

enum { N_COMMANDS = sizeof commands / sizeof commands[0] };

static void print_help(FILE *out)
{
  fputs("halflight: where the light is, from one photo of a glossy ball\n\n"
        "usage: halflight VERB [options]\n",
        out);
  for (int i = 0; i < N_COMMANDS; i++)
    fprintf(out, "  %-10s %s\n", commands[i]->name, commands[i]->sentence);
  fputs("\n'halflight VERB --help' explains a verb; 'halflight --version' says which.\n"
        "Exit status: 0 done, 1 failed, 2 wrong usage, 3 ran but not to be trusted.\n",
        out);
}

static int no_verb(const char *word)
{
  const char *names[N_COMMANDS + 2];
  int n = 0;
  for (int i = 0; i < N_COMMANDS; i++)
    names[n++] = commands[i]->name;
  names[n++] = "--help";
  names[n++] = "--version";
  const char *near = word ? hl_options_nearest(word, names, n) : NULL;
  if (!word)
    fprintf(stderr, "halflight: no verb given; 'halflight --help' lists them\n");
  else if (near)
    fprintf(stderr, "halflight: unknown verb '%.40s'; did you mean '%s'?\n", word, near);
  else
    fprintf(stderr, "halflight: unknown verb '%.40s'; 'halflight --help' lists them\n", word);
  return hl_status_exit(HL_ERR_ARG);
}

static hl_status run(hl_ctx *ctx, const hl_command *command, int n, char *const *words)
{
  for (int i = 0; i < n && strcmp(words[i], "--") != 0; i++)
    if (strcmp(words[i], "--help") == 0 || strcmp(words[i], "-h") == 0)
      return hl_options_help(ctx, command, stdout);
  void *args = calloc(1, command->size);
  if (!args)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for the arguments");
  if (command->defaults)
    command->defaults(args);
  hl_status st = hl_options_parse(ctx, command, n, words, args);
  if (st == HL_OK)
    st = command->run(ctx, args);
  hl_options_release(command, args);
  free(args);
  return st;
}

/* A message is one line whatever a file name holds. */
static void print_failure(const char *verb, const char *message)
{
  fprintf(stderr, "halflight: %s: ", verb);
  for (const char *c = message; *c; c++)
    fputc((unsigned char)*c < 0x20 || *c == 0x7f ? '?' : *c, stderr);
  fputc('\n', stderr);
}

int main(int argc, char **argv)
{
  hl_ctx ctx = {0};
  if (argc < 2)
    return no_verb(NULL);
  const bool help =
      strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0 || strcmp(argv[1], "help") == 0;
  if (help || strcmp(argv[1], "--version") == 0) {
    if (help)
      print_help(stdout);
    else
      printf("halflight %s\n", hl_version());
    const hl_status st = hl_outputs_print(&ctx);
    if (st != HL_OK)
      fprintf(stderr, "halflight: %s\n", ctx.msg);
    return hl_status_exit(st);
  }
  const hl_command *command = NULL;
  for (int i = 0; i < N_COMMANDS && !command; i++)
    if (strcmp(argv[1], commands[i]->name) == 0)
      command = commands[i];
  if (!command)
    return no_verb(argv[1]);
  hl_status st = run(&ctx, command, argc - 2, argv + 2);
  /* an untrusted answer is printed too; a lost one outranks its verdict */
  hl_ctx lost = {0};
  if (st != HL_ERR_IO && hl_outputs_print(&lost) != HL_OK) {
    ctx = lost;
    st = lost.status;
  }
  if (st != HL_OK)
    print_failure(command->name, ctx.msg);
  return hl_status_exit(st);
}
