/* A ball under one light, drawn by analytic reflectances that are not the fitted basis, with what a scene
 * may need beside them: ambient light, a light at a finite distance, a lobe about the view, a label on
 * the ball, a bent response. */
#ifndef HALFLIGHT_TESTS_TERM_SCENE_H
#define HALFLIGHT_TESTS_TERM_SCENE_H

#include "light_scene.h"

typedef enum term_shader { TERM_GGX, TERM_PHONG, TERM_OREN_NAYAR } term_shader;

typedef struct term_scene {
  lit_scene base; /* camera, ball, light, noise, channels; its lobe and body are not used */
  term_shader shader;
  double albedo[3], gloss[3]; /* of the body; scale of the lobe */
  double roughness[3];        /* GGX alpha, Oren-Nayar sigma; Phong's exponent is 2/alpha^2 - 2 */
  double distance_radii;      /* of the light from the ball's centre; 0 = distant */
  double ambient;
  double backscatter; /* of the lobe about the view, times n.s */
  double gamma;       /* recorded = radiance^(1 / (1 + gamma)), 0.4 held */
  double label;       /* share of the seen ball under a patch of other reflectance */
  int across;
} term_scene;

static inline term_scene term_ball(term_shader shader)
{
  term_scene s = {.base = lit_glossy(), .shader = shader, .across = 3};
  s.base.across = 1;
  s.base.noise = 0.001;
  for (int c = 0; c < 3; c++) {
    s.albedo[c] = 0.4;
    s.gloss[c] = shader == TERM_OREN_NAYAR ? 0 : 1;
    s.roughness[c] = shader == TERM_OREN_NAYAR ? 0.25 : 0.2;
  }
  return s;
}

static inline double term_smith(double cosine, double alpha)
{
  const double a2 = alpha * alpha, c2 = cosine * cosine;
  return 2 * cosine / (cosine + sqrt(a2 + (1 - a2) * c2));
}

/* Radiance under unit irradiance from s, cosine included. */
static inline double term_shade(const term_scene *t, const double n[3], const double v[3],
                                const double s[3], int c)
{
  const double ns = hl_dot(n, s), nv = hl_dot(n, v), alpha = t->roughness[c];
  double h[3], mirror[3];
  if (ns <= 0)
    return 0;
  hl_add_scaled(s, 1, v, h);
  hl_unit(h, h);
  const double nh = hl_dot(n, h);
  double value = t->albedo[c] * ns;
  if (t->shader == TERM_GGX) {
    const double q = nh * nh * (alpha * alpha - 1) + 1, d = alpha * alpha / (3.14159265 * q * q);
    const double fresnel = 0.04 + 0.96 * pow(1 - hl_dot(s, h), 5);
    value += t->gloss[c] * d * fresnel * term_smith(ns, alpha) * term_smith(nv, alpha) / (4 * nv);
  } else if (t->shader == TERM_PHONG) {
    for (int k = 0; k < 3; k++)
      mirror[k] = 2 * ns * n[k] - s[k];
    value += 0.3 * t->gloss[c] * pow(fmax(hl_dot(mirror, v), 0), 2 / (alpha * alpha) - 2);
  } else {
    const double s2 = alpha * alpha, a = 1 - 0.5 * s2 / (s2 + 0.33), b = 0.45 * s2 / (s2 + 0.09);
    const double flat = hl_dot(s, v) - ns * nv;
    value *= a + b * (flat > 0 ? flat / fmax(ns, nv) : flat);
  }
  const double nv4 = nv * nv * nv * nv;
  return value + t->backscatter * ns * nv4 * nv4;
}

static inline double term_point(const term_scene *t, const double n[3], const double v[3], int c)
{
  double s[3], fall = 1;
  memcpy(s, t->base.light, sizeof s);
  if (t->distance_radii > 0) {
    hl_add_scaled(s, -1 / t->distance_radii, n, s);
    fall = 1 / hl_dot(s, s);
    hl_unit(s, s);
  }
  return fall * term_shade(t, n, v, s, c) + t->ambient;
}

static inline double term_mean(const term_scene *t, int pixel, int c)
{
  const hl_camera *camera = &t->base.camera;
  const double *center = t->base.ball.center_m, r = t->base.ball.radius_m;
  const int across = t->across;
  double sum = 0;
  for (int k = 0; k < across * across; k++) {
    double ray[3], n[3];
    const double x = pixel % camera->width + (k % across + 0.5) / across - 0.5;
    const double y = pixel / camera->width + (k / across + 0.5) / across - 0.5;
    if (hl_camera_unproject(NULL, camera, x, y, ray) != HL_OK)
      abort();
    const double along = hl_dot(ray, center);
    const double inside = along * along - hl_dot(center, center) + r * r;
    for (int i = 0; i < 3; i++)
      n[i] = (ray[i] * (along - sqrt(fmax(inside, 0))) - center[i]) / r;
    const double v[3] = {-ray[0], -ray[1], -ray[2]};
    sum += term_point(t, n, v, c);
  }
  return sum / (across * across);
}

/* The label lies below the middle of the seen ball, a disc of evenly grey paper. */
static inline bool term_on_label(const term_scene *t, const double n[3])
{
  static const double middle[3] = {0.35, 0.35, -0.87};
  const double outer = sqrt(t->label);
  return t->label > 0 && hypot(n[0] - middle[0], n[1] - middle[1]) < outer;
}

static inline lit_shot term_shot(const term_scene *t, uint64_t seed)
{
  test_random random = {seed};
  lit_shot out = {.surface = lit_surface(&t->base)};
  out.frame = lit_frame(&t->base, &out.surface, &random);
  for (int i = 0; i < out.surface.n; i++)
    for (int c = 0; c < t->base.channels; c++) {
      const size_t at = (size_t)(out.surface.pixel[i] * t->base.channels + c);
      const double *n = out.surface.normal + 3 * i;
      double value = term_mean(t, out.surface.pixel[i], c);
      if (term_on_label(t, n))
        value = 0.1 + 0.7 * fmax(hl_dot(n, t->base.light), 0);
      value = 0.4 * pow(value / 0.4, 1 / (1 + t->gamma));
      out.frame.radiance[at] = (float)(value + t->base.noise * random_normal(&random));
    }
  return out;
}

static inline hl_light term_estimate(const term_scene *t, const hl_light_settings *settings,
                                     uint64_t seed)
{
  lit_shot shot = term_shot(t, seed);
  const hl_light out = lit_light_of(&shot, settings);
  lit_shot_free(&shot);
  return out;
}

static inline const char *term_note(const hl_notes *notes, const char *what)
{
  for (int i = 0; i < notes->n; i++)
    if (strcmp(notes->note[i].what, what) == 0)
      return notes->note[i].why;
  return NULL;
}

#endif
