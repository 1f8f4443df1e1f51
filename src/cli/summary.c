/* Plain text, aligned, within 80 columns. */
#include "summary.h"

#include <string.h>

#include "halflight/vec3.h"

enum { WIDTH = 79, COLUMN = 14 };

static const double degrees = 180 / 3.14159265358979323846;

void hl_summary_line(FILE *out, const char *label, const char *text)
{
  int at = fprintf(out, "%-*s", COLUMN, label);
  const char *c = text;
  while (*c) {
    const int word = (int)strcspn(c, " ");
    if (at > COLUMN && at + 1 + word > WIDTH)
      at = fprintf(out, "\n%*s", COLUMN, "") - 1;
    else if (at > COLUMN)
      at += fprintf(out, " ");
    at += fprintf(out, "%.*s", word, c);
    c += word;
    c += strspn(c, " ");
  }
  fputc('\n', out);
}

void hl_summary_notes(FILE *out, const char *label, const hl_notes *notes)
{
  for (int i = 0; i < notes->n; i++) {
    const hl_note *note = &notes->note[i];
    char text[sizeof note->what + sizeof note->why + 3];
    snprintf(text, sizeof text, "%s%s%s", note->what, note->what[0] && note->why[0] ? ": " : "",
             note->why);
    hl_summary_line(out, i == 0 ? label : "", text);
  }
}

void hl_summary_reasons(const hl_notes *reasons, char *out, size_t size)
{
  size_t n = 0;
  out[0] = '\0';
  for (int i = 0; i < reasons->n && n < size; i++) {
    const hl_note *note = &reasons->note[i];
    const int more = snprintf(out + n, size - n, "%s%s%s%s", i > 0 ? "; " : "", note->what,
                              note->what[0] && note->why[0] ? ": " : "", note->why);
    n += more > 0 ? (size_t)more : 0;
  }
  if (reasons->n == 0)
    snprintf(out, size, "no reason stated");
}

/* One part of the ellipse alone: its half axes, or that nothing is known of it. */
static void part_text(const hl_light *light, hl_light_part part, char *out, size_t size)
{
  static const char *const names[HL_PARTS] = {"noise", "model", "pose", "camera"};
  const double *axes = light->part_95_rad[part];
  if (light->part_stated[part])
    snprintf(out, size, "%s %.2g and %.2g", names[part], axes[0] * degrees, axes[1] * degrees);
  else
    snprintf(out, size, "%s not stated", names[part]);
}

static void print_parts(FILE *out, const hl_light *light)
{
  for (int i = 0; i < HL_PARTS; i += 2) {
    char one[48], two[48], text[120];
    part_text(light, (hl_light_part)i, one, sizeof one);
    part_text(light, (hl_light_part)(i + 1), two, sizeof two);
    snprintf(text, sizeof text, i == 0 ? "alone: %s, %s," : "%s, %s", one, two);
    hl_summary_line(out, "", text);
  }
}

static void print_direction(FILE *out, const hl_light *light)
{
  const double *s = light->direction;
  const double *h = light->half_angle_direction;
  double view[3]; /* the mean view is s mirrored at h */
  char text[160];
  for (int i = 0; i < 3; i++)
    view[i] = 2 * hl_dot(h, s) * h[i] - s[i];
  snprintf(text, sizeof text, "%9.6f %9.6f %9.6f  camera: x right, y down, z forward", s[0], s[1],
           s[2]);
  fprintf(out, "%-*s%s\n", COLUMN, "light", text);
  fprintf(out, "%-*s%9.6f %9.6f %9.6f  .lp: x right, y up, z to the camera\n", COLUMN, "", s[0],
          -s[1] + 0.0, -s[2] + 0.0);
  double azimuth = atan2(-s[1], s[0]) * degrees;
  azimuth += azimuth < 0 ? 360 : 0;
  snprintf(text, sizeof text, "%.2f deg from the view, azimuth %.2f deg (0 right, 90 up)",
           hl_angle(s, view) * degrees, azimuth);
  hl_summary_line(out, "", text);
  snprintf(text, sizeof text, "95 %% ellipse, half axes %.3g and %.3g deg",
           light->ellipse_95_rad[0] * degrees, light->ellipse_95_rad[1] * degrees);
  hl_summary_line(out, "", text);
  print_parts(out, light);
  if (light->efficiency > 0) {
    snprintf(text, sizeof text, "noise part: %.0f %% of what free curves allow at best",
             100 * light->efficiency);
    hl_summary_line(out, "", text);
  }
}

static void print_fit(FILE *out, const hl_light *light)
{
  static const char *const lobes[] = {"none", "plain, f(n.h)", "foreshortened, f(n.h) / (n.v)"};
  static const char *const verdicts[] = {"unique", "ambiguous", "not guaranteed"};
  char text[400];
  if (light->channels == 3) {
    snprintf(text, sizeof text, "%.3f %.3f %.3f (red, green, blue; largest 1)", light->color[0],
             light->color[1], light->color[2]);
    hl_summary_line(out, "colour", text);
  }
  hl_summary_line(out, "lobe", lobes[light->lobe]);
  snprintf(text, sizeof text, "highlight %.1f %%, shading %.1f %%", 100 * light->evidence_highlight,
           100 * (1 - light->evidence_highlight));
  hl_summary_line(out, "evidence", text);
  snprintf(text, sizeof text, "relative error %.2f %%, %d pixels, %d clipped, %d outliers",
           100 * light->relative_error, light->n_pixels, light->n_clipped, light->n_outliers);
  hl_summary_line(out, "fit", text);
  snprintf(text, sizeof text, "%s%s%s%s%s%s", verdicts[light->verdict],
           light->proposition ? " (" : "", light->proposition ? light->proposition : "",
           light->proposition ? ")" : "",
           light->stays_free && light->stays_free[0] ? "; free: " : "",
           light->stays_free ? light->stays_free : "");
  hl_summary_line(out, "reflectance", text);
}

void hl_summary_light(FILE *out, const hl_light *light, const hl_timing *timing)
{
  char text[160];
  print_direction(out, light);
  print_fit(out, light);
  hl_summary_notes(out, "used", &light->used);
  hl_summary_notes(out, "left out", &light->left_out);
  if (!light->trusted)
    hl_summary_notes(out, "NOT TRUSTED", &light->reasons);
  snprintf(text, sizeof text, "read %.1f, locate %.1f, estimate %.1f, export %.1f ms",
           timing->read_ms, timing->locate_ms, timing->estimate_ms, timing->export_ms);
  hl_summary_line(out, "time", text);
}

static void print_deviations(FILE *out, const double covariance[3][3], const char *of)
{
  char text[160];
  snprintf(text, sizeof text, "+- %.2g %.2g %.2g m%s", sqrt(covariance[0][0]),
           sqrt(covariance[1][1]), sqrt(covariance[2][2]), of);
  hl_summary_line(out, "", text);
}

void hl_summary_sphere(FILE *out, const hl_sphere *sphere, const hl_sphere_fit *fit)
{
  const double *c = sphere->center_m;
  char text[200];
  snprintf(text, sizeof text, "%.6f %.6f %.6f m (x right, y down, z forward)", c[0], c[1], c[2]);
  hl_summary_line(out, "centre", text);
  if (sphere->has_covariance)
    print_deviations(out, (const double(*)[3])sphere->covariance_m2, "");
  if (sphere->n_intrinsics > 0)
    print_deviations(out, (const double(*)[3])sphere->held_covariance_m2, " with the camera held");
  snprintf(text, sizeof text, "%.6g m", sphere->radius_m);
  hl_summary_line(out, "radius", text);
  snprintf(text, sizeof text, "centre %.3f, %.3f px, radius %.3f px", fit->center_px[0],
           fit->center_px[1], fit->radius_px);
  hl_summary_line(out, "outline", text);
  snprintf(text, sizeof text, "rms %.3f px over %d points, %.0f %% of the rim seen", fit->rms_px,
           fit->n_points, 100 * fit->arc);
  hl_summary_line(out, "", text);
}

/* ---- fits ---- */

static void print_term(FILE *out, const hl_fit *fit, int i)
{
  const hl_term *term = &fit->term[i];
  const double *a = term->direction;
  char text[240];
  const int n = snprintf(text, sizeof text, "%9.6f %9.6f %9.6f  ", a[0], a[1], a[2]);
  snprintf(text + n, sizeof text - (size_t)n, "%s%s%s%s",
           term->role == HL_TERM_LINEAR ? "linear" : "lobe", term->name[0] ? " about " : "",
           term->name, term->foreshortened ? ", over n.v" : "");
  fprintf(out, "%-*s%s\n", COLUMN, i == 0 ? "terms" : "", text);
  if (fit->channels == 1)
    snprintf(text, sizeof text, "strength %.4g, gain %.3g %% of the variance", term->strength[0],
             100 * term->gain);
  else
    snprintf(text, sizeof text, "strength %.4g %.4g %.4g, gain %.3g %% of the variance",
             term->strength[0], term->strength[1], term->strength[2], 100 * term->gain);
  hl_summary_line(out, "", text);
}

static void print_sizes(FILE *out, const hl_fit *fit)
{
  if (fit->n_sizes == 0)
    return;
  fprintf(out, "%-*sterms  error   unexplained  left out (cross-validated)\n", COLUMN, "sizes");
  for (int i = 0; i < fit->n_sizes; i++) {
    const hl_fit_size *s = &fit->size[i];
    fprintf(out, "%-*s%5d  %5.2f %%  %9.4f %%  %9.4f %%\n", COLUMN, "", s->terms,
            100 * s->relative_error, 100 * s->unexplained_variance, 100 * s->cross_validated);
  }
}

void hl_summary_fit(FILE *out, const hl_fit *fit)
{
  static const char *const verdicts[] = {"unique", "ambiguous", "not guaranteed"};
  char text[400];
  if (fit->has_light) {
    snprintf(text, sizeof text, "%9.6f %9.6f %9.6f  %s", fit->light[0], fit->light[1],
             fit->light[2], fit->light_given ? "given" : "from the lobes");
    fprintf(out, "%-*s%s\n", COLUMN, "light", text);
  }
  for (int i = 0; i < fit->n_terms; i++)
    print_term(out, fit, i);
  print_sizes(out, fit);
  snprintf(text, sizeof text, "relative error %.3g %%, unexplained variance %.3g %%, %d samples",
           100 * fit->relative_error, 100 * fit->unexplained_variance, fit->n_samples);
  hl_summary_line(out, "fit", text);
  snprintf(text, sizeof text, "%s (%s); free: %s", verdicts[fit->verdict], fit->proposition,
           fit->stays_free);
  hl_summary_line(out, "reflectance", text);
  snprintf(text, sizeof text, "directions to %.2g deg, condition %.3g, least angle %.3g deg",
           fit->direction_sigma_rad * degrees, fit->condition, fit->least_angle_rad * degrees);
  hl_summary_line(out, "", text);
  hl_summary_notes(out, "used", &fit->used);
  hl_summary_notes(out, "left out", &fit->left_out);
  if (!fit->trusted)
    hl_summary_notes(out, "NOT TRUSTED", &fit->reasons);
  snprintf(text, sizeof text, "read %.1f, estimate %.1f ms", fit->read_ms, fit->estimate_ms);
  hl_summary_line(out, "time", text);
}
