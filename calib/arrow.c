/*
 * Normal equations in the shape of an arrow.
 *
 * With theta the intrinsics, p_i the pose of view i, and r the residuals, H = J'J has the blocks
 *
 *   A = sum d(r)/d(theta)' d(r)/d(theta),  B_i = d(r)/d(p_i)' d(r)/d(p_i),
 *   E_i = d(r)/d(theta)' d(r)/d(p_i)
 *
 * and no block between two views. Eliminating every p_i leaves the Schur complement
 *
 *   S = A - sum E_i B_i^-1 E_i',   S d(theta) = sum (E_i B_i^-1 g_i - g_theta,i)
 *   d(p_i) = -B_i^-1 (g_i + E_i' d(theta))
 *
 * so the cost is linear in the number of views.
 */
#include "arrow.h"

#include <string.h>

void hl_arrow_clear(hl_arrow *arrow, int n)
{
  memset(arrow, 0, sizeof *arrow);
  arrow->n = n;
}

void hl_arrow_view_clear(hl_arrow_view *view)
{
  memset(view, 0, sizeof *view);
}

void hl_arrow_add(hl_arrow *arrow, hl_arrow_view *view, const double *by_intrinsics,
                  const double by_pose[HL_POSE_SIZE], double residual)
{
  const int n = arrow ? arrow->n : 0;
  for (int i = 0; i < HL_POSE_SIZE; i++) {
    view->gradient[i] += by_pose[i] * residual;
    for (int k = 0; k <= i; k++)
      view->b[i * HL_POSE_SIZE + k] += by_pose[i] * by_pose[k];
  }
  for (int i = 0; i < n; i++) {
    const double d = by_intrinsics[i];
    arrow->gradient[i] += d * residual;
    view->own_gradient[i] += d * residual;
    for (int k = 0; k <= i; k++)
      arrow->a[i * n + k] += d * by_intrinsics[k];
    for (int k = 0; k < HL_POSE_SIZE; k++)
      view->e[i][k] += d * by_pose[k];
  }
}

bool hl_arrow_factor(hl_arrow *arrow, hl_arrow_view *const *views, int n_views, double damping,
                     hl_arrow_fault *fault)
{
  const int n = arrow->n;
  memcpy(arrow->s, arrow->a, sizeof arrow->s);
  for (int v = 0; v < n_views; v++) {
    hl_arrow_view *view = views[v];
    fault->view = v;
    if (!hl_spd_factor(view->b, HL_POSE_SIZE, damping, &view->factor, &fault->unknown))
      return false;
    for (int i = 0; i < n; i++) {
      hl_spd_solve(&view->factor, view->e[i], view->w[i]);
      for (int k = 0; k <= i; k++)
        for (int j = 0; j < HL_POSE_SIZE; j++)
          arrow->s[i * n + k] -= view->w[i][j] * view->e[k][j];
    }
  }
  for (int i = 0; i < n; i++)
    for (int k = 0; k < i; k++)
      arrow->s[k * n + i] = arrow->s[i * n + k];
  fault->view = -1;
  return hl_spd_factor(arrow->s, n, damping, &arrow->schur, &fault->unknown);
}

void hl_arrow_view_pull(const hl_arrow_view *view, int n, double out[HL_INTRINSICS_MAX])
{
  for (int i = 0; i < n; i++) {
    out[i] = -view->own_gradient[i];
    for (int j = 0; j < HL_POSE_SIZE; j++)
      out[i] += view->w[i][j] * view->gradient[j];
  }
}

void hl_arrow_step(const hl_arrow *arrow, hl_arrow_view *const *views, int n_views,
                   double out[HL_INTRINSICS_MAX])
{
  double right[HL_INTRINSICS_MAX];
  for (int i = 0; i < arrow->n; i++) {
    right[i] = -arrow->gradient[i];
    for (int v = 0; v < n_views; v++)
      for (int j = 0; j < HL_POSE_SIZE; j++)
        right[i] += views[v]->w[i][j] * views[v]->gradient[j];
  }
  hl_spd_solve(&arrow->schur, right, out);
}

void hl_arrow_view_step(const hl_arrow_view *view, int n, const double *by_intrinsics,
                        double out[HL_POSE_SIZE])
{
  double right[HL_POSE_SIZE];
  for (int j = 0; j < HL_POSE_SIZE; j++) {
    right[j] = -view->gradient[j];
    for (int i = 0; i < n; i++)
      right[j] -= view->e[i][j] * by_intrinsics[i];
  }
  hl_spd_solve(&view->factor, right, out);
}
