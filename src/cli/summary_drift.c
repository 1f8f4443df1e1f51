/* A drift check in words: the verdict, what moved by how much and how sure, what was not compared. */
#include "summary_drift.h"

#include <math.h>
#include <string.h>

#include "halflight/vec3.h"
#include "summary.h"

static const double degrees = 180 / 3.14159265358979323846;

enum { TEXT_MAX = 320 };

/* How one number of a part is written. */
typedef struct number_style {
  const char *name[3];
  double factor;
  const char *unit;
} number_style;

static bool is(const hl_drift_cause *cause, const char *part)
{
  return strcmp(cause->part, part) == 0;
}

/* NULL: not number by number. */
static const number_style *style_of(const hl_drift_cause *cause)
{
  static const number_style focal = {{"fx", "fy", NULL}, 1, "px"};
  static const number_style centre = {{"cx", "cy", NULL}, 1, "px"};
  static const number_style rotation = {
      {"about x", "about y", "about z"}, 180 / 3.14159265358979323846, "deg"};
  static const number_style translation = {{"x", "y", "z"}, 1e3, "mm"};
  return is(cause, "focal length")  ? &focal
         : is(cause, "centre")      ? &centre
         : is(cause, "rotation")    ? &rotation
         : is(cause, "translation") ? &translation
                                    : NULL;
}

/* Metres as a person says them. */
static void write_figure(const hl_drift_cause *cause, double figure, char *out, size_t size)
{
  if (strcmp(cause->unit, "m") == 0)
    snprintf(out, size, "%.3g mm", 1e3 * figure);
  else
    snprintf(out, size, "%.3g %s", figure, cause->unit);
}

/* "+3.50 +- 0.11": as many digits as the deviation is worth. */
static int write_number(double value, double sigma, char *out, size_t size)
{
  const int digits = sigma > 0 ? (int)fmin(9, fmax(0, 1 - floor(log10(sigma)))) : 4;
  return snprintf(out, size, "%+.*f +- %.*f", digits, value, digits, sigma);
}

static void print_moved(FILE *out, const char *label, const hl_drift_cause *cause,
                        const hl_camera *reference)
{
  const number_style *style = style_of(cause);
  char text[TEXT_MAX], figure[40];
  write_figure(cause, cause->figure, figure, sizeof figure);
  size_t n = (size_t)snprintf(text, sizeof text, "%s by %s", cause->part, figure);
  if (is(cause, "focal length"))
    n += (size_t)snprintf(
        text + n, sizeof text - n, " (%+.3g %%)",
        50 * (cause->change[0] / reference->fx + cause->change[1] / reference->fy));
  for (int i = 0; style && i < cause->n && n + 80 < sizeof text; i++) {
    n += (size_t)snprintf(text + n, sizeof text - n, "%s%s ", i == 0 ? ": " : ", ", style->name[i]);
    n += (size_t)write_number(style->factor * cause->change[i], style->factor * cause->sigma[i],
                              text + n, sizeof text - n);
    n += (size_t)snprintf(text + n, sizeof text - n, " %s", style->unit);
  }
  if (!style) {
    write_figure(cause, cause->threshold, figure, sizeof figure);
    snprintf(text + n, sizeof text - n, " rms where it was looked at; noise explains %s", figure);
  }
  hl_summary_line(out, label, text);
}

static void print_still(FILE *out, const char *label, const hl_drift_cause *cause)
{
  char text[TEXT_MAX], figure[40], threshold[40];
  write_figure(cause, cause->figure, figure, sizeof figure);
  write_figure(cause, cause->threshold, threshold, sizeof threshold);
  if (isnan(cause->threshold))
    snprintf(text, sizeof text, "%s: cannot be told", cause->part);
  else
    snprintf(text, sizeof text, "%s: %s, and noise alone explains %s", cause->part, figure,
             threshold);
  hl_summary_line(out, label, text);
}

static void print_causes(FILE *out, const hl_drift *drift, const hl_camera *reference)
{
  const char *label = "moved";
  for (int i = 0; i < drift->n_causes; i++) {
    if (!drift->cause[i].moved)
      continue;
    print_moved(out, label, &drift->cause[i], reference);
    label = "";
  }
  label = "unmoved";
  for (int i = 0; i < drift->n_causes; i++) {
    if (drift->cause[i].moved)
      continue;
    print_still(out, label, &drift->cause[i]);
    label = "";
  }
}

static void print_difference(FILE *out, const hl_drift *drift)
{
  char text[TEXT_MAX];
  size_t n = (size_t)snprintf(text, sizeof text, "%s: mean %.3g px, largest %.3g px",
                              drift->columns > 0 ? "over the frame" : "at the board's corners",
                              drift->mean_px, drift->max_px);
  if (drift->columns > 0)
    n += (size_t)snprintf(text + n, sizeof text - n, ", after a rotation of %.3g deg",
                          degrees * hl_norm(drift->implied.rotation_rad));
  if (drift->columns > 0 && hl_norm(drift->implied.translation_m) > 0)
    snprintf(text + n, sizeof text - n, " and a translation of %.3g mm that best explain it",
             1e3 * hl_norm(drift->implied.translation_m));
  else if (drift->columns > 0)
    snprintf(text + n, sizeof text - n, " that best explains it");
  hl_summary_line(out, "projection", text);
}

void hl_summary_drift(FILE *out, const hl_drift *drift, const hl_camera *reference)
{
  char text[TEXT_MAX];
  if (drift->significance > 0)
    snprintf(text, sizeof text,
             "%s: where nothing moved, as large a difference has probability %.2g (alarm below %g)",
             drift->drifted ? "DRIFTED" : "same", drift->significance, drift->false_alarm);
  else
    snprintf(text, sizeof text,
             "DRIFTED: where nothing moved, as large a difference has probability below 1e-300 "
             "(alarm below %g)",
             drift->false_alarm);
  hl_summary_line(out, "verdict", text);
  print_causes(out, drift, reference);
  print_difference(out, drift);
  hl_summary_notes(out, "notes", &drift->notes);
}

void hl_summary_verdict(const hl_drift *drift, char *out, size_t size)
{
  size_t n = (size_t)snprintf(out, size, "%s", drift->drifted ? "drifted" : "same");
  if (!drift->drifted) {
    snprintf(out + n, size - n, ": the difference has probability %.2g where nothing moved",
             drift->significance);
    return;
  }
  const char *link = ": ";
  for (int i = 0; i < drift->n_causes && n + 80 < size; i++) {
    char figure[40];
    if (!drift->cause[i].moved)
      continue;
    write_figure(&drift->cause[i], drift->cause[i].figure, figure, sizeof figure);
    n += (size_t)snprintf(out + n, size - n, "%s%s by %s", link, drift->cause[i].part, figure);
    link = ", ";
  }
}

void hl_summary_board_pose(FILE *out, const hl_board_pose *pose)
{
  const double *r = pose->cam_from_board.rotation_rad, *t = pose->cam_from_board.translation_m;
  char text[TEXT_MAX];
  snprintf(text, sizeof text, "first corner at %.6f %.6f %.6f m (x right, y down, z forward)", t[0],
           t[1], t[2]);
  hl_summary_line(out, "board", text);
  snprintf(text, sizeof text, "+- %.2g %.2g %.2g m, the camera held", sqrt(pose->covariance[3][3]),
           sqrt(pose->covariance[4][4]), sqrt(pose->covariance[5][5]));
  hl_summary_line(out, "", text);
  snprintf(text, sizeof text, "turned by %.3f deg", degrees * hl_norm(r));
  hl_summary_line(out, "", text);
  snprintf(text, sizeof text, "%d, rms %.3f px", pose->corners, pose->rms_px);
  hl_summary_line(out, "corners", text);
}
