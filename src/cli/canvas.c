/* A sheet to draw on, in one of three file kinds. */
#include <math.h>
#include <string.h>

#include <cairo-pdf.h>
#include <cairo-svg.h>

#include "draw.h"
#include "png_density.h"

static bool ends_with(const char *text, const char *end)
{
  const size_t n = strlen(text);
  const size_t m = strlen(end);
  return n > m && strcmp(text + n - m, end) == 0;
}

hl_status hl_picture_kind_of(hl_ctx *ctx, const char *option, const char *path,
                             hl_picture_kind *out)
{
  if (ends_with(path, ".png"))
    *out = HL_PICTURE_PNG;
  else if (ends_with(path, ".svg"))
    *out = HL_PICTURE_SVG;
  else if (ends_with(path, ".pdf"))
    *out = HL_PICTURE_PDF;
  else
    return hl_fail(ctx, HL_ERR_ARG, "--%s %s: a name that ends in .png, .svg or .pdf is needed",
                   option, path);
  return HL_OK;
}

static hl_status cairo_failed(hl_ctx *ctx, const hl_canvas *canvas, cairo_status_t status)
{
  return hl_fail(ctx, HL_ERR_IO, "%s: the picture cannot be written: %s", canvas->path,
                 cairo_status_to_string(status));
}

hl_status hl_canvas_open(hl_ctx *ctx, hl_canvas *canvas, hl_picture_kind kind, const char *path,
                         double width, double height)
{
  canvas->kind = kind;
  canvas->path = path;
  canvas->dpi = 0;
  if (kind == HL_PICTURE_PNG) {
    canvas->surface = cairo_image_surface_create(CAIRO_FORMAT_RGB24, (int)width, (int)height);
  } else if (kind == HL_PICTURE_SVG) {
    canvas->surface = cairo_svg_surface_create(path, width, height);
  } else {
    canvas->surface = cairo_pdf_surface_create(path, width, height);
    /* without a date the same result gives the same bytes */
    cairo_pdf_surface_set_metadata(canvas->surface, CAIRO_PDF_METADATA_CREATE_DATE, "");
  }
  canvas->cr = cairo_create(canvas->surface);
  const cairo_status_t status = cairo_status(canvas->cr);
  if (status != CAIRO_STATUS_SUCCESS) {
    cairo_destroy(canvas->cr);
    cairo_surface_destroy(canvas->surface);
    return cairo_failed(ctx, canvas, status);
  }
  cairo_set_source_rgb(canvas->cr, 1, 1, 1);
  cairo_paint(canvas->cr);
  cairo_select_font_face(canvas->cr, "sans-serif", CAIRO_FONT_SLANT_NORMAL,
                         CAIRO_FONT_WEIGHT_NORMAL);
  return HL_OK;
}

hl_status hl_canvas_close(hl_ctx *ctx, hl_canvas *canvas)
{
  cairo_status_t status = cairo_status(canvas->cr);
  cairo_destroy(canvas->cr);
  if (status == CAIRO_STATUS_SUCCESS && canvas->kind == HL_PICTURE_PNG)
    status = hl_png_write(canvas->surface, canvas->path, canvas->dpi);
  cairo_surface_finish(canvas->surface);
  if (status == CAIRO_STATUS_SUCCESS)
    status = cairo_surface_status(canvas->surface);
  cairo_surface_destroy(canvas->surface);
  return status == CAIRO_STATUS_SUCCESS ? HL_OK : cairo_failed(ctx, canvas, status);
}

void hl_canvas_text(const hl_canvas *canvas, double x, double y, double align, double size,
                    const char *text)
{
  cairo_text_extents_t extents;
  cairo_set_font_size(canvas->cr, size);
  cairo_text_extents(canvas->cr, text, &extents);
  cairo_move_to(canvas->cr, x - align * extents.x_advance, y);
  cairo_show_text(canvas->cr, text);
}

double hl_canvas_step(double rough)
{
  const double base = pow(10, floor(log10(rough)));
  const double m = rough / base;
  return base * (m <= 1 ? 1 : m <= 2 ? 2 : m <= 5 ? 5 : 10);
}
