/*
 * The lights of a rig as `.lp` of RTI tools, and back: the count, then a line `name x y z` a light;
 * x right, y up, z towards the camera. What stands before the last three words of a line is the
 * name, blanks in it and all, though other readers part a line at each of them.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "halflight/export.h"
#include "lights_formats.h"
#include "number_text.h"

enum { DIGITS = 12, SHOWN_MAX = 40, WHERE_MAX = 32 };

static const char blanks[] = " \t\v\f\r";

/* ---------------------------------------------------------------- reading */

typedef struct span {
  const char *at;
  size_t n;
} span;

typedef struct reader {
  hl_json_source source;
  span rest;
  long line;
} reader;

/* Words may hold anything: only printable ones go into a message. */
static const char *shown(span w, char text[SHOWN_MAX])
{
  snprintf(text, SHOWN_MAX, "%.*s", w.n < SHOWN_MAX ? (int)w.n : SHOWN_MAX - 1, w.at);
  for (const char *c = text; *c; c++)
    if ((unsigned char)*c < ' ' || *c == 0x7f)
      return "?";
  return text;
}

static bool blank(char c)
{
  return c && strchr(blanks, c);
}

static span trimmed(span s)
{
  while (s.n > 0 && blank(s.at[0])) {
    s.at++;
    s.n--;
  }
  while (s.n > 0 && blank(s.at[s.n - 1]))
    s.n--;
  return s;
}

/* The next line that holds something; false at the end. */
static bool next_line(reader *r, span *out)
{
  while (r->rest.n > 0) {
    const char *end = memchr(r->rest.at, '\n', r->rest.n);
    const span line = {r->rest.at, end ? (size_t)(end - r->rest.at) : r->rest.n};
    const size_t used = line.n + (end ? 1 : 0);
    r->rest = (span){r->rest.at + used, r->rest.n - used};
    r->line++;
    *out = trimmed(line);
    if (out->n > 0)
      return true;
  }
  return false;
}

/* Take the last word off the line. */
static span last_word(span *line)
{
  size_t n = line->n;
  while (n > 0 && !blank(line->at[n - 1]))
    n--;
  const span word = {line->at + n, line->n - n};
  *line = trimmed((span){line->at, n});
  return word;
}

static hl_status read_count(reader *r, size_t *out)
{
  span line = {"", 0};
  char text[SHOWN_MAX];
  double count = 0;
  if (!next_line(r, &line) || !hl_number_parse(line.at, line.n, &count) || count < 1 ||
      count > HL_LIGHTS_FILE_MAX || count != (double)(size_t)count)
    return hl_fail(r->source.ctx, HL_ERR_FORMAT,
                   "%s: line %ld: '%s' is no count of lights; a whole number in [1, %d] is needed",
                   r->source.path, r->line, shown(line, text), HL_LIGHTS_FILE_MAX);
  *out = (size_t)count;
  return HL_OK;
}

static hl_status read_row(reader *r, span line, hl_rig_light *out)
{
  static const char axes[] = "xyz";
  char text[SHOWN_MAX], where[WHERE_MAX];
  const span all = line;
  double d[3] = {0};
  for (int k = 2; k >= 0; k--) {
    const span word = last_word(&line);
    if (line.n == 0)
      return hl_fail(r->source.ctx, HL_ERR_FORMAT,
                     "%s: line %ld: '%s'; a file's name and x y z are needed", r->source.path,
                     r->line, shown(all, text));
    if (!hl_number_parse(word.at, word.n, &d[k]))
      return hl_fail(r->source.ctx, HL_ERR_FORMAT,
                     "%s: line %ld: %c = '%s' is no number; digits with a decimal point are needed",
                     r->source.path, r->line, axes[k], shown(word, text));
  }
  if (memchr(line.at, '\0', line.n))
    return hl_fail(r->source.ctx, HL_ERR_FORMAT,
                   "%s: line %ld: a zero byte in the name; text is needed", r->source.path,
                   r->line);
  out->file = strndup(line.at, line.n);
  out->label = strdup("");
  if (!out->file || !out->label)
    return hl_fail(r->source.ctx, HL_ERR_MEMORY, "%s: no memory for the lights", r->source.path);
  snprintf(where, sizeof where, "line %ld", r->line);
  return hl_lights_set(r->source, where, d, -1, out);
}

hl_status hl_lights_lp_parse(hl_json_source source, const char *bytes, size_t n, hl_lights *out)
{
  reader r = {source, {bytes, n}, 0};
  size_t count = 0;
  span line;
  hl_status st = read_count(&r, &count);
  if (st == HL_OK)
    st = hl_lights_room(source, count, out);
  for (size_t i = 0; i < count && st == HL_OK; i++) {
    if (!next_line(&r, &line))
      return hl_fail(source.ctx, HL_ERR_FORMAT,
                     "%s: line %ld: the file ends after %zu lights; its first line says %zu",
                     source.path, r.line, i, count);
    out->n = (int)i + 1; /* what it has is released with the rest */
    out->light[i].frame = (int)i;
    st = read_row(&r, line, &out->light[i]);
  }
  if (st == HL_OK && next_line(&r, &line))
    return hl_fail(source.ctx, HL_ERR_FORMAT,
                   "%s: line %ld: a line after the last of the %zu lights that line 1 says",
                   source.path, r.line, count);
  return st;
}

/* ---------------------------------------------------------------- writing */

/* Readers part a line at its spaces, and want a name. */
static void put_name(hl_text *out, const char *file)
{
  if (file[0] == '\0')
    hl_text_add(out, "_");
  for (const char *c = file; *c; c++) {
    const char one[2] = {strchr(" \t\r\n\v\f", *c) ? '_' : *c, '\0'};
    hl_text_add(out, one);
  }
}

void hl_lights_lp_put(const hl_lights *lights, hl_text *out)
{
  int found = 0;
  for (int i = 0; i < lights->n; i++)
    found += lights->light[i].found;
  hl_text_number(out, found, 10);
  hl_text_add(out, "\n");
  for (int i = 0; i < lights->n; i++) {
    const hl_rig_light *light = &lights->light[i];
    if (!light->found)
      continue;
    const double *d = light->direction, lp[3] = {d[0], 0 - d[1], 0 - d[2]};
    put_name(out, light->file);
    for (int k = 0; k < 3; k++) {
      hl_text_add(out, " ");
      hl_text_number(out, lp[k], DIGITS);
    }
    hl_text_add(out, "\n");
  }
}

hl_status hl_lights_lp_write(hl_ctx *ctx, const char *path, const hl_lights *lights)
{
  char *text = NULL;
  hl_status st = hl_lights_text(ctx, lights, HL_LIGHTS_LP, &text);
  if (st == HL_OK)
    st = hl_file_write(ctx, path, text, strlen(text));
  free(text);
  return st;
}
