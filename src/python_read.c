/* Recursive descent, one function a rule; no deeper than DEPTH_MAX. */
#include "python_read.h"

#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "number_json.h"

enum { DEPTH_MAX = 16, SHOWN_MAX = 24 };

typedef struct reader {
  hl_json_source source;
  const char *at, *end;
  int line, depth;
} reader;

/* `needed` is what should stand where the reader stands. */
static hl_status refuse(const reader *r, const char *needed)
{
  char found[SHOWN_MAX + 4] = "the end of the file";
  const size_t left = (size_t)(r->end - r->at);
  size_t n = 0;
  while (n < left && n < SHOWN_MAX && r->at[n] > ' ' && r->at[n] < 0x7f)
    n++;
  if (left > 0)
    snprintf(found, sizeof found, "'%.*s'", (int)(n > 0 ? n : 0), r->at);
  return hl_fail(r->source.ctx, HL_ERR_FORMAT,
                 "%s: line %d: no Python dictionary: %s is needed, %s found", r->source.path,
                 r->line, needed, found);
}

static hl_status no_memory(const reader *r)
{
  return hl_fail(r->source.ctx, HL_ERR_MEMORY, "%s: no memory for its values", r->source.path);
}

/* jansson refused a text of the file, `errno` 0 before. */
static hl_status no_text(const reader *r, const char *what)
{
  if (errno == ENOMEM)
    return no_memory(r);
  return hl_fail(r->source.ctx, HL_ERR_FORMAT, "%s: line %d: a %s that is no UTF-8", r->source.path,
                 r->line, what);
}

static void skip_blanks(reader *r)
{
  for (; r->at < r->end; r->at++) {
    if (*r->at == '#')
      while (r->at + 1 < r->end && r->at[1] != '\n')
        r->at++;
    else if (*r->at == '\n')
      r->line++;
    else if (!strchr(" \t\r\f", *r->at) || *r->at == '\0')
      break;
  }
}

static bool is_next(reader *r, char c)
{
  skip_blanks(r);
  if (r->at >= r->end || *r->at != c)
    return false;
  r->at++;
  return true;
}

static bool is_text(const reader *r)
{
  const char *c = r->at;
  if (c < r->end && strchr("bBrRuU", *c) && *c)
    c++;
  return c < r->end && (*c == '\'' || *c == '"');
}

/* A text of one line; \\, \' and \" lose their backslash, other escapes stay as they are written. */
static hl_status read_text(reader *r, char **out)
{
  if (!is_text(r))
    return refuse(r, "a text in quotes");
  reader start = *r;
  r->at += *r->at != '\'' && *r->at != '"';
  const char quote = *r->at++;
  char *text = malloc((size_t)(r->end - r->at) + 1);
  size_t n = 0;
  if (!text)
    return no_memory(r);
  for (; r->at < r->end && *r->at != quote && *r->at != '\n' && *r->at != '\0'; r->at++) {
    if (*r->at == '\\' && r->end - r->at > 1 && strchr("\\'\"", r->at[1]) && r->at[1])
      r->at++;
    text[n++] = *r->at;
  }
  text[n] = '\0';
  if (r->at >= r->end || *r->at != quote) {
    free(text);
    return refuse(&start, "a text that ends on its line");
  }
  r->at++;
  *out = text;
  return HL_OK;
}

static hl_status read_value(reader *r, json_t **out);

static hl_status read_member(reader *r, json_t *object)
{
  char *key = NULL;
  json_t *value = NULL;
  skip_blanks(r);
  hl_status st = read_text(r, &key);
  if (st == HL_OK && json_object_get(object, key))
    st = hl_fail(r->source.ctx, HL_ERR_FORMAT, "%s: line %d: %.40s is given twice", r->source.path,
                 r->line, key);
  if (st == HL_OK && !is_next(r, ':'))
    st = refuse(r, "':' after a key");
  if (st == HL_OK)
    st = read_value(r, &value);
  errno = 0;
  if (st == HL_OK && json_object_set_new(object, key, value) != 0)
    st = no_text(r, "key");
  free(key);
  return st;
}

static hl_status read_item(reader *r, json_t *list)
{
  json_t *value = NULL;
  const hl_status st = read_value(r, &value);
  return st == HL_OK && json_array_append_new(list, value) != 0 ? no_memory(r) : st;
}

/* Members of a dictionary or items of a list up to `close`; takes over `container`. */
static hl_status read_all(reader *r, char close, json_t *container, json_t **out)
{
  const bool object = json_is_object(container);
  hl_status st = container ? HL_OK : no_memory(r);
  if (st == HL_OK && r->depth == DEPTH_MAX)
    st = hl_fail(r->source.ctx, HL_ERR_FORMAT, "%s: line %d: nested too deep for a camera file",
                 r->source.path, r->line);
  r->depth++;
  bool more = true;
  while (st == HL_OK && !is_next(r, close)) {
    if (!more)
      st = refuse(r, object ? "',' or '}'" : close == ']' ? "',' or ']'" : "',' or ')'");
    else
      st = object ? read_member(r, container) : read_item(r, container);
    more = st == HL_OK && is_next(r, ',');
  }
  r->depth--;
  if (st != HL_OK)
    json_decref(container);
  else
    *out = container;
  return st;
}

/* A number or one of the three words. */
static hl_status read_word(reader *r, json_t **out)
{
  size_t n = 0;
  while (r->at + n < r->end && r->at[n] && !strchr(" \t\r\n\f,:#'\"()[]{}", r->at[n]))
    n++;
  json_t *value = NULL;
  errno = 0;
  if (n == 4 && memcmp(r->at, "None", n) == 0)
    value = json_null();
  else if (n == 4 && memcmp(r->at, "True", n) == 0)
    value = json_true();
  else if (n == 5 && memcmp(r->at, "False", n) == 0)
    value = json_false();
  else
    value = hl_number_json(r->at, n);
  if (!value && errno == ENOMEM)
    return no_memory(r);
  if (!value)
    return refuse(r, "a number, a text, a list or a dictionary");
  r->at += n;
  *out = value;
  return HL_OK;
}

static hl_status read_value(reader *r, json_t **out)
{
  if (is_next(r, '{'))
    return read_all(r, '}', json_object(), out);
  if (is_next(r, '['))
    return read_all(r, ']', json_array(), out);
  if (is_next(r, '('))
    return read_all(r, ')', json_array(), out);
  if (!is_text(r))
    return read_word(r, out);
  char *text = NULL;
  const hl_status st = read_text(r, &text);
  if (st != HL_OK)
    return st;
  errno = 0;
  *out = json_string(text);
  free(text);
  return *out ? HL_OK : no_text(r, "text");
}

hl_status hl_python_parse(hl_json_source source, const char *bytes, size_t n, json_t **out)
{
  reader r = {.source = source, .at = bytes, .end = bytes + n, .line = 1};
  json_t *root = NULL;
  hl_status st = read_value(&r, &root);
  skip_blanks(&r);
  if (st == HL_OK && r.at < r.end) {
    json_decref(root);
    st = refuse(&r, "the end of the file");
  }
  if (st == HL_OK)
    *out = root;
  return st;
}
