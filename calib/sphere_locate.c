/*
 * One ball in a frame: search, sub-pixel outline, pose, and the reasons to refuse.
 *
 * 1. Edge points (sphere_edges.c) and circles among them (sphere_search.c), best first.
 * 2. Each candidate's outline is read in sectors (sphere_outline.c) and its cone fitted to them
 *    (sphere_pose.c), in turn, until neither moves.
 * 3. The first that passes is the ball, unless another one, apart from it, passes as well.
 */
#include <math.h>
#include <string.h>

#include "halflight/vec3.h"
#include "sphere_camera.h"
#include "sphere_outline.h"
#include "sphere_search.h"

static const double round_rad = 6.28318530717958647692;

static const double sigma_floor_px = 0.05;
static const double agreement_needed = 0.9;
/* what a straight rim and a three-term profile leave of a true ball, from rendered balls */
static const double model_floor_px = 0.006;

enum {
  TRIES = 4,
  ITERATIONS = 12,
  SECTORS_MIN = 16,
  BLUR_SECTORS = 32,
  KEPT_MIN = 7,
  NEAR_ITERATIONS = 4
};
static const double settled_px = 3e-3, near_px = 0.35;

hl_sphere_settings hl_sphere_defaults(void)
{
  return (hl_sphere_settings){
      .min_radius_px = 8, .max_radius_px = 0, .min_arc = 0.3, .max_rms_px = 0.4};
}

static const hl_field fields[] = {
    {"min_radius_px", HL_FIELD_DOUBLE, offsetof(hl_sphere_settings, min_radius_px), 5, 65536, "px",
     "smallest image radius searched for", NULL},
    {"max_radius_px", HL_FIELD_DOUBLE, offsetof(hl_sphere_settings, max_radius_px), 0, 65536, "px",
     "largest image radius searched for, 0 for 0.75 of the frame's longer side", NULL},
    {"min_arc", HL_FIELD_DOUBLE, offsetof(hl_sphere_settings, min_arc), 0.1, 1, "",
     "least share of the outline that must be seen", NULL},
    {"max_rms_px", HL_FIELD_DOUBLE, offsetof(hl_sphere_settings, max_rms_px), 0.01, 10, "px",
     "largest accepted rms of the outline points", NULL},
    {"hint_x_px", HL_FIELD_DOUBLE, offsetof(hl_sphere_settings, hint_x_px), -65536, 131072, "px",
     "column of a circle near the outline's", NULL},
    {"hint_y_px", HL_FIELD_DOUBLE, offsetof(hl_sphere_settings, hint_y_px), -65536, 131072, "px",
     "row of a circle near the outline's", NULL},
    {"hint_radius_px", HL_FIELD_DOUBLE, offsetof(hl_sphere_settings, hint_radius_px), 0, 65536,
     "px", "radius of a circle near the outline's, 0 for none", NULL},
    {"blur_px", HL_FIELD_DOUBLE, offsetof(hl_sphere_settings, blur_px), 0, 10, "px",
     "blur of the outline where it is known, 0 to find it", NULL},
};

const hl_field_table *hl_sphere_fields(void)
{
  static const hl_field_table table = {"sphere", fields, (int)(sizeof fields / sizeof fields[0])};
  return &table;
}

typedef enum verdict { BALL, NO_OUTLINE, SHORT_ARC, LOOSE, NOT_ROUND } verdict;

/* One candidate's outcome. */
typedef struct attempt {
  verdict verdict;
  hl_cone cone;
  hl_cone_fit fit;
  double rad_per_px, arc, rms_px, kept_share, blur_px, sigma_px;
  double by_intrinsics[3]
                      [HL_INTRINSICS_MAX]; /* of the cone's steps, where the camera is uncertain */
  int n_kept;
} attempt;

typedef struct scene {
  const hl_frame *frame;
  const hl_camera *camera;
  hl_sphere_settings settings;
} scene;

static int gather_readings(const hl_outline_sector *s, int n, hl_cone_offset *out)
{
  int m = 0;
  for (int i = 0; i < n; i++)
    if (s[i].kind == HL_OUTLINE_EDGE)
      out[m++] = (hl_cone_offset){.azimuth_rad = s[i].azimuth_rad,
                                  .offset_rad = s[i].offset_px * s[i].rad_per_px,
                                  .sigma_rad = s[i].sigma_px * s[i].rad_per_px};
  return m;
}

static double mean_scale(const hl_outline_sector *s, int n)
{
  double sum = 0;
  int m = 0;
  for (int i = 0; i < n; i++)
    if (s[i].rad_per_px > 0) {
      sum += s[i].rad_per_px;
      m++;
    }
  return m > 0 ? sum / m : 0;
}

/* Share of what is known about edges near the circle that agrees with it. Edges that are well seen
 * but elsewhere count against it: an ellipse touches a circle, a ball lies on it. */
static double agreement(const hl_outline_sector *s, int n, const hl_cone_offset *r)
{
  double kept = 0, all = 0;
  for (int i = 0, m = 0; i < n; i++) {
    if (s[i].kind != HL_OUTLINE_EDGE && s[i].kind != HL_OUTLINE_ASTRAY)
      continue;
    const double sigma = hypot(s[i].sigma_px, sigma_floor_px);
    all += 1 / (sigma * sigma);
    if (s[i].kind != HL_OUTLINE_EDGE)
      continue;
    if (r[m].weight > 0 && fabs(s[i].offset_px) < 4 * hypot(sigma, 0.1))
      kept += 1 / (sigma * sigma);
    m++;
  }
  return all > 0 ? kept / all : 0;
}

static void judge(const hl_outline_sector *s, int n, const hl_cone_offset *r, int m,
                  const hl_sphere_settings *settings, attempt *a)
{
  a->n_kept = 0;
  for (int i = 0; i < m; i++)
    a->n_kept += r[i].weight > 0.3;
  a->arc = (double)a->n_kept / n;
  a->kept_share = agreement(s, n, r);
  a->rms_px = a->fit.rms_rad / a->rad_per_px;
  const double var = a->fit.covariance[0][0] + a->fit.covariance[1][1] + a->fit.covariance[2][2];
  a->sigma_px = sqrt(var) / a->rad_per_px;
  a->verdict = BALL;
  if (!(a->arc >= settings->min_arc) || a->n_kept < KEPT_MIN || !(a->sigma_px < 1))
    a->verdict = SHORT_ARC;
  else if (!(a->rms_px <= settings->max_rms_px) ||
           !(a->fit.excess_rad / a->rad_per_px <= 0.5 * settings->max_rms_px))
    a->verdict = LOOSE;
  else if (!(a->kept_share >= agreement_needed))
    a->verdict = NOT_ROUND;
  const double floor_rad = model_floor_px * a->rad_per_px;
  for (int i = 0; i < 3; i++)
    a->fit.covariance[i][i] += floor_rad * floor_rad;
}

/* One reading of all sectors and one step of the cone; the step's length in pixels, NaN where the
 * outline is lost. */
static double advance(const scene *sc, int n, const hl_outline_look *look, attempt *a,
                      hl_outline_sector *sectors, hl_cone_offset *readings, int *m)
{
  hl_outline_read(sc->frame, sc->camera, &a->cone, n, look, sectors);
  *m = gather_readings(sectors, n, readings);
  const double scale = mean_scale(sectors, n);
  a->arc = (double)*m / n;
  if (a->arc < 0.5 * sc->settings.min_arc || *m < 4 || !(scale > 0))
    return NAN;
  a->rad_per_px = scale;
  if (!hl_cone_fit_offsets(readings, *m, 3 * scale, &a->fit))
    return NAN;
  const double moved = hl_norm(a->fit.step) / scale;
  const hl_cone next = hl_cone_step(&a->cone, a->fit.step);
  if (!(moved < 20) || !(next.half_angle_rad > 0 && next.half_angle_rad < 1.4))
    return NAN;
  a->cone = next;
  return moved;
}

/* Blur about the one assumed; a small gain from none to little is noise's. */
static double refine_blur(const scene *sc, const hl_cone *cone, const hl_outline_look *look)
{
  const double b = look->blur_px;
  const double about[5] = {fmax(b - 0.3, 0), fmax(b - 0.15, 0.1), fmax(b, 0.2), fmax(b, 0.2) + 0.15,
                           fmax(b, 0.2) + 0.3};
  const hl_outline_look near = {.reach_px = look->reach_px, .wide = false};
  return hl_outline_blur(sc->frame, sc->camera, cone, BLUR_SECTORS, &near, about, 5);
}

/* A cone to start from, with the sectors to read and how far about it. */
static double begin_at(const scene *sc, const hl_cone *start, attempt *a, int *n)
{
  memset(a, 0, sizeof *a);
  a->cone = *start;
  a->rad_per_px = 1 / sqrt(sc->camera->fx * sc->camera->fy);
  const double about_px = a->cone.half_angle_rad / a->rad_per_px;
  const int sectors = (int)(round_rad * about_px / 10);
  *n = sectors < SECTORS_MIN              ? SECTORS_MIN
       : sectors > HL_OUTLINE_SECTORS_MAX ? HL_OUTLINE_SECTORS_MAX
                                          : sectors;
  return fmin(fmax(0.25 * about_px, 2.5), 3.5);
}

static void judge_settled(const scene *sc, const hl_outline_sector *sectors, int n,
                          hl_cone_offset *readings, int m, attempt *a)
{
  judge(sectors, n, readings, m, &sc->settings, a);
  if (sc->camera->has_covariance &&
      !hl_cone_by_intrinsics(sc->camera, &a->cone, readings, m, &a->fit, a->by_intrinsics))
    a->verdict = NO_OUTLINE;
}

/* The same where the cone is nearly right and the blur known; false: it is not. */
static bool settle_near(const scene *sc, const hl_cone *start, attempt *a)
{
  hl_outline_sector sectors[HL_OUTLINE_SECTORS_MAX] = {{.offset_px = 0}};
  hl_cone_offset readings[HL_OUTLINE_SECTORS_MAX];
  int n, m = 0;
  const double reach = begin_at(sc, start, a, &n);
  const hl_outline_look look = {.blur_px = sc->settings.blur_px,
                                .reach_px = reach + 1.5 * sc->settings.blur_px};
  double moved = HUGE_VAL, longest = 0;
  for (int it = 0; it < NEAR_ITERATIONS && moved > settled_px; it++) {
    moved = advance(sc, n, &look, a, sectors, readings, &m);
    if (!(moved >= 0))
      return false;
    longest = fmax(longest, moved);
  }
  if (!(longest <= near_px) || moved > settled_px)
    return false;
  a->blur_px = look.blur_px;
  judge_settled(sc, sectors, n, readings, m, a);
  return a->verdict == BALL;
}

/* Reads the outline and moves the cone to it until neither moves. */
static void settle(const scene *sc, const hl_cone *start, attempt *a)
{
  hl_outline_sector sectors[HL_OUTLINE_SECTORS_MAX];
  hl_cone_offset readings[HL_OUTLINE_SECTORS_MAX];
  int n, m = 0;
  const double reach = begin_at(sc, start, a, &n);
  hl_outline_look look = {.reach_px = reach + 1, .wide = true};
  static const double blurs[] = {0.2, 0.7, 1.3, 2};
  look.blur_px = hl_outline_blur(sc->frame, sc->camera, &a->cone, SECTORS_MIN / 2, &look, blurs, 4);
  a->verdict = NO_OUTLINE;
  bool settled = false;
  int blur_reads = 0;
  for (int it = 0; it < ITERATIONS && !settled; it++) {
    look.reach_px = reach + 1.5 * look.blur_px;
    const double moved = advance(sc, n, &look, a, sectors, readings, &m);
    if (!(moved >= 0))
      return;
    if (blur_reads < (look.blur_px > 0.4 ? 3 : 2) && moved < 0.7) {
      look.blur_px = refine_blur(sc, &a->cone, &look);
      blur_reads++;
    }
    settled = moved < settled_px && blur_reads >= 2;
    look.wide = moved > 0.7 && it < 3;
  }
  a->blur_px = look.blur_px;
  judge_settled(sc, sectors, n, readings, m, a);
}

/* The outline's centre and mean radius in pixels. */
static hl_status describe(hl_ctx *ctx, const scene *sc, const attempt *a, hl_sphere_fit *out)
{
  hl_sphere_fit fit = {
      .rms_px = a->rms_px, .arc = a->arc, .n_points = a->n_kept, .blur_px = a->blur_px};
  const hl_status st = hl_camera_project(ctx, sc->camera, a->cone.axis, fit.center_px);
  if (st != HL_OK)
    return st;
  const double s = sin(a->cone.half_angle_rad), c = cos(a->cone.half_angle_rad);
  int n = 0;
  for (int i = 0; i < 32; i++) {
    const double az = round_rad * i / 32;
    double ray[3], p[2];
    for (int k = 0; k < 3; k++)
      ray[k] = c * a->cone.axis[k] + s * (cos(az) * a->cone.e1[k] + sin(az) * a->cone.e2[k]);
    if (hl_camera_project(NULL, sc->camera, ray, p) != HL_OK)
      continue;
    fit.radius_px += hypot(p[0] - fit.center_px[0], p[1] - fit.center_px[1]);
    n++;
  }
  fit.radius_px /= n > 0 ? n : 1;
  *out = fit;
  return HL_OK;
}

/* A background or ball at saturation has no edge that can be read. */
static double clipped_percent(const hl_frame *f)
{
  return 100 * (double)f->n_clipped / ((double)f->width * f->height * f->channels);
}

static hl_status refuse(hl_ctx *ctx, const scene *sc, const attempt *a, double coverage)
{
  hl_sphere_fit at;
  static const char help[] = "--circle X,Y,R near the outline or --sphere would help";
  if (a->verdict == NO_OUTLINE || describe(NULL, sc, a, &at) != HL_OK)
    return hl_fail(ctx, HL_ERR_DEGENERATE,
                   "no outline of a ball was found (%.0f %% of the frame is clipped); the best "
                   "circle shows %.0f %% of one, at least %.0f %% is needed; %s",
                   clipped_percent(sc->frame), 100 * fmin(a->arc > 0 ? a->arc : coverage, coverage),
                   100 * sc->settings.min_arc, help);
  const double x = at.center_px[0], y = at.center_px[1], r = at.radius_px;
  switch (a->verdict) {
  case SHORT_ARC:
    if (a->arc >= sc->settings.min_arc)
      return hl_fail(ctx, HL_ERR_DEGENERATE,
                     "the best circle, at %.0f,%.0f radius %.0f px, is uncertain by %.1f px "
                     "from %d outline points, at most 1 px from at least %d is accepted; %s",
                     x, y, r, a->sigma_px, a->n_kept, KEPT_MIN, help);
    return hl_fail(ctx, HL_ERR_DEGENERATE,
                   "the best circle, at %.0f,%.0f radius %.0f px, shows %.1f %% of its "
                   "outline, at least %.0f %% is needed; %s",
                   x, y, r, 100 * a->arc, 100 * sc->settings.min_arc, help);
  case LOOSE:
    return hl_fail(ctx, HL_ERR_RESIDUAL,
                   "the best outline, at %.0f,%.0f radius %.0f px, is off a ball's by %.2f "
                   "px rms (%.2f px beyond noise), at most %.2f px (half of it beyond noise) is "
                   "accepted; %s",
                   x, y, r, a->rms_px, a->fit.excess_rad / a->rad_per_px, sc->settings.max_rms_px,
                   help);
  case NOT_ROUND:
    return hl_fail(ctx, HL_ERR_RESIDUAL,
                   "only %.0f %% of the edge about the best circle, at %.0f,%.0f radius %.0f "
                   "px, is a ball's, at least %.0f %% is needed; %s",
                   100 * a->kept_share, x, y, r, 100 * agreement_needed, help);
  case BALL:
  case NO_OUTLINE:
    break;
  }
  return hl_fail(ctx, HL_ERR_DEGENERATE, "no ball");
}

/* Is this candidate a ball of its own, beside the one found? */
static bool apart(const attempt *a, const hl_candidate *c)
{
  const double larger = fmax(a->cone.half_angle_rad, c->cone.half_angle_rad);
  return hl_angle(a->cone.axis, c->cone.axis) > 0.9 * larger;
}

static hl_status choose(hl_ctx *ctx, const scene *sc, const hl_candidate *c, int n, attempt *out)
{
  attempt best = {.verdict = NO_OUTLINE}, other;
  int at = -1;
  for (int i = 0; i < n && i < TRIES && at < 0; i++) {
    if (c[i].coverage < 0.6 * sc->settings.min_arc)
      continue;
    settle(sc, &c[i].cone, &other);
    if (i == 0 || other.verdict == BALL || best.verdict == NO_OUTLINE)
      best = other;
    if (other.verdict == BALL)
      at = i;
  }
  if (at < 0)
    return refuse(ctx, sc, &best, n > 0 ? c[0].coverage : 0);
  for (int i = at + 1; i < n; i++) {
    if (c[i].score < 0.4 * c[at].score || !apart(&best, &c[i]))
      continue;
    settle(sc, &c[i].cone, &other);
    if (other.verdict != BALL || !apart(&best, &c[i]))
      continue;
    hl_sphere_fit one, two;
    if (describe(NULL, sc, &best, &one) != HL_OK || describe(NULL, sc, &other, &two) != HL_OK)
      continue;
    return hl_fail(ctx, HL_ERR_DEGENERATE,
                   "two balls look equally good, at %.0f,%.0f radius %.0f px and at %.0f,%.0f "
                   "radius %.0f px; choose one with --circle X,Y,R or give its pose with --sphere",
                   one.center_px[0], one.center_px[1], one.radius_px, two.center_px[0],
                   two.center_px[1], two.radius_px);
  }
  hl_trace(ctx, "locate: blur %.2f px, agreement %.2f, excess %.4f px", best.blur_px,
           best.kept_share, best.fit.excess_rad / best.rad_per_px);
  *out = best;
  return HL_OK;
}

static hl_status check_input(hl_ctx *ctx, const hl_frame *f, const hl_camera *c, double radius_m,
                             const hl_sphere_settings *s)
{
  if (!(radius_m > 0) || !isfinite(radius_m))
    return hl_fail(ctx, HL_ERR_ARG, "radius_m = %.6g, a finite number > 0 is needed", radius_m);
  if (f->width != c->width || f->height != c->height)
    return hl_fail(ctx, HL_ERR_ARG,
                   "the frame is %d x %d, the camera %d x %d; a camera calibrated at the frame's "
                   "size is needed",
                   f->width, f->height, c->width, c->height);
  hl_status st = hl_camera_check(ctx, c);
  if (st == HL_OK)
    st = hl_fields_check(ctx, hl_sphere_fields(), s);
  if (st != HL_OK || s->max_radius_px == 0 || s->max_radius_px > s->min_radius_px)
    return st;
  return hl_fail(ctx, HL_ERR_ARG,
                 "max_radius_px = %.6g px; 0 or above min_radius_px = %.6g is needed",
                 s->max_radius_px, s->min_radius_px);
}

static hl_status search(hl_ctx *ctx, const hl_frame *frame, const scene *sc, hl_candidate *found,
                        int *n)
{
  const hl_sphere_settings *s = &sc->settings;
  const int longer = frame->width > frame->height ? frame->width : frame->height;
  const hl_search_range range = {s->min_radius_px,
                                 s->max_radius_px > 0 ? s->max_radius_px : 0.75 * longer,
                                 {s->hint_x_px, s->hint_y_px, s->hint_radius_px}};
  hl_edges edges;
  hl_status st = hl_edges_find(ctx, frame, &edges);
  if (st != HL_OK)
    return st;
  const int n_edges = edges.found;
  st = hl_search_circles(ctx, &edges, sc->camera, &range, found, n);
  hl_edges_free(&edges);
  if (st != HL_OK || *n > 0)
    return st;
  if (range.hint[2] > 0)
    return hl_fail(ctx, HL_ERR_DEGENERATE,
                   "no outline near the circle at %.0f,%.0f radius %.0f px (%d edge points "
                   "in the frame); a circle within a tenth of its radius is needed",
                   range.hint[0], range.hint[1], range.hint[2], n_edges);
  return hl_fail(ctx, HL_ERR_DEGENERATE,
                 "no ball: %d edge points in the frame (%.0f %% of it clipped) and no circle of "
                 "%.0f to %.0f px radius among them; a ball that stands out from its background is "
                 "needed, or --sphere",
                 n_edges, clipped_percent(frame), range.min_radius_px, range.max_radius_px);
}

static hl_status search_and_choose(hl_ctx *ctx, const scene *sc, attempt *out)
{
  hl_candidate found[HL_CANDIDATES_MAX];
  int n = 0;
  const hl_status st = search(ctx, sc->frame, sc, found, &n);
  return st == HL_OK ? choose(ctx, sc, found, n, out) : st;
}

/* The pose of a candidate that passed, checked. */
static hl_status pose_of(hl_ctx *ctx, const scene *sc, const attempt *a, double radius_m,
                         hl_sphere *out, hl_sphere_fit *fit)
{
  hl_sphere_fit about;
  const hl_status st = describe(ctx, sc, a, &about);
  if (st != HL_OK)
    return st;
  hl_sphere ball;
  hl_ctx inner = {0};
  hl_cone_to_sphere(&a->cone, (const double(*)[3])a->fit.covariance, radius_m, &ball);
  if (sc->camera->has_covariance)
    hl_sphere_add_camera(sc->camera, &a->cone, (const double(*)[HL_INTRINSICS_MAX])a->by_intrinsics,
                         &ball);
  if (hl_sphere_check(&inner, &ball) != HL_OK)
    return hl_fail(ctx, HL_ERR_DEGENERATE, "the outline is an impossible ball's: %s", inner.msg);
  *out = ball;
  if (fit)
    *fit = about;
  return HL_OK;
}

hl_status hl_sphere_locate(hl_ctx *ctx, const hl_frame *frame, const hl_camera *camera,
                           double radius_m, const hl_sphere_settings *settings, hl_sphere *out,
                           hl_sphere_fit *fit)
{
  scene sc = {
      .frame = frame, .camera = camera, .settings = settings ? *settings : hl_sphere_defaults()};
  hl_status st = check_input(ctx, frame, camera, radius_m, &sc.settings);
  if (st != HL_OK)
    return st;
  attempt a;
  st = search_and_choose(ctx, &sc, &a);
  return st == HL_OK ? pose_of(ctx, &sc, &a, radius_m, out, fit) : st;
}

hl_status hl_sphere_relocate(hl_ctx *ctx, const hl_frame *frame, const hl_camera *camera,
                             const hl_sphere *near, const hl_sphere_settings *settings,
                             hl_sphere *out, hl_sphere_fit *fit)
{
  scene sc = {
      .frame = frame, .camera = camera, .settings = settings ? *settings : hl_sphere_defaults()};
  hl_status st = check_input(ctx, frame, camera, near->radius_m, &sc.settings);
  if (st == HL_OK)
    st = hl_sphere_check(ctx, near);
  if (st != HL_OK)
    return st;
  hl_cone cone;
  hl_unit(near->center_m, cone.axis);
  hl_tangent_basis(cone.axis, cone.e1, cone.e2);
  cone.half_angle_rad = asin(near->radius_m / hl_norm(near->center_m));
  attempt a;
  if (!(sc.settings.blur_px > 0) || !settle_near(&sc, &cone, &a))
    settle(&sc, &cone, &a);
  return a.verdict == BALL ? pose_of(ctx, &sc, &a, near->radius_m, out, fit)
                           : refuse(ctx, &sc, &a, 0);
}
