/* The pose of a ball once more, from the shading of all frames together.
 *
 * Each frame's score (light_pose.c) says how its cost falls as the centre moves while its own direction
 * and curves follow. Their sum, with the outlines' pose as a prior, gives the step
 *
 *   d = (sum H_i + C^-1)^-1 sum g_i,     s_i moves by (ds/dc)_i d.
 *
 * Misfit makes the frames' scores scatter more than their H states (g has no mean H only where the model
 * holds), so H is divided by that ratio: without it a model that is slightly wrong in the same way in
 * every frame would outvote the rim. The step is kept only where it lowers the cost of frames that had no
 * part in it: FOLDS groups, each judged by the step of the others, and by more than the groups' scatter.
 */
#include <math.h>
#include <string.h>

#include "halflight/notes.h"
#include "halflight/vec3.h"
#include "replay_work.h"

enum { FOLDS = 5, LEAST_FRAMES = 8 };
static const double chi2_95 = 5.9914645471079817; /* 2 degrees of freedom */

typedef struct system {
  double h[3][3], g[3];
  int n;
} system_3;

static void add(const hl_light_pose *p, system_3 *s)
{
  for (int i = 0; i < 3; i++) {
    s->g[i] += p->gradient[i];
    for (int j = 0; j < 3; j++)
      s->h[i][j] += p->information[i][j];
  }
  s->n++;
}

/* Mean of g_i' H_i^-1 g_i / 3: 1 where the frames' scores scatter as they state. */
static double scatter_of(const hl_replay_run *run, int b)
{
  double sum = 0, inverse[3][3];
  int n = 0;
  for (int i = 0; i < run->session->n; i++) {
    const hl_replay_seen *s = &run->frame[i].seen[b];
    if (!s->scored || !hl_replay_invert((const double(*)[3])s->pose.information, inverse))
      continue;
    for (int j = 0; j < 3; j++)
      sum += s->pose.gradient[j] * hl_dot(inverse[j], s->pose.gradient) / 3;
    n++;
  }
  return n > 0 ? fmax(1, sum / n) : 1;
}

static bool step_of(const system_3 *s, const double prior[3][3], double scatter, double step[3],
                    double covariance[3][3])
{
  double h[3][3];
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      h[i][j] = s->h[i][j] / scatter + prior[i][j];
  if (!hl_replay_invert((const double(*)[3])h, covariance))
    return false;
  for (int i = 0; i < 3; i++)
    step[i] = hl_dot(covariance[i], s->g) / scatter;
  return true;
}

static double saved(const system_3 *s, const double step[3])
{
  double sum = 0;
  for (int i = 0; i < 3; i++)
    sum += step[i] * (2 * s->g[i] - hl_dot(s->h[i], step));
  return sum;
}

/* Whether the step of the others lowers the cost of each group, on the whole and beyond its scatter. */
static bool cross_validated(const system_3 fold[FOLDS], const system_3 *all,
                            const double prior[3][3], double scatter)
{
  double sum = 0, sum2 = 0, step[3], covariance[3][3];
  for (int f = 0; f < FOLDS; f++) {
    system_3 others = *all;
    for (int i = 0; i < 3; i++) {
      others.g[i] -= fold[f].g[i];
      for (int j = 0; j < 3; j++)
        others.h[i][j] -= fold[f].h[i][j];
    }
    if (!step_of(&others, prior, scatter, step, covariance))
      return false;
    const double gain = saved(&fold[f], step);
    sum += gain;
    sum2 += gain * gain;
  }
  const double mean = sum / FOLDS;
  const double error = sqrt(fmax(0, sum2 / FOLDS - mean * mean) / (FOLDS - 1));
  return mean > error;
}

void hl_replay_add_parts(const hl_lights *lights, hl_rig_light *l)
{
  const hl_sphere *ball = &lights->ball[l->ball];
  const int n = lights->camera.has_covariance ? hl_camera_intrinsics_count(&lights->camera) : 0;
  double(*c)[2] = l->covariance_rad2;
  for (int u = 0; u < 2; u++)
    for (int v = 0; v < 2; v++) {
      c[u][v] = l->own_rad2[u][v];
      for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
          c[u][v] +=
              l->by_center[u][i] * l->by_center[v][j] *
              (ball->n_intrinsics > 0 ? ball->held_covariance_m2[i][j] : ball->covariance_m2[i][j]);
      for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
          c[u][v] += l->by_intrinsics[u][i] * l->by_intrinsics[v][j] *
                     lights->camera.covariance[i * n + j];
    }
  c[0][1] = c[1][0] = 0.5 * (c[0][1] + c[1][0]);
  const double half = 0.5 * (c[0][0] + c[1][1]), across = 0.5 * (c[0][0] - c[1][1]);
  const double root = sqrt(across * across + c[0][1] * c[0][1]);
  l->ellipse_95_rad[0] = sqrt(chi2_95 * fmax(0, half + root));
  l->ellipse_95_rad[1] = sqrt(chi2_95 * fmax(0, half - root));
}

/* The direction turns, and its tangents with it. */
static void turn(hl_rig_light *l, const double by_center[2][3], const double step[3])
{
  double s[3] = {l->direction[0], l->direction[1], l->direction[2]};
  for (int u = 0; u < 2; u++)
    hl_add_scaled(s, hl_dot(by_center[u], step), l->tangent_basis[u], s);
  hl_unit(s, l->direction);
  for (int u = 0; u < 2; u++) {
    double *t = l->tangent_basis[u];
    hl_add_scaled(t, -hl_dot(t, l->direction), l->direction, t);
    if (u == 1)
      hl_add_scaled(t, -hl_dot(t, l->tangent_basis[0]), l->tangent_basis[0], t);
    hl_unit(t, t);
  }
}

static void move(const hl_replay_run *run, int b, const double step[3],
                 const double covariance[3][3], hl_lights *out)
{
  hl_sphere *ball = &out->ball[b];
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      double *held = ball->n_intrinsics > 0 ? &ball->held_covariance_m2[i][j] : NULL;
      ball->covariance_m2[i][j] += covariance[i][j] - (held ? *held : ball->covariance_m2[i][j]);
      if (held)
        *held = covariance[i][j];
    }
  hl_add_scaled(ball->center_m, 1, step, ball->center_m);
  for (int i = 0; i < out->n; i++) {
    hl_rig_light *l = &out->light[i];
    if (l->found && l->ball == b && run->frame[i].seen[b].scored)
      turn(l, (const double(*)[3])run->frame[i].seen[b].pose.by_center, step);
  }
}

static void refine(const hl_replay_run *run, int b, hl_lights *out)
{
  system_3 all = {{{0}}, {0}, 0}, fold[FOLDS];
  double prior[3][3], step[3], covariance[3][3];
  const hl_sphere *ball = &out->ball[b];
  memset(fold, 0, sizeof fold);
  for (int i = 0; i < run->session->n; i++)
    if (run->frame[i].seen[b].scored) {
      add(&run->frame[i].seen[b].pose, &fold[all.n % FOLDS]);
      add(&run->frame[i].seen[b].pose, &all);
    }
  if (all.n < LEAST_FRAMES) {
    hl_notes_add(&out->left_out, "joint pose", "ball %d: %d frames; at least %d are needed", b,
                 all.n, LEAST_FRAMES);
    return;
  }
  const double(*known)[3] =
      (const double(*)[3])(ball->n_intrinsics > 0 ? ball->held_covariance_m2 : ball->covariance_m2);
  const double scatter = scatter_of(run, b);
  if (!ball->has_covariance || !hl_replay_invert(known, prior) ||
      !step_of(&all, (const double(*)[3])prior, scatter, step, covariance)) {
    hl_notes_add(&out->left_out, "joint pose", "ball %d: the pose has no covariance", b);
    return;
  }
  hl_sphere moved = *ball;
  hl_add_scaled(moved.center_m, 1, step, moved.center_m);
  const double px = hl_replay_moved_px(run, ball, &moved);
  if (!cross_validated(fold, &all, (const double(*)[3])prior, scatter)) {
    hl_notes_add(&out->left_out, "joint pose",
                 "ball %d: a step of %.3f px does not lower the error of frames left out", b, px);
    return;
  }
  hl_notes_add(&out->used, "joint pose",
               "ball %d: %.3f px from the outlines' pose, by the shading of %d frames", b, px,
               all.n);
  move(run, b, step, (const double(*)[3])covariance, out);
}

void hl_replay_joint(const hl_replay_run *run, hl_lights *out)
{
  if (run->settings.no_joint || run->settings.frame_by_frame) {
    hl_notes_add(&out->left_out, "joint pose", "not asked for");
    return;
  }
  for (int b = 0; b < run->n_balls; b++)
    refine(run, b, out);
}
