/* Verdicts in words: what was used, what was left out and why, and whether to trust the answer. */
#include <math.h>
#include <string.h>

#include "halflight/notes.h"
#include "halflight/vec3.h"
#include "light_work.h"

static const double deg = 57.295779513082320877;
static const double least_contrast = 0.02; /* of the median: flatter frames show no shading */
static const double least_explained = 0.6; /* of the variance */
static const double all_clipped = 0.95, most_clipped = 0.7; /* of the lit pixels */
static const double widest_ellipse_deg = 5;
static const int least_pixels = 60;

bool hl_light_hopeless(const struct hl_light_work *work, const hl_frame *frame, hl_light *out)
{
  const hl_light_brightness *b = &work->brightness;
  const int n = work->all.n;
  if (n < least_pixels)
    hl_notes_add(&out->reasons, "pixels",
                 "only %d usable pixels on the surface; at least %d are needed", n, least_pixels);
  else if (!(b->level > 0))
    hl_notes_add(
        &out->reasons, "black",
        "no light on the surface: its radiance is 0 or below; expose more, or check --black");
  else if (b->clipped >= all_clipped * b->lit)
    hl_notes_add(&out->reasons, "clipped",
                 "%.0f %% of the lit surface is at or above saturation %.6g: expose less",
                 100.0 * b->clipped / b->lit, frame->saturation);
  else if (b->p98 - b->p2 < least_contrast * fabs(b->p50))
    hl_notes_add(&out->reasons, "constant",
                 "the surface's radiance varies by %.2g %% only; shading or a highlight is needed",
                 100 * (b->p98 - b->p2) / b->p50);
  return out->reasons.n > 0;
}

static void identify(const hl_light_settled *settled, hl_light *out)
{
  const hl_light_variant *kept = &settled->variant[settled->kept];
  const double to_half = hl_angle(kept->s, out->half_angle_direction);
  out->verdict = HL_UNIQUE;
  out->stays_free = "the light's strength against the ball's albedo";
  if (!kept->model.has_lobe) {
    out->proposition = "Propositions 1 and 2: one curve along one direction";
  } else if (to_half * deg < 1) {
    out->verdict = HL_AMBIGUOUS;
    out->proposition = "Remark 3: light, view and half-angle coincide";
    out->stays_free = "how radiance divides between body and lobe; the direction itself is unique";
  } else if (out->diffuse_strength[0] + out->diffuse_strength[1] + out->diffuse_strength[2] <= 0) {
    out->proposition = "Propositions 1 and 2: one curve along the half-angle";
  } else {
    out->proposition = "Proposition 5: the body's axis is the light's, the lobe's the half-angle";
  }
}

static void note_geometry(const hl_surface *surface, hl_light *out)
{
  const hl_sphere *ball = &surface->ball;
  const hl_camera *camera = &surface->camera;
  if (out->part_stated[HL_PART_POSE])
    hl_notes_add(&out->used, "pose uncertainty", "the ball's covariance is part of the ellipse");
  else if (!surface->is_ball)
    hl_notes_add(&out->left_out, "pose uncertainty", "the normals are taken as exact");
  else
    hl_notes_add(&out->left_out, "pose uncertainty", "the ball's pose comes without a covariance");
  if (!out->part_stated[HL_PART_CAMERA])
    hl_notes_add(&out->left_out, "camera uncertainty", "the camera states none");
  else if (!surface->is_ball)
    hl_notes_add(&out->used, "camera uncertainty", "moves the views; the normals stay");
  else if (hl_surface_follows(surface))
    hl_notes_add(&out->used, "camera uncertainty", "the ball moves along: it was found through it");
  else if (ball->n_intrinsics > 0)
    hl_notes_add(&out->used, "camera uncertainty",
                 "the pose stays: it was found through a camera of %d intrinsics, this one has %d",
                 ball->n_intrinsics, hl_camera_intrinsics_count(camera));
  else
    hl_notes_add(&out->used, "camera uncertainty",
                 "the pose stays: it does not say how it depends on the camera");
}

static void note_terms(const struct hl_light_work *work, const hl_light_settled *settled,
                       hl_light *out)
{
  const hl_light_variant *kept = &settled->variant[settled->kept];
  const hl_light_model *m = &kept->model;
  hl_notes_add(&out->used, "perspective view", "half-angle and view of every pixel");
  hl_notes_add(&out->used, "attached shadow", "pixels that the light does not reach predict %s",
               m->ambient ? "the ambient" : "0");
  hl_notes_add(&out->used, "diffuse term", "shares the light's direction");
  if (m->has_lobe) {
    const bool foreshortened = m->lobe == HL_LOBE_FORESHORTENED;
    const char *other = foreshortened ? "plain lobe" : "foreshortened lobe";
    hl_notes_add(&out->used, foreshortened ? "foreshortened lobe" : "plain lobe",
                 "saves %.2f %% of the residual against no lobe", 100 * settled->lobe_gain);
    if (isfinite(settled->kind_ratio))
      hl_notes_add(&out->left_out, other, "its residual is %.2f times that of the kept one",
                   settled->kind_ratio);
    else
      hl_notes_add(&out->left_out, other, "not asked for");
    if (m->body > 1)
      hl_notes_add(&out->used, "masking and bent body",
                   "gain %.2f %%, above 2 %%; masking exponent %.2f", 100 * settled->bent_gain,
                   kept->exponent);
    else if (!isfinite(settled->bent_gain))
      hl_notes_add(&out->left_out, "masking and bent body", "cannot be fitted");
    else
      hl_notes_add(&out->left_out, "masking and bent body", "gain %.2f %% < 2 %%",
                   100 * settled->bent_gain);
  } else {
    hl_notes_add(&out->left_out, "lobe", "gain %.2f %% < 2 %%: the ball is matte",
                 100 * settled->lobe_gain);
  }
  if (m->ambient)
    hl_notes_add(&out->used, "ambient", "gain %.2f %%, above 0.5 %%", 100 * settled->ambient_gain);
  else if (!(settled->dark_share >= 0.002))
    hl_notes_add(&out->left_out, "ambient", "no part of the ball is in shadow to show it");
  else
    hl_notes_add(&out->left_out, "ambient", "gain %.2f %% < 0.5 %%", 100 * settled->ambient_gain);
  if (work->brightness.clipped > 0)
    hl_notes_add(&out->used, "censored clipping", "%d pixels say `at least this much'",
                 work->brightness.clipped);
  if (settled->outliers > 0)
    hl_notes_add(&out->used, "outlier rejection", "%d pixels left out", settled->outliers);
  else
    hl_notes_add(&out->left_out, "outlier rejection", "no pixel stands out");
}

static void judge(const struct hl_light_work *work, const hl_light_settled *settled,
                  const hl_light_spread *spread, hl_light *out)
{
  const hl_light_brightness *b = &work->brightness;
  const hl_light_variant *kept = &settled->variant[settled->kept];
  const double clipped = b->lit > 0 ? (double)b->clipped / b->lit : 1;
  if (clipped > most_clipped)
    hl_notes_add(&out->reasons, "clipped", "%.0f %% of the lit pixels are clipped: expose less",
                 100 * clipped);
  if (!(spread->explained > least_explained))
    hl_notes_add(&out->reasons, "model",
                 "the model explains %.0f %% of the ball's variation only: not a ball of one "
                 "material under one light, or a wrong pose",
                 100 * fmax(0, spread->explained));
  if (!kept->converged)
    hl_notes_add(&out->reasons, "not converged",
                 "the direction still moved after the last iteration");
  if (!(out->ellipse_95_rad[0] * deg < widest_ellipse_deg))
    hl_notes_add(&out->reasons, "uncertain",
                 "the direction is known to %.1f deg only (95 %%): a larger or glossier ball, or "
                 "less noise, is needed",
                 out->ellipse_95_rad[0] * deg);
  if (settled->outliers > work->all.n / 4)
    hl_notes_add(&out->reasons, "outliers",
                 "%.0f %% of the pixels do not fit: something covers "
                 "the ball, or the room is reflected in it",
                 100.0 * settled->outliers / work->all.n);
  out->trusted = out->reasons.n == 0;
}

void hl_light_notes(const struct hl_light_work *work, const hl_light_settled *settled,
                    const hl_light_spread *spread, const hl_surface *surface, hl_light *out)
{
  identify(settled, out);
  note_terms(work, settled, out);
  note_geometry(surface, out);
  judge(work, settled, spread, out);
}
