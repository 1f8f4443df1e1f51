/*
 * The model: the one asked for, or the smallest that explains the corners.
 *
 * Models are compared by what they predict, not by what they fit: the views are dealt into folds,
 * each fold is left out in turn, the camera is solved from the others and held, only the poses of
 * the fold's views are fitted again, and their residuals are summed over all folds. A larger model
 * is kept where the rms of these is smaller by `model_gain`, and by two of its own standard errors
 * over the views. All models are compared on the same corners: those that at least one of them
 * explains, so that a small model cannot drop what it does not explain.
 *
 * A fisheye model is tried where the field of view asks for it; within a narrow one it differs from
 * a pinhole by its fifth coefficient only.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "halflight/lens_names.h"
#include "halflight/notes.h"
#include "halflight/vec3.h"
#include "intrinsics.h"

enum { MODELS = 3, FOLDS_MAX = 5 };

static const double degrees = 180 / 3.14159265358979323846;
static const double fisheye_from_deg = 90; /* across the frame's diagonal */
static const double standard_errors = 2;

/* In the order in which they must earn their place; a fisheye in a wide field has fewer unknowns
 * than the rational model. */
static const hl_lens_model order[MODELS] = {HL_LENS_PINHOLE, HL_LENS_FISHEYE, HL_LENS_RATIONAL};

/* One model's try. */
typedef struct candidate {
  hl_lens_model model;
  bool solved, validated;
  hl_intrinsics_state state;
  double *held_out; /* shape (n_views): sum of squares of a view while it was held out */
  double rms;       /* of all of them, a corner */
  char why[HL_NOTE_TEXT_MAX];
} candidate;

static hl_status solve_model(hl_ctx *ctx, hl_intrinsics *p, hl_lens_model model)
{
  hl_status st = hl_intrinsics_start(ctx, p, model);
  if (st == HL_OK)
    st = hl_intrinsics_sift(ctx, p);
  return st == HL_OK ? hl_camera_check(ctx, &p->camera) : st;
}

/* ---- one model, as asked for ---- */

static hl_status as_asked(hl_ctx *ctx, hl_intrinsics *p, hl_lens_model model, hl_notes *used,
                          hl_notes *left_out)
{
  const hl_status st = solve_model(ctx, p, model);
  if (st != HL_OK)
    return st;
  hl_notes_add(used, hl_lens_name((int)model), "asked for");
  for (int i = 0; i < MODELS; i++)
    if (order[i] != model)
      hl_notes_add(left_out, hl_lens_name((int)order[i]),
                   "not asked for; the model auto weighs it by cross-validation");
  return HL_OK;
}

/* ---- cross-validation ---- */

/* Views and corners that at least one candidate uses. */
static void mark_common(const candidate *c, hl_intrinsics *p)
{
  for (int i = 0; i < p->n_views; i++) {
    p->view[i].used = false;
    for (int m = 0; m < MODELS; m++)
      p->view[i].used = p->view[i].used || (c[m].solved && c[m].state.view[i].used);
  }
  for (int i = 0; i < p->n_sightings; i++) {
    p->sighting[i].used = false;
    for (int m = 0; m < MODELS; m++)
      p->sighting[i].used = p->sighting[i].used || (c[m].solved && c[m].state.sighting[i].used);
  }
}

/* The fold of every view: dealt in their order, unused ones skipped. */
static int deal(const hl_intrinsics *p, int *fold)
{
  const int used = hl_intrinsics_views_used(p);
  const int folds = used < FOLDS_MAX ? used : FOLDS_MAX;
  int next = 0;
  for (int i = 0; i < p->n_views; i++)
    fold[i] = p->view[i].used ? next++ % folds : -1;
  return folds;
}

/* One fold: solve without it, then its views with the camera held. */
static hl_status hold_out(hl_ctx *ctx, hl_intrinsics *p, const int *fold, int k, double *held_out)
{
  for (int i = 0; i < p->n_views; i++)
    p->view[i].used = fold[i] >= 0 && fold[i] != k;
  const hl_status st = hl_intrinsics_solve(ctx, p);
  for (int i = 0; i < p->n_views && st == HL_OK; i++) {
    hl_intrinsics_view *view = &p->view[i];
    if (fold[i] != k)
      continue;
    held_out[i] = hl_sightings_refine(&p->camera, view->sighting, view->n, &view->pose);
    if (!isfinite(held_out[i]))
      return hl_fail(ctx, HL_ERR_DEGENERATE, "%.80s fits no pose while it is held out",
                     view->source->name);
  }
  return st;
}

static hl_status cross_validate(hl_ctx *ctx, hl_intrinsics *p, candidate *c, const candidate *all,
                                int *fold)
{
  hl_intrinsics_state common;
  hl_status st = hl_intrinsics_state_new(ctx, p, &common);
  if (st != HL_OK)
    return st;
  hl_intrinsics_restore(p, &c->state);
  mark_common(all, p);
  const int folds = deal(p, fold);
  const int corners = hl_intrinsics_corners_used(p);
  st = hl_intrinsics_solve(ctx, p);
  hl_intrinsics_save(p, &common);
  double sum = 0;
  for (int k = 0; k < folds && st == HL_OK; k++) {
    hl_intrinsics_restore(p, &common);
    st = hold_out(ctx, p, fold, k, c->held_out);
  }
  for (int i = 0; i < p->n_views; i++)
    sum += fold[i] >= 0 ? c->held_out[i] : 0;
  c->rms = sqrt(sum / corners);
  hl_intrinsics_state_free(&common);
  return st;
}

/* ---- auto ---- */

/* Angle across the frame's diagonal. */
static double field_of_view_deg(const hl_camera *camera)
{
  double a[3], b[3];
  if (hl_camera_unproject(NULL, camera, 0, 0, a) != HL_OK ||
      hl_camera_unproject(NULL, camera, camera->width - 1, camera->height - 1, b) != HL_OK)
    return 180;
  return hl_angle(a, b) * degrees;
}

/* Solve a candidate; one that cannot be is left out with its reason. */
static hl_status attempt(hl_ctx *ctx, hl_intrinsics *p, const hl_intrinsics_state *begin,
                         candidate *c)
{
  hl_ctx inner = {0};
  hl_intrinsics_restore(p, begin);
  const hl_status st = solve_model(&inner, p, c->model);
  if (st == HL_ERR_MEMORY || st == HL_ERR_UNAVAILABLE)
    return hl_fail(ctx, st, "%s", inner.msg);
  c->solved = st == HL_OK;
  if (c->solved)
    hl_intrinsics_save(p, &c->state);
  else
    snprintf(c->why, sizeof c->why, "%.*s", HL_NOTE_TEXT_MAX - 1, inner.msg);
  return HL_OK;
}

/* Whether `larger` predicts better than `kept` by enough; says so in larger->why. */
static bool earns(const hl_intrinsics *p, const candidate *kept, candidate *larger, const int *fold)
{
  double sum = 0, squares = 0;
  int n = 0;
  for (int i = 0; i < p->n_views; i++) {
    if (fold[i] < 0)
      continue;
    const double d = kept->held_out[i] - larger->held_out[i];
    sum += d;
    squares += d * d;
    n++;
  }
  const double error = sqrt(fmax(squares - sum * sum / n, 0) * n / fmax(n - 1, 1));
  const double gain = 1 - larger->rms / kept->rms;
  const bool enough = gain >= p->settings->model_gain;
  snprintf(larger->why, sizeof larger->why,
           "held-out rms %.4g px, %s %.4g px: gain %.2g %% %s %.2g %%%s", larger->rms,
           hl_lens_name((int)kept->model), kept->rms, 100 * gain, enough ? ">=" : "<",
           100 * p->settings->model_gain,
           enough && !(sum > standard_errors * error) ? ", but within its scatter over the views"
                                                      : "");
  return enough && sum > standard_errors * error;
}

/* The smallest candidate that is not outdone; NULL where none could be solved. */
static candidate *pick(const hl_intrinsics *p, candidate *c, const int *fold)
{
  candidate *kept = NULL;
  for (int m = 0; m < MODELS; m++) {
    if (!c[m].validated)
      continue;
    if (!kept) {
      kept = &c[m];
      snprintf(kept->why, sizeof kept->why, "held-out rms %.4g px", kept->rms);
    } else if (earns(p, kept, &c[m], fold)) {
      snprintf(kept->why, sizeof kept->why, "held-out rms %.4g px, %s %.4g px", kept->rms,
               hl_lens_name((int)c[m].model), c[m].rms);
      kept = &c[m];
    }
  }
  return kept;
}

static hl_status try_all(hl_ctx *ctx, hl_intrinsics *p, candidate *c, int *fold)
{
  hl_intrinsics_state begin;
  hl_status st = hl_intrinsics_state_new(ctx, p, &begin);
  if (st != HL_OK)
    return st;
  hl_intrinsics_save(p, &begin);
  double widest = 0;
  for (int m = 0; m < MODELS && st == HL_OK; m++) {
    if (c[m].model == HL_LENS_FISHEYE && widest > 0 && widest < fisheye_from_deg) {
      snprintf(c[m].why, sizeof c[m].why, "field of view %.0f deg; tried from %.0f deg", widest,
               fisheye_from_deg);
      continue;
    }
    st = attempt(ctx, p, &begin, &c[m]);
    if (st == HL_OK && c[m].solved)
      widest = fmax(widest, field_of_view_deg(&p->camera));
  }
  for (int m = 0; m < MODELS && st == HL_OK; m++) {
    if (!c[m].solved)
      continue;
    hl_ctx inner = {0};
    st = cross_validate(&inner, p, &c[m], c, fold);
    c[m].validated = st == HL_OK;
    if (st == HL_ERR_DEGENERATE || st == HL_ERR_NOT_CONVERGED) {
      snprintf(c[m].why, sizeof c[m].why, "%.*s", HL_NOTE_TEXT_MAX - 1, inner.msg);
      st = HL_OK;
    } else if (st != HL_OK) {
      st = hl_fail(ctx, st, "%s", inner.msg);
    }
  }
  hl_intrinsics_state_free(&begin);
  return st;
}

static hl_status choose(hl_ctx *ctx, hl_intrinsics *p, candidate *c, int *fold, hl_notes *used,
                        hl_notes *left_out)
{
  hl_status st = try_all(ctx, p, c, fold);
  if (st != HL_OK)
    return st;
  candidate *kept = pick(p, c, fold);
  if (!kept)
    return hl_fail(ctx, HL_ERR_DEGENERATE, "%.240s", c[0].why);
  hl_intrinsics_restore(p, &kept->state);
  st = hl_intrinsics_solve(ctx, p);
  hl_notes_add(used, hl_lens_name((int)kept->model), "%s", kept->why);
  for (int m = 0; m < MODELS; m++)
    if (&c[m] != kept)
      hl_notes_add(left_out, hl_lens_name((int)c[m].model), "%s", c[m].why);
  return st;
}

static hl_status automatic(hl_ctx *ctx, hl_intrinsics *p, hl_notes *used, hl_notes *left_out)
{
  candidate c[MODELS] = {{0}};
  hl_status st = HL_OK;
  int *fold = calloc((size_t)p->n_views + 1, sizeof *fold);
  if (!fold)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for %d views", p->n_views);
  for (int m = 0; m < MODELS && st == HL_OK; m++) {
    c[m].model = order[m];
    c[m].held_out = calloc((size_t)p->n_views + 1, sizeof *c[m].held_out);
    st = c[m].held_out ? hl_intrinsics_state_new(ctx, p, &c[m].state)
                       : hl_fail(ctx, HL_ERR_MEMORY, "no memory for %d views", p->n_views);
  }
  if (st == HL_OK)
    st = choose(ctx, p, c, fold, used, left_out);
  for (int m = 0; m < MODELS; m++) {
    hl_intrinsics_state_free(&c[m].state);
    free(c[m].held_out);
  }
  free(fold);
  return st;
}

hl_status hl_intrinsics_choose(hl_ctx *ctx, hl_intrinsics *p, hl_notes *used, hl_notes *left_out)
{
  switch (p->settings->model) {
  case HL_MODEL_PINHOLE:
    return as_asked(ctx, p, HL_LENS_PINHOLE, used, left_out);
  case HL_MODEL_RATIONAL:
    return as_asked(ctx, p, HL_LENS_RATIONAL, used, left_out);
  case HL_MODEL_FISHEYE:
    return as_asked(ctx, p, HL_LENS_FISHEYE, used, left_out);
  default:
    return automatic(ctx, p, used, left_out);
  }
}
