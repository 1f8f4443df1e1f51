/**
 * Settings as data: one table a struct gives validation, command-line options and their help.
 */
#ifndef HALFLIGHT_SETTINGS_H
#define HALFLIGHT_SETTINGS_H

#include "halflight/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/** What a settings field holds. */
typedef enum hl_field_kind {
  HL_FIELD_DOUBLE, /* double */
  HL_FIELD_INT,    /* int */
  HL_FIELD_CHOICE  /* int, an index into `choices` */
} hl_field_kind;

/** One member of a settings struct; on the command line `a_b` is spelt `--a-b`. */
typedef struct hl_field {
  const char *name;
  hl_field_kind kind;
  size_t offset;
  double min, max;            /* inclusive; for a choice 0 and count - 1 */
  const char *unit;           /* "" where there is none */
  const char *help;           /* one clause, no full stop */
  const char *const *choices; /* NULL-terminated, only for HL_FIELD_CHOICE */
} hl_field;

/** The fields of one settings struct. */
typedef struct hl_field_table {
  const char *what; /* name of the struct, for messages */
  const hl_field *fields;
  int n;
} hl_field_table;

/**
 * Check every member against its bounds; NaN fails.
 * @return HL_OK; HL_ERR_ARG naming the field, its value and its bounds
 */
HL_API hl_status hl_fields_check(hl_ctx *ctx, const hl_field_table *table, const void *settings);

/**
 * Set one member from text, as a command line gives it. The decimal mark is that of the program's
 * LC_NUMERIC locale: a point unless the program has called setlocale.
 * @return HL_OK; HL_ERR_ARG (not a number, out of bounds, not one of the choices), struct untouched
 */
HL_API hl_status hl_field_parse(hl_ctx *ctx, const hl_field *field, const char *text,
                                void *settings);

#ifdef __cplusplus
}
#endif
#endif
