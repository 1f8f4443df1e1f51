/* The report of a replayed session, from LIGHTS.json. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "draw_lights.h"
#include "report.h"
#include "report_dome.h"
#include "summary.h"

static const double DEGREES = 180 / 3.14159265358979323846;

/* One array of figures a light, in the session's order. */
typedef struct session_figures {
  int n, n_found, n_good;
  hl_dome_light *dome; /* shape (n_found) */
  double *major_deg, *minor_deg, *intensity;
  bool *good;
} session_figures;

static void free_figures(session_figures *f)
{
  free(f->dome);
  free(f->major_deg);
  free(f->minor_deg);
  free(f->intensity);
  free(f->good);
}

static double mean_intensity(const json_t *light)
{
  double rgb[3];
  hl_json_doubles(light, "intensity", 3, rgb);
  return isfinite(rgb[1]) && isfinite(rgb[2]) ? (rgb[0] + rgb[1] + rgb[2]) / 3 : rgb[0];
}

static hl_status read_figures(hl_ctx *ctx, const json_t *lights, session_figures *f)
{
  f->n = (int)json_array_size(lights);
  const size_t room = (size_t)f->n + 1;
  f->dome = calloc(room, sizeof *f->dome);
  f->major_deg = calloc(room, sizeof *f->major_deg);
  f->minor_deg = calloc(room, sizeof *f->minor_deg);
  f->intensity = calloc(room, sizeof *f->intensity);
  f->good = calloc(room, sizeof *f->good);
  if (!f->dome || !f->major_deg || !f->minor_deg || !f->intensity || !f->good)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for %d lights", f->n);
  for (int i = 0; i < f->n; i++) {
    const json_t *light = json_array_get(lights, (size_t)i);
    const bool found = hl_json_is_true(light, "found");
    double axes[2];
    hl_json_doubles(light, "ellipse_95_rad", 2, axes);
    f->good[i] = found && hl_json_is_true(light, "trusted");
    f->n_good += f->good[i];
    f->major_deg[i] = found ? axes[0] * DEGREES : NAN;
    f->minor_deg[i] = found ? axes[1] * DEGREES : NAN;
    f->intensity[i] = found ? mean_intensity(light) : NAN;
    if (found)
      f->n_found += hl_dome_light_read(light, hl_json_text_of(light, "file"), f->good[i],
                                       f->dome + f->n_found);
  }
  return HL_OK;
}

static hl_status put_charts(hl_ctx *ctx, const hl_report_source *source, hl_page *page,
                            const session_figures *f)
{
  const hl_bars ellipse = {"95 % half axes [deg]", f->n, f->minor_deg, f->major_deg, f->good, true};
  const hl_bars intensity = {"intensity", f->n, f->intensity, NULL, f->good, false};
  const hl_evidence_picture pictures[2] = {
      {"ellipses", "How sure each direction is",
       "From the smaller to the larger half axis of each light's 95 % ellipse. Blue discs: to be "
       "trusted; vermillion squares: not.",
       true, HL_PICTURE_SVG, hl_draw_bars, &ellipse},
      {"intensities", "How bright each light is",
       "Each light's intensity, mean of the channels, relative to the session's. Blue discs: to be "
       "trusted; vermillion squares: not.",
       true, HL_PICTURE_SVG, hl_draw_bars, &intensity}};
  hl_page drawn = {page->out, source->drawn->document};
  hl_status st = HL_OK;
  fputs("<div class=\"pair\">\n", page->out);
  for (int i = 0; i < 2 && st == HL_OK; i++) {
    st = hl_evidence_add(ctx, source->drawn, pictures + i);
    hl_page_picture(&drawn, pictures[i].name);
  }
  fputs("</div>\n", page->out);
  return st;
}

/* All reasons in one line of a table's cell. */
static void join_reasons(const json_t *reasons, char *out, size_t size)
{
  out[0] = '\0';
  for (size_t i = 0, n = 0; i < json_array_size(reasons) && n < size; i++) {
    const json_t *r = json_array_get(reasons, i);
    const int more = snprintf(out + n, size - n, "%s%s: %s", i ? "; " : "",
                              hl_json_text_of(r, "what"), hl_json_text_of(r, "why"));
    n += more > 0 ? (size_t)more : 0;
  }
}

static void put_light(hl_page *page, const session_figures *f, int i, const json_t *light)
{
  const bool found = hl_json_is_true(light, "found");
  char reasons[600], figure[32];
  double s[3];
  hl_json_doubles(light, "direction", 3, s);
  join_reasons(json_object_get(light, "reasons"), reasons, sizeof reasons);
  hl_page_row_begin(page, !f->good[i], hl_json_text_of(light, "file"));
  hl_page_cell(page, "Verdict", false, "%s%s%s",
               f->good[i] ? "to be trusted"
               : found    ? "not to be trusted"
                          : "no light",
               reasons[0] ? ": " : "", reasons);
  if (found) {
    hl_page_cell(page, "Direction (.lp)", true, "%.5f %.5f %.5f", s[0], -s[1] + 0.0, -s[2] + 0.0);
    hl_page_cell(page, "95 % half axes [deg]", true, "%.3g, %.3g", f->major_deg[i],
                 f->minor_deg[i]);
    hl_page_cell(page, "Intensity", true, "%s", hl_figure(f->intensity[i], figure));
  } else {
    hl_page_cell(page, "Direction (.lp)", true, "none");
    hl_page_cell(page, "95 % half axes [deg]", true, "none");
    hl_page_cell(page, "Intensity", true, "none");
  }
  hl_page_row_end(page);
}

static void put_balls(hl_page *page, const json_t *balls)
{
  if (json_array_size(balls) == 0)
    return;
  hl_page_heading(page, "Balls");
  hl_page_facts_begin(page);
  for (size_t i = 0; i < json_array_size(balls); i++) {
    const json_t *ball = json_array_get(balls, i);
    double c[3];
    char name[32];
    hl_json_doubles(ball, "center_m", 3, c);
    snprintf(name, sizeof name, "Ball %d", (int)i);
    hl_page_fact(page, name, "centre %.6f, %.6f, %.6f m (camera frame), radius %.6g m", c[0], c[1],
                 c[2], hl_json_double(ball, "radius_m"));
  }
  hl_page_facts_end(page);
}

/* HL_ERR_FORMAT, HL_ERR_MEMORY, as reading the document. */
static hl_status put_dome(hl_ctx *ctx, const hl_report_source *source, hl_page *page)
{
  hl_lights lights;
  char text[400];
  if (!json_is_object(json_object_get(source->document, "dome")))
    return HL_OK;
  const hl_status st = hl_lights_read(ctx, source->path, &lights);
  if (st != HL_OK)
    return st;
  hl_page_heading(page, "What they stand on");
  hl_page_facts_begin(page);
  hl_summary_dome_text(&lights, text, sizeof text);
  hl_page_fact(page, "Shape", "%s", text);
  if (hl_summary_off_dome(&lights, text, sizeof text))
    hl_page_fact(page, "Off it", "%s", text);
  hl_page_facts_end(page);
  hl_lights_free(&lights);
  return HL_OK;
}

static void put_verdict(hl_page *page, const json_t *d, const session_figures *f)
{
  const bool good = hl_json_is_true(d, "trusted");
  char text[160];
  snprintf(text, sizeof text, "%d of %d frames gave a light, %d of them to be trusted.", f->n_found,
           f->n, f->n_good);
  hl_page_verdict(page, good, text, json_object_get(d, "reasons"),
                  good
                      ? NULL
                      : "The other lights can be used. The table says what stood against each that "
                        "cannot; expose or place those lights anew, or leave them out.");
}

hl_status hl_report_session(hl_ctx *ctx, const hl_report_source *source, hl_page *page)
{
  static const char *const columns[] = {"Frame", "Verdict", "Direction (.lp)",
                                        "95 % half axes [deg]", "Intensity"};
  const json_t *d = source->document, *lights = json_object_get(d, "lights");
  session_figures f = {0};
  if (!json_is_array(lights))
    return hl_fail(ctx, HL_ERR_FORMAT, "%s: lights is no list", source->path);
  hl_status st = read_figures(ctx, lights, &f);
  if (st == HL_OK) {
    hl_page_element(page, "h1", NULL, "The lights of a session");
    put_verdict(page, d, &f);
    hl_page_dome(page, f.dome, f.n_found);
    hl_page_heading(page, "Uncertainty and brightness");
    st = put_charts(ctx, source, page, &f);
  }
  if (st == HL_OK) {
    hl_page_heading(page, "Every light");
    hl_page_element(page, "p", "quiet",
                    "Directions are those of .lp files: x right, y up, z to the "
                    "camera, from the ball to the light.");
    hl_page_table_begin(page, columns, 5, 2);
    for (int i = 0; i < f.n; i++)
      put_light(page, &f, i, json_array_get(lights, (size_t)i));
    hl_page_table_end(page);
    st = put_dome(ctx, source, page);
  }
  if (st == HL_OK) {
    put_balls(page, json_object_get(d, "balls"));
    hl_page_notes(page, "Used", json_object_get(d, "used"));
    hl_page_notes(page, "Left out", json_object_get(d, "left_out"));
  }
  free_figures(&f);
  return st;
}
