/* What stands below the photo: the light, how far to trust it, and what the marks mean. */
#include <stdio.h>

#include "draw.h"
#include "marks.h"
#include "summary.h"

static const double PI = 3.14159265358979323846;
static const double MARGIN = 14;
static const double TEXT = 15;

enum { LINE = HL_CAPTION_LINE };

/* One sample of a line and what it is, wrapped to the sheet; moves the pen. */
static void legend_entry(const hl_canvas *canvas, double width, double pen[2], hl_ink mark,
                         const char *text)
{
  cairo_t *cr = canvas->cr;
  cairo_text_extents_t extents;
  cairo_set_font_size(cr, TEXT);
  cairo_text_extents(cr, text, &extents);
  if (pen[0] > MARGIN && pen[0] + 34 + extents.x_advance > width - MARGIN) {
    pen[0] = MARGIN;
    pen[1] += LINE;
  }
  const double x = pen[0];
  const double y = pen[1] - 5;
  const double from[2] = {x, y};
  const double to[2] = {x + 24, y};
  if (mark == HL_INK_OUTLINE) {
    cairo_move_to(cr, x, y);
    cairo_line_to(cr, x + 24, y);
    hl_marks_stroke(cr, HL_INK_OUTLINE, 1.6);
  } else if (mark == HL_INK_HIGHLIGHT) {
    hl_marks_cross(cr, x + 12, y);
  } else if (mark == HL_INK_LIGHT) {
    hl_marks_arrow(cr, from, to);
  } else {
    cairo_save(cr);
    cairo_translate(cr, x + 12, y);
    cairo_scale(cr, 12, 6);
    cairo_new_sub_path(cr);
    cairo_arc(cr, 0, 0, 1, 0, 2 * PI);
    cairo_restore(cr);
    hl_marks_stroke(cr, HL_INK_ELLIPSE, 1.4);
  }
  cairo_set_source_rgb(cr, HL_TEXT_GREY);
  hl_canvas_text(canvas, x + 34, pen[1], 0, TEXT, text);
  pen[0] = x + 34 + extents.x_advance + 26;
}

static void describe_light(const hl_light *light, char *out, size_t size)
{
  const double *d = light->direction;
  const double degrees = 180 / PI;
  snprintf(out, size,
           "Light (%.4f, %.4f, %.4f): x right, y up, z to the camera.  95 %% ellipse %.2g\302\260 "
           "\303\227 %.2g\302\260",
           d[0], 0.0 - d[1], 0.0 - d[2], light->ellipse_95_rad[0] * degrees,
           light->ellipse_95_rad[1] * degrees);
}

/* Smaller letters where a line would not fit. */
static void caption_line(const hl_canvas *canvas, double width, double y, const char *text)
{
  cairo_text_extents_t extents;
  cairo_set_font_size(canvas->cr, TEXT);
  cairo_text_extents(canvas->cr, text, &extents);
  const double room = width - 2 * MARGIN;
  const double size = extents.x_advance > room ? TEXT * room / extents.x_advance : TEXT;
  hl_canvas_text(canvas, MARGIN, y, 0, size, text);
}

void hl_draw_caption(const hl_canvas *canvas, const hl_photo *p, int factor, double width,
                     double top)
{
  cairo_t *cr = canvas->cr;
  const bool lit = p->light && p->light->found;
  char text[HL_MESSAGE_MAX + 40];
  double pen[2] = {MARGIN, top + LINE};
  cairo_set_source_rgb(cr, HL_TEXT_GREY);
  if (lit) {
    describe_light(p->light, text, sizeof text);
    caption_line(canvas, width, pen[1], text);
    pen[1] += LINE;
  } else if (p->fit) {
    snprintf(text, sizeof text,
             "Ball at %.1f, %.1f px, radius %.1f px; outline rms %.2f px, %.0f %% of the rim seen",
             p->fit->center_px[0], p->fit->center_px[1], p->fit->radius_px, p->fit->rms_px,
             100 * p->fit->arc);
    caption_line(canvas, width, pen[1], text);
    pen[1] += LINE;
  }
  if (lit && !p->light->trusted) {
    char reasons[HL_MESSAGE_MAX];
    hl_summary_reasons(&p->light->reasons, reasons, sizeof reasons);
    snprintf(text, sizeof text, "Not to be trusted: %s", reasons);
    cairo_set_source_rgb(cr, 0.7, 0.1, 0);
    caption_line(canvas, width, pen[1], text);
    pen[1] += LINE;
  }
  if (p->sphere)
    legend_entry(canvas, width, pen, HL_INK_OUTLINE, "outline of the ball");
  if (!lit)
    return;
  legend_entry(canvas, width, pen, HL_INK_HIGHLIGHT, "highlight, n = h");
  legend_entry(canvas, width, pen, HL_INK_LIGHT, "to the light");
  if (factor > 1)
    snprintf(text, sizeof text, "95 %% ellipse of the highlight, %d \303\227 enlarged", factor);
  else
    snprintf(text, sizeof text, "95 %% ellipse of the highlight");
  if (factor > 0)
    legend_entry(canvas, width, pen, HL_INK_ELLIPSE, text);
}
