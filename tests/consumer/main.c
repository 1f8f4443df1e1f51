/* The smallest program that needs the installed library and its JSON. */
#include <halflight/halflight.h>
#include <math.h>
#include <stdio.h>

int main(int argc, char **argv)
{
  hl_ctx ctx = {0};
  hl_camera camera;
  double ray[3];
  if (argc != 2 || hl_camera_read(&ctx, argv[1], &camera) != HL_OK ||
      hl_camera_unproject(&ctx, &camera, camera.cx, camera.cy, ray) != HL_OK) {
    fprintf(stderr, "consumer: %s\n", ctx.msg);
    return 1;
  }
  printf("%s %d %.3f\n", hl_version(), camera.width, ray[2]);
  return fabs(ray[2] - 1) < 1e-12 ? 0 : 1;
}
