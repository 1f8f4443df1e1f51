/* locate: the ball's pose from its outline. */
#include <stdio.h>
#include <stdlib.h>

#include "commands.h"
#include "draw.h"
#include "halflight/halflight.h"
#include "inputs.h"
#include "options.h"
#include "outputs.h"
#include "summary.h"

typedef struct locate_args {
  const char *frame, *camera, *out, *picture;
  double radius_m;
  bool json;
  hl_frame_settings frame_settings;
  hl_sphere_settings sphere_settings;
} locate_args;

#define AT(member) offsetof(locate_args, member)

static const hl_operand operands[] = {
    {"FRAME", "the photo: PNG, JPEG, TIFF, EXR or PFM", AT(frame), HL_OPERAND_NEEDED},
};

static const hl_option options[] = {
    {"camera", "CAMERA", "Geometry",
     "the calibrated camera, always needed: CAMERA.json, OpenCV or Kalibr YAML, mrcal .cameramodel",
     AT(camera), 0, 0},
    {"radius-m", "R", NULL, "the ball's radius; always needed", AT(radius_m),
     hl_inputs_radius_fields, 0},
    {"circle", "X,Y,R", NULL, "look near this circle only [px]", AT(sphere_settings), 0,
     hl_inputs_circle},
    {"min-radius-px", "R", "Search", NULL, AT(sphere_settings), hl_sphere_fields, 0},
    {"max-radius-px", "R", NULL, NULL, AT(sphere_settings), hl_sphere_fields, 0},
    {"min-arc", "A", NULL, NULL, AT(sphere_settings), hl_sphere_fields, 0},
    {"max-rms-px", "E", NULL, NULL, AT(sphere_settings), hl_sphere_fields, 0},
    {"transfer", "linear|srgb|gamma:G", "Frame",
     "how codes become radiance (default: 8-bit files are sRGB, others linear)", AT(frame_settings),
     0, hl_inputs_transfer},
    {"black", "B", NULL, NULL, AT(frame_settings), hl_frame_fields, 0},
    {"saturation", "S", NULL, NULL, AT(frame_settings), hl_frame_fields, 0},
    {"json", NULL, "Output", "print SPHERE.json on stdout and nothing else", AT(json), 0, 0},
    {"out", "SPHERE.json", NULL, "write the pose there", AT(out), 0, 0},
    {"picture", "FILE", NULL, "photo with the outline: .png, .svg or .pdf", AT(picture), 0, 0},
};

static void defaults(void *args)
{
  locate_args *a = args;
  a->frame_settings = hl_frame_defaults();
  a->sphere_settings = hl_sphere_defaults();
}

typedef struct locate_run {
  const locate_args *args;
  hl_camera camera;
  hl_frame frame;
  hl_sphere sphere;
  hl_sphere_fit fit;
  hl_outputs outputs;
  int sphere_at, picture_at; /* places in outputs; -1 = not asked for */
  hl_picture_kind picture_kind;
} locate_run;

static hl_status plan(hl_ctx *ctx, locate_run *r)
{
  const locate_args *a = r->args;
  hl_status st = HL_OK;
  r->sphere_at = r->picture_at = -1;
  if (!a->camera)
    return hl_fail(ctx, HL_ERR_ARG, "--camera is missing; --camera CAMERA is needed");
  if (!(a->radius_m > 0))
    return hl_fail(ctx, HL_ERR_ARG, "--radius-m is missing; the ball's radius in metres is needed");
  if (a->out)
    st = hl_outputs_add(ctx, &r->outputs, NULL, a->out, &r->sphere_at);
  if (st == HL_OK && a->picture) {
    st = hl_picture_kind_of(ctx, "picture", a->picture, &r->picture_kind);
    if (st == HL_OK)
      st = hl_outputs_add(ctx, &r->outputs, NULL, a->picture, &r->picture_at);
  }
  return st;
}

static hl_status find_ball(hl_ctx *ctx, locate_run *r)
{
  const hl_status st = hl_sphere_locate(ctx, &r->frame, &r->camera, r->args->radius_m,
                                        &r->args->sphere_settings, &r->sphere, &r->fit);
  return hl_inputs_blame(ctx, st, r->args->frame);
}

static hl_status print_result(hl_ctx *ctx, const locate_run *r)
{
  if (!r->args->json) {
    hl_summary_sphere(stdout, &r->sphere, &r->fit);
    return HL_OK;
  }
  char *text = NULL;
  const hl_status st = hl_sphere_json(ctx, &r->sphere, &r->fit, &text);
  if (st == HL_OK)
    fputs(text, stdout);
  free(text);
  return st;
}

/* Text that stdout does not take leaves no files. */
static hl_status write_and_print(hl_ctx *ctx, locate_run *r)
{
  hl_outputs *o = &r->outputs;
  const hl_photo photo = {&r->frame, &r->camera, &r->sphere, NULL, NULL, &r->fit, false};
  hl_status st = hl_outputs_begin(ctx, o);
  if (st == HL_OK && r->sphere_at >= 0)
    st = hl_sphere_write(ctx, o->stage[r->sphere_at], &r->sphere, &r->fit);
  if (st == HL_OK && r->picture_at >= 0)
    st = hl_draw_frame(ctx, r->picture_kind, o->stage[r->picture_at], &photo);
  if (st == HL_OK)
    st = print_result(ctx, r);
  if (st == HL_OK)
    st = hl_outputs_print(ctx);
  if (st == HL_OK)
    st = hl_outputs_commit(ctx, o);
  hl_outputs_end(ctx, o);
  return st;
}

static hl_status run(hl_ctx *ctx, const void *args)
{
  locate_run *r = calloc(1, sizeof *r);
  if (!r)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for the run");
  r->args = args;
  hl_status st = plan(ctx, r);
  if (st == HL_OK)
    st = hl_inputs_read(ctx, r->args->frame, r->args->camera, &r->args->frame_settings, &r->camera,
                        &r->frame);
  if (st == HL_OK)
    st = find_ball(ctx, r);
  if (st == HL_OK)
    st = write_and_print(ctx, r);
  hl_frame_free(&r->frame);
  free(r);
  return st;
}

const hl_command hl_command_locate = {
    .name = "locate",
    .sentence = "Find the ball in a photo: its centre, from its outline.",
    .operands = operands,
    .n_operands = sizeof operands / sizeof *operands,
    .options = options,
    .n_options = sizeof options / sizeof *options,
    .notes = "Exit status: 0 done, 1 failed, 2 wrong usage, 3 no ball that can be trusted.",
    .example = "  $ halflight locate frame.pfm --camera camera.json --radius-m 0.02 \\\n"
               "      --out found.json --picture outline.png\n"
               "  centre        0.002499 -0.001001 0.180009 m (x right, y down, z forward)\n"
               "                +- 3.8e-06 3.3e-06 2.7e-05 m\n"
               "  radius        0.02 m\n"
               "  outline       centre 85.054, 57.275 px, radius 44.722 px\n"
               "  ...",
    .size = sizeof(locate_args),
    .defaults = defaults,
    .run = run,
};
