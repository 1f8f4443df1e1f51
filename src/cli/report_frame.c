/* The report of one frame, from LIGHT.json and the evidence beside it. */
#include <math.h>
#include <string.h>

#include "report.h"
#include "report_dome.h"

static const double DEGREES = 180 / 3.14159265358979323846;

static void put_direction(hl_page *page, const json_t *light, const json_t *fit)
{
  double s[3], axes[2], view[3];
  hl_json_doubles(light, "direction", 3, s);
  hl_json_doubles(light, "ellipse_95_deg", 2, axes);
  hl_page_fact(page, "Direction, camera", "%.6f, %.6f, %.6f (x right, y down, z forward)", s[0],
               s[1], s[2]);
  hl_page_fact(page, "Direction, .lp", "%.6f, %.6f, %.6f (x right, y up, z to the camera)", s[0],
               -s[1] + 0.0, -s[2] + 0.0);
  double azimuth = atan2(-s[1], s[0]) * DEGREES;
  azimuth += azimuth < 0 ? 360 : 0;
  hl_json_doubles(fit, "mean_view", 3, view);
  const double cosine = s[0] * view[0] + s[1] * view[1] + s[2] * view[2];
  if (isfinite(cosine))
    hl_page_fact(page, "Angle from the view", "%.2f deg",
                 acos(fmin(fmax(cosine, -1), 1)) * DEGREES);
  hl_page_fact(page, "Azimuth", "%.2f deg (0 right, 90 up)", azimuth);
  if (isfinite(axes[0]) && isfinite(axes[1]))
    hl_page_fact(page, "95 % ellipse", "half axes %.3g and %.3g deg", axes[0], axes[1]);
}

/* What each source of uncertainty would leave alone. */
static void put_parts(hl_page *page, const json_t *light)
{
  static const char *const parts[][2] = {{"noise", "Noise alone"},
                                         {"model", "Model misfit alone"},
                                         {"pose", "Ball's pose alone"},
                                         {"camera", "Camera alone"}};
  const json_t *stated = json_object_get(light, "ellipse_parts_deg");
  for (int i = 0; json_is_object(stated) && i < 4; i++) {
    double axes[2];
    hl_json_doubles(stated, parts[i][0], 2, axes);
    if (isfinite(axes[0]) && isfinite(axes[1]))
      hl_page_fact(page, parts[i][1], "%.2g and %.2g deg", axes[0], axes[1]);
    else
      hl_page_fact(page, parts[i][1], "not stated, and so counted as none");
  }
  double color[3], position[3];
  hl_json_doubles(light, "color", 3, color);
  if (isfinite(color[0]) && isfinite(color[1]) && isfinite(color[2]))
    hl_page_fact(page, "Colour", "%.3f, %.3f, %.3f (red, green, blue; largest 1)", color[0],
                 color[1], color[2]);
  hl_json_doubles(light, "position_m", 3, position);
  if (isfinite(position[0]))
    hl_page_fact(page, "Position", "%.4g, %.4g, %.4g m, camera frame", position[0], position[1],
                 position[2]);
}

static void put_fit(hl_page *page, const json_t *fit)
{
  const json_t *evidence = json_object_get(fit, "evidence");
  const json_t *unique = json_object_get(fit, "identifiability");
  hl_page_facts_begin(page);
  hl_page_fact(page, "Pixels", "%.0f samples used, %.0f pixels clipped, %.0f left out",
               hl_json_double(fit, "pixels"), hl_json_double(fit, "clipped"),
               hl_json_double(fit, "outliers"));
  hl_page_fact(page, "Relative error", "%.3g %%", 100 * hl_json_double(fit, "relative_error"));
  hl_page_fact(page, "Evidence", "highlight %.1f %%, shading %.1f %%",
               100 * hl_json_double(evidence, "highlight"),
               100 * hl_json_double(evidence, "shading"));
  hl_page_fact(page, "Lobe", "%s", hl_json_text_of(fit, "lobe"));
  hl_page_fact(page, "Reflectance", "%s", hl_json_text_of(unique, "verdict"));
  if (hl_json_text_of(unique, "proposition")[0])
    hl_page_fact(page, "By", "%s", hl_json_text_of(unique, "proposition"));
  if (hl_json_text_of(unique, "free")[0])
    hl_page_fact(page, "Stays free", "%s", hl_json_text_of(unique, "free"));
  hl_page_facts_end(page);
}

static void put_times(hl_page *page, const json_t *times)
{
  static const char *const steps[] = {"read", "locate", "estimate", "export"};
  if (!json_is_object(times))
    return;
  hl_page_heading(page, "Time");
  hl_page_facts_begin(page);
  for (int i = 0; i < 4; i++)
    hl_page_fact(page, steps[i], "%.1f ms", hl_json_double(times, steps[i]));
  hl_page_facts_end(page);
}

static void put_pictures(hl_page *page)
{
  static const char *const panels[] = {"measured", "fitted", "residual", "normals", "mask"};
  if (!page->evidence)
    return;
  hl_page_heading(page, "Fit and photo");
  fputs("<div class=\"panels\">\n", page->out);
  for (int i = 0; i < 5; i++)
    hl_page_picture(page, panels[i]);
  fputs("</div>\n", page->out);
  hl_page_heading(page, "Reflectance");
  fputs("<div class=\"pair\">\n", page->out);
  hl_page_picture(page, "specular");
  hl_page_picture(page, "diffuse");
  fputs("</div>\n", page->out);
}

static void put_guide(hl_page *page)
{
  hl_page_heading(page, "How to read this");
  hl_page_element(
      page, "p", NULL,
      "The ellipse holds the true direction with a probability of 95 %, as far as noise, "
      "the model's misfit, the ball's pose and the camera are stated. Where the residual "
      "shows rings or a second bright spot, the model misfits or there is a second light, "
      "and the error may be larger than the ellipse.");
  hl_page_element(
      page, "p", NULL,
      "A term is used only where it earns its place; the tables say what was used and what "
      "was left out, with the figure that decided.");
}

hl_status hl_report_frame(hl_ctx *ctx, const hl_report_source *source, hl_page *page)
{
  const json_t *d = source->document;
  const json_t *light = json_array_get(json_object_get(d, "lights"), 0);
  const bool good = strcmp(hl_json_text_of(d, "status"), "ok") == 0;
  hl_dome_light dome;
  if (!json_is_array(json_object_get(d, "lights")) || !json_is_object(json_object_get(d, "fit")))
    return hl_fail(ctx, HL_ERR_FORMAT, "%s: lights or fit is missing", source->path);
  hl_page_element(page, "h1", NULL, "The light of one frame");
  hl_page_verdict(page, good, good ? "The answer can be used." : "The answer is not to be trusted.",
                  json_object_get(d, "reasons"),
                  good ? NULL
                       : "The figures below are the best that could be had from this frame.");
  const bool has_dome = hl_dome_light_read(light, "the light", good, &dome);
  fputs("<div class=\"pair\">\n", page->out);
  hl_page_picture(page, "photo");
  if (has_dome)
    hl_page_dome(page, &dome, 1);
  fputs("</div>\n", page->out);
  hl_page_no_pictures(page, "halflight estimate --out DIR");
  if (light) {
    hl_page_heading(page, "The light");
    hl_page_facts_begin(page);
    if (has_dome)
      put_direction(page, light, json_object_get(d, "fit"));
    put_parts(page, light);
    hl_page_facts_end(page);
  }
  put_pictures(page);
  hl_page_heading(page, "The fit");
  put_fit(page, json_object_get(d, "fit"));
  const json_t *used = json_object_get(page->evidence, "used");
  hl_page_notes(page, "Used", used ? used : json_object_get(d, "used"));
  hl_page_notes(page, "Left out", json_object_get(d, "left_out"));
  put_times(page, json_object_get(d, "timing_ms"));
  put_guide(page);
  return HL_OK;
}
