/* light_speed FIXTURES [REPEATS]: error of the light against the estimate's run time, over the recorded
 * frames with their true pose and over drawn balls with GGX lobes. A table; nothing is asserted. */
#include <dirent.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "halflight/halflight.h"

enum { SCENES_MAX = 64, DRAWN = 12, DRAWN_SIDE = 280 };
static const double deg = 57.295779513082320877, min_cos_view = 0.1;

typedef struct scene {
  char name[64];
  hl_camera camera;
  hl_sphere ball;
  hl_frame frame;
  hl_surface surface;
  double light[3];
} scene;

static void trace(void *user, const char *line)
{
  (void)user;
  fprintf(stderr, "    %s\n", line);
}

static double clock_ms(void)
{
  struct timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
}

static double dot(const double a[3], const double b[3])
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static double error_deg(const double a[3], const double b[3])
{
  const double x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2],
               z = a[0] * b[1] - a[1] * b[0];
  return atan2(sqrt(x * x + y * y + z * z), dot(a, b)) * deg;
}

static bool read_truth(const char *path, double light[3])
{
  char text[8192];
  FILE *f = fopen(path, "r");
  if (!f)
    return false;
  text[fread(text, 1, sizeof text - 1, f)] = 0;
  fclose(f);
  const char *at = strstr(text, "\"light\"");
  return at && sscanf(strchr(at, '[') + 1, "%lf , %lf , %lf", &light[0], &light[1], &light[2]) == 3;
}

static bool read_scene(const char *fixtures, const char *name, scene *s)
{
  static const char *const kinds[] = {"png", "jpg", "pfm", "exr", "tiff", "tif", "jpeg"};
  char path[512];
  hl_ctx ctx = {0};
  const hl_frame_settings settings = hl_frame_defaults();
  memset(s, 0, sizeof *s);
  snprintf(s->name, sizeof s->name, "%.60s", name);
  snprintf(path, sizeof path, "%s/%s/truth.json", fixtures, name);
  if (!read_truth(path, s->light))
    return false;
  snprintf(path, sizeof path, "%s/%s/sphere.json", fixtures, name);
  if (hl_sphere_read(&ctx, path, &s->ball) != HL_OK)
    return false;
  snprintf(path, sizeof path, "%s/%s/camera.json", fixtures, name);
  if (hl_camera_read(&ctx, path, &s->camera) != HL_OK)
    return false;
  for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++) {
    snprintf(path, sizeof path, "%s/%s/frame.%s", fixtures, name, kinds[k]);
    FILE *f = fopen(path, "r");
    if (!f)
      continue;
    fclose(f);
    return hl_frame_read(&ctx, path, &settings, &s->frame) == HL_OK &&
           hl_surface_of_sphere(&ctx, &s->camera, &s->ball, min_cos_view, &s->surface) == HL_OK;
  }
  return false;
}

static double uniform(uint64_t *state)
{
  *state += 0x9e3779b97f4a7c15u;
  uint64_t z = *state;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return (double)((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

static double normal(uint64_t *state)
{
  const double r = sqrt(-2 * log(uniform(state) + 1e-300));
  return r * cos(6.283185307179586 * uniform(state));
}

/* A ball of 100 px: Lambert's body and a GGX lobe over n.v, noise of 1 %, each pixel the model's value
 * at its middle, so the surface is one of given normals. */
static bool draw_scene(int k, scene *s)
{
  uint64_t state = 1000 + (uint64_t)k;
  hl_ctx ctx = {0};
  memset(s, 0, sizeof *s);
  snprintf(s->name, sizeof s->name, "drawn-%d", k);
  s->camera = (hl_camera){.width = DRAWN_SIDE,
                          .height = DRAWN_SIDE,
                          .fx = 900,
                          .fy = 900,
                          .cx = DRAWN_SIDE / 2.0,
                          .cy = DRAWN_SIDE / 2.0};
  s->ball.radius_m = 0.03;
  s->ball.center_m[2] = 0.03 / sin(atan(100.0 / 900));
  if (hl_surface_of_sphere(&ctx, &s->camera, &s->ball, min_cos_view, &s->surface) != HL_OK)
    return false;
  s->surface.is_ball = false;
  const double angle = (10 + 70 * uniform(&state)) / deg, turn = 6.283185 * uniform(&state);
  s->light[0] = sin(angle) * cos(turn);
  s->light[1] = sin(angle) * sin(turn);
  s->light[2] = -cos(angle);
  const double alpha = exp(log(0.03) + (log(0.5) - log(0.03)) * uniform(&state));
  const double gloss = 0.05 / (alpha * alpha) * (0.3 + uniform(&state));
  hl_frame *f = &s->frame;
  *f = (hl_frame){.width = DRAWN_SIDE, .height = DRAWN_SIDE, .channels = 3, .bits = 32};
  const size_t n = (size_t)DRAWN_SIDE * DRAWN_SIDE * 3;
  f->radiance = calloc(n, sizeof *f->radiance);
  f->state = malloc(n);
  if (!f->radiance || !f->state)
    return false;
  memset(f->state, HL_SAMPLE_UNUSABLE, n);
  for (int i = 0; i < s->surface.n; i++) {
    const double *nn = s->surface.normal + 3 * i, *v = s->surface.view + 3 * i;
    double h[3];
    for (int j = 0; j < 3; j++)
      h[j] = s->light[j] + v[j];
    const double length = sqrt(dot(h, h)), nh = dot(nn, h) / length, ns = dot(nn, s->light);
    const double w = s->surface.footprint[i], ramp = fmin(fmax(ns / w + 0.5, 0), 1);
    const double body = ns > w / 2 ? ns : 0.5 * ramp * ramp * w;
    const double q = nh * nh * (alpha * alpha - 1) + 1;
    const double lobe = gloss * alpha * alpha * alpha * alpha / (q * q) / dot(nn, v) * ramp;
    for (int c = 0; c < 3; c++) {
      const double y = (0.3 + 0.2 * c) * body + lobe;
      f->radiance[3 * (size_t)s->surface.pixel[i] + (size_t)c] =
          (float)(y + sqrt(1e-4 * y + 1e-6) * normal(&state));
      f->state[3 * (size_t)s->surface.pixel[i] + (size_t)c] = HL_SAMPLE_OK;
    }
  }
  return true;
}

static int ascending(const void *a, const void *b)
{
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

static double middle(double *a, int n)
{
  qsort(a, (size_t)n, sizeof *a, ascending);
  return n % 2 ? a[n / 2] : 0.5 * (a[n / 2 - 1] + a[n / 2]);
}

/* Median and largest error, median of the time and of the wanted share inside the ellipse. */
static void run(const scene *all, int n, const char *what, const hl_light_settings *settings,
                int repeats, bool each)
{
  double error[SCENES_MAX], time[SCENES_MAX], size[SCENES_MAX];
  double most = 0;
  int inside = 0, trusted = 0;
  for (int i = 0; i < n; i++) {
    const scene *s = &all[i];
    hl_light_work *work = NULL;
    hl_light light = {0};
    hl_ctx ctx = {.trace = getenv("TRACE") ? trace : NULL};
    if (hl_light_work_new(&ctx, s->surface.n, s->frame.channels, &work) != HL_OK)
      exit(1);
    time[i] = HUGE_VAL;
    for (int k = 0; k < repeats; k++) {
      const double start = clock_ms();
      if (hl_light_estimate(&ctx, work, &s->frame, &s->surface, settings, &light) != HL_OK)
        fprintf(stderr, "%s: %s\n", s->name, ctx.msg);
      time[i] = fmin(time[i], clock_ms() - start);
    }
    hl_light_work_free(work);
    error[i] = light.found ? error_deg(light.direction, s->light) : 180;
    size[i] = light.n_pixels;
    most = fmax(most, error[i]);
    trusted += light.trusted;
    const double d[2] = {dot(s->light, light.tangent_basis[0]),
                         dot(s->light, light.tangent_basis[1])};
    const double(*c)[2] = (const double(*)[2])light.covariance_rad2;
    const double det = c[0][0] * c[1][1] - c[0][1] * c[1][0];
    inside += (c[1][1] * d[0] * d[0] - 2 * c[0][1] * d[0] * d[1] + c[0][0] * d[1] * d[1]) / det <
              5.991464547107981;
    if (each)
      printf("  %-18s %6.0f px %8.2f ms  %8.4f deg  ellipse %.4f  %s, %d iterations, %d outliers\n",
             s->name, size[i], time[i], error[i], light.ellipse_95_rad[0] * deg,
             light.trusted ? "ok" : "untrusted", light.iterations, light.n_outliers);
  }
  printf("%-16s error median %.4f largest %.4f deg, inside %d, ok %d of %d, time median %.2f ms\n",
         what, middle(error, n), most, inside, trusted, n, middle(time, n));
  fflush(stdout);
}

int main(int argc, char **argv)
{
  static const int pixels[] = {500, 1000, 2000, 4000, 8000, 16000};
  static const double budgets[] = {2, 5, 10, 20, 50, 100};
  static scene recorded[SCENES_MAX], drawn[DRAWN];
  int n = 0;
  if (argc < 2)
    return 2;
  const int repeats = argc > 2 ? atoi(argv[2]) : 1;
  const char *which = argc > 3 ? argv[3] : "all";
  struct dirent **names;
  const int count = scandir(argv[1], &names, NULL, alphasort);
  for (int i = 0; i < count; i++)
    if (names[i]->d_name[0] != '.' && n < SCENES_MAX &&
        read_scene(argv[1], names[i]->d_name, &recorded[n]))
      n++;
  for (int k = 0; k < DRAWN; k++)
    if (!draw_scene(k, &drawn[k]))
      return 1;
  for (int set = 0; set < 2; set++) {
    const scene *s = set == 0 ? recorded : drawn;
    const int scenes = set == 0 ? n : DRAWN;
    char what[32];
    hl_light_settings settings = hl_light_defaults();
    printf("%s\n", set == 0 ? "recorded frames, pose given" : "drawn GGX balls");
    run(s, scenes, "all", &settings, repeats, strchr(which, 'e') != NULL);
    for (size_t i = 0; strchr(which, 'p') && i < sizeof pixels / sizeof *pixels; i++) {
      settings.pixels = pixels[i];
      snprintf(what, sizeof what, "%d pixels", pixels[i]);
      run(s, scenes, what, &settings, repeats, false);
    }
    settings.pixels = 0;
    for (size_t i = 0; strchr(which, 'b') && i < sizeof budgets / sizeof *budgets; i++) {
      settings.budget_ms = budgets[i];
      snprintf(what, sizeof what, "%g ms", budgets[i]);
      run(s, scenes, what, &settings, repeats, false);
    }
  }
  return 0;
}
