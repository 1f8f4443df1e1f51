/* A verb's table of options as the text that --help prints. */
#include <stdlib.h>
#include <string.h>

#include "options.h"

static const double UNBOUNDED = 1e30; /* a larger bound is none to a reader */

enum { HELP_WIDTH = 79, HELP_COLUMN = 26 };

/* Text wrapped at HELP_WIDTH, continued at `column`; `at` is where the pen stands. */
static void print_wrapped(FILE *out, const char *text, int at, int column)
{
  while (*text) {
    const int word = (int)strcspn(text, " ");
    if (at > column && at + 1 + word > HELP_WIDTH) {
      fprintf(out, "\n%*s", column, "");
      at = column;
    } else if (at > column) {
      fputc(' ', out);
      at++;
    }
    fprintf(out, "%.*s", word, text);
    at += word;
    text += word;
    text += strspn(text, " ");
  }
  fputc('\n', out);
}

static void print_entry(FILE *out, const char *left, const char *right)
{
  int at = fprintf(out, "  %s", left);
  if (at >= HELP_COLUMN) {
    fputc('\n', out);
    at = 0;
  }
  fprintf(out, "%*s", HELP_COLUMN - at, "");
  print_wrapped(out, right, HELP_COLUMN, HELP_COLUMN);
}

/* "help [unit] (default, range)" of an option that is a settings field. */
static void describe_field(const hl_option *option, const hl_field *field, const void *args,
                           char *out, size_t size)
{
  const char *at = (const char *)args + option->offset + field->offset;
  const char *help = option->help ? option->help : field->help;
  int n = snprintf(out, size, "%s%s%s%s (", help, field->unit[0] ? " [" : "", field->unit,
                   field->unit[0] ? "]" : "");
  double value = 0;
  int whole = 0;
  if (field->kind == HL_FIELD_DOUBLE) {
    memcpy(&value, at, sizeof value);
  } else {
    memcpy(&whole, at, sizeof whole);
    value = whole;
  }
  if (n < 0 || (size_t)n >= size)
    return;
  const bool stated = value >= field->min && value <= field->max;
  if (field->kind == HL_FIELD_CHOICE && stated)
    snprintf(out + n, size - (size_t)n, "default %s)", field->choices[whole]);
  else if (stated && field->max > UNBOUNDED)
    snprintf(out + n, size - (size_t)n, "default %.6g, at least %.6g)", value, field->min);
  else if (stated)
    snprintf(out + n, size - (size_t)n, "default %.6g, %.6g to %.6g)", value, field->min,
             field->max);
  else
    snprintf(out + n, size - (size_t)n, "%.6g to %.6g)", field->min, field->max);
}

void hl_options_describe(const hl_option *option, const void *args, char *out, size_t size)
{
  const hl_field *field = option->table ? hl_options_field(option) : NULL;
  if (field)
    describe_field(option, field, args, out, size);
  else
    snprintf(out, size, "%s", option->help);
}

static void print_option(FILE *out, const hl_option *option, const void *args)
{
  char left[80], right[HL_OPTION_TEXT_MAX];
  snprintf(left, sizeof left, "--%s%s%s", option->name, option->value ? " " : "",
           option->value ? option->value : "");
  hl_options_describe(option, args, right, sizeof right);
  print_entry(out, left, right);
}

void *hl_options_defaults(hl_ctx *ctx, const hl_command *command)
{
  void *args = calloc(1, command->size);
  if (args && command->defaults)
    command->defaults(args);
  if (!args)
    hl_fail(ctx, HL_ERR_MEMORY, "no memory for the arguments");
  return args;
}

static void print_operand(FILE *out, const hl_operand *operand)
{
  const bool needed = operand->count == HL_OPERAND_NEEDED;
  fprintf(out, " %s%s%s%s", needed ? "" : "[", operand->name,
          operand->count == HL_OPERAND_MANY ? "..." : "", needed ? "" : "]");
}

hl_status hl_options_help(hl_ctx *ctx, const hl_command *command, FILE *out)
{
  void *args = hl_options_defaults(ctx, command);
  if (!args)
    return HL_ERR_MEMORY;
  print_wrapped(out, command->sentence, 0, 0);
  fprintf(out, "\nusage: halflight %s", command->name);
  for (int i = 0; i < command->n_operands; i++)
    print_operand(out, &command->operands[i]);
  fprintf(out, "%s\n", command->n_options ? " [options]" : "");
  for (int i = 0; i < command->n_operands; i++)
    print_entry(out, command->operands[i].name, command->operands[i].help);
  for (int i = 0; i < command->n_options; i++) {
    if (command->options[i].group)
      fprintf(out, "\n%s:\n", command->options[i].group);
    print_option(out, &command->options[i], args);
  }
  if (command->notes)
    fprintf(out, "\n%s\n", command->notes);
  if (command->example)
    fprintf(out, "\nexample:\n%s\n", command->example);
  free(args);
  return HL_OK;
}
