/* Whether the corners are those of one camera at all, and whether to trust what they say, in words. */
#include <math.h>
#include <stdio.h>

#include "halflight/notes.h"
#include "intrinsics.h"

static const double hopeless = 0.005;     /* rms over the frame's diagonal */
static const double suspicious = 0.0025;  /* of it: more than any lens and any print */
static const double least_coverage = 0.3; /* of the frame's cells */
static const double least_tilt_deg = 8;   /* between two boards */
static const double loose_focal = 0.02;   /* stated deviation of the focal length, of itself */
static const double loose_centre = 0.02;  /* of the centre, of the frame's longer side */
static const double most_condition = 1e12;
static const double most_corners_out = 0.05; /* share of the corners seen in used views */
static const double most_views_out = 0.5;    /* share of the views in which a board was found */
static const double uneven_scatter = 2.5;    /* of the views' pulls */
static const double most_scatter = 100;      /* deviations ten times too small */
static const double wrong_shape = 0.3;       /* of the sum of squares, explained by another board */
static const double sure_shape = 5;          /* deviations */

static double rms_over_diagonal(const hl_intrinsics *p)
{
  return sqrt(p->cost / hl_intrinsics_corners_used(p)) / hypot(p->camera.width, p->camera.height);
}

static hl_status another_board(hl_ctx *ctx, const hl_intrinsics *p, const char *why)
{
  const hl_target *target = &p->corners->target;
  char spec[HL_TARGET_SPEC_MAX];
  return hl_fail(ctx, HL_ERR_DEGENERATE,
                 "the corners fit no camera: %.100s; they are taken as %d x %d corners of %s, row "
                 "by row: is that the board that was seen?",
                 why, hl_target_corner_columns(target), hl_target_corner_rows(target),
                 hl_target_spec(target, spec));
}

hl_status hl_intrinsics_explain(hl_ctx *ctx, const hl_intrinsics *p, hl_status st, const char *msg)
{
  const double tilt_deg = hl_intrinsics_tilt_deg(p);
  const bool folds = st == HL_ERR_FORMAT; /* hl_camera_check's */
  if (!folds && st != HL_ERR_DEGENERATE && st != HL_ERR_NOT_CONVERGED)
    return hl_fail(ctx, st, "%s", msg);
  if (!p->solved_once || !(rms_over_diagonal(p) <= hopeless))
    return another_board(ctx, p, msg);
  if (tilt_deg < least_tilt_deg)
    return hl_fail(ctx, HL_ERR_DEGENERATE,
                   "the boards are parallel, tilted by %.1f deg against each other at most, which "
                   "does not determine the camera; tilts of 20 to 45 deg in several directions are "
                   "needed",
                   tilt_deg);
  if (folds)
    return hl_fail(ctx, HL_ERR_DEGENERATE,
                   "the corners, in %.0f %% of the frame's cells, give a camera that does not see "
                   "all of it: %.180s",
                   100 * hl_intrinsics_coverage(p), msg);
  return hl_fail(ctx, st, "%s", msg);
}

hl_status hl_intrinsics_refuse(hl_ctx *ctx, const hl_intrinsics *p)
{
  char why[40];
  if (rms_over_diagonal(p) <= hopeless)
    return HL_OK;
  snprintf(why, sizeof why, "rms %.3g px", sqrt(p->cost / hl_intrinsics_corners_used(p)));
  return another_board(ctx, p, why);
}

/* ---- what was done ---- */

static bool has_levels(const hl_intrinsics *p)
{
  for (int i = 0; i < p->n_views; i++)
    for (int c = 0; p->view[i].used && c < p->view[i].n; c++)
      if (p->view[i].sighting[c].used && fabs(p->view[i].sighting[c].weight - 1) > 0)
        return true;
  return false;
}

static int views_rejected(const hl_intrinsics *p)
{
  int n = 0;
  for (int i = 0; i < p->n_views; i++)
    n += !p->view[i].used && p->view[i].source->used;
  return n;
}

static void note_work(const hl_intrinsics *p, hl_calibration *out)
{
  const int out_views = views_rejected(p);
  hl_notes_add(&out->used, "covariance",
               "of all parameters at the minimum, noise %.3g px a coordinate", out->noise_px);
  if (has_levels(p))
    hl_notes_add(&out->used, "levels", "every corner by its own relative deviation");
  if (out->corners_left_out > 0 || out_views > 0)
    hl_notes_add(&out->used, "outlier rejection", "%d corners and %d views left out",
                 out->corners_left_out, out_views);
  else
    hl_notes_add(&out->left_out, "outlier rejection", "no corner or view stands out");
  if (p->opencv.msg[0])
    hl_notes_add(&out->left_out, "OpenCV's start", "%.120s", p->opencv.msg);
  else
    hl_notes_add(&out->used, "OpenCV's start",
                 "%.2g stated deviations from the minimum, where it was taken", p->opencv_off);
  if (p->camera.model == HL_LENS_RATIONAL)
    hl_notes_add(&out->used, "held denominator",
                 "within a factor e of 1, so that it does not cancel the numerator");
  hl_notes_add(&out->left_out, "the board's shape", "taken as flat and as its spec says");
  if (out->scatter > uneven_scatter)
    hl_notes_add(&out->left_out, "shared errors",
                 "the views disagree %.2g times as much as independent corners would: true "
                 "deviations may be %.2g times those stated",
                 out->scatter, sqrt(out->scatter));
}

/* ---- whether to trust it ---- */

static void judge_board(hl_intrinsics *p, hl_calibration *out)
{
  hl_board_shape shape;
  if (!hl_intrinsics_shape(p, &shape) || !(shape.explained > wrong_shape))
    return;
  const double percent = 100 * shape.explained;
  if (fabs(shape.ratio_off) > sure_shape * shape.ratio_sd)
    hl_notes_add(&out->reasons, "target spec",
                 "a spacing ratio of %.3g instead of %.3g would explain %.0f %% of what is left",
                 out->target.spacing_ratio + shape.ratio_off, out->target.spacing_ratio, percent);
  else if (fabs(shape.stretch) > sure_shape * shape.stretch_sd)
    hl_notes_add(&out->reasons, "target spec",
                 "a board %.2g %% %s along its rows would explain %.0f %% of what is left",
                 100 * fabs(shape.stretch), shape.stretch > 0 ? "longer" : "shorter", percent);
}

static void judge_fit(const hl_intrinsics *p, hl_calibration *out)
{
  const double diagonal = hypot(p->camera.width, p->camera.height);
  const int seen = out->corners_used + out->corners_left_out;
  const int used = hl_intrinsics_views_used(p);
  const int rejected = views_rejected(p);
  if (!(out->camera.rms_px <= suspicious * diagonal))
    hl_notes_add(&out->reasons, "residuals",
                 "rms %.3g px: more than a lens or a print is off by; a wrong target spec, or "
                 "another lens model",
                 out->camera.rms_px);
  if (out->scatter > most_scatter)
    hl_notes_add(&out->reasons, "shared errors",
                 "the views disagree %.2g times as much as independent corners would: another "
                 "lens model, or a board that is not flat or not as its spec says",
                 out->scatter);
  if (out->corners_left_out > most_corners_out * seen)
    hl_notes_add(&out->reasons, "outliers", "%.0f %% of the corners do not fit",
                 100.0 * out->corners_left_out / seen);
  if (rejected > most_views_out * (used + rejected))
    hl_notes_add(&out->reasons, "views", "%d of %d views do not fit or cannot be used", rejected,
                 used + rejected);
}

static void judge_geometry(const hl_intrinsics *p, hl_calibration *out)
{
  const hl_camera *c = &out->camera;
  const int n = p->arrow.n;
  const double times = sqrt(fmax(out->scatter, 1)); /* what the stated deviations leave out */
  const double focal =
      times * fmax(sqrt(c->covariance[0]) / c->fx, sqrt(c->covariance[n + 1]) / c->fy);
  const double centre = times * sqrt(fmax(c->covariance[2 * n + 2], c->covariance[3 * n + 3]));
  if (!(out->tilt_deg >= least_tilt_deg))
    hl_notes_add(&out->reasons, "parallel boards",
                 "the boards tilt by %.1f deg against each other at most, which does not determine "
                 "the focal length: tilt them by 20 to 45 deg, in several directions",
                 out->tilt_deg);
  if (!(focal <= loose_focal))
    hl_notes_add(
        &out->reasons, "focal length",
        "known to %.2g %% only (one deviation, shared errors included): tilt the boards more",
        100 * focal);
  if (!(centre <= loose_centre * fmax(c->width, c->height)))
    hl_notes_add(
        &out->reasons, "centre",
        "known to %.2g px only (one deviation, shared errors included): tilt the boards in "
        "several directions",
        centre);
  if (!(out->coverage >= least_coverage))
    hl_notes_add(&out->reasons, "coverage",
                 "%.0f %% of the frame holds corners; distortion elsewhere is a guess: fill the "
                 "frame, or check the frames' size",
                 100 * out->coverage);
  if (!(out->condition <= most_condition)) {
    int weakest = 0;
    hl_spd_condition(p->arrow.s, &p->arrow.schur, &weakest, NULL);
    hl_notes_add(&out->reasons, "ill-conditioned",
                 "condition %.1e; parameter %d cannot be told apart from the others: use a "
                 "smaller model",
                 out->condition, weakest);
  }
}

void hl_intrinsics_judge(hl_intrinsics *p, hl_calibration *out)
{
  note_work(p, out);
  judge_geometry(p, out);
  judge_fit(p, out);
  judge_board(p, out);
  out->trusted = out->reasons.n == 0;
}
