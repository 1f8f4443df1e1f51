/* One table a verb: it drives the parser, the usage line and the help text. */
#ifndef HL_CLI_OPTIONS_H
#define HL_CLI_OPTIONS_H

#include <stdbool.h>
#include <stdio.h>

#include "halflight/settings.h"

/* The kind follows from what is filled in: `table` (a settings field, which brings text, unit and
 * bounds), `parse` (the option reads its own text), neither (the text itself, const char *), or no
 * `value` at all (a flag, bool). */
typedef struct hl_option {
  const char *name;  /* without the dashes */
  const char *value; /* what stands for its value in the help; NULL for a flag */
  const char *group; /* heading in the help; NULL = the one before */
  const char *help;  /* one clause; NULL with a table: the field's */
  size_t offset;     /* in the verb's arguments: of the member, with a table of the settings */
  const hl_field_table *(*table)(void); /* the field is called `name`, with _ for - */
  hl_status (*parse)(hl_ctx *ctx, const char *text, void *member);
} hl_option;

typedef enum hl_operand_count {
  HL_OPERAND_NEEDED,
  HL_OPERAND_OPTIONAL, /* after the needed ones */
  HL_OPERAND_MANY      /* the last: any number, none included; the verb says what it needs */
} hl_operand_count;

/* The words of an HL_OPERAND_MANY, in their order. */
typedef struct hl_words {
  int n;
  const char **word; /* released by hl_options_release */
} hl_words;

typedef struct hl_operand {
  const char *name;
  const char *help;
  size_t offset; /* const char *, NULL where it is not given; hl_words for HL_OPERAND_MANY */
  hl_operand_count count;
} hl_operand;

typedef struct hl_command {
  const char *name;
  const char *sentence;
  const hl_operand *operands;
  int n_operands;
  const hl_option *options;
  int n_options;
  const char *notes;            /* printed after the options; may be NULL */
  const char *example;          /* a command and what it prints; may be NULL */
  size_t size;                  /* of the arguments */
  void (*defaults)(void *args); /* fills zeroed arguments; may be NULL */
  hl_status (*run)(hl_ctx *ctx, const void *args);
} hl_command;

/* Fill `args` from the words after the verb. HL_ERR_ARG says which word and what to write. */
hl_status hl_options_parse(hl_ctx *ctx, const hl_command *command, int n, char *const *words,
                           void *args);

/* Free what hl_options_parse took for the arguments, however it ended. */
void hl_options_release(const hl_command *command, void *args);

/* The settings field that an option with a table stands for; NULL where there is none. */
const hl_field *hl_options_field(const hl_option *option);

enum { HL_OPTION_TEXT_MAX = 400 };

/* What an option does, with unit, default and bounds; `args` holds the verb's defaults. */
void hl_options_describe(const hl_option *option, const void *args, char *out, size_t size);

/* A verb's arguments as they are before any word; free(). NULL without memory, and ctx says so. */
void *hl_options_defaults(hl_ctx *ctx, const hl_command *command);

/* Print what `halflight VERB --help` shows. HL_ERR_MEMORY. */
hl_status hl_options_help(hl_ctx *ctx, const hl_command *command, FILE *out);

/* Exactly n comma-separated finite numbers; HL_ERR_ARG names the option. */
hl_status hl_options_numbers(hl_ctx *ctx, const char *option, const char *text, int n, double *out);

/* The name nearest to `word` by edits; NULL when none is near. */
const char *hl_options_nearest(const char *word, const char *const *names, int n);

#endif
