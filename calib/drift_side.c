/*
 * One calibration, ready to be compared: its covariance as the product of a lower triangle with itself.
 *
 * Where views pull the intrinsics apart by more than white noise does (hl_calibration.scatter, tested
 * as chi-squared with as many degrees of freedom as views times intrinsics), the covariances are
 * widened by that factor, and it is the views that the noise is known from.
 */
#include "drift_side.h"

#include <math.h>
#include <stdio.h>

#include "halflight/notes.h"
#include "significance.h"
#include "spd.h"

static const double scatter_rate = 0.01; /* how often white noise is called more than that */

bool hl_drift_lower(const double *matrix, int n, int stride, double *out)
{
  hl_spd f;
  if (!hl_spd_factor(matrix, n, 0, &f, NULL))
    return false;
  for (int i = 0; i < n; i++)
    for (int k = 0; k < n; k++)
      out[i * stride + k] = k <= i ? f.l[i * n + k] / f.scale[i] : 0;
  return true;
}

void hl_drift_whiten(const double *lower, int lower_stride, int n, double *rows, int columns,
                     int stride)
{
  for (int i = 0; i < n; i++)
    for (int c = 0; c < columns; c++) {
      double sum = rows[i * stride + c];
      for (int k = 0; k < i; k++)
        sum -= lower[i * lower_stride + k] * rows[k * stride + c];
      rows[i * stride + c] = sum / lower[i * lower_stride + i];
    }
}

static int views_used(const hl_calibration *c)
{
  int n = 0;
  for (int i = 0; i < c->n_views; i++)
    n += c->view[i].used;
  return n;
}

static void widen(const char *which, const hl_calibration *c, hl_drift_side *out, hl_notes *notes)
{
  const int views = views_used(c);
  const double dof = (double)out->n * views;
  out->widened = 1;
  out->noise_dof = HUGE_VAL;
  if (c->camera.observations > 0)
    out->noise_dof = fmax(1, 2.0 * c->camera.observations - out->n - HL_POSE_SIZE * views);
  if (!(c->scatter > 1) || hl_significance(c->scatter * dof, dof, out->noise_dof) > scatter_rate)
    return;
  out->widened = c->scatter;
  out->noise_dof = dof;
  hl_notes_add(notes, which,
               "its views disagree more than their corners' noise explains; its deviations are "
               "taken %.2f times as large",
               sqrt(c->scatter));
}

hl_status hl_drift_side_of(hl_ctx *ctx, const char *which, const hl_calibration *calibration,
                           hl_drift_side *out, hl_notes *notes)
{
  static const char *const names[] = {"fx", "fy", "cx", "cy"};
  const hl_camera *camera = &calibration->camera;
  const int n = hl_camera_intrinsics_count(camera);
  hl_spd factor;
  int weakest = 0;
  if (!camera->has_covariance)
    return hl_fail(ctx, HL_ERR_DEGENERATE,
                   "the %s camera states no covariance; one that 'halflight calibrate' wrote does",
                   which);
  if (!hl_spd_factor(camera->covariance, n, 0, &factor, &weakest)) {
    char name[24];
    if (weakest < 4)
      snprintf(name, sizeof name, "%s", names[weakest]);
    else
      snprintf(name, sizeof name, "distortion[%d]", weakest - 4);
    return hl_fail(ctx, HL_ERR_DEGENERATE,
                   "the %s camera's covariance is singular at %s; a calibration that determines "
                   "every intrinsic is needed: 'halflight calibrate' with tilted boards",
                   which, name);
  }
  out->calibration = calibration;
  out->n = n;
  hl_camera_intrinsics(camera, out->theta);
  widen(which, calibration, out, notes);
  hl_drift_lower(camera->covariance, n, HL_INTRINSICS_MAX, out->lower[0]);
  for (int i = 0; i < n; i++)
    for (int k = 0; k <= i; k++)
      out->lower[i][k] *= sqrt(out->widened);
  return HL_OK;
}
