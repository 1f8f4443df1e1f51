/*
 * A target, drawn in millimetres: all its black as one path, then all the white within it as
 * another, so that no seam shows between neighbours.
 *
 * AprilGrids as Kalibr's kalibr_create_target_pdf draws them: tags upright, and at each of a tag's
 * corners a black square as wide as the gap, so that every corner is a saddle, which blur does not
 * move. cairo keeps places to 1/256 point in a PDF, 1/256 mm in an SVG, 1/256 pixel in a PNG.
 */
#include <math.h>
#include <stdio.h>

#include <cairo-pdf.h>
#include <cairo-svg.h>

#include "target_sheet.h"

static const double TEXT = 3.2; /* mm, as all below */
static const double LINE = 4.6;
static const double RULER_LINE = 0.15;
static const double INCH = 25.4;

/* ---- the pattern ---- */

/* The white of one row of a tag's code, neighbours together. */
static void add_white(cairo_t *cr, const bool row[HL_TARGET_TAG_CELLS], double x, double y,
                      double cell)
{
  for (int i = 0; i < HL_TARGET_TAG_CELLS; i++) {
    int run = 0;
    while (i + run < HL_TARGET_TAG_CELLS && row[i + run])
      run++;
    if (run > 0)
      cairo_rectangle(cr, x + i * cell, y, run * cell, cell);
    i += run;
  }
}

static hl_status add_code(hl_ctx *ctx, cairo_t *cr, const hl_sheet *s, int id, double x, double y)
{
  bool white[HL_TARGET_TAG_CELLS][HL_TARGET_TAG_CELLS];
  const hl_status st = hl_target_tag_cells(ctx, id, white);
  const double border = s->border_bits * s->cell_mm;
  for (int i = 0; st == HL_OK && i < HL_TARGET_TAG_CELLS; i++)
    add_white(cr, white[i], x + border, y + border + i * s->cell_mm, s->cell_mm);
  return st;
}

/* Column or row i of the tags, from the sheet's edge. */
static double tag_at(const hl_sheet *s, int axis, int i)
{
  const double side = s->cell_mm * (HL_TARGET_TAG_CELLS + 2 * s->border_bits);
  return s->first_mm[axis] + i * (side + s->around_mm);
}

static void add_squares(cairo_t *cr, const hl_sheet *s)
{
  const hl_target *t = &s->target;
  const double side = s->cell_mm * (HL_TARGET_TAG_CELLS + 2 * s->border_bits);
  const double gap = s->around_mm;
  for (int row = 0; row <= t->rows; row++)
    for (int column = 0; column <= t->columns; column++) {
      const double x = tag_at(s, 0, column);
      const double y = tag_at(s, 1, row);
      cairo_rectangle(cr, x - gap, y - gap, gap, gap);
      if (row < t->rows && column < t->columns)
        cairo_rectangle(cr, x, y, side, side);
    }
}

static hl_status add_codes(hl_ctx *ctx, cairo_t *cr, const hl_sheet *s)
{
  const hl_target *t = &s->target;
  hl_status st = HL_OK;
  for (int row = 0; st == HL_OK && row < t->rows; row++)
    for (int column = 0; st == HL_OK && column < t->columns; column++)
      st = add_code(ctx, cr, s, hl_target_tag_id(t, column, row), tag_at(s, 0, column),
                    tag_at(s, 1, row));
  return st;
}

static void add_chessboard(cairo_t *cr, const hl_sheet *s)
{
  for (int row = 0; row <= s->target.rows; row++)
    for (int column = row % 2; column <= s->target.columns; column += 2)
      cairo_rectangle(cr, s->first_mm[0] + (column - 1) * s->cell_mm,
                      s->first_mm[1] + (row - 1) * s->cell_mm, s->cell_mm, s->cell_mm);
}

static hl_status draw_pattern(hl_ctx *ctx, cairo_t *cr, const hl_sheet *s)
{
  const bool tags = s->target.kind == HL_TARGET_APRILGRID;
  cairo_new_path(cr);
  if (tags)
    add_squares(cr, s);
  else
    add_chessboard(cr, s);
  cairo_set_source_rgb(cr, 0, 0, 0);
  cairo_fill(cr);
  const hl_status st = tags ? add_codes(ctx, cr, s) : HL_OK;
  cairo_set_source_rgb(cr, 1, 1, 1);
  cairo_fill(cr);
  cairo_set_source_rgb(cr, 0, 0, 0);
  return st;
}

/* ---- below it ---- */

/* Of a line that fits: smaller letters where TEXT would not. */
static double text_size(const hl_canvas *canvas, const hl_sheet *s, const char *text)
{
  cairo_text_extents_t extents;
  cairo_set_font_size(canvas->cr, TEXT);
  cairo_text_extents(canvas->cr, text, &extents);
  const double room = s->width_mm - s->left_mm - 4;
  return extents.x_advance > room ? TEXT * room / extents.x_advance : TEXT;
}

static void draw_caption(const hl_canvas *canvas, const hl_sheet *s)
{
  const hl_target *t = &s->target;
  char spec[HL_TARGET_SPEC_MAX];
  char what[200];
  char how[200];
  char dpi[32] = "";
  hl_target_spec(t, spec);
  if (t->kind == HL_TARGET_APRILGRID)
    snprintf(what, sizeof what, "%s   tag36h11, %d-bit border, ids 0 to %d from the bottom left",
             spec, s->border_bits, t->columns * t->rows - 1);
  else
    snprintf(what, sizeof what, "%s   %d \303\227 %d squares", spec, t->columns + 1, t->rows + 1);
  if (s->kind == HL_PICTURE_PNG)
    snprintf(dpi, sizeof dpi, " (%g dpi)", s->dpi);
  snprintf(how, sizeof how,
           "Print at 100 %%%s, then measure: first to last corner %.6g mm across, %.6g mm down; "
           "ruler %g mm",
           dpi, s->span_mm[0], s->span_mm[1], s->ruler_mm);
  const double size = fmin(text_size(canvas, s, what), text_size(canvas, s, how));
  hl_canvas_text(canvas, s->left_mm, s->caption_mm + LINE, 0, size, what);
  hl_canvas_text(canvas, s->left_mm, s->caption_mm + 2 * LINE, 0, size, how);
}

/* From the middle of its first mark to that of its last; marks every 10 mm, longer every 50. */
static void draw_ruler(const hl_canvas *canvas, const hl_sheet *s)
{
  cairo_t *cr = canvas->cr;
  const double x = s->left_mm + RULER_LINE / 2;
  const double y = s->caption_mm + 2 * LINE + 2.2;
  char text[16];
  cairo_set_line_width(cr, RULER_LINE);
  for (int mm = 0; mm <= (int)s->ruler_mm; mm += 10) {
    const bool is_end = mm == 0 || mm == (int)s->ruler_mm;
    cairo_move_to(cr, x + mm, y);
    cairo_rel_line_to(cr, 0, is_end || mm % 50 == 0 ? 4 : 2.5);
  }
  cairo_move_to(cr, x - RULER_LINE / 2, y);
  cairo_rel_line_to(cr, s->ruler_mm + RULER_LINE, 0);
  cairo_stroke(cr);
  hl_canvas_text(canvas, x, y + 4 + TEXT, 0, TEXT, "0");
  snprintf(text, sizeof text, "%g mm", s->ruler_mm);
  hl_canvas_text(canvas, x + s->ruler_mm, y + 4 + TEXT, 0.5, TEXT, text);
}

/* ---- the sheet ---- */

/* The sheet's canvas, whose units are millimetres. */
static hl_status open_canvas(hl_ctx *ctx, const hl_sheet *s, const char *path, hl_canvas *canvas)
{
  double scale = 1;
  double size[2] = {s->width_mm, s->height_mm};
  if (s->kind == HL_PICTURE_PDF)
    scale = 72 / INCH;
  else if (s->kind == HL_PICTURE_PNG)
    scale = s->dpi / INCH;
  for (int i = 0; i < 2; i++)
    size[i] = s->kind == HL_PICTURE_PNG ? hl_sheet_pixels(s, size[i]) : size[i] * scale;
  const hl_status st = hl_canvas_open(ctx, canvas, s->kind, path, size[0], size[1]);
  if (st != HL_OK)
    return st;
  if (s->kind == HL_PICTURE_SVG)
    cairo_svg_surface_set_document_unit(canvas->surface, CAIRO_SVG_UNIT_MM);
  if (s->kind == HL_PICTURE_PNG)
    canvas->dpi = s->dpi;
  cairo_scale(canvas->cr, scale, scale);
  return HL_OK;
}

hl_status hl_draw_target(hl_ctx *ctx, const hl_sheet *sheet, const char *path)
{
  hl_canvas canvas;
  hl_status st = open_canvas(ctx, sheet, path, &canvas);
  if (st != HL_OK)
    return st;
  if (sheet->kind == HL_PICTURE_PDF) {
    char spec[HL_TARGET_SPEC_MAX];
    cairo_pdf_surface_set_metadata(canvas.surface, CAIRO_PDF_METADATA_TITLE,
                                   hl_target_spec(&sheet->target, spec));
  }
  st = draw_pattern(ctx, canvas.cr, sheet);
  draw_caption(&canvas, sheet);
  draw_ruler(&canvas, sheet);
  const hl_status closed = hl_canvas_close(st == HL_OK ? ctx : NULL, &canvas);
  return st == HL_OK ? closed : st;
}
