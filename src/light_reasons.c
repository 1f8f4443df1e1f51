/* Whether to trust the answer and, where not, what a person can change, with figures.
 *
 * How much less to expose: a clipped lobe's height is not seen, but its flank is. With f the lobe where
 * clipping has ended, at angle u from the highlight, the bell that has the same value and slope there,
 * P exp(-x^2/w^2), peaks at P = f exp(-u f'/(2 f)); where clipping ends, at e < u, it exceeds the level by
 * exp(-u f'/(2 f) (e/u)^2). Of a clipped disc hl_light_clipped_to says 1.14 of its radius e: mean and two
 * deviations of the distance from its middle, 2/3 + 2/sqrt(18).
 */
#include <math.h>
#include <string.h>

#include "halflight/notes.h"
#include "halflight/vec3.h"
#include "light_work.h"

static const double deg = 57.295779513082320877;
static const double least_explained = 0.6;  /* of the variance */
static const double most_clipped = 0.7;     /* of the lit pixels */
static const double widest_ellipse_deg = 5; /* the half axis of a useful direction */
static const double behind_deg = 120;       /* from the view: a crescent is left of the lit side */
static const double least_stops = 0.5, most_stops = 9; /* that a flank can tell */
static const double structured_ratio = 2.5;
static const double lit_share = 0.02;    /* of the level */
static const double most_equal = 0.9;    /* of lit neighbours: codes too few to show shading */
static const double edge_share = 0.8787; /* e/u = 1 / (2/3 + 2/sqrt(18)) */

static double log2_of(double x)
{
  return log(x) / 0.69314718055994531;
}

/* Stops by which the lobe exceeds the saturation level; at least least_stops. */
static double stops_over(const struct hl_light_work *work, const hl_light *out)
{
  const double edge = hl_light_clipped_to(work);
  double most = least_stops;
  for (int k = 0; k < out->n_curves; k++) {
    const hl_curve *f = &out->curves[k];
    if (strcmp(f->lobe, "specular") != 0)
      continue;
    int i = 1;
    while (i + 3 < f->n && f->angle_rad[i] < edge)
      i++;
    if (!(f->value[i] > 0) || !(f->value[i + 2] > 0))
      continue;
    const double across = f->angle_rad[i + 2] - f->angle_rad[i];
    const double fall = log2_of(f->value[i] / f->value[i + 2]) / across;
    most = fmax(most, 0.5 * f->angle_rad[i] * fall * edge_share * edge_share);
  }
  return fmin(most, most_stops);
}

static void judge_clipping(const struct hl_light_work *work, hl_light *out)
{
  const hl_light_brightness *b = &work->brightness;
  const double clipped = b->lit > 0 ? (double)b->clipped / b->lit : 1;
  if (clipped > most_clipped)
    hl_notes_add(&out->reasons, "clipped",
                 "%.0f %% of the lit pixels are clipped: expose less, by %.1f stops or more",
                 100 * clipped, stops_over(work, out));
}

static hl_light_part largest_part(const hl_light *out)
{
  hl_light_part largest = HL_PART_NOISE;
  for (int i = 0; i < HL_PARTS; i++)
    if (out->part_95_rad[i][0] > out->part_95_rad[largest][0])
      largest = (hl_light_part)i;
  return largest;
}

/* What the noise's share asks for: `times` less of it. */
static void judge_noise(const struct hl_light_work *work, const hl_light *light, double times,
                        hl_notes *reasons)
{
  const double wide = light->part_95_rad[HL_PART_NOISE][0] * deg;
  const double angle = hl_angle(light->direction, light->mean_view) * deg;
  if (angle > behind_deg)
    hl_notes_add(reasons, "uncertain",
                 "known to %.1f deg (95 %%): the light is %.0f deg from the view, behind the ball: "
                 "move it, or the camera, to below %.0f deg",
                 wide, angle, behind_deg);
  else
    hl_notes_add(
        reasons, "uncertain",
        "known to %.1f deg (95 %%), by noise: average %.0f frames, expose %.1f stops more, "
        "or a ball of %.0f px across, now %.0f",
        wide, ceil(times * times), 2 * log2_of(times),
        ceil(times * 2 * sqrt(hl_light_pixels(&work->all) / 3.141592653589793)),
        2 * sqrt(hl_light_pixels(&work->all) / 3.141592653589793));
}

static void judge_width(const struct hl_light_work *work, const hl_light_spread *spread,
                        hl_light *out)
{
  const double wide = out->ellipse_95_rad[0] * deg;
  const hl_light_part part = largest_part(out);
  const double *axes = out->part_95_rad[part];
  if (wide < widest_ellipse_deg)
    return;
  if (!isfinite(wide))
    hl_notes_add(&out->reasons, "uncertain",
                 "the pixels do not bound the direction: a larger or glossier ball is needed");
  else if (part == HL_PART_NOISE)
    judge_noise(work, out, fmax(wide / widest_ellipse_deg, 1.05), &out->reasons);
  else if (part == HL_PART_MODEL)
    hl_notes_add(&out->reasons, "uncertain",
                 "known to %.1f deg (95 %%): the residual has structure, %.1f times noise (%.1f is "
                 "fair); models differ by %.1f and %.1f deg: look for a second light",
                 wide, spread->structure, structured_ratio, axes[0] * deg, axes[1] * deg);
  else
    hl_notes_add(&out->reasons, "uncertain",
                 part == HL_PART_POSE
                     ? "known to %.1f deg (95 %%), %.1f of it by the ball's pose: locate it more "
                       "exactly (a sharper outline, several frames)"
                     : "known to %.1f deg (95 %%), %.1f of it by the camera's intrinsics: "
                       "calibrate with more views",
                 wide, axes[0] * deg);
}

/* Shading in a handful of codes is steps, which no noise hides: neighbours then hold the same value. */
static void judge_codes(const struct hl_light_work *work, hl_light *out)
{
  const double rounding = 1e-9; /* of the area taken off and added again */
  const bool aside = work->on_cells;
  const hl_light_data *d = aside ? &work->aside.all : &work->all;
  const int *index = aside ? work->aside.index : work->index;
  const double *area = aside ? work->aside.area[0] : work->area[0], *y = d->value[0];
  long pairs = 0, equal = 0;
  for (int i = 1; i < d->n; i++)
    if (index[i] == index[i - 1] + 1 && !d->clipped[i] && !d->clipped[i - 1] && y[i] > lit_share &&
        y[i - 1] > lit_share) {
      pairs++;
      equal += fabs(y[i] + area[i] - y[i - 1] - area[i - 1]) < rounding;
    }
  if (pairs > 0 && (double)equal > most_equal * (double)pairs)
    hl_notes_add(&out->reasons, "codes",
                 "%.0f %% of neighbouring lit pixels hold the same value: too few codes; expose "
                 "more, or record more bits",
                 100.0 * (double)equal / (double)pairs);
}

void hl_light_judge(const struct hl_light_work *work, const hl_light_settled *settled,
                    const hl_light_spread *spread, hl_light *out)
{
  judge_clipping(work, out);
  judge_codes(work, out);
  if (!(spread->explained > least_explained))
    hl_notes_add(&out->reasons, "model",
                 "the model explains %.0f %% of the ball's variation only: not a ball of one "
                 "material under one light, or a wrong pose",
                 100 * fmax(0, spread->explained));
  if (!settled->variant[settled->kept].converged)
    hl_notes_add(&out->reasons, "not converged",
                 "the direction still moved after the last iteration");
  judge_width(work, spread, out);
  if (settled->outliers > settled->sought / 4)
    hl_notes_add(&out->reasons, "outliers",
                 "%.0f %% of the pixels do not fit: something covers "
                 "the ball, or the room is reflected in it",
                 100.0 * settled->outliers / settled->sought);
  out->trusted = out->reasons.n == 0;
}
