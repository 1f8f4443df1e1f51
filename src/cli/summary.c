/* Plain text, aligned, within 80 columns. */
#include "summary.h"

#include <string.h>

#include "halflight/vec3.h"

enum { WIDTH = 79, COLUMN = 14 };

static const double degrees = 180 / 3.14159265358979323846;

/* Words after a label, wrapped under each other. */
static void print_line(FILE *out, const char *label, const char *text)
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

static void print_notes(FILE *out, const char *label, const hl_notes *notes)
{
  for (int i = 0; i < notes->n; i++) {
    const hl_note *note = &notes->note[i];
    char text[sizeof note->what + sizeof note->why + 3];
    snprintf(text, sizeof text, "%s%s%s", note->what, note->what[0] && note->why[0] ? ": " : "",
             note->why);
    print_line(out, i == 0 ? label : "", text);
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
  print_line(out, "", text);
  snprintf(text, sizeof text, "95 %% ellipse, half axes %.3g and %.3g deg",
           light->ellipse_95_rad[0] * degrees, light->ellipse_95_rad[1] * degrees);
  print_line(out, "", text);
}

static void print_fit(FILE *out, const hl_light *light)
{
  static const char *const lobes[] = {"none", "plain, f(n.h)", "foreshortened, f(n.h) / (n.v)"};
  static const char *const verdicts[] = {"unique", "ambiguous", "not guaranteed"};
  char text[400];
  if (light->channels == 3) {
    snprintf(text, sizeof text, "%.3f %.3f %.3f (red, green, blue; largest 1)", light->color[0],
             light->color[1], light->color[2]);
    print_line(out, "colour", text);
  }
  print_line(out, "lobe", lobes[light->lobe]);
  snprintf(text, sizeof text, "highlight %.1f %%, shading %.1f %%", 100 * light->evidence_highlight,
           100 * (1 - light->evidence_highlight));
  print_line(out, "evidence", text);
  snprintf(text, sizeof text, "relative error %.2f %%, %d pixels, %d clipped, %d outliers",
           100 * light->relative_error, light->n_pixels, light->n_clipped, light->n_outliers);
  print_line(out, "fit", text);
  snprintf(text, sizeof text, "%s%s%s%s%s%s", verdicts[light->verdict],
           light->proposition ? " (" : "", light->proposition ? light->proposition : "",
           light->proposition ? ")" : "",
           light->stays_free && light->stays_free[0] ? "; free: " : "",
           light->stays_free ? light->stays_free : "");
  print_line(out, "reflectance", text);
}

void hl_summary_light(FILE *out, const hl_light *light, const hl_timing *timing)
{
  char text[160];
  print_direction(out, light);
  print_fit(out, light);
  print_notes(out, "used", &light->used);
  print_notes(out, "left out", &light->left_out);
  if (!light->trusted)
    print_notes(out, "NOT TRUSTED", &light->reasons);
  snprintf(text, sizeof text, "read %.1f, locate %.1f, estimate %.1f, export %.1f ms",
           timing->read_ms, timing->locate_ms, timing->estimate_ms, timing->export_ms);
  print_line(out, "time", text);
}

void hl_summary_sphere(FILE *out, const hl_sphere *sphere, const hl_sphere_fit *fit)
{
  const double *c = sphere->center_m;
  char text[200];
  snprintf(text, sizeof text, "%.6f %.6f %.6f m (x right, y down, z forward)", c[0], c[1], c[2]);
  print_line(out, "centre", text);
  if (sphere->has_covariance) {
    snprintf(text, sizeof text, "+- %.2g %.2g %.2g m", sqrt(sphere->covariance_m2[0][0]),
             sqrt(sphere->covariance_m2[1][1]), sqrt(sphere->covariance_m2[2][2]));
    print_line(out, "", text);
  }
  snprintf(text, sizeof text, "%.6g m", sphere->radius_m);
  print_line(out, "radius", text);
  snprintf(text, sizeof text, "centre %.3f, %.3f px, radius %.3f px", fit->center_px[0],
           fit->center_px[1], fit->radius_px);
  print_line(out, "outline", text);
  snprintf(text, sizeof text, "rms %.3f px over %d points, %.0f %% of the rim seen", fit->rms_px,
           fit->n_points, 100 * fit->arc);
  print_line(out, "", text);
}
