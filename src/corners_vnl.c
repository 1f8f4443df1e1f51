/*
 * Corners as mrcal keeps them: a `.vnl`, which is a table of words between blanks.
 *
 *   ## whatever
 *   # filename x y level
 *   left01.png 244.45 94.12 0
 *   left01.png - - -
 *
 * A row a corner, in board order, the rows of one file together. `-` or a negative x, y or level is
 * a corner that was not seen; a level is the number of halvings of the frame in which it was found,
 * so its standard deviation is 2^level. A single row without a corner is a file without a board.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "file_read.h"
#include "halflight/corners.h"
#include "halflight/export.h"
#include "number_text.h"
#include "text.h"

enum {
  FIELDS = 4,
  DIGITS = 15, /* of x and y: decimals of up to so many digits come back as they were */
  LEVEL_DIGITS = 9,
  LEVEL_MAX = 30,
  SEEN_MIN = 4 /* fewer corners say nothing about a board, and mrcal drops such a file */
};

#define BYTES_MAX ((size_t)1 << 31)
#define COORDINATE_MAX 1e6

static const char blanks[] = " \t\v\f\r";

/* ---------------------------------------------------------------- reading */

typedef struct word {
  const char *at;
  size_t n;
} word;

/* The first row of a view. */
typedef struct start {
  word name;
  long line;
} start;

typedef struct reader {
  hl_ctx *ctx;
  const char *path;
  hl_corners *set;
  int corners;   /* of the target */
  long line;     /* counted from 1 */
  start *starts; /* shape (set->n_views) */
  int room;
  long rows; /* of the last view so far */
  hl_view *view;
} reader;

/* The words of a line; returns how many there are, of which up to FIELDS are kept. */
static int split(const char *line, size_t n, word out[FIELDS])
{
  int count = 0;
  for (size_t i = 0; i < n;) {
    if (strchr(blanks, line[i]) && line[i]) {
      i++;
      continue;
    }
    const size_t begin = i;
    while (i < n && !(strchr(blanks, line[i]) && line[i]))
      i++;
    if (count < FIELDS)
      out[count] = (word){line + begin, i - begin};
    count++;
  }
  return count;
}

static bool is(word w, const char *text)
{
  return w.n == strlen(text) && memcmp(w.at, text, w.n) == 0;
}

/* Words may hold anything: only printable ones go into a message. */
static const char *shown(word w, char text[32])
{
  snprintf(text, 32, "%.*s", w.n < 31 ? (int)w.n : 31, w.at);
  for (const char *c = text; *c; c++)
    if ((unsigned char)*c < ' ' || *c == 0x7f)
      return "?";
  return text;
}

/* A comment is a legend where it begins with `filename`; then it must name our columns. */
static hl_status check_legend(const reader *r, const char *line, size_t n)
{
  char text[32];
  word w[FIELDS];
  if (n > 1 && (line[1] == '#' || line[1] == '!'))
    return HL_OK;
  const int count = split(line + 1, n - 1, w);
  if (count == 0 || !is(w[0], "filename"))
    return HL_OK;
  static const char *const names[FIELDS] = {"filename", "x", "y", "level"};
  for (int i = 1; i < count && i < FIELDS; i++)
    if (!is(w[i], names[i]))
      return hl_fail(r->ctx, HL_ERR_FORMAT,
                     "%s: line %ld: column %d is '%s'; columns filename x y [level] are read",
                     r->path, r->line, i + 1, shown(w[i], text));
  if (count == 3 || count == FIELDS)
    return HL_OK;
  return hl_fail(r->ctx, HL_ERR_FORMAT,
                 "%s: line %ld: %d columns; columns filename x y [level] are read", r->path,
                 r->line, count);
}

/* The most square COLSxROWS that has so many corners; "" where none looks like a board. */
static const char *hint(const hl_target *target, long corners, char text[64])
{
  const bool tags = target->kind == HL_TARGET_APRILGRID;
  const long n = tags ? corners / 4 : corners;
  text[0] = '\0';
  if (tags && corners % 4 != 0)
    return text;
  for (long rows = (long)sqrt((double)n); rows >= 2; rows--)
    if (n % rows == 0) {
      if (n / rows <= 2 * rows)
        snprintf(text, 64, "; %ldx%ld %s would fit", n / rows, rows, tags ? "tags" : "corners");
      break;
    }
  return text;
}

/* The last view has all its rows. */
static hl_status finish_view(const reader *r)
{
  hl_view *view = r->view;
  if (!view)
    return HL_OK;
  for (int i = 0; i < r->corners; i++)
    view->seen += view->corner[i].sigma > 0;
  if (r->rows != r->corners && !(r->rows == 1 && view->seen == 0)) {
    char spec[HL_TARGET_SPEC_MAX];
    char fits[64];
    return hl_fail(
        r->ctx, HL_ERR_FORMAT, "%s: line %ld: '%.60s' has %ld row%s from here; %s needs %d%s",
        r->path, r->starts[r->set->n_views - 1].line, view->name, r->rows, r->rows == 1 ? "" : "s",
        hl_target_spec(&r->set->target, spec), r->corners, hint(&r->set->target, r->rows, fits));
  }
  view->used = view->seen >= SEEN_MIN;
  if (!view->used)
    snprintf(view->why, sizeof view->why, "%d corner%s seen; at least %d are needed", view->seen,
             view->seen == 1 ? "" : "s", SEEN_MIN);
  return HL_OK;
}

static hl_status begin_view(reader *r, word name)
{
  char text[HL_VIEW_NAME_MAX];
  hl_status st = finish_view(r);
  if (st != HL_OK)
    return st;
  for (size_t i = 0; i < name.n; i++)
    if ((unsigned char)name.at[i] < ' ' || name.at[i] == 0x7f)
      return hl_fail(r->ctx, HL_ERR_FORMAT,
                     "%s: line %ld: the file's name holds byte 0x%02x; printable ones are accepted",
                     r->path, r->line, (unsigned)name.at[i]);
  if (name.n >= sizeof text)
    return hl_fail(r->ctx, HL_ERR_FORMAT,
                   "%s: line %ld: the file's name has %zu bytes; up to %d are accepted", r->path,
                   r->line, name.n, HL_VIEW_NAME_MAX - 1);
  if (r->set->n_views == r->room) {
    const int room = r->room > 0 ? 2 * r->room : 64;
    start *starts = realloc(r->starts, (size_t)room * sizeof *starts);
    if (!starts)
      return hl_fail(r->ctx, HL_ERR_MEMORY, "%s: no memory for %d views", r->path, room);
    r->starts = starts;
    r->room = room;
  }
  memcpy(text, name.at, name.n);
  text[name.n] = '\0';
  st = hl_corners_add(r->ctx, r->set, text, &r->view);
  if (st != HL_OK)
    return st;
  r->starts[r->set->n_views - 1] = (start){name, r->line};
  r->rows = 0;
  return HL_OK;
}

/* A number within bounds. */
static hl_status number(const reader *r, const char *what, word w, double max, double *out)
{
  char text[32];
  if (hl_number_parse(w.at, w.n, out) && *out <= max)
    return HL_OK;
  return hl_fail(r->ctx, HL_ERR_FORMAT,
                 "%s: line %ld: %s is '%s'; a number up to %g, or -, is needed", r->path, r->line,
                 what, shown(w, text), max);
}

static hl_status read_row(reader *r, const char *line, size_t n)
{
  word w[FIELDS];
  const int count = split(line, n, w);
  if (count == 0)
    return HL_OK;
  if (count != 3 && count != FIELDS)
    return hl_fail(r->ctx, HL_ERR_FORMAT,
                   "%s: line %ld: %d words; a row is filename x y [level], and a name holds no "
                   "blank",
                   r->path, r->line, count);
  hl_status st = HL_OK;
  if (!r->view || !is(w[0], r->view->name))
    st = begin_view(r, w[0]);
  static const char *const names[FIELDS] = {"filename", "x", "y", "level"};
  static const double most[FIELDS] = {0, COORDINATE_MAX, COORDINATE_MAX, LEVEL_MAX};
  double value[FIELDS] = {0};
  bool seen = true;
  for (int i = 1; i < count && st == HL_OK; i++) {
    if (is(w[i], "-"))
      seen = false;
    else
      st = number(r, names[i], w[i], most[i], &value[i]);
    seen = seen && value[i] >= 0;
  }
  if (st == HL_OK && r->view && seen && r->rows < r->corners)
    r->view->corner[r->rows] = (hl_corner){value[1], value[2], exp2(value[3])};
  r->rows++;
  return st;
}

static hl_status read_lines(reader *r, const char *bytes, size_t n)
{
  hl_status st = HL_OK;
  for (size_t at = 0; at < n && st == HL_OK;) {
    const char *line = bytes + at;
    const char *end = memchr(line, '\n', n - at);
    size_t length = end ? (size_t)(end - line) : n - at;
    at += length + 1;
    r->line++;
    while (length > 0 && strchr(blanks, *line) && *line) {
      line++;
      length--;
    }
    st = length > 0 && *line == '#' ? check_legend(r, line, length) : read_row(r, line, length);
  }
  if (st == HL_OK)
    st = finish_view(r);
  if (st == HL_OK && r->set->n_views == 0)
    st = hl_fail(r->ctx, HL_ERR_FORMAT,
                 "%s: no row; '# filename x y level' and a row a corner are needed", r->path);
  return st;
}

static int by_name(const void *a, const void *b)
{
  const start *p = a;
  const start *q = b;
  const int order = memcmp(p->name.at, q->name.at, p->name.n < q->name.n ? p->name.n : q->name.n);
  if (order != 0)
    return order;
  if (p->name.n != q->name.n)
    return p->name.n < q->name.n ? -1 : 1;
  return (p->line > q->line) - (p->line < q->line);
}

/* Every file once. Leaves `starts` sorted. */
static hl_status check_names(const reader *r)
{
  char text[32];
  const int n = r->set->n_views;
  if (!r->starts)
    return HL_OK;
  qsort(r->starts, (size_t)n, sizeof *r->starts, by_name);
  for (int i = 1; i < n; i++) {
    const start *p = &r->starts[i - 1];
    const start *q = &r->starts[i];
    if (p->name.n == q->name.n && memcmp(p->name.at, q->name.at, p->name.n) == 0)
      return hl_fail(
          r->ctx, HL_ERR_FORMAT,
          "%s: line %ld: '%s' was there from line %ld; a file's rows must stand together", r->path,
          q->line, shown(q->name, text), p->line);
  }
  return HL_OK;
}

hl_status hl_corners_read(hl_ctx *ctx, const char *path, const hl_target *target, hl_corners *out)
{
  unsigned char *bytes = NULL;
  size_t n = 0;
  hl_status st = hl_file_read(ctx, path, BYTES_MAX, &bytes, &n);
  if (st != HL_OK)
    return st;
  hl_corners set = hl_corners_of(target);
  reader r = {.ctx = ctx, .path = path, .set = &set, .corners = hl_target_corners(target)};
  st = read_lines(&r, (const char *)bytes, n);
  if (st == HL_OK)
    st = check_names(&r);
  free(r.starts);
  free(bytes);
  if (st == HL_OK)
    *out = set;
  else
    hl_corners_free(&set);
  return st;
}

/* ---------------------------------------------------------------- writing */

static hl_status check_view(hl_ctx *ctx, const char *path, const hl_view *view, int n)
{
  if (view->name[0] == '\0' || view->name[0] == '#' || strpbrk(view->name, " \t\v\f\r\n"))
    return hl_fail(ctx, HL_ERR_ARG,
                   "%s: a .vnl cannot hold the name '%.80s'; one without blanks that does not "
                   "begin with # is needed: rename the frame",
                   path, view->name);
  for (int i = 0; view->used && i < n; i++) {
    const hl_corner *c = &view->corner[i];
    if (c->sigma > 0 && !(c->x >= 0 && c->y >= 0 && c->x <= COORDINATE_MAX &&
                          c->y <= COORDINATE_MAX && c->sigma >= 1 && log2(c->sigma) <= LEVEL_MAX))
      return hl_fail(ctx, HL_ERR_ARG,
                     "%s: corner %d of '%.60s' is at (%g, %g), sigma %g; x, y >= 0 and sigma >= 1 "
                     "can be written",
                     path, i, view->name, c->x, c->y, c->sigma);
  }
  return HL_OK;
}

static void add_row(hl_text *text, const char *name, const hl_corner *c)
{
  hl_text_add(text, name);
  if (!c || !(c->sigma > 0)) {
    hl_text_add(text, " - - -\n");
    return;
  }
  hl_text_add(text, " ");
  hl_text_number(text, c->x, DIGITS);
  hl_text_add(text, " ");
  hl_text_number(text, c->y, DIGITS);
  hl_text_add(text, " ");
  hl_text_number(text, log2(c->sigma), LEVEL_DIGITS);
  hl_text_add(text, "\n");
}

/* A view that is left out stands there as a file without a board, its reason above it: other
 * programs must not use what we do not. */
static void add_view(hl_text *text, const hl_view *view, int n)
{
  if (!view->used) {
    hl_text_add(text, "## left out: ");
    for (const char *c = view->why; *c; c++)
      hl_text_add(text, (const char[2]){*c == '\n' ? ' ' : *c, '\0'});
    hl_text_add(text, "\n");
    add_row(text, view->name, NULL);
    return;
  }
  for (int i = 0; i < n; i++)
    add_row(text, view->name, &view->corner[i]);
}

hl_status hl_corners_write(hl_ctx *ctx, const char *path, const hl_corners *corners)
{
  char spec[HL_TARGET_SPEC_MAX];
  const int n = hl_target_corners(&corners->target);
  for (int i = 0; i < corners->n_views; i++) {
    const hl_status st = check_view(ctx, path, &corners->view[i], n);
    if (st != HL_OK)
      return st;
  }
  hl_text text = {0};
  hl_text_add(&text, "## ");
  hl_text_add(&text, hl_target_spec(&corners->target, spec));
  hl_text_add(&text, "\n# filename x y level\n");
  for (int i = 0; i < corners->n_views; i++)
    add_view(&text, &corners->view[i], n);
  const hl_status st = text.failed ? hl_fail(ctx, HL_ERR_MEMORY, "%s: no memory for %d views", path,
                                             corners->n_views)
                                   : hl_file_write(ctx, path, text.bytes, text.n);
  free(text.bytes);
  return st;
}
