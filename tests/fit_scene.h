/* Samples of a sum of known curves along known directions: truth for the fits' tests. */
#ifndef HALFLIGHT_TESTS_FIT_SCENE_H
#define HALFLIGHT_TESTS_FIT_SCENE_H

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "halflight/fit.h"
#include "halflight/vec3.h"
#include "near.h"

#define SCENE_DEG 57.295779513082320877

enum { SCENE_TERMS = 4 };

typedef double (*scene_curve)(double t);

typedef struct scene_term {
  double a[3];
  scene_curve curve;
  bool foreshortened;
  double strength[HL_CHANNELS_MAX];
} scene_term;

typedef struct scene {
  int n, channels, terms;
  scene_term term[SCENE_TERMS];
  double light[3]; /* samples it does not light are left out; 0: all are lit */
  double noise;    /* standard deviation */
  unsigned seed;
} scene;

static inline double scene_linear(double t)
{
  return t;
}

static inline double scene_square(double t)
{
  return t * t;
}

static inline double scene_cubic(double t)
{
  return t * t * t + 0.5 * t;
}

static inline double scene_gloss(double t)
{
  return pow(t, 20);
}

static inline double scene_growth(double t)
{
  return 0.3 * expm1(2 * t);
}

static inline void scene_add(scene *s, double x, double y, double z, scene_curve curve,
                             double strength)
{
  scene_term *t = &s->term[s->terms++];
  const double a[3] = {x, y, z};
  hl_unit(a, t->a);
  t->curve = curve;
  for (int c = 0; c < HL_CHANNELS_MAX; c++)
    t->strength[c] = strength * (1 - 0.25 * c);
}

static inline scene scene_of(int n)
{
  return (scene){.n = n, .channels = 1, .seed = 1};
}

/* Two lobes about (3,2,9) and (-5,3,8). */
static inline scene scene_two_lobes(int n)
{
  scene s = scene_of(n);
  scene_add(&s, 3, 2, 9, scene_gloss, 1);
  scene_add(&s, -5, 3, 8, scene_growth, 1);
  return s;
}

/* A linear part along (1,1,1) and a lobe about the half vector with the view. */
static inline scene scene_dichromatic(int n)
{
  scene s = scene_of(n);
  const double light[3] = {1, 1, 1};
  double h[3];
  hl_unit(light, s.light);
  for (int k = 0; k < 3; k++)
    h[k] = s.light[k] + (k == 2);
  scene_add(&s, 1, 1, 1, scene_linear, 1);
  scene_add(&s, h[0], h[1], h[2], scene_gloss, 0.8);
  return s;
}

/* Normals of a spiral over the half sphere that is seen, what they show, and nothing else. */
static inline hl_samples scene_samples(const scene *s)
{
  hl_samples out = {.channels = s->channels};
  test_random r = {s->seed};
  const bool lit = hl_norm(s->light) > 0;
  out.normal = malloc(3 * (size_t)s->n * sizeof(double));
  for (int c = 0; c < s->channels; c++)
    out.value[c] = malloc((size_t)s->n * sizeof(double));
  for (int i = 0; i < s->n; i++) {
    const double z = 1 - 0.95 * (i + 0.5) / s->n, radius = sqrt(1 - z * z);
    const double turn = 10.166407384630519 * (i + 0.5); /* pi (1 + sqrt 5) */
    const double n[3] = {radius * cos(turn), radius * sin(turn), z};
    if (lit && hl_dot(n, s->light) < 0.02)
      continue;
    memcpy(out.normal + 3 * (size_t)out.n, n, sizeof n);
    for (int c = 0; c < s->channels; c++) {
      double sum = s->noise > 0 ? s->noise * random_normal(&r) : 0;
      for (int k = 0; k < s->terms; k++) {
        const scene_term *t = &s->term[k];
        const double cosine = hl_dot(t->a, n);
        if (cosine > 0 || t->curve == scene_linear)
          sum += t->strength[c] * t->curve(cosine) * (t->foreshortened ? 1 / n[2] : 1);
      }
      out.value[c][out.n] = sum > 0 ? sum : 0;
    }
    out.n++;
  }
  return out;
}

static inline hl_fit *scene_fit_samples(const hl_samples *samples, hl_fit_model model,
                                        const hl_fit_known *known, const hl_fit_settings *settings)
{
  hl_ctx ctx = {0};
  hl_fit *fit = malloc(sizeof *fit);
  assert_non_null(fit);
  if (hl_fit_samples(&ctx, samples, model, known, settings, fit) != HL_OK) {
    print_error("%s\n", ctx.msg);
    fail();
  }
  return fit;
}

/* free() */
static inline hl_fit *scene_fit(const scene *s, hl_fit_model model, const hl_fit_known *known,
                                const hl_fit_settings *settings)
{
  hl_samples samples = scene_samples(s);
  hl_fit *fit = scene_fit_samples(&samples, model, known, settings);
  hl_samples_free(&samples);
  return fit;
}

static inline hl_fit_settings scene_terms(int terms)
{
  hl_fit_settings s = hl_fit_defaults();
  s.terms = terms;
  s.max_terms = terms;
  return s;
}

/* Angle from the term nearest to a to it [deg]. */
static inline double scene_off_deg(const hl_fit *fit, const double a[3], int *nearest)
{
  double least = HUGE_VAL;
  for (int i = 0; i < fit->n_terms; i++) {
    const double off = SCENE_DEG * hl_angle(fit->term[i].direction, a);
    if (off < least) {
      least = off;
      if (nearest)
        *nearest = i;
    }
  }
  return least;
}

#endif
