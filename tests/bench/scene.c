/* The bench's frame, and its ball's pixels as a table for another program.
 *
 *   scene FOLDER       writes frame.pfm, camera.json, sphere.json and pixels.csv there
 *
 * A ball of 100 px radius in 640 x 480, three channels: a body plus a Beckmann-like lobe
 * exp(-tan^2(a) / m^2), m = 0.2, over 4 n.v, and noise (read 0.001, shot 0.003 at radiance 1) from
 * a fixed seed. pixels.csv holds normal and green radiance of the very pixels that `estimate` fits.
 */
#include <halflight/halflight.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>

enum { WIDTH = 640, HEIGHT = 480, OVERSAMPLE = 2 };

static const double MIN_COS_VIEW = 0.1; /* the command's */
static const hl_camera camera = {.model = HL_LENS_PINHOLE,
                                 .width = WIDTH,
                                 .height = HEIGHT,
                                 .fx = 1400,
                                 .fy = 1400,
                                 .cx = 319.5,
                                 .cy = 239.5,
                                 .n_distortion = 5};
static const hl_sphere ball = {.center_m = {0.002, -0.001, 0.2817}, .radius_m = 0.02};
static float pixels[HEIGHT * WIDTH * 3];

static double dot(const double a[3], const double b[3])
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void unit(double a[3])
{
  const double n = sqrt(dot(a, a));
  for (int i = 0; i < 3; i++)
    a[i] /= n;
}

/* Radiance along the ray through a place in the image, added to `out`. */
static void add_radiance(double x, double y, double out[3])
{
  static const double body[3] = {0.5, 0.2, 0.08};
  double s[3] = {0.5, -0.4, -0.77},
         ray[3] = {(x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1};
  unit(s);
  unit(ray);
  const double along = dot(ray, ball.center_m);
  const double left =
      along * along - dot(ball.center_m, ball.center_m) + ball.radius_m * ball.radius_m;
  if (left <= 0) {
    for (int c = 0; c < 3; c++)
      out[c] += 0.1;
    return;
  }
  double n[3], h[3];
  for (int i = 0; i < 3; i++) {
    n[i] = ((along - sqrt(left)) * ray[i] - ball.center_m[i]) / ball.radius_m;
    h[i] = s[i] - ray[i];
  }
  unit(h);
  const double lit = dot(n, s), seen = -dot(n, ray), half = dot(n, h);
  if (lit <= 0)
    return;
  const double lobe = exp((1 - 1 / (half * half)) / 0.04) / (4 * fmax(seen, 0.05));
  for (int c = 0; c < 3; c++)
    out[c] += body[c] * lit + lobe;
}

/* About normal: twelve uniform numbers, from Vigna's splitmix64. */
static double noise(uint64_t *state)
{
  double sum = -6;
  for (int i = 0; i < 12; i++) {
    uint64_t z = *state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    sum += (double)((z ^ (z >> 31)) >> 11) * 0x1p-53;
  }
  return sum;
}

static void render(void)
{
  uint64_t state = 1;
  for (int i = 0; i < WIDTH * HEIGHT; i++) {
    double sum[3] = {0};
    for (int k = 0; k < OVERSAMPLE * OVERSAMPLE; k++)
      add_radiance(i % WIDTH + (k % OVERSAMPLE + 0.5) / OVERSAMPLE - 0.5,
                   i / WIDTH + (k / OVERSAMPLE + 0.5) / OVERSAMPLE - 0.5, sum);
    for (int c = 0; c < 3; c++) {
      const double clean = sum[c] / (OVERSAMPLE * OVERSAMPLE);
      pixels[3 * i + c] =
          (float)(clean + noise(&state) * sqrt(0.001 * 0.001 + 0.003 * 0.003 * clean));
    }
  }
}

static hl_status write_table(hl_ctx *ctx, const char *path)
{
  hl_surface surface = {0};
  const hl_status st = hl_surface_of_sphere(ctx, &camera, &ball, MIN_COS_VIEW, &surface);
  if (st != HL_OK)
    return st;
  FILE *f = fopen(path, "w");
  if (!f) {
    hl_surface_free(&surface);
    return HL_ERR_IO;
  }
  fputs("nx,ny,nz,value\n", f);
  for (int i = 0; i < surface.n; i++)
    fprintf(f, "%.9g,%.9g,%.9g,%.9g\n", surface.normal[3 * i], surface.normal[3 * i + 1],
            surface.normal[3 * i + 2], (double)pixels[3 * surface.pixel[i] + 1]);
  hl_surface_free(&surface);
  return fclose(f) == 0 ? HL_OK : HL_ERR_IO;
}

static hl_status write_camera(const char *path)
{
  FILE *f = fopen(path, "w");
  if (!f)
    return HL_ERR_IO;
  fprintf(f,
          "{\"format\": \"halflight-camera\", \"version\": 1, \"model\": \"pinhole\",\n"
          " \"width\": %d, \"height\": %d, \"fx\": %.17g, \"fy\": %.17g, \"cx\": %.17g,\n"
          " \"cy\": %.17g, \"distortion\": [0, 0, 0, 0, 0]}\n",
          camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy);
  return fclose(f) == 0 ? HL_OK : HL_ERR_IO;
}

int main(int argc, char **argv)
{
  static const char *const names[] = {"frame.pfm", "camera.json", "sphere.json", "pixels.csv"};
  char path[4][4096];
  hl_ctx ctx = {0};
  if (argc != 2) {
    fputs("usage: scene FOLDER\n", stderr);
    return 2;
  }
  for (int i = 0; i < 4; i++)
    snprintf(path[i], sizeof path[i], "%s/%s", argv[1], names[i]);
  render();
  if (hl_pfm_write(&ctx, path[0], pixels, WIDTH, HEIGHT, 3) != HL_OK ||
      write_camera(path[1]) != HL_OK || hl_sphere_write(&ctx, path[2], &ball, NULL) != HL_OK ||
      write_table(&ctx, path[3]) != HL_OK) {
    fprintf(stderr, "scene: %s\n", ctx.msg);
    return 1;
  }
  return 0;
}
