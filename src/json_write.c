/* JSON out: jansson holds the document, this file lays it out in lines. */
#include "json_write.h"

#include <errno.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "file_write.h"

enum { LINE_MAX_CHARS = 100, REAL_DIGITS = 17, PASSED_ON = 1 << 16 };

typedef struct text_buffer {
  char *bytes;
  size_t n, capacity;
  bool failed; /* and stays so: jansson does not pass on a failure to write a member's name */
  const hl_json_long *list; /* NULL: none */
  int file;                 /* where each element goes as it is done; -1: all is kept */
  int error;                /* of the file */
} text_buffer;

static int append(const char *bytes, size_t n, void *user)
{
  text_buffer *t = user;
  if (t->failed)
    return -1;
  if (t->n + n + 1 > t->capacity) {
    const size_t capacity = 2 * (t->capacity + n + 1);
    char *grown = capacity > t->n ? realloc(t->bytes, capacity) : NULL;
    t->failed = !grown;
    if (t->failed)
      return -1;
    t->bytes = grown;
    t->capacity = capacity;
  }
  memcpy(t->bytes + t->n, bytes, n);
  t->n += n;
  t->bytes[t->n] = '\0';
  return 0;
}

static int append_line(text_buffer *out, int indent)
{
  int bad = append("\n", 1, out);
  for (int i = 0; i < indent && !bad; i++)
    bad = append(" ", 1, out);
  return bad;
}

static bool is_plain_list(const json_t *value)
{
  if (!json_is_array(value))
    return false;
  for (size_t i = 0; i < json_array_size(value); i++)
    if (!json_is_number(json_array_get(value, i)))
      return false;
  return true;
}

static int append_value(text_buffer *out, json_t *value, int indent);

/* To the file, once there is enough of it. */
static int pass_on(text_buffer *out, size_t enough)
{
  if (out->file < 0 || out->n < enough)
    return 0;
  out->error = hl_file_put(out->file, out->bytes, out->n);
  out->n = 0;
  return out->error;
}

static int append_long(text_buffer *out, int indent)
{
  const hl_json_long *list = out->list;
  int bad = append("[", 1, out);
  for (int i = 0; i < list->n && !bad; i++) {
    json_t *one = list->element(list->user, i);
    bad = !one || (i > 0 && append(",", 1, out)) || append_line(out, indent + 1) ||
          append_value(out, one, indent + 1) || pass_on(out, PASSED_ON);
    json_decref(one);
  }
  return bad || (list->n > 0 && append_line(out, indent)) || append("]", 1, out);
}

static int append_object(text_buffer *out, json_t *object, int indent)
{
  const char *key;
  json_t *item;
  int bad = append("{", 1, out);
  bool first = true;
  json_object_foreach(object, key, item)
  {
    json_t *name = json_string(key);
    bad = bad || !name || (!first && append(",", 1, out)) || append_line(out, indent + 1) ||
          json_dump_callback(name, append, out, JSON_ENCODE_ANY) || append(": ", 2, out) ||
          (indent == 0 && out->list && strcmp(key, out->list->member) == 0
               ? append_long(out, indent + 1)
               : append_value(out, item, indent + 1));
    json_decref(name);
    first = false;
  }
  return bad || (!first && append_line(out, indent)) || append("}", 1, out);
}

static int append_array(text_buffer *out, json_t *array, int indent)
{
  int bad = append("[", 1, out);
  for (size_t i = 0; i < json_array_size(array) && !bad; i++)
    bad = (i > 0 && append(",", 1, out)) || append_line(out, indent + 1) ||
          append_value(out, json_array_get(array, i), indent + 1);
  return bad || append_line(out, indent) || append("]", 1, out);
}

/* On one line where it fits or is a list of numbers, else a member a line. */
static int append_value(text_buffer *out, json_t *value, int indent)
{
  const size_t start = out->n;
  if (json_dump_callback(value, append, out, JSON_ENCODE_ANY | JSON_REAL_PRECISION(REAL_DIGITS)))
    return -1;
  const bool fits = out->n - start + (size_t)indent <= LINE_MAX_CHARS;
  if (is_plain_list(value) || !(json_is_array(value) || json_is_object(value)) ||
      (fits && indent > 0) || (json_is_array(value) && json_array_size(value) == 0))
    return 0;
  out->n = start;
  return json_is_array(value) ? append_array(out, value, indent)
                              : append_object(out, value, indent);
}

hl_status hl_json_text(hl_ctx *ctx, json_t *document, char **out)
{
  return hl_json_long_text(ctx, document, NULL, out);
}

hl_status hl_json_long_text(hl_ctx *ctx, json_t *document, const hl_json_long *list, char **out)
{
  text_buffer text = {.list = list, .file = -1};
  const bool good = document && append_value(&text, document, 0) == 0 &&
                    append("\n", 1, &text) == 0 && !text.failed;
  json_decref(document);
  if (!good) {
    free(text.bytes);
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for the JSON document");
  }
  *out = text.bytes;
  return HL_OK;
}

typedef struct streamed {
  json_t *document;
  const hl_json_long *list;
} streamed;

static int produce(void *user, int file)
{
  const streamed *s = user;
  text_buffer text = {.list = s->list, .file = file};
  const bool good = append_value(&text, s->document, 0) == 0 && append("\n", 1, &text) == 0 &&
                    !text.failed && pass_on(&text, 0) == 0;
  free(text.bytes);
  return good ? 0 : text.error != 0 ? text.error : ENOMEM;
}

hl_status hl_json_long_write(hl_ctx *ctx, json_t *document, const hl_json_long *list,
                             const char *path)
{
  streamed s = {document, list};
  const hl_status st = document ? hl_file_write_by(ctx, path, produce, &s)
                                : hl_fail(ctx, HL_ERR_MEMORY, "no memory for the JSON document");
  json_decref(document);
  return st;
}

json_t *hl_json_real(double value)
{
  return isfinite(value) ? json_real(value) : json_null();
}

json_t *hl_json_reals(const double *values, int n)
{
  json_t *list = json_array();
  for (int i = 0; i < n; i++) {
    if (json_array_append_new(list, hl_json_real(values[i])) != 0) {
      json_decref(list);
      return NULL;
    }
  }
  return list;
}

bool hl_json_set(json_t *object, const char *key, json_t *value)
{
  return json_object_set_new(object, key, value) == 0;
}

json_t *hl_json_kept(json_t *value, bool good)
{
  if (good)
    return value;
  json_decref(value);
  return NULL;
}
