/* render: a ball of a measured material, as a frame or as samples. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "commands.h"
#include "halflight/halflight.h"
#include "halflight/vec3.h"
#include "inputs.h"
#include "options.h"
#include "outputs.h"
#include "summary.h"

typedef struct render_args {
  const char *table, *camera, *sphere, *out;
  double light[3]; /* 0,0,0: not given */
  int sphere_px;   /* 0: not given */
  hl_merl_ball_settings settings;
} render_args;

#define AT(member) offsetof(render_args, member)

static const hl_field_table *radius_fields(void)
{
  static const hl_field fields[] = {
      {"sphere_px", HL_FIELD_INT, 0, 1, 1024, "px",
       "seen from afar, filling an image of 2R x 2R pixels", NULL},
  };
  static const hl_field_table table = {"ball", fields, 1};
  return &table;
}

static hl_status parse_light(hl_ctx *ctx, const char *text, void *member)
{
  double light[3];
  const hl_status st = hl_options_numbers(ctx, "light", text, 3, light);
  if (st != HL_OK)
    return st;
  if (!(hl_norm(light) > 0 && isfinite(hl_norm(light))))
    return hl_fail(ctx, HL_ERR_ARG, "--light '%.40s' is no direction; x,y,z not all 0 is needed",
                   text);
  hl_unit(light, light);
  memcpy(member, light, sizeof light);
  return HL_OK;
}

static const hl_operand operands[] = {
    {"NAME.binary", "a table of the MERL database", AT(table), HL_OPERAND_NEEDED},
};

static const hl_option options[] = {
    {"light", "X,Y,Z", "Scene", "direction from the ball to the light; always needed", AT(light), 0,
     parse_light},
    {"sphere-px", "R", NULL, NULL, AT(sphere_px), radius_fields, 0},
    {"camera", "CAMERA.json", NULL, "the ball through this camera (with --sphere)", AT(camera), 0,
     0},
    {"sphere", "SPHERE.json", NULL, "that ball's pose", AT(sphere), 0, 0},
    {"background", "B", NULL, NULL, AT(settings), hl_merl_ball_fields, 0},
    {"lookup", "smooth|nearest", "Table", NULL, AT(settings), hl_merl_ball_fields, 0},
    {"oversample", "N", NULL, NULL, AT(settings), hl_merl_ball_fields, 0},
    {"min-cos-light", "C", "Samples", NULL, AT(settings), hl_merl_ball_fields, 0},
    {"min-cos-view", "C", NULL, NULL, AT(settings), hl_merl_ball_fields, 0},
    {"out", "F.pfm|F.csv", "Output", "a frame, or samples as `fit` reads them; always needed",
     AT(out), 0, 0},
};

static void defaults(void *args)
{
  render_args *a = args;
  a->settings = hl_merl_ball_defaults();
}

static bool ends_with(const char *text, const char *end)
{
  const size_t n = strlen(text), m = strlen(end);
  return n > m && strcmp(text + n - m, end) == 0;
}

static hl_status check_usage(hl_ctx *ctx, const render_args *a)
{
  if (!(hl_norm(a->light) > 0))
    return hl_fail(ctx, HL_ERR_ARG, "--light is missing; --light X,Y,Z is needed");
  if (!a->out)
    return hl_fail(ctx, HL_ERR_ARG, "--out is missing; --out F.pfm or F.csv is needed");
  if (!ends_with(a->out, ".pfm") && !ends_with(a->out, ".csv"))
    return hl_fail(ctx, HL_ERR_ARG, "--out %s: a name that ends in .pfm or .csv is needed", a->out);
  if (a->sphere_px > 0 && (a->camera || a->sphere))
    return hl_fail(ctx, HL_ERR_ARG,
                   "--sphere-px and --%s contradict; seen from afar or through a camera, not both",
                   a->camera ? "camera" : "sphere");
  if (!a->camera != !a->sphere)
    return hl_fail(ctx, HL_ERR_ARG, "--%s is missing; --camera and --sphere go together",
                   a->camera ? "sphere" : "camera");
  if (a->sphere_px == 0 && !a->camera)
    return hl_fail(ctx, HL_ERR_ARG,
                   "the ball is missing; --sphere-px R, or --camera CAMERA.json with --sphere "
                   "SPHERE.json, is needed");
  return HL_OK;
}

typedef struct render_run {
  const render_args *args;
  hl_camera camera;
  hl_sphere sphere;
  hl_merl merl;
  hl_merl_ball ball;
  hl_outputs outputs;
  int out_at;
} render_run;

static hl_status read_inputs(hl_ctx *ctx, render_run *r)
{
  const render_args *a = r->args;
  hl_status st = HL_OK;
  if (a->camera) {
    st = hl_camera_read(ctx, a->camera, &r->camera);
    if (st == HL_OK)
      st = hl_sphere_read(ctx, a->sphere, &r->sphere);
  }
  if (st == HL_OK)
    st = hl_merl_read(ctx, a->table, &r->merl);
  return st;
}

static hl_status shade(hl_ctx *ctx, render_run *r)
{
  const render_args *a = r->args;
  const hl_status st =
      a->camera
          ? hl_merl_ball_through_camera(ctx, &r->merl, &r->camera, &r->sphere, a->light,
                                        &a->settings, &r->ball)
          : hl_merl_ball_from_afar(ctx, &r->merl, a->sphere_px, a->light, &a->settings, &r->ball);
  return hl_inputs_blame(ctx, st, a->table);
}

/* Pixels that were not measured are not a number in the file: readers mask them. */
static hl_status write_frame(hl_ctx *ctx, const render_run *r)
{
  hl_frame f = r->ball.frame;
  const size_t n = (size_t)f.width * (size_t)f.height * (size_t)f.channels;
  for (size_t i = 0; i < n; i++)
    if (f.state[i] == HL_SAMPLE_UNUSABLE)
      f.radiance[i] = NAN;
  return hl_pfm_write(ctx, r->outputs.stage[r->out_at], f.radiance, f.width, f.height, f.channels);
}

static void print_summary(const render_run *r)
{
  const render_args *a = r->args;
  const hl_merl_ball *b = &r->ball;
  char text[200];
  snprintf(text, sizeof text, "%.1f %% of the cells above the horizon are measured",
           100 * hl_merl_measured(&r->merl));
  hl_summary_line(stdout, "table", text);
  snprintf(text, sizeof text, "%.6f %.6f %.6f, %s", a->light[0], a->light[1], a->light[2],
           a->camera ? "camera: x right, y down, z forward"
                     : "x right, y up, z to the viewer, view 0,0,1");
  hl_summary_line(stdout, "light", text);
  snprintf(text, sizeof text, "radiance, BRDF x cos, under a light of irradiance 1");
  hl_summary_line(stdout, "values", text);
  if (ends_with(a->out, ".csv"))
    snprintf(text, sizeof text, "%d samples with n.s > %g and n.v > %g, all measured", b->samples.n,
             a->settings.min_cos_light, a->settings.min_cos_view);
  else
    snprintf(text, sizeof text, "%d x %d px, %d of them on the ball, %d not measured%s",
             b->frame.width, b->frame.height, b->n_pixels, b->n_unmeasured,
             b->n_unmeasured > 0 ? ": NaN in the file" : "");
  hl_summary_line(stdout, ends_with(a->out, ".csv") ? "samples" : "frame", text);
}

static hl_status write_and_print(hl_ctx *ctx, render_run *r)
{
  hl_outputs *o = &r->outputs;
  hl_status st = hl_outputs_begin(ctx, o);
  if (st == HL_OK && ends_with(r->args->out, ".csv"))
    st = hl_samples_write(ctx, o->stage[r->out_at], &r->ball.samples);
  else if (st == HL_OK)
    st = write_frame(ctx, r);
  if (st == HL_OK) {
    print_summary(r);
    st = hl_outputs_print(ctx);
  }
  if (st == HL_OK)
    st = hl_outputs_commit(ctx, o);
  hl_outputs_end(ctx, o);
  return st;
}

static hl_status run(hl_ctx *ctx, const void *args)
{
  render_run *r = calloc(1, sizeof *r);
  if (!r)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for the run");
  r->args = args;
  hl_status st = check_usage(ctx, r->args);
  if (st == HL_OK)
    st = hl_outputs_add(ctx, &r->outputs, NULL, r->args->out, &r->out_at);
  if (st == HL_OK)
    st = read_inputs(ctx, r);
  if (st == HL_OK)
    st = shade(ctx, r);
  if (st == HL_OK)
    st = write_and_print(ctx, r);
  hl_merl_ball_free(&r->ball);
  hl_merl_free(&r->merl);
  free(r);
  return st;
}

const hl_command hl_command_render = {
    .name = "render",
    .sentence = "Draw a ball of a measured material (MERL): a frame or samples.",
    .operands = operands,
    .n_operands = sizeof operands / sizeof *operands,
    .options = options,
    .n_options = sizeof options / sizeof *options,
    .notes = "Values are radiance, BRDF x cos, under a light of irradiance 1. With --sphere-px\n"
             "directions are x right, y up, z to the viewer; with --camera the camera's: x\n"
             "right, y down, z forward. Where the table was not measured a frame has NaN, and\n"
             "there is no sample.\n"
             "Exit status: 0 done, 1 failed, 2 wrong usage, 3 nothing lit is seen.",
    .example = "  $ halflight render ball.binary --light=1,1,1 --sphere-px 50 --out ball.csv\n"
               "  table         100.0 % of the cells above the horizon are measured\n"
               "  ...",
    .size = sizeof(render_args),
    .defaults = defaults,
    .run = run,
};
