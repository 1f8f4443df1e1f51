/* BRDFs of known form, and tables of them: truth for the tests of measured materials. */
#ifndef HALFLIGHT_TESTS_MERL_SCENE_H
#define HALFLIGHT_TESTS_MERL_SCENE_H

#include "halflight/merl.h"
#include "halflight/vec3.h"
#include "near.h"

typedef void (*test_brdf)(const double n[3], const double s[3], const double v[3], double out[3]);

static inline void brdf_lambert(const double n[3], const double s[3], const double v[3],
                                double out[3])
{
  (void)n;
  (void)s;
  (void)v;
  out[0] = 0.3;
  out[1] = 0.2;
  out[2] = 0.1;
}

/* GGX without Fresnel or shadowing, roughness 0.3, over Lambert: 1 / ((n.s)(n.v)) at grazing. */
static inline void brdf_ggx(const double n[3], const double s[3], const double v[3], double out[3])
{
  const double a2 = 0.09;
  double h[3];
  hl_add_scaled(s, 1, v, h);
  hl_unit(h, h);
  const double nh = hl_dot(n, h), q = nh * nh * (a2 - 1) + 1;
  const double d = a2 / (3.14159265358979323846 * q * q);
  const double lobe = d / (4 * hl_dot(n, s) * hl_dot(n, v));
  for (int c = 0; c < 3; c++)
    out[c] = 0.1 * (c + 1) + lobe;
}

/* A reciprocal isotropic BRDF that is not the same for phi_diff and -phi_diff: the turn of s about n,
 * from v on, counts by its sign. sin 2x is the same when s and v change places, x to x + pi. */
static inline void brdf_twisted(const double n[3], const double s[3], const double v[3],
                                double out[3])
{
  double h[3], b[3], t[3];
  hl_add_scaled(s, 1, v, h);
  hl_unit(h, h);
  hl_cross(n, h, b);
  hl_unit(b, b);
  hl_cross(b, h, t);
  const double x = hl_dot(t, s), y = hl_dot(b, s), z = hl_dot(h, s);
  out[0] = 1 + x * y;
  out[1] = 1 + z * (x * x - y * y);
  out[2] = 2 - hl_dot(n, h) * x * y;
}

/* Centres below the horizon are not measured. */
static inline hl_merl table_of(test_brdf brdf)
{
  static const double n[3] = {0, 0, 1};
  hl_merl merl = {0};
  assert_int_equal(hl_merl_new(NULL, &merl), HL_OK);
  for (int i = 0; i < HL_MERL_THETA_HALF; i++)
    for (int j = 0; j < HL_MERL_THETA_DIFF; j++)
      for (int k = 0; k < HL_MERL_PHI_DIFF; k++) {
        double s[3], v[3], value[3];
        hl_merl_directions(hl_merl_center(i, j, k), s, v);
        if (s[2] <= 0 || v[2] <= 0)
          continue;
        brdf(n, s, v, value);
        for (int c = 0; c < 3; c++)
          merl.value[(size_t)c * HL_MERL_CELLS + hl_merl_cell(i, j, k)] =
              value[c] / hl_merl_scale(c);
      }
  return merl;
}

static inline void random_direction(test_random *r, double out[3])
{
  for (int i = 0; i < 3; i++)
    out[i] = random_normal(r);
  hl_unit(out, out);
}

/* n, s, v with n.s and n.v above `least`. */
static inline void random_scene(test_random *r, double least, double n[3], double s[3], double v[3])
{
  random_direction(r, n);
  do
    random_direction(r, s);
  while (hl_dot(n, s) < least);
  do
    random_direction(r, v);
  while (hl_dot(n, v) < least);
}

#endif
