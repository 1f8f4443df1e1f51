/* Samples and models for the tests of sums of ridges. */
#ifndef HALFLIGHT_TESTS_RIDGE_SCENE_H
#define HALFLIGHT_TESTS_RIDGE_SCENE_H

#include <stdlib.h>
#include <string.h>

#include "../src/ridge_refine.h"
#include "halflight/vec3.h"
#include "near.h"

/* Random normals that are seen and lit, random data above 0; with views of their own or without. */
static inline hl_ridge_data ridge_samples(int n, int channels, bool views, uint64_t seed)
{
  test_random r = {seed};
  hl_ridge_data d = {.n = n, .channels = channels, .mean_view = {0, 0, 1}};
  for (int k = 0; k < 3; k++) {
    d.normal[k] = malloc((size_t)n * sizeof(double));
    d.view[k] = views ? malloc((size_t)n * sizeof(double)) : NULL;
    d.y[k] = k < channels ? malloc((size_t)n * sizeof(double)) : NULL;
  }
  d.nv = malloc((size_t)n * sizeof(double));
  d.w = malloc((size_t)n * sizeof(double));
  for (int i = 0; i < n; i++) {
    const double raw[3] = {random_between(&r, -0.7, 0.9), random_between(&r, -0.7, 0.9), 1};
    double m[3], v[3] = {views ? random_between(&r, -0.1, 0.1) : 0,
                         views ? random_between(&r, -0.1, 0.1) : 0, 1};
    hl_unit(raw, m);
    hl_unit(v, v);
    for (int k = 0; k < 3; k++) {
      d.normal[k][i] = m[k];
      if (views)
        d.view[k][i] = v[k];
      if (k < channels)
        d.y[k][i] = random_between(&r, 0.2, 2) * (1 + k);
    }
    d.nv[i] = hl_dot(m, v);
    d.w[i] = random_between(&r, 0.5, 2);
  }
  return d;
}

static inline void ridge_samples_free(hl_ridge_data *d)
{
  for (int k = 0; k < 3; k++) {
    free(d->normal[k]);
    free(d->view[k]);
    free(d->y[k]);
  }
  free(d->nv);
  free(d->w);
}

static inline hl_spline ridge_spline(int intervals, double top)
{
  double breaks[HL_SPLINE_MAX];
  hl_spline spline;
  for (int i = 0; i <= intervals; i++)
    breaks[i] = top * i * i / ((double)intervals * intervals);
  hl_spline_init(&spline, breaks, intervals + 1);
  return spline;
}

static inline hl_axis ridge_axis(hl_axis_kind kind, double x, double y, double z)
{
  hl_axis axis = {.kind = kind, .cs = x, .cv = y};
  const double a[3] = {x, y, z};
  hl_unit(a, axis.a);
  return axis;
}

/* A linear term and a foreshortened and a plain lobe on one spline. */
static inline hl_ridges ridge_model(const hl_spline *spline)
{
  hl_ridges r = {.n = 3, .linear = {true}, .foreshortened = {false, true}};
  for (int i = 0; i < 3; i++) {
    r.spline[i] = i > 0 ? spline : NULL;
    r.smooth[i] = 1e-5;
  }
  return r;
}

#endif
