/* A calibration in words: numbers with their deviations, views, and how sure a pixel is. */
#include "summary_calibration.h"

#include <math.h>
#include <string.h>

#include "summary.h"

enum { STANDARD = 5 }; /* pixels whose uncertainty every calibration states: centre and corners */

static double deviation(const hl_camera *c, int k)
{
  return sqrt(c->covariance[k * hl_camera_intrinsics_count(c) + k]);
}

/* A value to one digit more than its deviation has. */
static void with_deviation(char *out, size_t size, double value, double sd)
{
  const int digits = sd > 0 ? (int)fmin(fmax(2 - ceil(log10(sd)), 0), 9) : 6;
  snprintf(out, size, "%.*f +- %.2g", digits, value, sd);
}

static void print_intrinsics(FILE *out, const hl_camera *c)
{
  static const char *const pairs[] = {"focal length", "centre"};
  static const char *const names[3][HL_DISTORTION_MAX] = {
      [HL_LENS_PINHOLE] = {"k1", "k2", "p1", "p2", "k3"},
      [HL_LENS_RATIONAL] = {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"},
      [HL_LENS_FISHEYE] = {"k1", "k2", "k3", "k4"},
  };
  double theta[HL_INTRINSICS_MAX];
  char text[200], x[64], y[64];
  hl_camera_intrinsics(c, theta);
  for (int i = 0; i < 2; i++) {
    with_deviation(x, sizeof x, theta[2 * i], deviation(c, 2 * i));
    with_deviation(y, sizeof y, theta[2 * i + 1], deviation(c, 2 * i + 1));
    snprintf(text, sizeof text, "%s, %s px", x, y);
    hl_summary_line(out, pairs[i], text);
  }
  for (int k = 0; k < c->n_distortion; k++) {
    with_deviation(x, sizeof x, c->distortion[k], deviation(c, 4 + k));
    snprintf(text, sizeof text, "%s %s", names[c->model][k], x);
    hl_summary_line(out, k == 0 ? "distortion" : "", text);
  }
}

static void print_views(FILE *out, const hl_calibration *c)
{
  char text[HL_VIEW_NAME_MAX + HL_REASON_MAX + 80];
  int used = 0;
  for (int i = 0; i < c->n_views; i++)
    used += c->view[i].used;
  snprintf(text, sizeof text, "rms %.3g px over %d corners, %d left out", c->camera.rms_px,
           c->corners_used, c->corners_left_out);
  hl_summary_line(out, "fit", text);
  snprintf(text, sizeof text, "%d of %d used, tilted by up to %.0f deg against each other", used,
           c->n_views, c->tilt_deg);
  hl_summary_line(out, "views", text);
  for (int i = 0; i < c->n_views; i++) {
    if (c->view[i].used)
      continue;
    snprintf(text, sizeof text, "without %s: %s", c->view[i].name, c->view[i].why);
    hl_summary_line(out, "", text);
  }
  snprintf(text, sizeof text, "corners in %.0f %% of the frame's cells", 100 * c->coverage);
  hl_summary_line(out, "coverage", text);
}

/* The larger half axis of the one-sigma ellipse. */
static double largest(const hl_projection *p)
{
  const double(*v)[2] = p->covariance_px2;
  return sqrt((v[0][0] + v[1][1]) / 2 + hypot((v[0][0] - v[1][1]) / 2, v[0][1]));
}

static void at_distance(char *out, size_t size, double distance_m)
{
  if (isfinite(distance_m))
    snprintf(out, size, "at %.3g m", distance_m);
  else
    snprintf(out, size, "at infinity");
}

static void print_projection(FILE *out, const hl_calibration *c)
{
  char text[160], where[48];
  int next = 0;
  for (; next + STANDARD <= c->n_projections && next < 2 * STANDARD; next += STANDARD) {
    double most = 0;
    for (int i = 1; i < STANDARD; i++)
      most = fmax(most, largest(&c->projection[next + i]));
    at_distance(where, sizeof where, c->projection[next].distance_m);
    snprintf(text, sizeof text, "+- %.2g px at the frame's centre, %.2g px at its corners, %s",
             largest(&c->projection[next]), most, where);
    hl_summary_line(out, next == 0 ? "projection" : "", text);
  }
  for (; next < c->n_projections; next++) {
    const hl_projection *p = &c->projection[next];
    at_distance(where, sizeof where, p->distance_m);
    snprintf(text, sizeof text, "+- %.2g px at pixel %.6g, %.6g %s", largest(p), p->pixel[0],
             p->pixel[1], where);
    hl_summary_line(out, "", text);
  }
}

void hl_summary_calibration(FILE *out, const hl_calibration *c)
{
  static const char *const models[] = {"pinhole", "rational", "fisheye"};
  char text[160];
  snprintf(text, sizeof text, "%s, %d x %d px", models[c->camera.model], c->camera.width,
           c->camera.height);
  hl_summary_line(out, "camera", text);
  print_intrinsics(out, &c->camera);
  print_views(out, c);
  print_projection(out, c);
  hl_summary_notes(out, "used", &c->used);
  hl_summary_notes(out, "left out", &c->left_out);
  if (!c->trusted)
    hl_summary_notes(out, "NOT TRUSTED", &c->reasons);
}
