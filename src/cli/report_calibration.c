/* The report of a camera's calibration, from CAMERA.json. */
#include <math.h>
#include <string.h>

#include "report.h"

/* "value +- deviation"; the deviation is the root of the covariance's diagonal. */
static void put_parameter(hl_page *page, const json_t *document, const char *name, double value,
                          size_t place)
{
  const json_t *row = json_array_get(json_object_get(document, "covariance"), place);
  const json_t *variance = json_array_get(row, place);
  if (json_is_number(variance) && json_number_value(variance) >= 0)
    hl_page_fact(page, name, "%.7g \302\261 %.2g", value, sqrt(json_number_value(variance)));
  else
    hl_page_fact(page, name, "%.7g (deviation not stated)", value);
}

static void put_camera(hl_page *page, const json_t *d)
{
  static const char *const named[] = {"fx", "fy", "cx", "cy"};
  static const char *const titles[] = {"fx [px]", "fy [px]", "cx [px]", "cy [px]"};
  static const char *const opencv[] = {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"};
  static const char *const fisheye[] = {"k1", "k2", "k3", "k4"};
  const json_t *distortion = json_object_get(d, "distortion");
  const bool is_fisheye = strcmp(hl_json_text_of(d, "model"), "fisheye") == 0;
  hl_page_heading(page, "The camera");
  hl_page_facts_begin(page);
  hl_page_fact(page, "Model", "%s, %.0f x %.0f px", hl_json_text_of(d, "model"),
               hl_json_double(d, "width"), hl_json_double(d, "height"));
  for (size_t i = 0; i < 4; i++)
    put_parameter(page, d, titles[i], hl_json_double(d, named[i]), i);
  for (size_t i = 0; i < json_array_size(distortion) && i < (is_fisheye ? 4U : 8U); i++)
    put_parameter(page, d, is_fisheye ? fisheye[i] : opencv[i],
                  json_number_value(json_array_get(distortion, i)), 4 + i);
  hl_page_facts_end(page);
}

static void put_fit(hl_page *page, const json_t *d)
{
  char text[32];
  hl_page_heading(page, "The fit");
  hl_page_facts_begin(page);
  hl_page_fact(page, "Residual", "rms %s px", hl_figure(hl_json_double(d, "rms_px"), text));
  hl_page_fact(page, "Corners", "%.0f used, %.0f left out", hl_json_double(d, "corners_used"),
               hl_json_double(d, "corners_left_out"));
  hl_page_fact(page, "Noise of a corner", "%s px a coordinate",
               hl_figure(hl_json_double(d, "noise_px"), text));
  if (isfinite(hl_json_double(d, "coverage")))
    hl_page_fact(page, "Coverage", "corners in %.0f %% of the frame's cells",
                 100 * hl_json_double(d, "coverage"));
  if (isfinite(hl_json_double(d, "tilt_deg")))
    hl_page_fact(page, "Tilt", "views up to %.0f deg against each other",
                 hl_json_double(d, "tilt_deg"));
  if (hl_json_text_of(d, "target")[0])
    hl_page_fact(page, "Target", "%s", hl_json_text_of(d, "target"));
  hl_page_facts_end(page);
}

static void put_projection(hl_page *page, const json_t *list)
{
  static const char *const columns[] = {"Pixel", "Distance [m]", "Deviation [px]"};
  if (json_array_size(list) == 0)
    return;
  hl_page_heading(page, "How sure the projection is");
  hl_page_table_begin(page, columns, 3, 1);
  for (size_t i = 0; i < json_array_size(list); i++) {
    const json_t *at = json_array_get(list, i);
    double pixel[2];
    char name[64], text[32];
    hl_json_doubles(at, "pixel", 2, pixel);
    snprintf(name, sizeof name, "%.1f, %.1f", pixel[0], pixel[1]);
    hl_page_row_begin(page, false, name);
    const double distance = hl_json_double(at, "distance_m");
    hl_page_cell(page, "Distance [m]", true, "%s",
                 isfinite(distance) ? hl_figure(distance, text) : "infinity");
    hl_page_cell(page, "Deviation [px]", true, "%s", hl_figure(hl_json_double(at, "sd_px"), text));
    hl_page_row_end(page);
  }
  hl_page_table_end(page);
}

static void put_views(hl_page *page, const json_t *views)
{
  static const char *const columns[] = {"View", "Verdict", "Corners", "rms [px]"};
  if (json_array_size(views) == 0)
    return;
  hl_page_heading(page, "Every view");
  hl_page_table_begin(page, columns, 4, 2);
  for (size_t i = 0; i < json_array_size(views); i++) {
    const json_t *view = json_array_get(views, i);
    const bool used = hl_json_is_true(view, "used");
    char text[32];
    hl_page_row_begin(page, !used, hl_json_text_of(view, "file"));
    hl_page_cell(page, "Verdict", false, "%s%s",
                 used ? "used" : "left out: ", used ? "" : hl_json_text_of(view, "why"));
    hl_page_cell(page, "Corners", true, "%.0f of %.0f", hl_json_double(view, "corners"),
                 hl_json_double(view, "seen"));
    hl_page_cell(page, "rms [px]", true, "%s", hl_figure(hl_json_double(view, "rms_px"), text));
    hl_page_row_end(page);
  }
  hl_page_table_end(page);
}

hl_status hl_report_calibration(hl_ctx *ctx, const hl_report_source *source, hl_page *page)
{
  const json_t *d = source->document;
  const char *status = hl_json_text_of(d, "status");
  const bool good = strcmp(status, "ok") == 0;
  if (!json_is_number(json_object_get(d, "fx")) || !json_is_array(json_object_get(d, "distortion")))
    return hl_fail(ctx, HL_ERR_FORMAT, "%s: fx or distortion is missing", source->path);
  hl_page_element(page, "h1", NULL, "Camera calibration");
  if (!status[0])
    hl_page_verdict(page, false, "The file holds a camera without a verdict.", NULL,
                    "Only halflight calibrate states one; nothing is known of how sure this camera "
                    "is beyond the covariance, if there is one.");
  else
    hl_page_verdict(page, good,
                    good ? "The calibration can be used." : "The calibration is not to be trusted.",
                    json_object_get(d, "reasons"),
                    good ? NULL
                         : "Take more views: the board tilted by 20 to 45 degrees in several "
                           "directions, its corners all over the frame, sharp.");
  hl_page_picture(page, "calibration");
  hl_page_no_pictures(page, "halflight calibrate --out DIR/");
  put_camera(page, d);
  put_fit(page, d);
  put_projection(page, json_object_get(d, "projection_uncertainty"));
  put_views(page, json_object_get(d, "views"));
  hl_page_notes(page, "Used", json_object_get(d, "used"));
  hl_page_notes(page, "Left out", json_object_get(d, "left_out"));
  return HL_OK;
}
