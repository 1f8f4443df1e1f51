/* Where a near light is, and how sure that is.
 *
 * The fit has its direction s from the ball's centre C and its nearness k = R / distance, so
 *
 *   L = C + (R / k) s,   dL = dC + (R / k) (T dt - s dk / k)
 *
 * with T the tangents of s. dt and dk come from the pixels (joint covariance of the fit) and follow the
 * ball's centre; the two are independent. The radius is taken as exact, and so is what the camera's
 * intrinsics move beyond the centre.
 */
#include <math.h>

#include "halflight/vec3.h"
#include "light_work.h"

void hl_light_position(struct hl_light_work *work, const hl_light_model *model,
                       const hl_surface *surface, const hl_light_spread *spread, int threads,
                       hl_light *out)
{
  const hl_model_point *at = &work->best.at;
  const hl_sphere *ball = &surface->ball;
  if (!model->near || !(at->nearness > 0))
    return;
  const double distance = ball->radius_m / at->nearness;
  const int place[3] = {0, 1, hl_model_nearness(model)};
  double by_fit[3][3], by_center[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  hl_light_response r;
  out->near = true;
  hl_add_scaled(ball->center_m, distance, at->s, out->position_m);
  for (int i = 0; i < 3; i++) {
    by_fit[i][0] = distance * at->t[0][i];
    by_fit[i][1] = distance * at->t[1][i];
    by_fit[i][2] = -distance / at->nearness * at->s[i];
  }
  if (surface->is_ball && ball->has_covariance) {
    hl_light_respond(work, model, surface, spread, threads, &r);
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 3; j++)
        by_center[i][j] += by_fit[i][0] * r.by_center[0][j] + by_fit[i][1] * r.by_center[1][j] +
                           by_fit[i][2] * r.nearness_by_center[j];
  }
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      double sum = 0;
      for (int k = 0; k < 3; k++)
        for (int l = 0; l < 3; l++) {
          sum += by_fit[i][k] * spread->joint[place[k]][place[l]] * by_fit[j][l];
          if (surface->is_ball && ball->has_covariance)
            sum += by_center[i][k] * ball->covariance_m2[k][l] * by_center[j][l];
        }
      out->position_covariance_m2[i][j] = sum;
    }
}
