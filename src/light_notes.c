/* Verdicts in words: what was used, what was left out and why, and whether to trust the answer. */
#include <math.h>
#include <string.h>

#include "halflight/notes.h"
#include "halflight/vec3.h"
#include "light_work.h"

static const double deg = 57.295779513082320877;
static const double least_contrast = 0.02; /* of the median: flatter frames show no shading */
static const double all_clipped = 0.95;    /* of the lit pixels */
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

/* A term in `used` or `left_out`, with its figure. */
static void note_term(const hl_light_settled *settled, const hl_light_settings *settings,
                      hl_light_term which, hl_light *out)
{
  const hl_term_verdict *v = &settled->term[which];
  const char *name = hl_light_term_name(which);
  const char *what = which == HL_LIGHT_AMBIENT ? "gain" : "of the misfit it saves";
  if (settled->on >> which & 1) {
    if (settings->with >> which & 1)
      hl_notes_add(&out->used, name, "%s %.2f %%; asked for", what, 100 * v->gain);
    else
      hl_notes_add(&out->used, name, "%s %.2f %%, above %.3g %%", what, 100 * v->gain,
                   100 * v->least);
  } else if (v->unfit)
    hl_notes_add(&out->left_out, name, "%s", v->unfit);
  else if (which == HL_LIGHT_AMBIENT && !(settled->dark_share >= 0.002))
    hl_notes_add(&out->left_out, name, "no part of the ball is in shadow to show it");
  else
    hl_notes_add(&out->left_out, name, "%s%s %.2f %% < %.3g %%", what,
                 v->screened ? ", predicted," : "", 100 * v->gain, 100 * v->least);
}

static void note_colored(const hl_light_settled *settled, hl_light *out)
{
  const hl_term_verdict *v = &settled->term[HL_LIGHT_COLORED_LOBE];
  const char *name = hl_light_term_name(HL_LIGHT_COLORED_LOBE);
  if (settled->on >> HL_LIGHT_COLORED_LOBE & 1)
    hl_notes_add(&out->used, name, "lobes of one shape would lose %.2f %%", 100 * v->gain);
  else if (v->unfit)
    hl_notes_add(&out->left_out, name, "%s", v->unfit);
  else
    hl_notes_add(&out->left_out, name,
                 "gain %.2f %% < %.3g %%: the channels' lobes, fitted apart, agree in shape",
                 100 * v->gain, 100 * v->least);
}

static void note_terms(const struct hl_light_work *work, const hl_light_settled *settled,
                       const hl_light_settings *settings, hl_light *out)
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
    if (settings->without >> HL_LIGHT_BENDS & 1)
      hl_notes_add(&out->left_out, "masking and bent body", "not asked for");
    else if (m->body > 1 && settings->with >> HL_LIGHT_BENDS & 1)
      hl_notes_add(&out->used, "masking and bent body",
                   "gain %.2f %%; asked for; masking exponent %.2f", 100 * settled->bent_gain,
                   kept->exponent);
    else if (m->body > 1)
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
  note_term(settled, settings, HL_LIGHT_AMBIENT, out);
  note_term(settled, settings, HL_LIGHT_NEAR, out);
  note_term(settled, settings, HL_LIGHT_BACKSCATTER, out);
  note_colored(settled, out);
  hl_notes_add(&out->left_out, hl_light_term_name(HL_LIGHT_RESPONSE),
               "not tried: one frame cannot tell it from the free curves of lobe and body");
  if (work->brightness.clipped > 0)
    hl_notes_add(&out->used, "censored clipping", "%d pixels say `at least this much'",
                 work->brightness.clipped);
  if (settled->outliers > 0)
    hl_notes_add(&out->used, "outlier rejection", "%d pixels left out", settled->outliers);
  else if (settings->without >> HL_LIGHT_OUTLIERS & 1)
    hl_notes_add(&out->left_out, "outlier rejection", "not asked for");
  else
    hl_notes_add(&out->left_out, "outlier rejection", "no pixel stands out");
}

void hl_light_notes(const struct hl_light_work *work, const hl_light_settled *settled,
                    const hl_light_spread *spread, const hl_surface *surface,
                    const hl_light_settings *settings, hl_light *out)
{
  identify(settled, out);
  note_terms(work, settled, settings, out);
  note_geometry(surface, out);
  hl_light_judge(work, settled, spread, out);
}
