/* A photographed ball under another light: OUT.pfm shows it lit from (X, Y, Z), camera frame. */
#include <halflight/halflight.h>
#include <halflight/vec3.h>
#include <stdio.h>
#include <stdlib.h>

typedef struct ball {
  hl_camera camera;
  hl_sphere sphere;
  hl_frame photo;
  hl_surface surface;
  hl_light light;
  hl_reflectance reflectance;
} ball;

/* LIGHT.json is how a light becomes a reflectance; here it stands beside the picture. */
static hl_status understand(hl_ctx *ctx, char **words, const char *json, ball *b)
{
  hl_light_work *work = NULL;
  hl_status st = hl_frame_read(ctx, words[1], NULL, &b->photo);
  if (st == HL_OK)
    st = hl_camera_read(ctx, words[2], &b->camera);
  if (st == HL_OK)
    st = hl_sphere_read(ctx, words[3], &b->sphere);
  if (st == HL_OK)
    st = hl_surface_of_sphere(ctx, &b->camera, &b->sphere, 0.1, &b->surface);
  if (st == HL_OK)
    st = hl_light_work_new(ctx, b->surface.n, b->photo.channels, &work);
  if (st == HL_OK)
    st = hl_light_estimate(ctx, work, &b->photo, &b->surface, NULL, &b->light);
  if (st == HL_OK)
    st = hl_light_json_write(ctx, json, &b->light, NULL);
  hl_light_work_free(work);
  return st == HL_OK ? hl_reflectance_read(ctx, json, &b->reflectance) : st;
}

static hl_status draw(hl_ctx *ctx, const ball *b, const double light[3], const char *path)
{
  hl_frame relit = {0};
  hl_relit_error error = {0};
  hl_status st = hl_relight(ctx, &b->reflectance, &b->surface, b->light.direction, &relit);
  if (st == HL_OK)
    st = hl_relit_compare(ctx, &relit, &b->surface, b->light.direction, &b->photo, false, &error,
                          NULL);
  hl_frame_free(&relit);
  if (st == HL_OK)
    st = hl_relight(ctx, &b->reflectance, &b->surface, light, &relit);
  if (st == HL_OK)
    st = hl_pfm_write(ctx, path, relit.radiance, relit.width, relit.height, relit.channels);
  hl_frame_free(&relit);
  if (st == HL_OK)
    printf("the photo itself to %.1f %% over %d pixels; relit in %s\n", 100 * error.relative_error,
           error.n_pixels, path);
  return st;
}

int main(int argc, char **argv)
{
  hl_ctx ctx = {0};
  ball b = {0};
  double light[3];
  char json[1024];
  if (argc != 8) {
    fprintf(stderr, "relight_photo FRAME CAMERA.json SPHERE.json X Y Z OUT.pfm\n");
    return 2;
  }
  for (int k = 0; k < 3; k++)
    light[k] = strtod(argv[4 + k], NULL);
  hl_unit(light, light);
  snprintf(json, sizeof json, "%s.json", argv[7]);
  hl_status st = understand(&ctx, argv, json, &b);
  if (st == HL_OK)
    st = draw(&ctx, &b, light, argv[7]);
  if (st != HL_OK)
    fprintf(stderr, "relight_photo: %s\n", ctx.msg);
  hl_surface_free(&b.surface);
  hl_frame_free(&b.photo);
  return hl_status_exit(st);
}
