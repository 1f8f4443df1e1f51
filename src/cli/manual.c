/* Manual pages in man(7): one for the command, one a verb. */
#include "manual.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

#include "commands.h"
#include "halflight/info.h"

static const char purpose[] = "where the light is, from one photo of a glossy ball";

void hl_manual_overview(FILE *out)
{
  fprintf(out, "halflight: %s\n\nusage: halflight VERB [options]\n", purpose);
  for (int i = 0; i < hl_commands_count; i++)
    fprintf(out, "  %-10s %s\n", hl_commands[i]->name, hl_commands[i]->sentence);
  fputs("\n'halflight VERB --help' explains a verb; 'halflight --version' says which.\n"
        "Exit status: 0 done, 1 failed, 2 wrong usage, 3 ran but not to be trusted.\n",
        out);
}

/* Text that roff must not read as its own: backslashes, hyphens that are typed, and a dot or a quote at
 * the start of a line. */
static void escaped(FILE *out, const char *text)
{
  bool start = true;
  for (; *text; text++) {
    if (start && (*text == '.' || *text == '\''))
      fputs("\\&", out);
    start = *text == '\n';
    if (*text == '\\')
      fputs("\\e", out);
    else if (*text == '-')
      fputs("\\-", out);
    else if (*text == '\'')
      fputs("\\(aq", out);
    else
      fputc(*text, out);
  }
}

static void title(FILE *out, const char *verb)
{
  fputs(".TH HALFLIGHT", out);
  for (const char *c = verb; c && *c; c++)
    fprintf(out, "%s%c", c == verb ? "\\-" : "", toupper((unsigned char)*c));
  fprintf(out, " 1 \"\" \"halflight %s\" \"User commands\"\n", hl_version());
}

static void name(FILE *out, const char *verb, const char *sentence)
{
  const size_t length = strlen(sentence);
  const bool stop = length > 0 && sentence[length - 1] == '.';
  fprintf(out, ".SH NAME\nhalflight%s%s \\- ", verb ? "\\-" : "", verb ? verb : "");
  char first = (char)tolower((unsigned char)sentence[0]);
  fputc(first, out);
  for (size_t i = 1; i < length - (stop ? 1 : 0); i++)
    fputc(sentence[i], out);
  fputc('\n', out);
}

static void literal(FILE *out, const char *heading, const char *text)
{
  fprintf(out, ".SH %s\n.nf\n", heading);
  escaped(out, text);
  fputs("\n.fi\n", out);
}

static void statuses(FILE *out)
{
  fputs(
      ".SH EXIT STATUS\n"
      ".TP\n.B 0\ndone\n"
      ".TP\n.B 1\nfailed: unreadable, malformed, or not in this build; one line on standard error "
      "says what, where, and what would be accepted\n"
      ".TP\n.B 2\nwrong usage\n"
      ".TP\n.B 3\nran, and the answer should not be trusted\n",
      out);
}

static void whole_page(FILE *out)
{
  title(out, NULL);
  name(out, NULL, purpose);
  fputs(".SH SYNOPSIS\n.B halflight\n.I VERB\n[options]\n.SH DESCRIPTION\n", out);
  fputs("Estimates the direction of the light, with its uncertainty, from one photo of a ball "
        "taken with a calibrated camera.\n.SH VERBS\n",
        out);
  for (int i = 0; i < hl_commands_count; i++) {
    fprintf(out, ".TP\n.BR halflight\\-%s (1)\n", hl_commands[i]->name);
    escaped(out, hl_commands[i]->sentence);
    fputc('\n', out);
  }
  statuses(out);
}

static void operand(FILE *out, const hl_operand *o)
{
  const bool needed = o->count == HL_OPERAND_NEEDED;
  fprintf(out, "%s\\fI", needed ? "" : "[");
  escaped(out, o->name);
  fprintf(out, "\\fR%s%s\n", o->count == HL_OPERAND_MANY ? "..." : "", needed ? "" : "]");
}

hl_status hl_manual_page(hl_ctx *ctx, const hl_command *command, FILE *out)
{
  if (!command) {
    whole_page(out);
    return HL_OK;
  }
  void *args = hl_options_defaults(ctx, command);
  if (!args)
    return HL_ERR_MEMORY;
  title(out, command->name);
  name(out, command->name, command->sentence);
  fprintf(out, ".SH SYNOPSIS\n.B halflight %s\n", command->name);
  for (int i = 0; i < command->n_operands; i++)
    operand(out, &command->operands[i]);
  fprintf(out, "%s.SH DESCRIPTION\n", command->n_options ? "[options]\n" : "");
  escaped(out, command->sentence);
  fputc('\n', out);
  for (int i = 0; i < command->n_operands; i++) {
    fputs(".TP\n", out);
    operand(out, &command->operands[i]);
    escaped(out, command->operands[i].help);
    fputc('\n', out);
  }
  if (command->n_options)
    fputs(".SH OPTIONS\n", out);
  for (int i = 0; i < command->n_options; i++) {
    const hl_option *o = &command->options[i];
    char text[HL_OPTION_TEXT_MAX];
    hl_options_describe(o, args, text, sizeof text);
    if (o->group)
      fprintf(out, ".SS %s\n", o->group);
    fputs(".TP\n\\fB\\-\\-", out);
    escaped(out, o->name);
    fputs("\\fR", out);
    if (o->value) {
      fputs(" \\fI", out);
      escaped(out, o->value);
      fputs("\\fR", out);
    }
    fputc('\n', out);
    escaped(out, text);
    fputc('\n', out);
  }
  if (command->notes)
    literal(out, "NOTES", command->notes);
  if (command->example)
    literal(out, "EXAMPLE", command->example);
  statuses(out);
  fputs(".SH SEE ALSO\n.BR halflight (1)\n", out);
  free(args);
  return HL_OK;
}
