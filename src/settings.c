/* Settings as data: bounds checked and text parsed by the same table that prints the help. */
#include "halflight/settings.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static double field_value(const hl_field *field, const void *settings)
{
  const char *at = (const char *)settings + field->offset;
  double d;
  int i;
  if (field->kind == HL_FIELD_DOUBLE) {
    memcpy(&d, at, sizeof d);
    return d;
  }
  memcpy(&i, at, sizeof i);
  return i;
}

/* Written so that NaN fails. */
static int in_bounds(const hl_field *field, double value)
{
  return value >= field->min && value <= field->max;
}

static const char *space_before(const char *unit)
{
  return unit[0] ? " " : "";
}

static hl_status out_of_bounds(hl_ctx *ctx, const hl_field *field, double value)
{
  return hl_fail(ctx, HL_ERR_ARG, "%s = %.6g%s%s is outside [%.6g, %.6g]", field->name, value,
                 space_before(field->unit), field->unit, field->min, field->max);
}

hl_status hl_fields_check(hl_ctx *ctx, const hl_field_table *table, const void *settings)
{
  for (int i = 0; i < table->n; i++) {
    const double value = field_value(&table->fields[i], settings);
    if (!in_bounds(&table->fields[i], value))
      return out_of_bounds(ctx, &table->fields[i], value);
  }
  return HL_OK;
}

static hl_status parse_choice(hl_ctx *ctx, const hl_field *field, const char *text, int *out)
{
  char all[128] = "";
  for (int i = 0; field->choices[i]; i++) {
    if (strcmp(text, field->choices[i]) == 0) {
      *out = i;
      return HL_OK;
    }
    if (i > 0)
      strncat(all, ", ", sizeof all - strlen(all) - 1);
    strncat(all, field->choices[i], sizeof all - strlen(all) - 1);
  }
  return hl_fail(ctx, HL_ERR_ARG, "%s = '%.40s' is none of %s", field->name, text, all);
}

hl_status hl_field_parse(hl_ctx *ctx, const hl_field *field, const char *text, void *settings)
{
  char *at = (char *)settings + field->offset;
  int whole = 0;
  if (field->kind == HL_FIELD_CHOICE) {
    const hl_status st = parse_choice(ctx, field, text, &whole);
    if (st == HL_OK)
      memcpy(at, &whole, sizeof whole);
    return st;
  }
  char *end = NULL;
  errno = 0;
  const double value = strtod(text, &end);
  if (end == text || *end != '\0')
    return hl_fail(ctx, HL_ERR_ARG, "%s = '%.40s' is not a number; one in [%.6g, %.6g] is needed",
                   field->name, text, field->min, field->max);
  if (!in_bounds(field, value))
    return out_of_bounds(ctx, field, value);
  if (field->kind == HL_FIELD_DOUBLE) {
    memcpy(at, &value, sizeof value);
    return HL_OK;
  }
  if (value != floor(value))
    return hl_fail(ctx, HL_ERR_ARG, "%s = %.6g is not a whole number", field->name, value);
  whole = (int)value;
  memcpy(at, &whole, sizeof whole);
  return HL_OK;
}
