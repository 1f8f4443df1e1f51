/* Words of a command line into a verb's arguments, driven by its option table. */
#include "options.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { WORD_MAX = 32, NAMES_MAX = 64 };

/* Levenshtein distance; words longer than WORD_MAX are far from everything. */
static int edit_distance(const char *a, const char *b)
{
  const size_t na = strlen(a);
  const size_t nb = strlen(b);
  if (na > WORD_MAX || nb > WORD_MAX)
    return WORD_MAX;
  int row[WORD_MAX + 1];
  for (size_t j = 0; j <= nb; j++)
    row[j] = (int)j;
  for (size_t i = 1; i <= na; i++) {
    int diagonal = row[0];
    row[0] = (int)i;
    for (size_t j = 1; j <= nb; j++) {
      const int swap = diagonal + (a[i - 1] != b[j - 1]);
      diagonal = row[j];
      const int step = 1 + (row[j] < row[j - 1] ? row[j] : row[j - 1]);
      row[j] = swap < step ? swap : step;
    }
  }
  return row[nb];
}

const char *hl_options_nearest(const char *word, const char *const *names, int n)
{
  const char *best = NULL;
  int least = WORD_MAX;
  for (int i = 0; i < n; i++) {
    const int d = edit_distance(word, names[i]);
    if (d < least) {
      least = d;
      best = names[i];
    }
  }
  return best && least <= 1 + (int)strlen(best) / 3 ? best : NULL;
}

hl_status hl_options_numbers(hl_ctx *ctx, const char *option, const char *text, int n, double *out)
{
  double value[8];
  const char *at = text;
  if (n > (int)(sizeof value / sizeof *value))
    return hl_fail(ctx, HL_ERR_ARG, "--%s: %d numbers are too many", option, n);
  for (int i = 0; i < n; i++) {
    char *end = NULL;
    value[i] = strtod(at, &end);
    if (end == at || *end != (i + 1 < n ? ',' : '\0') || !isfinite(value[i]))
      return hl_fail(ctx, HL_ERR_ARG, "--%s '%.40s': %d finite numbers with commas are needed",
                     option, text, n);
    at = end + 1;
  }
  memcpy(out, value, (size_t)n * sizeof *out);
  return HL_OK;
}

const hl_field *hl_options_field(const hl_option *option)
{
  const hl_field_table *table = option->table();
  for (int i = 0; i < table->n; i++) {
    const char *a = option->name;
    const char *b = table->fields[i].name;
    while (*a && (*a == *b || (*a == '-' && *b == '_'))) {
      a++;
      b++;
    }
    if (!*a && !*b)
      return &table->fields[i];
  }
  return NULL;
}

static hl_status set_option(hl_ctx *ctx, const hl_option *option, const char *text, void *args)
{
  void *member = (char *)args + option->offset;
  if (option->table) {
    const hl_field *field = hl_options_field(option);
    if (!field)
      return hl_fail(ctx, HL_ERR_ARG, "--%s has no settings field", option->name);
    char typed[WORD_MAX + 3]; /* what the message names */
    snprintf(typed, sizeof typed, "--%s", option->name);
    hl_field as_typed = *field;
    as_typed.name = typed;
    return hl_field_parse(ctx, &as_typed, text, member);
  }
  if (option->parse)
    return option->parse(ctx, text, member);
  if (!text[0])
    return hl_fail(ctx, HL_ERR_ARG, "--%s is empty; %s is needed", option->name, option->value);
  memcpy(member, &text, sizeof text);
  return HL_OK;
}

static hl_status unknown_option(hl_ctx *ctx, const hl_command *command, const char *word)
{
  const char *names[NAMES_MAX] = {"help"};
  int n = 1;
  for (int i = 0; i < command->n_options && n < NAMES_MAX; i++)
    names[n++] = command->options[i].name;
  char name[WORD_MAX + 2];
  snprintf(name, sizeof name, "%.*s", (int)strcspn(word, "="), word);
  const char *near = hl_options_nearest(name + strspn(name, "-"), names, n);
  if (near)
    return hl_fail(ctx, HL_ERR_ARG, "unknown option '%.40s'; did you mean '--%s'?", word, near);
  return hl_fail(ctx, HL_ERR_ARG, "unknown option '%.40s'; 'halflight %s --help' lists them", word,
                 command->name);
}

/* One option at words[*i], its value after '=' or in the next word; moves *i to its last word. */
static hl_status parse_option(hl_ctx *ctx, const hl_command *command, int n, char *const *words,
                              int *i, void *args)
{
  const char *word = words[*i];
  const size_t length = strcspn(word + 2, "=");
  const char *text = word[2 + length] == '=' ? word + 2 + length + 1 : NULL;
  const hl_option *option = NULL;
  for (int k = 0; k < command->n_options && !option; k++) {
    const char *name = command->options[k].name;
    if (strlen(name) == length && strncmp(name, word + 2, length) == 0)
      option = &command->options[k];
  }
  if (!option)
    return unknown_option(ctx, command, word);
  if (!option->value) {
    const bool yes = true;
    if (text)
      return hl_fail(ctx, HL_ERR_ARG, "--%s takes no value, '%.40s' given", option->name, text);
    memcpy((char *)args + option->offset, &yes, sizeof yes);
    return HL_OK;
  }
  if (!text) {
    if (*i + 1 >= n || strncmp(words[*i + 1], "--", 2) == 0)
      return hl_fail(ctx, HL_ERR_ARG, "--%s needs a value: --%s %s", option->name, option->name,
                     option->value);
    text = words[++*i];
  }
  return set_option(ctx, option, text, args);
}

/* `most` words may come; room for all of them is taken at the first. */
static hl_status append_word(hl_ctx *ctx, const char *word, int most, void *member)
{
  hl_words words;
  memcpy(&words, member, sizeof words);
  if (!words.word)
    words.word = malloc((size_t)most * sizeof *words.word);
  if (!words.word)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for %d names", most);
  words.word[words.n++] = word;
  memcpy(member, &words, sizeof words);
  return HL_OK;
}

static hl_status set_operand(hl_ctx *ctx, const hl_command *command, int k, const char *word,
                             int most, void *args)
{
  const int last = command->n_operands - 1;
  const bool many = last >= 0 && command->operands[last].count == HL_OPERAND_MANY;
  if (k > last && !many)
    return hl_fail(ctx, HL_ERR_ARG,
                   "'%.80s' is one word too many; 'halflight %s --help' shows the usage", word,
                   command->name);
  const hl_operand *operand = &command->operands[k < last ? k : last];
  void *member = (char *)args + operand->offset;
  if (!word[0])
    return hl_fail(ctx, HL_ERR_ARG, "%s is empty; a file name is needed", operand->name);
  if (operand->count == HL_OPERAND_MANY)
    return append_word(ctx, word, most, member);
  memcpy(member, &word, sizeof word);
  return HL_OK;
}

void hl_options_release(const hl_command *command, void *args)
{
  for (int i = 0; i < command->n_operands; i++)
    if (command->operands[i].count == HL_OPERAND_MANY) {
      hl_words words;
      memcpy(&words, (char *)args + command->operands[i].offset, sizeof words);
      free(words.word);
    }
}

hl_status hl_options_parse(hl_ctx *ctx, const hl_command *command, int n, char *const *words,
                           void *args)
{
  int operands = 0;
  bool only_operands = false;
  for (int i = 0; i < n; i++) {
    hl_status st = HL_OK;
    if (!only_operands && strcmp(words[i], "--") == 0)
      only_operands = true;
    else if (!only_operands && strncmp(words[i], "--", 2) == 0)
      st = parse_option(ctx, command, n, words, &i, args);
    else if (!only_operands && words[i][0] == '-' && words[i][1])
      st = unknown_option(ctx, command, words[i]);
    else
      st = set_operand(ctx, command, operands++, words[i], n, args);
    if (st != HL_OK)
      return st;
  }
  if (operands < command->n_operands && command->operands[operands].count == HL_OPERAND_NEEDED)
    return hl_fail(ctx, HL_ERR_ARG, "%s is missing: halflight %s %s ...",
                   command->operands[operands].name, command->name,
                   command->operands[operands].name);
  return HL_OK;
}
