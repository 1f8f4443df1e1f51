/* Completion for bash and zsh: verbs, options, the words of a choice, else file names. */
#include <string.h>

#include "commands.h"
#include "manual.h"

/* The settings field of an option that is a choice; NULL where it is none. */
static const hl_field *choice_of(const hl_option *o)
{
  const hl_field *field = o->table ? hl_options_field(o) : NULL;
  return field && field->kind == HL_FIELD_CHOICE ? field : NULL;
}

/* Whether the value is one of a few words: a choice, or lower-case words parted by bars. */
static bool has_choices(const hl_option *o)
{
  return choice_of(o) || (o->value && strchr(o->value, '|') &&
                          strspn(o->value, "abcdefghijklmnopqrstuvwxyz-|") == strlen(o->value));
}

static void print_choices(FILE *out, const hl_option *o)
{
  const hl_field *field = choice_of(o);
  for (int k = 0; field && field->choices[k]; k++)
    fprintf(out, "%s%s", k ? " " : "", field->choices[k]);
  for (const char *c = o->value; !field && *c; c++)
    fputc(*c == '|' ? ' ' : *c, out);
}

static void print_verbs(FILE *out)
{
  for (int i = 0; i < hl_commands_count; i++)
    fprintf(out, "%s%s", i ? " " : "", hl_commands[i]->name);
}

static void bash(FILE *out)
{
  fputs("# bash completion for halflight\n"
        "_halflight()\n{\n"
        "  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]}\n"
        "  COMPREPLY=()\n"
        "  if [ \"$COMP_CWORD\" -eq 1 ]; then\n    COMPREPLY=($(compgen -W \"",
        out);
  print_verbs(out);
  fputs(" --help --version\" -- \"$word\"))\n    return\n  fi\n"
        "  case ${COMP_WORDS[1]},$before in\n",
        out);
  for (int i = 0; i < hl_commands_count; i++)
    for (int k = 0; k < hl_commands[i]->n_options; k++) {
      const hl_option *o = &hl_commands[i]->options[k];
      if (!has_choices(o))
        continue;
      fprintf(out, "  %s,--%s) COMPREPLY=($(compgen -W \"", hl_commands[i]->name, o->name);
      print_choices(out, o);
      fputs("\" -- \"$word\")); return ;;\n", out);
    }
  fputs("  esac\n  case $word in\n  -*)\n    case ${COMP_WORDS[1]} in\n", out);
  for (int i = 0; i < hl_commands_count; i++) {
    fprintf(out, "    %s) COMPREPLY=($(compgen -W \"--help", hl_commands[i]->name);
    for (int k = 0; k < hl_commands[i]->n_options; k++)
      fprintf(out, " --%s", hl_commands[i]->options[k].name);
    fputs("\" -- \"$word\")) ;;\n", out);
  }
  fputs("    esac\n    return ;;\n  esac\n"
        "  if [ \"${COMP_WORDS[1]}\" = help ]; then\n    COMPREPLY=($(compgen -W \"",
        out);
  print_verbs(out);
  fputs("\" -- \"$word\"))\n    return\n  fi\n"
        "  compopt -o filenames 2>/dev/null\n"
        "  COMPREPLY=($(compgen -f -- \"$word\"))\n}\n"
        "complete -F _halflight halflight\n",
        out);
}

/* Text between zsh's brackets, inside single quotes. */
static void bracketed(FILE *out, const char *text)
{
  for (; *text; text++) {
    if (*text == '\'')
      fputs("'\\''", out);
    else if (strchr("[]:\\", *text))
      fprintf(out, "\\%c", *text);
    else
      fputc(*text, out);
  }
}

static void zsh_option(FILE *out, const hl_option *o)
{
  const hl_field *field = o->table ? hl_options_field(o) : NULL;
  const char *help = o->help ? o->help : field ? field->help : "";
  fprintf(out, " \\\n      '--%s[", o->name);
  bracketed(out, help);
  fputc(']', out);
  if (o->value) {
    fputc(':', out);
    bracketed(out, o->value);
    if (has_choices(o)) {
      fputs(":(", out);
      print_choices(out, o);
      fputc(')', out);
    } else {
      fputs(field ? ": " : ":_files", out);
    }
  }
  fputc('\'', out);
}

static void zsh(FILE *out)
{
  fputs("#compdef halflight\n"
        "_halflight() {\n"
        "  local -a verbs\n  verbs=(\n",
        out);
  for (int i = 0; i < hl_commands_count; i++) {
    fprintf(out, "    '%s:", hl_commands[i]->name);
    bracketed(out, hl_commands[i]->sentence);
    fputs("'\n", out);
  }
  fputs("  )\n"
        "  if (( CURRENT == 2 )); then\n    _describe verb verbs\n    return\n  fi\n"
        "  local verb=$words[2]\n  shift words\n  (( CURRENT-- ))\n  case $verb in\n",
        out);
  for (int i = 0; i < hl_commands_count; i++) {
    fprintf(out, "  %s)\n    _arguments '--help[show the options]'", hl_commands[i]->name);
    for (int k = 0; k < hl_commands[i]->n_options; k++)
      zsh_option(out, &hl_commands[i]->options[k]);
    fprintf(out, " \\\n      '*:%s:_files'\n    ;;\n",
            hl_commands[i]->n_operands ? hl_commands[i]->operands[0].name : "file");
  }
  fputs("  esac\n}\n_halflight \"$@\"\n", out);
}

void hl_manual_completion(hl_shell shell, FILE *out)
{
  if (shell == HL_SHELL_BASH)
    bash(out);
  else
    zsh(out);
}
