/*
 * SAMPLES.csv: a table of normals and radiance, a row a sample.
 *
 * Read line by line into arrays that grow by doubling, so that a million rows need no more memory
 * than their numbers. Most numbers have at most 15 digits and a small exponent: digits and power of
 * ten are then exact doubles, and one division rounds as strtod does (Clinger 1990, the fast path);
 * strtod itself, which follows the program's locale, is for the others.
 */
#include <errno.h>
#include <locale.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "halflight/samples.h"
#include "halflight/vec3.h"

enum { COLUMNS = 10, FIELDS_MAX = 64, NUMBER_MAX = 64, SAMPLES_MAX = 1 << 28 };
enum { NX, NY, NZ, VALUE, RED, GREEN, BLUE, VX, VY, VZ };
static const char *const column_names[COLUMNS] = {"nx", "ny", "nz", "value", "r",
                                                  "g",  "b",  "vx", "vy",    "vz"};
static const double unit_tolerance = 0.01;

typedef struct table {
  hl_ctx *ctx;
  const char *path;
  long line;
  int fields;      /* of the header */
  int at[COLUMNS]; /* field of each column; -1: absent */
  int room;        /* samples the arrays hold */
  hl_samples samples;
} table;

static hl_status bad_row(const table *t, const char *what, double value, const char *needed)
{
  return hl_fail(t->ctx, HL_ERR_FORMAT, "%s: line %ld: %s = %.9g; %s is needed", t->path, t->line,
                 what, value, needed);
}

/* ---- numbers ---- */

/* By strtod, whatever the locale's decimal mark. */
static double slow_number(const char *text, size_t length, bool *good)
{
  char copy[NUMBER_MAX + 8];
  const char *mark = localeconv()->decimal_point;
  size_t n = 0;
  *good = length > 0 && length <= NUMBER_MAX && strlen(mark) < 8 &&
          strspn(text, "0123456789+-.eEnaNAifIFtyTY") >= length;
  for (size_t i = 0; i < length && *good; i++) {
    if (text[i] != '.') {
      copy[n++] = text[i];
      continue;
    }
    memcpy(copy + n, mark, strlen(mark));
    n += strlen(mark);
    *good = !memchr(text + i + 1, '.', length - i - 1);
  }
  copy[*good ? n : 0] = '\0';
  char *end = copy;
  const double value = strtod(copy, &end);
  *good = *good && end != copy && *end == '\0';
  return value;
}

static double number(const char *text, size_t length, bool *good)
{
  static const double ten[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                               1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                               1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
  const char *c = text;
  const char *end = text + length;
  int64_t digits = 0;
  int n = 0, places = 0;
  const bool negative = c < end && *c == '-';
  c += negative;
  for (; c < end && *c >= '0' && *c <= '9' && n < 16; c++, n++)
    digits = 10 * digits + (*c - '0');
  if (c < end && *c == '.')
    for (c++; c < end && *c >= '0' && *c <= '9' && n < 16; c++, n++, places++)
      digits = 10 * digits + (*c - '0');
  if (c != end || n == 0 || n > 15 || places > 22)
    return slow_number(text, length, good);
  *good = true;
  const double value = (double)digits / ten[places];
  return negative ? -value : value;
}

/* ---- header ---- */

static char *trimmed(char *text)
{
  text += strspn(text, " \t\"");
  size_t n = strlen(text);
  while (n > 0 && strchr(" \t\r\n\"", text[n - 1]))
    text[--n] = '\0';
  return text;
}

static hl_status read_header(table *t, char *line)
{
  for (int k = 0; k < COLUMNS; k++)
    t->at[k] = -1;
  for (char *next = line; next; t->fields++) {
    char *name = next;
    next = strchr(name, ',');
    if (next)
      *next++ = '\0';
    name = trimmed(name);
    if (t->fields >= FIELDS_MAX)
      return hl_fail(t->ctx, HL_ERR_FORMAT, "%s: line %ld: over %d columns", t->path, t->line,
                     FIELDS_MAX);
    for (int k = 0; k < COLUMNS; k++)
      if (strcasecmp(name, column_names[k]) == 0) {
        if (t->at[k] >= 0)
          return hl_fail(t->ctx, HL_ERR_FORMAT, "%s: line %ld: column %s comes twice", t->path,
                         t->line, column_names[k]);
        t->at[k] = t->fields;
      }
  }
  return HL_OK;
}

static hl_status check_header(table *t)
{
  const bool colour = t->at[RED] >= 0 || t->at[GREEN] >= 0 || t->at[BLUE] >= 0;
  const bool views = t->at[VX] >= 0 || t->at[VY] >= 0 || t->at[VZ] >= 0;
  const int first = colour ? RED : VALUE, last = colour ? BLUE : VALUE;
  if (colour && t->at[VALUE] >= 0)
    return hl_fail(t->ctx, HL_ERR_FORMAT,
                   "%s: line %ld: columns value and r, g, b; one of the two is needed", t->path,
                   t->line);
  for (int k = 0; k < COLUMNS; k++)
    if (t->at[k] < 0 && (k <= NZ || (k >= first && k <= last) || (views && k >= VX)))
      return hl_fail(t->ctx, HL_ERR_FORMAT,
                     "%s: line %ld: no column %s; a header nx,ny,nz,value or nx,ny,nz,r,g,b, with "
                     "vx,vy,vz or without, is needed",
                     t->path, t->line, column_names[k]);
  t->samples.channels = colour ? 3 : 1;
  return HL_OK;
}

/* ---- rows ---- */

static bool grow_one(double **array, size_t count)
{
  double *more = realloc(*array, (count > 0 ? count : 1) * sizeof **array);
  if (more)
    *array = more;
  return more != NULL;
}

static hl_status resize(table *t, int room)
{
  hl_samples *s = &t->samples;
  bool good = grow_one(&s->normal, 3 * (size_t)room) &&
              (t->at[VX] < 0 || grow_one(&s->view, 3 * (size_t)room));
  for (int c = 0; c < s->channels && good; c++)
    good = grow_one(&s->value[c], (size_t)room);
  if (!good)
    return hl_fail(t->ctx, HL_ERR_MEMORY, "%s: no memory for %d samples", t->path, room);
  t->room = room;
  return HL_OK;
}

static hl_status grow(table *t)
{
  if (t->samples.n < t->room)
    return HL_OK;
  if (t->room >= SAMPLES_MAX)
    return hl_fail(t->ctx, HL_ERR_FORMAT, "%s: over %d samples", t->path, SAMPLES_MAX);
  return resize(t, t->room > 0 ? 2 * t->room : 1024);
}

static hl_status unit_vector(const table *t, const char *what, const double in[3], double *out)
{
  const double length = hl_norm(in);
  if (!(fabs(length - 1) <= unit_tolerance))
    return bad_row(t, what, length, "a length within 1 % of 1");
  for (int k = 0; k < 3; k++)
    out[k] = in[k] / length;
  return HL_OK;
}

static hl_status store_row(table *t, const double value[COLUMNS])
{
  hl_samples *s = &t->samples;
  hl_status st = grow(t);
  if (st == HL_OK)
    st = unit_vector(t, "length of (nx,ny,nz)", value + NX, s->normal + 3 * (size_t)s->n);
  if (st == HL_OK && s->view)
    st = unit_vector(t, "length of (vx,vy,vz)", value + VX, s->view + 3 * (size_t)s->n);
  if (st != HL_OK)
    return st;
  const int first = s->channels == 3 ? RED : VALUE;
  for (int c = 0; c < s->channels; c++) {
    if (!(value[first + c] >= 0))
      return bad_row(t, column_names[first + c], value[first + c], "a radiance of 0 or more");
    s->value[c][s->n] = value[first + c];
  }
  s->n++;
  return HL_OK;
}

static hl_status read_row(table *t, const char *line)
{
  const char *start[FIELDS_MAX];
  size_t length[FIELDS_MAX];
  double value[COLUMNS] = {0};
  int n = 0;
  for (const char *c = line;;) {
    c += strspn(c, " \t");
    const size_t all = strcspn(c, ",\r\n");
    size_t used = all;
    while (used > 0 && (c[used - 1] == ' ' || c[used - 1] == '\t'))
      used--;
    if (n < FIELDS_MAX) {
      start[n] = c;
      length[n] = used;
    }
    n++;
    c += all;
    if (*c != ',')
      break;
    c++;
  }
  if (n != t->fields)
    return hl_fail(t->ctx, HL_ERR_FORMAT, "%s: line %ld: %d values; the header names %d columns",
                   t->path, t->line, n, t->fields);
  for (int k = 0; k < COLUMNS; k++) {
    if (t->at[k] < 0)
      continue;
    bool good = false;
    value[k] = number(start[t->at[k]], length[t->at[k]], &good);
    if (!good || !isfinite(value[k]))
      return hl_fail(t->ctx, HL_ERR_FORMAT, "%s: line %ld: %s = '%.*s'; a finite number is needed",
                     t->path, t->line, column_names[k],
                     (int)(length[t->at[k]] < 40 ? length[t->at[k]] : 40), start[t->at[k]]);
  }
  return store_row(t, value);
}

static bool is_passed_over(const char *line)
{
  const char c = line[strspn(line, " \t\r\n")];
  return c == '\0' || c == '#';
}

static hl_status read_lines(table *t, FILE *file)
{
  static const char mark[] = "\xef\xbb\xbf"; /* that some programs put before UTF-8 */
  char *buffer = NULL;
  size_t room = 0;
  bool has_header = false;
  hl_status st = HL_OK;
  errno = 0;
  while (st == HL_OK && getline(&buffer, &room, file) >= 0) {
    char *line = buffer;
    if (t->line++ == 0 && strncmp(line, mark, strlen(mark)) == 0)
      line += strlen(mark);
    if (is_passed_over(line))
      continue;
    if (has_header) {
      st = read_row(t, line);
      continue;
    }
    has_header = true;
    st = read_header(t, line);
    if (st == HL_OK)
      st = check_header(t);
  }
  free(buffer);
  if (st == HL_OK && ferror(file))
    st = hl_fail(t->ctx, HL_ERR_IO, "%s: cannot read: %s", t->path, strerror(errno));
  else if (st == HL_OK && t->samples.n == 0)
    st = hl_fail(t->ctx, HL_ERR_FORMAT, "%s: no samples; %s", t->path,
                 has_header ? "rows under the header are needed"
                            : "a header nx,ny,nz,value and rows under it are needed");
  return st;
}

hl_status hl_samples_read(hl_ctx *ctx, const char *path, hl_samples *out)
{
  table t = {.ctx = ctx, .path = path};
  FILE *file = fopen(path, "r");
  if (!file)
    return hl_fail(ctx, HL_ERR_IO, "%s: cannot open: %s", path, strerror(errno));
  hl_status st = read_lines(&t, file);
  fclose(file);
  if (st == HL_OK)
    st = resize(&t, t.samples.n);
  if (st == HL_OK)
    *out = t.samples;
  else
    hl_samples_free(&t.samples);
  return st;
}

void hl_samples_free(hl_samples *samples)
{
  if (!samples)
    return;
  free(samples->normal);
  free(samples->view);
  for (int c = 0; c < HL_CHANNELS_MAX; c++)
    free(samples->value[c]);
  memset(samples, 0, sizeof *samples);
}

hl_status hl_samples_check(hl_ctx *ctx, const hl_samples *s)
{
  if (s->n < 1 || (s->channels != 1 && s->channels != HL_CHANNELS_MAX))
    return hl_fail(ctx, HL_ERR_ARG, "%d samples of %d channels; some of 1 or 3 are needed", s->n,
                   s->channels);
  for (int i = 0; i < s->n; i++) {
    const size_t at = 3 * (size_t)i;
    if (!(fabs(hl_norm(s->normal + at) - 1) <= unit_tolerance))
      return hl_fail(ctx, HL_ERR_ARG, "sample %d: length of the normal = %.6g; 1 is needed", i,
                     hl_norm(s->normal + at));
    if (s->view && !(fabs(hl_norm(s->view + at) - 1) <= unit_tolerance))
      return hl_fail(ctx, HL_ERR_ARG, "sample %d: length of the view = %.6g; 1 is needed", i,
                     hl_norm(s->view + at));
    for (int c = 0; c < s->channels; c++)
      if (!(s->value[c][i] >= 0 && isfinite(s->value[c][i])))
        return hl_fail(ctx, HL_ERR_ARG,
                       "sample %d: value of channel %d = %.6g; a radiance of 0 or more is needed",
                       i, c, s->value[c][i]);
  }
  return HL_OK;
}
