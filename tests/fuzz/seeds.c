/* fuzz_seeds FOLDER: FOLDER/READER/seed for what is best written by the library itself. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "documents.h"
#include "readers.h"

static const char *path_of(const char *folder, const char *reader)
{
  static char path[1024];
  snprintf(path, sizeof path, "%s/%s", folder, reader);
  mkdir(path, 0777);
  snprintf(path, sizeof path, "%s/%s/seed", folder, reader);
  return path;
}

static hl_status put_text(hl_ctx *ctx, const char *folder, const char *reader, hl_status st,
                          char *text)
{
  if (st == HL_OK)
    st = hl_file_write(ctx, path_of(folder, reader), text, strlen(text));
  free(text);
  return st;
}

static hl_status light_seed(hl_ctx *ctx, const char *folder)
{
  char *text = NULL;
  const hl_light light = document_light();
  const hl_status st = hl_light_json(ctx, &light, NULL, &text);
  if (st == HL_OK && hl_file_write(ctx, path_of(folder, "sight"), text, strlen(text)) != HL_OK) {
    free(text);
    return HL_ERR_IO;
  }
  return put_text(ctx, folder, "reflectance", st, text);
}

static hl_status fit_seed(hl_ctx *ctx, const char *folder)
{
  char *text = NULL;
  const hl_fit fit = document_fit();
  const hl_status st = hl_fit_json(ctx, &fit, &text);
  return put_text(ctx, folder, "fit", st, text);
}

static hl_status calibration_seed(hl_ctx *ctx, const char *folder)
{
  char *text = NULL;
  hl_view_pose view;
  const hl_calibration calibration = document_calibration(&view);
  const hl_status st = hl_calibration_json(ctx, &calibration, &text);
  return put_text(ctx, folder, "calibration", st, text);
}

static hl_status pose_seed(hl_ctx *ctx, const char *folder)
{
  char *text = NULL;
  const hl_board_pose pose = document_pose();
  const hl_status st = hl_board_pose_json(ctx, &pose, &text);
  return put_text(ctx, folder, "board_pose", st, text);
}

static hl_status lights_seed(hl_ctx *ctx, const char *folder)
{
  char *text = NULL;
  hl_rig_light light;
  const hl_lights lights = document_lights(&light);
  const hl_status st = hl_lights_json(ctx, &lights, &text);
  return put_text(ctx, folder, "lights", st, text);
}

/* The sides of a table and a byte that lets it be filled up. */
static hl_status merl_seed(hl_ctx *ctx, const char *folder)
{
  const int sides[4] = {HL_MERL_THETA_HALF, HL_MERL_THETA_DIFF, HL_MERL_PHI_DIFF, 0};
  return hl_file_write(ctx, path_of(folder, "merl"), (const char *)sides, sizeof sides);
}

int main(int argc, char **argv)
{
  hl_status (*const seeds[])(hl_ctx *, const char *) = {
      light_seed, fit_seed, calibration_seed, pose_seed, lights_seed, merl_seed,
  };
  hl_ctx ctx = {0};
  if (argc != 2)
    return 2;
  for (size_t i = 0; i < sizeof seeds / sizeof seeds[0]; i++)
    if (seeds[i](&ctx, argv[1]) != HL_OK) {
      fprintf(stderr, "fuzz_seeds: %s\n", ctx.msg);
      return 1;
    }
  return 0;
}
