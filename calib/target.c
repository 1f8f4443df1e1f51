/*
 * A target's spec and where its corners are.
 *
 *   chessboard:  corner (i, k) at (i, k) SIZE
 *   AprilGrid:   corner (i, k) of tag (i / 2, k / 2) at
 *                x = SIZE ((i / 2) (1 + RATIO) + i mod 2), y likewise with k
 *
 * Numbers are read and written by hand, since the C library's follow the locale. Up to 15
 * significant digits m and a power of ten up to 22 are both doubles without error, so that m 10^e
 * needs one rounding and is the nearest double (Clinger, How to Read Floating Point Numbers
 * Accurately, 1990); more digits round once more.
 */
#include "halflight/target.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

enum { DIGITS_MAX = 18, POWER_MAX = 22, PARTS_MAX = 5, PART_MAX = 32 };

static const char aprilgrid_form[] = "aprilgrid:COLSxROWS:TAG_M:SPACING_RATIO";
static const char chessboard_form[] = "chessboard:COLSxROWS:SQUARE_M";

/* ---- numbers ---- */

/* Digits and one point into mantissa and power of ten; digits below what a double holds are
 * dropped. Returns where they end, NULL where there is no digit. */
static const char *read_mantissa(const char *at, uint64_t *mantissa, int *power)
{
  int digits = 0;
  bool any = false;
  bool after_point = false;
  *mantissa = 0;
  *power = 0;
  for (;; at++) {
    if (*at == '.' && !after_point) {
      after_point = true;
      continue;
    }
    if (*at < '0' || *at > '9')
      break;
    any = true;
    if (digits < DIGITS_MAX) {
      *mantissa = *mantissa * 10 + (uint64_t)(*at - '0');
      digits += *mantissa > 0;
      *power -= after_point;
    } else {
      *power += !after_point;
    }
  }
  return any ? at : NULL;
}

static bool read_power(const char *at, int *power)
{
  int sign = 1;
  int value = 0;
  if (*at == '+' || *at == '-')
    sign = *at++ == '-' ? -1 : 1;
  if (!*at)
    return false;
  for (; *at; at++) {
    if (*at < '0' || *at > '9' || value > POWER_MAX)
      return false;
    value = value * 10 + (*at - '0');
  }
  *power += sign * value;
  return true;
}

/* The whole of `text`, a decimal number without a sign. */
static bool read_number(const char *text, double *out)
{
  uint64_t mantissa;
  int power;
  const char *end = read_mantissa(text, &mantissa, &power);
  if (!end)
    return false;
  if ((*end == 'e' || *end == 'E') ? !read_power(end + 1, &power) : *end != '\0')
    return false;
  if (power > POWER_MAX || power < -POWER_MAX)
    return false;
  double scale = 1;
  for (int i = 0; i < power || i < -power; i++)
    scale *= 10;
  *out = power < 0 ? (double)mantissa / scale : (double)mantissa * scale;
  return true;
}

/* A %g text holds nothing but digits, signs, letters and the locale's mark, of one byte or more. */
static const char *write_digits(double value, int digits, char text[PART_MAX])
{
  static const char plain[] = "+-0123456789abcdefghijklmnopqrstuvwxyz";
  snprintf(text, PART_MAX, "%.*g", digits, value);
  char *mark = text + strspn(text, plain);
  const size_t length = strcspn(mark, plain);
  if (length > 0) {
    memmove(mark + 1, mark + length, strlen(mark + length) + 1);
    *mark = '.';
  }
  return text;
}

/* As a person would write it, where that is the same number. */
static const char *write_number(double value, char text[PART_MAX])
{
  double back;
  if (read_number(write_digits(value, 15, text), &back) && !(back < value) && !(back > value))
    return text;
  return write_digits(value, 17, text);
}

/* ---- what a target may be ---- */

static hl_status check_count(hl_ctx *ctx, const char *name, int value, int min, const char *of)
{
  if (value >= min && value <= HL_TARGET_SIDE_MAX)
    return HL_OK;
  return hl_fail(ctx, HL_ERR_ARG, "target: %s = %d %s is outside [%d, %d]", name, value, of, min,
                 HL_TARGET_SIDE_MAX);
}

/* Written so that NaN is outside. */
static hl_status check_range(hl_ctx *ctx, const char *name, double value, const char *unit,
                             double min, double max)
{
  char number[3][PART_MAX];
  if (value >= min && value <= max)
    return HL_OK;
  return hl_fail(ctx, HL_ERR_ARG, "target: %s = %s%s is outside [%s, %s]", name,
                 write_number(value, number[0]), unit, write_number(min, number[1]),
                 write_number(max, number[2]));
}

hl_status hl_target_check(hl_ctx *ctx, const hl_target *t)
{
  const bool tags = t->kind == HL_TARGET_APRILGRID;
  if (!tags && t->kind != HL_TARGET_CHESSBOARD)
    return hl_fail(ctx, HL_ERR_ARG, "target: kind = %d is neither aprilgrid nor chessboard",
                   (int)t->kind);
  const char *of = tags ? "tags" : "inner corners";
  const int min = tags ? 1 : HL_TARGET_CHESSBOARD_MIN;
  hl_status st = check_count(ctx, "columns", t->columns, min, of);
  if (st == HL_OK)
    st = check_count(ctx, "rows", t->rows, min, of);
  if (st == HL_OK && tags && t->columns * t->rows > HL_TARGET_TAGS_MAX)
    st = hl_fail(ctx, HL_ERR_ARG,
                 "target: %d x %d = %d tags are more than the %d of family tag36h11; fewer columns "
                 "or rows are needed",
                 t->columns, t->rows, t->columns * t->rows, HL_TARGET_TAGS_MAX);
  if (st == HL_OK)
    st = check_range(ctx, tags ? "tag" : "square", t->size_m, " m", HL_TARGET_SIZE_MIN_M,
                     HL_TARGET_SIZE_MAX_M);
  if (st != HL_OK)
    return st;
  if (tags)
    return check_range(ctx, "spacing ratio", t->spacing_ratio, "", HL_TARGET_RATIO_MIN,
                       HL_TARGET_RATIO_MAX);
  if (t->spacing_ratio != 0)
    return hl_fail(ctx, HL_ERR_ARG,
                   "target: spacing ratio = %g; a chessboard has none, 0 is needed",
                   t->spacing_ratio);
  return HL_OK;
}

/* ---- the spec ---- */

typedef struct parts {
  int n; /* of the spec, which may be more than there is room for */
  char text[PARTS_MAX][PART_MAX];
} parts;

/* At the colons. False where a part has no room: nothing that is meant is so long. */
static bool split(const char *spec, parts *out)
{
  out->n = 0;
  for (const char *at = spec;; at++) {
    const size_t length = strcspn(at, ":");
    if (length >= PART_MAX || out->n >= PARTS_MAX)
      return false;
    memcpy(out->text[out->n], at, length);
    out->text[out->n++][length] = '\0';
    at += length;
    if (!*at)
      return true;
  }
}

/* A count of up to six digits; larger ones are not told apart from 999999. */
static const char *read_count(const char *at, int *out)
{
  const char *start = at;
  int value = 0;
  for (; *at >= '0' && *at <= '9'; at++)
    value = value < 100000 ? value * 10 + (*at - '0') : 999999;
  *out = value;
  return at > start ? at : NULL;
}

static bool read_counts(const char *text, hl_target *t)
{
  const char *at = read_count(text, &t->columns);
  if (!at || *at != 'x')
    return false;
  at = read_count(at + 1, &t->rows);
  return at && *at == '\0';
}

static hl_status malformed(hl_ctx *ctx, const char *spec, const char *what, const char *value,
                           const char *form)
{
  return hl_fail(ctx, HL_ERR_ARG, "target '%.60s': %s '%.20s'; %s is needed", spec, what, value,
                 form);
}

static hl_status read_parts(hl_ctx *ctx, const char *spec, const parts *p, const char *form,
                            hl_target *t)
{
  const bool tags = t->kind == HL_TARGET_APRILGRID;
  const int due = tags ? 4 : 3;
  if (p->n != due)
    return hl_fail(ctx, HL_ERR_ARG, "target '%.60s': %d parts between colons; %s is needed", spec,
                   p->n, form);
  if (!read_counts(p->text[1], t))
    return malformed(ctx, spec, "COLSxROWS is", p->text[1], form);
  if (!read_number(p->text[2], &t->size_m))
    return malformed(ctx, spec, tags ? "TAG_M is" : "SQUARE_M is", p->text[2], form);
  if (tags && !read_number(p->text[3], &t->spacing_ratio))
    return malformed(ctx, spec, "SPACING_RATIO is", p->text[3], form);
  return hl_target_check(ctx, t);
}

hl_status hl_target_parse(hl_ctx *ctx, const char *spec, hl_target *out)
{
  parts p;
  hl_target t = {0};
  const size_t kind = strcspn(spec, ":");
  const bool tags = kind == 9 && strncmp(spec, "aprilgrid", kind) == 0;
  if (!tags && !(kind == 10 && strncmp(spec, "chessboard", kind) == 0))
    return hl_fail(ctx, HL_ERR_ARG,
                   "target '%.60s': '%.*s' is no kind of target; %s or %s is needed", spec,
                   kind < 20 ? (int)kind : 20, spec, aprilgrid_form, chessboard_form);
  const char *form = tags ? aprilgrid_form : chessboard_form;
  t.kind = tags ? HL_TARGET_APRILGRID : HL_TARGET_CHESSBOARD;
  if (!split(spec, &p))
    return hl_fail(ctx, HL_ERR_ARG, "target '%.60s' is too long; %s is needed", spec, form);
  const hl_status st = read_parts(ctx, spec, &p, form, &t);
  if (st == HL_OK)
    *out = t;
  return st;
}

const char *hl_target_spec(const hl_target *t, char text[HL_TARGET_SPEC_MAX])
{
  char size[PART_MAX];
  char ratio[PART_MAX];
  write_number(t->size_m, size);
  write_number(t->spacing_ratio, ratio);
  if (t->kind == HL_TARGET_APRILGRID)
    snprintf(text, HL_TARGET_SPEC_MAX, "aprilgrid:%dx%d:%s:%s", t->columns, t->rows, size, ratio);
  else
    snprintf(text, HL_TARGET_SPEC_MAX, "chessboard:%dx%d:%s", t->columns, t->rows, size);
  return text;
}

/* ---- geometry ---- */

static int corners_of(const hl_target *t, int count)
{
  return t->kind == HL_TARGET_APRILGRID ? 2 * count : count;
}

int hl_target_corner_columns(const hl_target *target)
{
  return corners_of(target, target->columns);
}

int hl_target_corner_rows(const hl_target *target)
{
  return corners_of(target, target->rows);
}

int hl_target_corners(const hl_target *target)
{
  return hl_target_corner_columns(target) * hl_target_corner_rows(target);
}

static double along(const hl_target *t, int i)
{
  if (t->kind == HL_TARGET_CHESSBOARD)
    return t->size_m * i;
  const int tag = i / 2;
  return t->size_m * (tag * (1 + t->spacing_ratio) + i % 2);
}

void hl_target_corner(const hl_target *target, int index, double out_m[3])
{
  const int columns = hl_target_corner_columns(target);
  out_m[0] = along(target, index % columns);
  out_m[1] = along(target, index / columns);
  out_m[2] = 0;
}

int hl_target_tag_id(const hl_target *target, int column, int row)
{
  return (target->rows - 1 - row) * target->columns + column;
}
