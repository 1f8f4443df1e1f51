/* The light from pixels in memory: a ball is drawn under a known light and the light asked back. */
#include <halflight/halflight.h>
#include <halflight/vec3.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { WIDTH = 160, HEIGHT = 120 };

/* A white body and a highlight, where the ball is seen; the rest stays black. */
static void draw(const hl_surface *surface, const double light[3], float *pixels)
{
  for (int i = 0; i < surface->n; i++) {
    const double *n = surface->normal + 3 * i, *v = surface->view + 3 * i;
    double half[3] = {0, 0, 0};
    hl_add_scaled(v, 1, light, half);
    hl_unit(half, half);
    const double lit = hl_dot(n, light);
    if (lit > 0)
      pixels[surface->pixel[i]] = (float)(0.4 * lit + 0.5 * pow(fmax(0, hl_dot(n, half)), 60));
  }
}

static hl_status estimate(hl_ctx *ctx, const double light[3], hl_light *out)
{
  const hl_camera camera = {.model = HL_LENS_PINHOLE,
                            .n_distortion = 5,
                            .width = WIDTH,
                            .height = HEIGHT,
                            .fx = 400,
                            .fy = 400,
                            .cx = 79.5,
                            .cy = 59.5};
  const hl_sphere sphere = {.center_m = {0.002, -0.001, 0.18}, .radius_m = 0.02};
  float *pixels = calloc((size_t)WIDTH * HEIGHT, sizeof *pixels);
  hl_surface surface = {0};
  hl_frame frame = {0};
  hl_light_work *work = NULL;
  hl_status st = pixels ? hl_surface_of_sphere(ctx, &camera, &sphere, 0.1, &surface)
                        : hl_fail(ctx, HL_ERR_MEMORY, "no memory for the pixels");
  if (st == HL_OK) {
    draw(&surface, light, pixels);
    st = hl_frame_from_codes(ctx, pixels, WIDTH, HEIGHT, 1, 32, NULL, &frame);
  }
  if (st == HL_OK)
    st = hl_light_work_new(ctx, surface.n, frame.channels, &work);
  if (st == HL_OK)
    st = hl_light_estimate(ctx, work, &frame, &surface, NULL, out);
  hl_light_work_free(work);
  hl_frame_free(&frame);
  hl_surface_free(&surface);
  free(pixels);
  return st;
}

int main(void)
{
  double light[3] = {0.4, -0.3, -0.8};
  hl_ctx ctx = {0};
  hl_light found;
  hl_unit(light, light);
  const hl_status st = estimate(&ctx, light, &found);
  if (st != HL_OK) {
    fprintf(stderr, "estimate_memory: %s\n", ctx.msg);
    return hl_status_exit(st);
  }
  const double off_deg = hl_angle(light, found.direction) * 180 / 3.14159265358979323846;
  printf("light %.4f %.4f %.4f, off by %.4f deg, %s\n", found.direction[0], found.direction[1],
         found.direction[2], off_deg, found.trusted ? "trusted" : "not trusted");
  return found.trusted && off_deg < 0.1 ? 0 : 3;
}
