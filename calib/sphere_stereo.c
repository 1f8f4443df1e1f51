/*
 * The stereographic picture X = 2 f (ux, uy) / (1 + uz) of rays u: angles are kept and every cone
 * of rays is a circle, for any lens and any place in the frame.
 */
#include "sphere_stereo.h"

#include <stdlib.h>

hl_status hl_stereo_make(hl_ctx *ctx, const hl_camera *camera, double focal, hl_stereo *g)
{
  g->nx = (camera->width + 31) / 32;
  g->ny = (camera->height + 31) / 32;
  if (g->nx > 64)
    g->nx = 64;
  if (g->ny > 64)
    g->ny = 64;
  g->dx = (double)(camera->width - 1) / g->nx;
  g->dy = (double)(camera->height - 1) / g->ny;
  g->at = malloc((size_t)(g->nx + 1) * (size_t)(g->ny + 1) * 2 * sizeof *g->at);
  if (!g->at)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for a grid of rays");
  for (int j = 0; j <= g->ny; j++) {
    for (int i = 0; i <= g->nx; i++) {
      double u[3];
      const hl_status st = hl_camera_unproject(ctx, camera, i * g->dx, j * g->dy, u);
      if (st != HL_OK) {
        free(g->at);
        g->at = NULL;
        return st;
      }
      double *to = g->at + 2 * ((size_t)j * (size_t)(g->nx + 1) + (size_t)i);
      to[0] = 2 * focal * u[0] / (1 + u[2]);
      to[1] = 2 * focal * u[1] / (1 + u[2]);
    }
  }
  return HL_OK;
}

static int clamp_int(int v, int low, int high)
{
  return v < low ? low : v > high ? high : v;
}

void hl_stereo_at(const hl_stereo *g, double x, double y, double out[2], double jac[2][2])
{
  const int i = clamp_int((int)(x / g->dx), 0, g->nx - 1);
  const int j = clamp_int((int)(y / g->dy), 0, g->ny - 1);
  const double a = x / g->dx - i, b = y / g->dy - j;
  const double *p = g->at + 2 * ((size_t)j * (size_t)(g->nx + 1) + (size_t)i);
  const double *q = p + 2 * (size_t)(g->nx + 1);
  for (int k = 0; k < 2; k++) {
    out[k] = (1 - b) * ((1 - a) * p[k] + a * p[2 + k]) + b * ((1 - a) * q[k] + a * q[2 + k]);
    jac[k][0] = ((1 - b) * (p[2 + k] - p[k]) + b * (q[2 + k] - q[k])) / g->dx;
    jac[k][1] = ((1 - a) * (q[k] - p[k]) + a * (q[2 + k] - p[2 + k])) / g->dy;
  }
}

void hl_stereo_free(hl_stereo *g)
{
  free(g->at);
  g->at = NULL;
}
