/*
 * Editing a reflectance: a term scaled, aimed elsewhere, or given another curve.
 *
 * What leaves physics is done and noted. A BRDF is reciprocal: unchanged when s and v change places.
 * A term along (cs s + cv v)/|.| is so for cs = cv alone; the body's n.s is the cosine of the light,
 * not of the BRDF, and counts as reciprocal too. Curves of a real surface are not negative and grow
 * with the cosine (paper L1 to L4). In the log domain a term is the logarithm of a factor: to scale it
 * adds log F, and its sign says nothing.
 */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "file_read.h"
#include "halflight/notes.h"
#include "halflight/relight.h"
#include "number_text.h"

enum { CURVE_BYTES_MAX = 1 << 20 };

static hl_status find(hl_ctx *ctx, hl_reflectance *r, const char *name, hl_lobe_term **out)
{
  char known[160] = "";
  for (int i = 0; i < r->n_terms; i++) {
    if (strcmp(r->term[i].name, name) == 0) {
      *out = &r->term[i];
      return HL_OK;
    }
    if (i > 0)
      strncat(known, ", ", sizeof known - strlen(known) - 1);
    strncat(known, r->term[i].name, sizeof known - strlen(known) - 1);
  }
  hl_fail(ctx, HL_ERR_ARG, "there is no term '%.40s'; there are: %s", name, known);
  return HL_ERR_ARG;
}

hl_status hl_reflectance_scale(hl_ctx *ctx, hl_reflectance *reflectance, const char *term,
                               double factor)
{
  hl_lobe_term *t = NULL;
  const hl_status st = find(ctx, reflectance, term, &t);
  if (st != HL_OK)
    return st;
  if (!isfinite(factor))
    return hl_fail(ctx, HL_ERR_ARG, "factor %g of '%.40s'; a finite one is needed", factor, term);
  const bool factors = reflectance->log_domain; /* the curve is the log of a factor */
  if (factors && !(factor > 0))
    return hl_fail(ctx, HL_ERR_ARG,
                   "factor %g of '%.40s', a factor of a product; above 0 is needed", factor, term);
  for (int c = 0; c < HL_CHANNELS_MAX; c++) {
    t->view_slope[c] *= factors ? 1 : factor;
    for (int i = 0; i < t->n; i++)
      t->value[c][i] = factors ? t->value[c][i] + log(factor) : factor * t->value[c][i];
  }
  if (factor < 0)
    hl_notes_add(&reflectance->notes, "not physical", "%s is scaled by %g: light is taken away",
                 term, factor);
  return HL_OK;
}

hl_status hl_reflectance_aim(hl_ctx *ctx, hl_reflectance *reflectance, const char *term, double cs,
                             double cv)
{
  hl_lobe_term *t = NULL;
  const hl_status st = find(ctx, reflectance, term, &t);
  if (st != HL_OK)
    return st;
  if (!isfinite(cs) || !isfinite(cv) || !(fabs(cs) + fabs(cv) > 0))
    return hl_fail(ctx, HL_ERR_ARG, "'%.40s' along %g s + %g v; a direction is needed", term, cs,
                   cv);
  t->cs = cs;
  t->cv = cv;
  t->fixed_axis = false;
  if (cs != cv && cv != 0)
    hl_notes_add(&reflectance->notes, "not physical",
                 "%s along %g s + %g v is not reciprocal: s and v cannot change places", term, cs,
                 cv);
  return HL_OK;
}

/* One row: t, then one value or three. 0 at the end of the row's numbers, -1 where it is no row. */
static int read_row(const char *line, double number[4])
{
  int n = 0;
  const char *at = line;
  while (n < 4) {
    at += strspn(at, " \t");
    const size_t length = strcspn(at, ", \t\r");
    if (!hl_number_parse(at, length, &number[n]))
      return -1;
    n++;
    const char *end = at + length + strspn(at + length, " \t\r");
    if (*end == '\0')
      return n;
    if (*end != ',')
      return -1;
    at = end + 1;
  }
  return -1;
}

static hl_status read_curve(hl_ctx *ctx, const char *path, char *text, hl_lobe_term *out)
{
  int line = 0, columns = 0;
  out->n = 0;
  for (char *at = text; at;) {
    char *end = strchr(at, '\n');
    double number[4];
    line++;
    if (end)
      *end++ = '\0';
    const int n = read_row(at, number);
    const bool header = n < 0 && line == 1 && strncmp(at, "t,", 2) == 0;
    const bool blank = at[strspn(at, " \t\r")] == '\0';
    if (!header && !blank) {
      if ((n != 2 && n != 4) || (columns && n != columns))
        return hl_fail(ctx, HL_ERR_FORMAT, "%s:%d: '%.40s' is no row; t,value or t,r,g,b is needed",
                       path, line, at);
      if (!(fabs(number[0]) <= 1) || (out->n > 0 && !(number[0] > out->t[out->n - 1])))
        return hl_fail(ctx, HL_ERR_FORMAT,
                       "%s:%d: t = %g; ascending ones within [-1, 1] are needed", path, line,
                       number[0]);
      if (out->n == HL_CURVE_POINTS)
        return hl_fail(ctx, HL_ERR_FORMAT, "%s:%d: more than %d rows", path, line, HL_CURVE_POINTS);
      columns = n;
      out->t[out->n] = number[0];
      for (int c = 0; c < HL_CHANNELS_MAX; c++)
        out->value[c][out->n] = number[n == 2 ? 1 : 1 + c];
      out->n++;
    }
    at = end;
  }
  return out->n >= 2
             ? HL_OK
             : hl_fail(ctx, HL_ERR_FORMAT, "%s: %d rows; at least 2 are needed", path, out->n);
}

static void note_shape(hl_reflectance *reflectance, const hl_lobe_term *t)
{
  bool negative = false, falls = false;
  for (int c = 0; c < HL_CHANNELS_MAX; c++)
    for (int i = 0; i < t->n; i++) {
      negative = negative || (!reflectance->log_domain && t->value[c][i] < 0);
      falls = falls || (i > 0 && t->value[c][i] < t->value[c][i - 1]);
    }
  if (negative)
    hl_notes_add(&reflectance->notes, "not physical", "the curve of %s is negative in places",
                 t->name);
  if (falls)
    hl_notes_add(&reflectance->notes, "not physical",
                 "the curve of %s falls towards its axis in places", t->name);
}

hl_status hl_reflectance_replace(hl_ctx *ctx, hl_reflectance *reflectance, const char *term,
                                 const char *path)
{
  hl_lobe_term *t = NULL;
  unsigned char *bytes = NULL;
  size_t n = 0;
  hl_status st = find(ctx, reflectance, term, &t);
  if (st == HL_OK)
    st = hl_file_read(ctx, path, CURVE_BYTES_MAX, &bytes, &n);
  if (st != HL_OK)
    return st;
  hl_lobe_term *edited = malloc(sizeof *edited);
  if (edited) {
    *edited = *t;
    st = read_curve(ctx, path, (char *)bytes, edited);
  } else {
    hl_fail(ctx, HL_ERR_MEMORY, "%s: no memory for a curve", path);
    st = HL_ERR_MEMORY;
  }
  if (st == HL_OK) {
    memset(edited->view_slope, 0,
           sizeof edited->view_slope); /* the new curve holds for every view */
    *t = *edited;
    note_shape(reflectance, t);
  }
  free(edited);
  free(bytes);
  return st;
}
