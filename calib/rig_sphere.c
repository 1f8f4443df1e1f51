/*
 * A ball's place in two sessions.
 *
 * D = c' - c against Cov(c) + Cov(c'), the camera's share entering once where both sessions used one
 * calibration: chi-squared of 3. A camera that turned by w carries the ball along: where the mount is
 * named, w x c is taken off first.
 */
#include <math.h>

#include "halflight/notes.h"
#include "halflight/vec3.h"
#include "rig_work.h"

/* += J K J' of the camera's share; J may be the difference of two. */
static void add_camera(const hl_camera *camera, const hl_sphere *to, const hl_sphere *from,
                       double cov[9])
{
  const int n = hl_camera_intrinsics_count(camera);
  double j[3][HL_INTRINSICS_MAX];
  for (int i = 0; i < 3; i++)
    for (int k = 0; k < n; k++)
      j[i][k] = to->by_intrinsics[i][k] - (from ? from->by_intrinsics[i][k] : 0);
  for (int i = 0; i < 9; i++)
    for (int k = 0; k < n; k++)
      for (int l = 0; l < n; l++)
        cov[i] += j[i / 3][k] * camera->covariance[k * n + l] * j[i % 3][l];
}

static void sphere_covariance(const hl_rig_run *r, int i, double cov[9])
{
  const hl_sphere *a = &r->reference->ball[i], *b = &r->current->ball[i];
  const bool apart = a->n_intrinsics > 0 && b->n_intrinsics > 0;
  const double *p = apart ? &a->held_covariance_m2[0][0] : &a->covariance_m2[0][0];
  const double *q = apart ? &b->held_covariance_m2[0][0] : &b->covariance_m2[0][0];
  for (int k = 0; k < 9; k++)
    cov[k] = p[k] + q[k];
  if (apart && r->reference->camera.has_covariance && r->current->camera.has_covariance) {
    add_camera(&r->current->camera, b, r->one_camera ? a : NULL, cov);
    if (!r->one_camera)
      add_camera(&r->reference->camera, a, NULL, cov);
  }
}

/* Takes off what the mount's rotation explains; its uncertainty joins that of the change. */
static void take_off_mount(const hl_rig_turn *turn, const double center[3], double change[3],
                           double cov[9])
{
  double carried[3], j[3][3]; /* w x c = J w */
  hl_cross(turn->rotation_rad, center, carried);
  hl_add_scaled(change, -1, carried, change);
  for (int k = 0; k < 3; k++) {
    double column[3], unit[3] = {0};
    unit[k] = 1;
    hl_cross(unit, center, column);
    for (int i = 0; i < 3; i++)
      j[i][k] = column[i];
  }
  for (int i = 0; i < 9; i++)
    for (int k = 0; k < 3; k++)
      for (int l = 0; l < 3; l++)
        cov[i] += j[i / 3][k] * turn->rotation_covariance[k][l] * j[i % 3][l];
}

void hl_rig_compare_spheres(hl_rig_run *r, bool turned)
{
  for (int i = 0; i < r->reference->n_balls; i++) {
    const hl_sphere *a = &r->reference->ball[i], *b = &r->current->ball[i];
    double cov[9];
    if (!a->has_covariance || !b->has_covariance)
      continue;
    hl_rig_cause *c = hl_rig_add(r, HL_RIG_SPHERE, "", i, i);
    hl_add_scaled(b->center_m, -1, a->center_m, c->change);
    sphere_covariance(r, i, cov);
    if (turned)
      take_off_mount(&r->turn, a->center_m, c->change, cov);
    hl_rig_judge(r, c, hl_norm(c->change), hl_rig_square(cov, c->change, 3), 3);
    if (c->moved && turned)
      hl_notes_add(&r->out->notes, "sphere",
                   "the camera turned, and whether it also shifted or the ball did cannot be told");
  }
}
