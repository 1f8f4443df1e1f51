/*
 * Where a target is on its sheet, and whether it fits.
 *
 *   width  = max(w + 2 margin, NARROWEST)      w, h: the pattern with what goes on beyond its corners
 *   height = margin + h + margin + CAPTION + EDGE
 *   margin = max(EDGE, quiet zone)
 *
 * The quiet zone is white: a square's side around a chessboard, which OpenCV's detector asks for,
 * and a bit's around an AprilGrid, which AprilTag's reads to see that the border ends.
 */
#include "target_sheet.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const double EDGE = 6;        /* printers leave white about so much */
static const double CAPTION = 20;    /* two lines and the ruler */
static const double NARROWEST = 60;  /* for the caption to be read */
static const double SIDE_MAX = 5080; /* a PDF's page has 14400 points */
static const double CELL_MIN = 0.05; /* several times a PDF's resolution of 1/256 point */
static const double INCH = 25.4;
static const double DPI = 300;

enum { PIXELS_MAX = 16384, CELL_PIXELS_MIN = 2 };

static const char *const page_names[] = {"fit", "a4", "a3", "letter", NULL};
static const double pages[][2] = {{0, 0}, {210, 297}, {297, 420}, {215.9, 279.4}};

const hl_field_table *hl_sheet_fields(void)
{
  static const hl_field fields[] = {
      {"border_bits", HL_FIELD_INT, offsetof(hl_sheet_settings, border_bits), 1, 2, "",
       "black border of the tags: 2 bits as Kalibr's, which is taken where nothing is said, or 1 "
       "as "
       "AprilTag's",
       NULL},
      {"page", HL_FIELD_CHOICE, offsetof(hl_sheet_settings, page), 0, 3, "",
       "the paper, upright or across; fit: as large as the target needs", page_names},
      {"dpi", HL_FIELD_DOUBLE, offsetof(hl_sheet_settings, dpi), 10, 4800, "",
       "pixels an inch of a .png, 300 where nothing is said", NULL},
  };
  static const hl_field_table table = {"target sheet", fields, 3};
  return &table;
}

/* ---- how large it is ---- */

static double quiet_zone(const hl_sheet *s)
{
  return fmax(EDGE, s->cell_mm);
}

/* Of the pattern alone, along axis 0 or 1. */
static double pattern(const hl_sheet *s, int axis)
{
  return s->span_mm[axis] + 2 * s->around_mm;
}

static void needed(const hl_sheet *s, double out[2])
{
  out[0] = fmax(pattern(s, 0) + 2 * quiet_zone(s), NARROWEST);
  out[1] = pattern(s, 1) + 2 * quiet_zone(s) + CAPTION + EDGE;
}

/* The lengths that follow from the target. */
static void measure(hl_sheet *s, double size_m)
{
  const hl_target *t = &s->target;
  const double size = 1e3 * size_m;
  if (t->kind == HL_TARGET_APRILGRID) {
    s->span_mm[0] = size * (t->columns + (t->columns - 1) * t->spacing_ratio);
    s->span_mm[1] = size * (t->rows + (t->rows - 1) * t->spacing_ratio);
    s->around_mm = size * t->spacing_ratio;
    s->cell_mm = size / (HL_TARGET_TAG_CELLS + 2 * s->border_bits);
  } else {
    s->span_mm[0] = size * (t->columns - 1);
    s->span_mm[1] = size * (t->rows - 1);
    s->around_mm = size;
    s->cell_mm = size;
  }
}

/* Whether it fits the page, and then how the page lies. */
static bool fits(const hl_sheet *s, const double page[2], double out[2])
{
  double need[2];
  needed(s, need);
  for (int turn = 0; turn < 2; turn++) {
    out[0] = page[turn];
    out[1] = page[1 - turn];
    if (need[0] <= out[0] + 1e-9 && need[1] <= out[1] + 1e-9)
      return true;
  }
  return false;
}

/* The largest tag or square that fits the page, in tenths of a millimetre; 0 where none does. */
static double largest_fit_m(const hl_sheet *s, const double page[2])
{
  double low = 0;
  double high = s->target.size_m;
  for (int i = 0; i < 60; i++) {
    hl_sheet trial = *s;
    double lies[2];
    measure(&trial, (low + high) / 2);
    if (fits(&trial, page, lies))
      low = (low + high) / 2;
    else
      high = (low + high) / 2;
  }
  return floor(low * 1e4 + 1e-6) / 1e4;
}

static hl_status does_not_fit(hl_ctx *ctx, const hl_sheet *s, int page)
{
  char others[40] = "";
  double need[2];
  double lies[2];
  needed(s, need);
  for (int i = HL_PAGE_A4; page_names[i]; i++)
    if (i != page && fits(s, pages[i], lies))
      snprintf(others + strlen(others), sizeof others - strlen(others), "%s or ", page_names[i]);
  return hl_fail(ctx, HL_ERR_ARG,
                 "--page %s: the target needs %.1f x %.1f mm, the page has %.1f x %.1f; a %s of at "
                 "most %g m, or --page %sfit, is needed",
                 page_names[page], need[0], need[1], pages[page][0], pages[page][1],
                 s->target.kind == HL_TARGET_APRILGRID ? "tag" : "square",
                 largest_fit_m(s, pages[page]), others);
}

/* ---- what can be drawn ---- */

static hl_status check_cells(hl_ctx *ctx, const hl_sheet *s)
{
  const hl_target *t = &s->target;
  const bool tags = t->kind == HL_TARGET_APRILGRID;
  if (!(s->cell_mm >= CELL_MIN))
    return hl_fail(ctx, HL_ERR_ARG,
                   "%s of %.3g mm cannot be printed; at least %g mm, a %s of %g m, is needed",
                   tags ? "bits" : "squares", s->cell_mm, CELL_MIN, tags ? "tag" : "square",
                   CELL_MIN / s->cell_mm * t->size_m);
  if (tags && !(s->around_mm >= s->cell_mm * (1 - 1e-9)))
    return hl_fail(ctx, HL_ERR_ARG,
                   "spacing ratio %g leaves less white between the tags than one bit of theirs; "
                   "with --border-bits %d at least %g is needed",
                   t->spacing_ratio, s->border_bits, s->cell_mm / (1e3 * t->size_m));
  return HL_OK;
}

static hl_status check_pixels(hl_ctx *ctx, const hl_sheet *s)
{
  const double pixel = INCH / s->dpi;
  const double side = fmax(s->width_mm, s->height_mm);
  if (s->kind != HL_PICTURE_PNG)
    return HL_OK;
  if (!(s->cell_mm >= CELL_PIXELS_MIN * pixel * (1 - 1e-9)))
    return hl_fail(ctx, HL_ERR_ARG,
                   "--dpi %g: %s would be %.2g pixels large; %d pixels, --dpi %.0f, is needed",
                   s->dpi, s->target.kind == HL_TARGET_APRILGRID ? "bits" : "squares",
                   s->cell_mm / pixel, CELL_PIXELS_MIN, ceil(CELL_PIXELS_MIN * INCH / s->cell_mm));
  if (!(side <= PIXELS_MAX * pixel))
    return hl_fail(ctx, HL_ERR_ARG,
                   "--dpi %g: the sheet of %.1f x %.1f mm would be larger than %d pixels; --dpi "
                   "%.0f, or a .pdf, is needed",
                   s->dpi, s->width_mm, s->height_mm, PIXELS_MAX, floor(PIXELS_MAX * INCH / side));
  return HL_OK;
}

static hl_status choose_page(hl_ctx *ctx, hl_sheet *s, int page)
{
  double size[2];
  needed(s, size);
  if (page != HL_PAGE_FIT && !fits(s, pages[page], size))
    return does_not_fit(ctx, s, page);
  s->width_mm = size[0];
  s->height_mm = size[1];
  if (fmax(size[0], size[1]) <= SIDE_MAX)
    return HL_OK;
  return hl_fail(ctx, HL_ERR_ARG,
                 "the target needs a sheet of %.0f x %.0f mm; one of at most %g mm can be drawn",
                 size[0], size[1], SIDE_MAX);
}

/* ---- what goes where ---- */

int hl_sheet_pixels(const hl_sheet *sheet, double mm)
{
  return (int)ceil(mm * sheet->dpi / INCH - 1e-6);
}

static bool is_whole(double pixels)
{
  return fabs(pixels - round(pixels)) < 1e-6;
}

/* The first corner between four pixels; the other edges follow where the resolution lets them. */
static void align(hl_sheet *s)
{
  const double scale = s->dpi / INCH;
  for (int i = 0; i < 2; i++)
    s->first_mm[i] = round(s->first_mm[i] * scale) / scale;
  s->whole_pixels = is_whole(s->cell_mm * scale) && is_whole(s->around_mm * scale);
}

static void place(hl_sheet *s)
{
  static const double lengths[] = {100, 50, 20, 10};
  const double below = CAPTION + EDGE;
  s->first_mm[0] = (s->width_mm - s->span_mm[0]) / 2;
  s->first_mm[1] = (s->height_mm - below - s->span_mm[1]) / 2;
  if (s->kind == HL_PICTURE_PNG)
    align(s);
  s->caption_mm = s->height_mm - below;
  s->left_mm = pattern(s, 0) < NARROWEST ? EDGE : s->first_mm[0] - s->around_mm;
  for (int i = 3; i >= 0; i--)
    if (lengths[i] <= s->width_mm - s->left_mm - EDGE - 10) /* and its last label */
      s->ruler_mm = lengths[i];
}

hl_status hl_sheet_plan(hl_ctx *ctx, const hl_target *target, hl_picture_kind kind,
                        const hl_sheet_settings *settings, hl_sheet *out)
{
  const bool tags = target->kind == HL_TARGET_APRILGRID;
  hl_sheet s = {.target = *target, .kind = kind, .dpi = settings->dpi > 0 ? settings->dpi : DPI};
  hl_status st = hl_target_check(ctx, target);
  if (st != HL_OK)
    return st;
  if (settings->border_bits && !tags)
    return hl_fail(ctx, HL_ERR_ARG, "--border-bits %d: a chessboard has no tags; leave it out",
                   settings->border_bits);
  if (settings->dpi > 0 && kind != HL_PICTURE_PNG)
    return hl_fail(ctx, HL_ERR_ARG, "--dpi %g: only a .png has pixels; leave it out",
                   settings->dpi);
  if (tags)
    s.border_bits = settings->border_bits ? settings->border_bits : 2;
  measure(&s, target->size_m);
  st = check_cells(ctx, &s);
  if (st == HL_OK)
    st = choose_page(ctx, &s, settings->page);
  if (st == HL_OK)
    st = check_pixels(ctx, &s);
  if (st != HL_OK)
    return st;
  place(&s);
  *out = s;
  return HL_OK;
}
