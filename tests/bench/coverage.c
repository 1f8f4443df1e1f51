/* coverage [DRAWS [SCENE]]: how often the stated 95 % ellipse holds the light, by scene.
 *
 * Each scene is an analytic reflectance, its pixels true means over their areas (8 x 8 samples), to
 * which every draw adds noise of a fixed seed before it is clipped. Columns:
 *
 *   inside  share of draws whose ellipse holds the light
 *   ratio   mean of d' C^-1 d / 2: squared error over stated variance, 1 where the ellipse is true
 *   median  the same's median over that of a chi-square: above 1 too narrow, below 1 too wide
 *   bias    distance of the mean answer from the light [deg]; `rms` the answers' error [deg]
 *   scatter bound over the draws' own covariance (square root of determinants)
 *   stated  efficiency as the answer states it, mean
 *   ok      share of draws called ok; `worst` largest (error - 0.2 deg) of those in stated deviations
 *   plain, bent  shares of draws that keep a plain lobe, and the bends
 *
 * Asserts nothing. From the tree's root:
 *   cc -std=c11 -O2 -Iinclude -Itests tests/bench/coverage.c build/libhalflight.a -lcmocka -fopenmp \
 *     -ljansson -lyaml -lz -lm -o coverage
 */
#include <stdio.h>

#include "light_scene.h"

enum { ACROSS = 8, DRAWS_MAX = 2000 };

typedef enum shader { GGX, GGX_MASKED, PHONG, OREN_NAYAR } shader;

typedef struct scene {
  const char *name;
  shader shader;
  double width; /* GGX roughness^2, Phong exponent, Oren and Nayar's sigma */
  double body, gloss;
  double radius_px, angle_deg, turn_deg;
  double noise, shot; /* variance = noise^2 + shot y */
  double clip;        /* 0 = none */
  bool wide;          /* ball at the corner of a wide, distorting lens */
  bool holds;         /* the model describes it exactly */
} scene;

static const scene scenes[] = {
    {"glossy", GGX, 0.2, 0.5, 0.4, 40, 45, -60, 0.004, 0, 0, false, true},
    {"clipped", GGX, 0.2, 0.5, 0.6, 40, 45, -60, 0.004, 0, 0.6, false, true},
    {"clipped phong", PHONG, 60, 0.4, 0.8, 40, 60, 30, 0.004, 0, 0.7, false, true},
    {"wide lens", GGX, 0.25, 0.5, 0.4, 26, 50, 120, 0.004, 0, 0, true, true},
    {"matte", GGX, 0.2, 0.6, 0, 40, 45, 30, 0.004, 0, 0, false, true},
    {"oblique", GGX, 0.2, 0.5, 0.3, 40, 80, 200, 0.004, 0, 0, false, true},
    {"narrow", GGX, 0.06, 0.5, 1.5, 40, 40, 10, 0.004, 0, 0, false, true},
    {"rough", GGX, 0.45, 0.5, 0.2, 40, 40, 100, 0.004, 0, 0, false, true},
    {"shot noise", GGX, 0.2, 0.5, 0.4, 40, 45, -60, 0.001, 3e-5, 0, false, true},
    {"masked", GGX_MASKED, 0.3, 0.4, 0.4, 40, 50, 60, 0.003, 0, 0, false, false},
    {"oren-nayar", OREN_NAYAR, 0.5, 0.6, 0, 40, 50, 60, 0.003, 0, 0, false, false},
};

static double smith(double c, double a2)
{
  return 2 * c / (c + sqrt(a2 + (1 - a2) * c * c));
}

static double oren_nayar(double sigma, double nl, double nv, const double n[3], const double l[3],
                         const double v[3])
{
  const double s2 = sigma * sigma, a = 1 - 0.5 * s2 / (s2 + 0.33), b = 0.45 * s2 / (s2 + 0.09);
  double pl[3], pv[3];
  hl_add_scaled(l, -nl, n, pl);
  hl_add_scaled(v, -nv, n, pv);
  const double both = hl_norm(pl) * hl_norm(pv);
  const double phi = both > 1e-12 ? fmax(0, hl_dot(pl, pv) / both) : 0;
  const double sin_both = sqrt(fmax(0, (1 - nl * nl) * (1 - nv * nv)));
  return nl * (a + b * phi * sin_both / fmax(nl, nv));
}

static double shade(const scene *s, const double n[3], const double v[3], const double l[3])
{
  const double nl = hl_dot(n, l), nv = hl_dot(n, v);
  double h[3];
  if (!(nl > 0))
    return 0;
  hl_add_scaled(l, 1, v, h);
  hl_unit(h, h);
  const double nh = hl_dot(n, h), a2 = s->width * s->width, q = nh * nh * (a2 - 1) + 1;
  switch (s->shader) {
  case GGX:
    return s->body * nl + s->gloss * a2 * a2 / (q * q) / nv;
  case GGX_MASKED:
    return s->body * nl + s->gloss * a2 * a2 / (q * q) * smith(nl, a2) * smith(nv, a2) / nv;
  case PHONG:
    return s->body * nl + s->gloss * pow(fmax(nh, 0), s->width);
  default:
    return s->body * oren_nayar(s->width, nl, nv, n, l, v);
  }
}

static double pixel_mean(const scene *s, const hl_camera *camera, const hl_sphere *ball, int pixel,
                         const double l[3])
{
  const double *center = ball->center_m, r = ball->radius_m;
  double sum = 0;
  int hits = 0;
  for (int k = 0; k < ACROSS * ACROSS; k++) {
    double ray[3], n[3];
    const double x = pixel % camera->width + (k % ACROSS + 0.5) / ACROSS - 0.5;
    const double y = pixel / camera->width + (k / ACROSS + 0.5) / ACROSS - 0.5;
    if (hl_camera_unproject(NULL, camera, x, y, ray) != HL_OK)
      continue;
    const double along = hl_dot(ray, center);
    const double inside = along * along - hl_dot(center, center) + r * r;
    if (!(inside > 0))
      continue;
    for (int i = 0; i < 3; i++)
      n[i] = (ray[i] * (along - sqrt(inside)) - center[i]) / r;
    const double v[3] = {-ray[0], -ray[1], -ray[2]};
    sum += shade(s, n, v, l);
    hits++;
  }
  return hits > 0 ? sum / hits : 0;
}

static lit_scene geometry(const scene *s)
{
  lit_scene out = lit_ball(s->radius_px);
  lit_direction(s->angle_deg, s->turn_deg, out.light);
  if (s->wide) {
    out.camera.fx = out.camera.fy = 90;
    out.camera.cx = out.camera.cy = 71.5;
    out.camera.n_distortion = 5;
    out.camera.distortion[0] = -0.12;
    out.camera.distortion[1] = 0.01;
    double ray[3];
    if (hl_camera_unproject(NULL, &out.camera, 105, 102, ray) != HL_OK)
      abort();
    const double distance = out.ball.radius_m / sin(atan(s->radius_px / 110));
    for (int i = 0; i < 3; i++)
      out.ball.center_m[i] = distance * ray[i];
    /* the angle is from where the ball is seen */
    const double away[3] = {-ray[0], -ray[1], -ray[2]};
    double t[2][3];
    hl_tangent_basis(away, t[0], t[1]);
    const double a = s->angle_deg * LIT_DEG, b = s->turn_deg * LIT_DEG;
    for (int i = 0; i < 3; i++)
      out.light[i] = cos(a) * away[i] + sin(a) * (cos(b) * t[0][i] + sin(b) * t[1][i]);
  }
  return out;
}

typedef struct tally {
  double m[DRAWS_MAX], sum[2], square[2][2], efficiency, bound[2][2], worst;
  int n, inside, ok, plain, bent;
} tally;

static double half_square(double c[2][2], const double d[2])
{
  const double det = c[0][0] * c[1][1] - c[0][1] * c[1][0];
  return 0.5 * (c[1][1] * d[0] * d[0] - 2 * c[0][1] * d[0] * d[1] + c[0][0] * d[1] * d[1]) / det;
}

/* In tangents of the true light, common to all draws. */
static void add(tally *t, hl_light *light, const double truth[3])
{
  double d[2], b[2][3], r[2][2];
  hl_tangent_basis(truth, b[0], b[1]);
  for (int k = 0; k < 2; k++)
    d[k] = hl_dot(b[k], light->direction);
  double own[2];
  for (int k = 0; k < 2; k++)
    own[k] = -hl_dot(light->tangent_basis[k], truth);
  const double m = half_square(light->covariance_rad2, own);
  for (int i = 0; i < 2; i++)
    for (int j = 0; j < 2; j++)
      r[i][j] = hl_dot(b[i], light->tangent_basis[j]);
  for (int i = 0; i < 2; i++)
    for (int j = 0; j < 2; j++) {
      t->square[i][j] += d[i] * d[j];
      for (int p = 0; p < 2; p++)
        for (int q = 0; q < 2; q++)
          t->bound[i][j] += r[i][p] * light->bound_rad2[p][q] * r[j][q];
    }
  for (int i = 0; i < 2; i++)
    t->sum[i] += d[i];
  t->efficiency += light->efficiency;
  t->plain += light->lobe == HL_LOBE_PLAIN;
  t->bent += light->masking_exponent != 0;
  t->inside += m <= 5.991464547107982 / 2;
  t->m[t->n++] = m;
  if (light->trusted) {
    const double error = hypot(own[0], own[1]);
    const double deviation = light->ellipse_95_rad[0] / sqrt(5.991464547107982);
    t->ok++;
    t->worst = fmax(t->worst, (error - 0.2 * LIT_DEG) / deviation);
  }
}

static int ascending(const void *a, const void *b)
{
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

static double root_det(double a[2][2])
{
  return sqrt(fmax(0, a[0][0] * a[1][1] - a[0][1] * a[1][0]));
}

static void print(const scene *s, tally *t)
{
  const double n = t->n;
  double mean = 0, scatter[2][2];
  if (t->n == 0)
    return;
  for (int i = 0; i < t->n; i++)
    mean += t->m[i] / n;
  for (int i = 0; i < 2; i++)
    for (int j = 0; j < 2; j++) {
      scatter[i][j] = t->square[i][j] / n - t->sum[i] * t->sum[j] / (n * n);
      t->bound[i][j] /= n;
    }
  qsort(t->m, (size_t)t->n, sizeof t->m[0], ascending);
  printf("%-14s %5d %7.3f %6.2f %6.2f %8.5f %8.5f %7.2f %6.2f %5.2f %6.1f %5.2f %5.2f%s\n", s->name,
         t->n, t->inside / n, mean, t->m[t->n / 2] / 0.6931,
         hypot(t->sum[0], t->sum[1]) / n / LIT_DEG,
         sqrt((t->square[0][0] + t->square[1][1]) / n) / LIT_DEG,
         root_det(t->bound) / root_det(scatter), t->efficiency / n, t->ok / n, t->worst,
         t->plain / n, t->bent / n, s->holds ? "" : "  (the model does not hold)");
  fflush(stdout);
}

static void run(const scene *s, int draws)
{
  static tally t;
  lit_scene g = geometry(s);
  g.across = 1; /* a ball, whose pixels show means */
  hl_surface surface = lit_surface(&g);
  g.saturation = s->clip;
  hl_frame frame = lit_frame(&g, &surface, NULL);
  double *clean = malloc((size_t)surface.n * sizeof *clean);
  hl_light_work *work = NULL;
  if (!clean || hl_light_work_new(NULL, surface.n, 1, &work) != HL_OK)
    abort();
  for (int i = 0; i < surface.n; i++)
    clean[i] = pixel_mean(s, &g.camera, &g.ball, surface.pixel[i], g.light);
  memset(&t, 0, sizeof t);
  for (int draw = 0; draw < draws; draw++) {
    test_random random = {(uint64_t)(draw + 1) * 0x9E3779B97F4A7C15u};
    hl_light light;
    for (int i = 0; i < surface.n; i++) {
      const double deviation = sqrt(s->noise * s->noise + s->shot * clean[i]);
      const double y = clean[i] + deviation * random_normal(&random);
      const bool clipped = s->clip > 0 && y >= s->clip;
      frame.radiance[surface.pixel[i]] = (float)(clipped ? s->clip : y);
      frame.state[surface.pixel[i]] = clipped ? HL_SAMPLE_CLIPPED : HL_SAMPLE_OK;
    }
    if (hl_light_estimate(NULL, work, &frame, &surface, NULL, &light) == HL_OK)
      add(&t, &light, g.light);
  }
  print(s, &t);
  free(clean);
  hl_light_work_free(work);
  lit_frame_free(&frame);
  hl_surface_free(&surface);
}

int main(int argc, char **argv)
{
  const int draws = argc > 1 ? atoi(argv[1]) : 500;
  printf("%-14s draws  inside  ratio median     bias      rms scatter stated    ok  worst plain  "
         "bent\n",
         "scene");
  for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++)
    if (argc < 3 || strcmp(argv[2], scenes[i].name) == 0)
      run(&scenes[i], draws < DRAWS_MAX ? draws : DRAWS_MAX);
  return 0;
}
