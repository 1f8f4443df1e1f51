/*
 * A versioned JSON document, member by member.
 *
 * Every refusal reads `FILE: MEMBER = VALUE ...; what would be accepted`, because the person who
 * sees it has the file open in an editor. The bounds are tested so that a value that is not a
 * number fails; JSON itself has none, and the texts NaN and Infinity that some writers emit are
 * refused by name.
 */
#include "json_read.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "file_read.h"

enum { SHOWN_MAX = 40, FORMATS_TEXT = 128 };

/* The place of a parse error, as "line L", and the word there. */
static hl_status not_json(hl_json_source source, const char *text, size_t n,
                          const json_error_t *error)
{
  static const char *const words[] = {"NaN", "nan", "-Infinity", "Infinity", "inf"};
  const size_t at = error->position > 0 ? (size_t)error->position : 0;
  for (size_t i = 0; i < sizeof words / sizeof words[0]; i++) {
    const size_t length = strlen(words[i]);
    for (size_t back = 0; back <= length && back <= at; back++) {
      const size_t start = at - back;
      if (start + length <= n && memcmp(text + start, words[i], length) == 0)
        return hl_fail(source.ctx, HL_ERR_FORMAT,
                       "%s: line %d: %s is not JSON; a finite number is needed", source.path,
                       error->line, words[i]);
    }
  }
  return hl_fail(source.ctx, HL_ERR_FORMAT, "%s: line %d: not JSON: %s", source.path, error->line,
                 error->text);
}

/* `needed`: "'a'" or "'a' or 'b'". */
static void name_formats(const char *const *formats, int n, char needed[FORMATS_TEXT])
{
  size_t at = 0;
  needed[0] = '\0';
  for (int i = 0; i < n && at < FORMATS_TEXT; i++)
    at +=
        (size_t)snprintf(needed + at, FORMATS_TEXT - at, "%s'%s'", i > 0 ? " or " : "", formats[i]);
}

static hl_status check_header(hl_json_source source, const json_t *root, const char *const *formats,
                              int n, int newest, int *which)
{
  char needed[FORMATS_TEXT];
  name_formats(formats, n, needed);
  if (!json_is_object(root))
    return hl_fail(source.ctx, HL_ERR_FORMAT, "%s: not a JSON object; one of format %s is needed",
                   source.path, needed);
  const char *found = "";
  hl_status st = hl_json_string(source, root, "format", &found);
  if (st != HL_OK)
    return st;
  int at = 0;
  while (at < n && strcmp(found, formats[at]) != 0)
    at++;
  if (at == n)
    return hl_fail(source.ctx, HL_ERR_FORMAT, "%s: format = '%.*s'; %s is needed", source.path,
                   SHOWN_MAX, found, needed);
  *which = at;
  const json_t *version = json_object_get(root, "version");
  if (json_is_integer(version) && json_integer_value(version) > newest)
    return hl_fail(source.ctx, HL_ERR_FORMAT,
                   "%s: version = %lld is newer than this program; up to %d is accepted",
                   source.path, (long long)json_integer_value(version), newest);
  int ignored = 0;
  return hl_json_int(source, root, "version", 1, newest, &ignored);
}

hl_status hl_json_header(hl_json_source source, const json_t *root, const char *format, int newest)
{
  int which = 0;
  return check_header(source, root, &format, 1, newest, &which);
}

hl_status hl_json_parse(hl_json_source source, const char *bytes, size_t n, json_t **out)
{
  json_error_t error;
  errno = 0;
  json_t *root = json_loadb(bytes, n, JSON_REJECT_DUPLICATES | JSON_DECODE_ANY, &error);
  /* jansson calls a text that it has no memory for malformed */
  if (!root && errno == ENOMEM)
    return hl_fail(source.ctx, HL_ERR_MEMORY, "%s: no memory for the document", source.path);
  if (!root)
    return not_json(source, bytes, n, &error);
  *out = root;
  return HL_OK;
}

hl_status hl_json_open(hl_json_source source, const char *format, int newest, json_t **out)
{
  int which = 0;
  return hl_json_open_one_of(source, &format, 1, newest, &which, out);
}

hl_status hl_json_open_one_of(hl_json_source source, const char *const *formats, int n_formats,
                              int newest, int *which, json_t **out)
{
  unsigned char *bytes = NULL;
  size_t n = 0;
  json_t *root = NULL;
  hl_status st = hl_file_read(source.ctx, source.path, HL_JSON_BYTES_MAX, &bytes, &n);
  if (st != HL_OK)
    return st;
  st = hl_json_parse(source, (const char *)bytes, n, &root);
  free(bytes);
  if (st == HL_OK)
    st = check_header(source, root, formats, n_formats, newest, which);
  if (st != HL_OK) {
    json_decref(root);
    return st;
  }
  *out = root;
  return HL_OK;
}

bool hl_json_has(const json_t *object, const char *member)
{
  const json_t *value = json_object_get(object, member);
  return value && !json_is_null(value);
}

/* What stands there, short enough for a message. */
static void show(const json_t *value, char *text, size_t room)
{
  char *dump =
      value ? json_dumps(value, JSON_ENCODE_ANY | JSON_COMPACT | JSON_REAL_PRECISION(9)) : NULL;
  if (!dump)
    snprintf(text, room, "missing");
  else if (strlen(dump) > SHOWN_MAX)
    snprintf(text, room, "%.*s...", SHOWN_MAX, dump);
  else
    snprintf(text, room, "%s", dump);
  free(dump);
}

/* `name` is the member, or "member[i]" inside an array. */
static hl_status refuse(hl_json_source source, const char *name, const json_t *value,
                        const char *needed)
{
  if (!value)
    return hl_fail(source.ctx, HL_ERR_FORMAT, "%s: %s is missing; %s is needed", source.path, name,
                   needed);
  char text[SHOWN_MAX + 8];
  show(value, text, sizeof text);
  return hl_fail(source.ctx, HL_ERR_FORMAT, "%s: %s = %s; %s is needed", source.path, name, text,
                 needed);
}

static hl_status number_value(hl_json_source source, const char *name, const json_t *value,
                              double min, double max, double *out)
{
  const double number = json_is_number(value) ? json_number_value(value) : NAN;
  if (!(number >= min && number <= max && isfinite(number))) {
    char needed[96];
    if (min <= -1e300 && max >= 1e300)
      snprintf(needed, sizeof needed, "a finite number");
    else
      snprintf(needed, sizeof needed, "a number in [%.6g, %.6g]", min, max);
    return refuse(source, name, value, needed);
  }
  *out = number;
  return HL_OK;
}

hl_status hl_json_number(hl_json_source source, const json_t *object, const char *member,
                         double min, double max, double *out)
{
  return number_value(source, member, json_object_get(object, member), min, max, out);
}

hl_status hl_json_int(hl_json_source source, const json_t *object, const char *member, int min,
                      int max, int *out)
{
  const json_t *value = json_object_get(object, member);
  const double number = json_is_number(value) ? json_number_value(value) : NAN;
  if (!(number >= min && number <= max && number == floor(number))) {
    char needed[96];
    snprintf(needed, sizeof needed, "a whole number in [%d, %d]", min, max);
    return refuse(source, member, value, needed);
  }
  *out = (int)number;
  return HL_OK;
}

hl_status hl_json_string(hl_json_source source, const json_t *object, const char *member,
                         const char **out)
{
  const json_t *value = json_object_get(object, member);
  const char *text = json_string_value(value);
  if (!text)
    return refuse(source, member, value, "a text");
  *out = text;
  return HL_OK;
}

static hl_status array_values(hl_json_source source, const char *name, const json_t *value, int n,
                              double *out)
{
  char needed[64];
  snprintf(needed, sizeof needed, "an array of %d numbers", n);
  if (!json_is_array(value) || json_array_size(value) != (size_t)n)
    return refuse(source, name, value, needed);
  for (int i = 0; i < n; i++) {
    char element[96];
    snprintf(element, sizeof element, "%s[%d]", name, i);
    const hl_status st = number_value(source, element, json_array_get(value, (size_t)i), -HUGE_VAL,
                                      HUGE_VAL, &out[i]);
    if (st != HL_OK)
      return st;
  }
  return HL_OK;
}

hl_status hl_json_numbers(hl_json_source source, const json_t *object, const char *member, int n,
                          double *out)
{
  return array_values(source, member, json_object_get(object, member), n, out);
}

hl_status hl_json_matrix(hl_json_source source, const json_t *object, const char *member, int rows,
                         int columns, double *out)
{
  const json_t *value = json_object_get(object, member);
  char needed[64];
  snprintf(needed, sizeof needed, "%d rows of %d numbers", rows, columns);
  if (!json_is_array(value) || json_array_size(value) != (size_t)rows)
    return refuse(source, member, value, needed);
  for (int i = 0; i < rows; i++) {
    char row[64];
    snprintf(row, sizeof row, "%s[%d]", member, i);
    const hl_status st = array_values(source, row, json_array_get(value, (size_t)i), columns,
                                      out + (size_t)i * (size_t)columns);
    if (st != HL_OK)
      return st;
  }
  return HL_OK;
}

hl_status hl_json_blame(hl_json_source source, hl_status status, const char *msg)
{
  return hl_fail(source.ctx, status, "%s: %s", source.path, msg);
}
