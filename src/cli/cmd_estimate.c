/* estimate: one frame of a ball, or of any surface of known normals, to its light. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "commands.h"
#include "draw_curves.h"
#include "evidence_frame.h"
#include "halflight/halflight.h"
#include "inputs.h"
#include "options.h"
#include "outputs.h"
#include "summary.h"

typedef struct estimate_args {
  const char *frame, *camera, *sphere, *normals, *out, *picture, *plot;
  double radius_m;
  bool json;
  hl_frame_settings frame_settings;
  hl_sphere_settings sphere_settings;
  hl_light_settings light_settings;
} estimate_args;

#define AT(member) offsetof(estimate_args, member)

static const hl_operand operands[] = {
    {"FRAME", "the photo: PNG, JPEG, TIFF, EXR or PFM", AT(frame), HL_OPERAND_NEEDED},
};

static const hl_option options[] = {
    {"camera", "CAMERA", "Geometry",
     "the calibrated camera, always needed: CAMERA.json, OpenCV or Kalibr YAML, mrcal .cameramodel",
     AT(camera), 0, 0},
    {"sphere", "SPHERE.json", NULL, "the ball's pose, where it is known", AT(sphere), 0, 0},
    {"radius-m", "R", NULL, "the ball's radius; its pose is then found in the frame", AT(radius_m),
     hl_inputs_radius_fields, 0},
    {"circle", "X,Y,R", NULL, "look for the ball near this circle only [px]", AT(sphere_settings),
     0, hl_inputs_circle},
    {"normals", "N.pfm", NULL,
     "normals of another surface: three channels, x right, y down, z forward, 0,0,0 for none",
     AT(normals), 0, 0},
    {"transfer", "linear|srgb|gamma:G", "Frame",
     "how codes become radiance (default: 8-bit files are sRGB, others linear)", AT(frame_settings),
     0, hl_inputs_transfer},
    {"black", "B", NULL, NULL, AT(frame_settings), hl_frame_fields, 0},
    {"saturation", "S", NULL, NULL, AT(frame_settings), hl_frame_fields, 0},
    {"lobe", "auto|plain|foreshortened", "Light", NULL, AT(light_settings), hl_light_fields, 0},
    {"with", "NAME", NULL,
     "keep this term whatever it saves: ambient, near, backscatter, colored-lobe, outliers, "
     "response, "
     "bends; once a term",
     AT(light_settings.with), 0, hl_inputs_with},
    {"without", "NAME", NULL, "never try this term; once a term", AT(light_settings.without), 0,
     hl_inputs_without},
    {"model-error", "E", NULL, NULL, AT(light_settings), hl_light_fields, 0},
    {"outlier-sigmas", "K", NULL, NULL, AT(light_settings), hl_light_fields, 0},
    {"widest-deg", "A", NULL, NULL, AT(light_settings), hl_light_fields, 0},
    {"pixels", "N", NULL, NULL, AT(light_settings), hl_light_fields, 0},
    {"budget-ms", "T", NULL, NULL, AT(light_settings), hl_light_fields, 0},
    {"threads", "N", NULL, NULL, AT(light_settings), hl_light_fields, 0},
    {"json", NULL, "Output", "print LIGHT.json on stdout and nothing else", AT(json), 0, 0},
    {"out", "DIR", NULL,
     "write light.json, curves.csv, lights.lp, and evidence.json for `report` there", AT(out), 0,
     0},
    {"picture", "FILE", NULL, "annotated photo: .png, .svg or .pdf", AT(picture), 0, 0},
    {"plot", "FILE", NULL, "fitted curves: .png, .svg or .pdf", AT(plot), 0, 0},
};

static void defaults(void *args)
{
  estimate_args *a = args;
  a->frame_settings = hl_frame_defaults();
  a->sphere_settings = hl_sphere_defaults();
  a->light_settings = hl_light_defaults();
}

/* Pixels seen more obliquely than acos of this say more about their neighbours than themselves. */
static const double MIN_COS_VIEW = 0.1;

/* A ball's radius, given twice, is the same to this share. */
static const double SAME_RADIUS = 1e-6;

/* Everything one run owns. */
typedef struct estimate_run {
  const estimate_args *args;
  hl_camera camera;
  hl_frame frame;
  hl_sphere sphere;
  bool has_sphere, has_fit;
  hl_sphere_fit fit;
  hl_surface surface;
  hl_light light;
  hl_light_work *work;
  hl_timing timing;
  hl_outputs outputs;
  int light_at, curves_at, lp_at, evidence_at, picture_at,
      plot_at; /* places in outputs; -1 = not asked for */
  hl_picture_kind picture_kind, plot_kind;
} estimate_run;

static hl_status check_usage(hl_ctx *ctx, const estimate_args *a)
{
  const bool hint = a->sphere_settings.hint_radius_px > 0;
  if (!a->camera)
    return hl_fail(ctx, HL_ERR_ARG, "--camera is missing; --camera CAMERA is needed");
  if (a->sphere && a->normals)
    return hl_fail(ctx, HL_ERR_ARG,
                   "--sphere and --normals contradict; one of the two describes the surface");
  if (a->normals && a->radius_m > 0)
    return hl_fail(ctx, HL_ERR_ARG,
                   "--radius-m and --normals contradict; a ball or a normal map, not both");
  if (hint && (a->sphere || a->normals))
    return hl_fail(ctx, HL_ERR_ARG,
                   "--circle and --%s contradict; a hint is for finding the ball with --radius-m",
                   a->sphere ? "sphere" : "normals");
  if (!a->sphere && !a->normals && !(a->radius_m > 0))
    return hl_fail(ctx, HL_ERR_ARG,
                   "the surface is missing; --radius-m R (the ball is then found), --sphere "
                   "SPHERE.json or --normals N.pfm is needed");
  return HL_OK;
}

static hl_status plan_outputs(hl_ctx *ctx, estimate_run *r)
{
  const estimate_args *a = r->args;
  hl_outputs *o = &r->outputs;
  hl_status st = HL_OK;
  r->light_at = r->curves_at = r->lp_at = r->evidence_at = r->picture_at = r->plot_at = -1;
  if (a->out) {
    st = hl_outputs_folder(ctx, o, a->out);
    if (st == HL_OK)
      st = hl_outputs_add(ctx, o, a->out, "light.json", &r->light_at);
    if (st == HL_OK)
      st = hl_outputs_add(ctx, o, a->out, "curves.csv", &r->curves_at);
    if (st == HL_OK)
      st = hl_outputs_add(ctx, o, a->out, "lights.lp", &r->lp_at);
    if (st == HL_OK)
      st = hl_outputs_add(ctx, o, a->out, "evidence.json", &r->evidence_at);
  }
  if (st == HL_OK && a->picture) {
    st = hl_picture_kind_of(ctx, "picture", a->picture, &r->picture_kind);
    if (st == HL_OK)
      st = hl_outputs_add(ctx, o, NULL, a->picture, &r->picture_at);
  }
  if (st == HL_OK && a->plot) {
    st = hl_picture_kind_of(ctx, "plot", a->plot, &r->plot_kind);
    if (st == HL_OK)
      st = hl_outputs_add(ctx, o, NULL, a->plot, &r->plot_at);
  }
  return st;
}

static hl_status read_sphere(hl_ctx *ctx, estimate_run *r)
{
  const estimate_args *a = r->args;
  const hl_status st = hl_sphere_read(ctx, a->sphere, &r->sphere);
  if (st != HL_OK)
    return st;
  const double found = r->sphere.radius_m;
  if (a->radius_m > 0 && !(fabs(found - a->radius_m) <= SAME_RADIUS * a->radius_m))
    return hl_fail(
        ctx, HL_ERR_ARG,
        "--radius-m %.9g m and radius_m %.9g m of %s contradict; one of the two is enough",
        a->radius_m, found, a->sphere);
  r->has_sphere = true;
  return HL_OK;
}

static hl_status surface_of_normals(hl_ctx *ctx, estimate_run *r)
{
  hl_frame_settings settings = hl_frame_defaults();
  settings.transfer = HL_TRANSFER_LINEAR;
  hl_frame normals;
  hl_status st = hl_frame_read(ctx, r->args->normals, &settings, &normals);
  if (st != HL_OK)
    return st;
  st = hl_surface_of_normals(ctx, &r->camera, &normals, MIN_COS_VIEW, &r->surface);
  hl_frame_free(&normals);
  return hl_inputs_blame(ctx, st, r->args->normals);
}

/* The surface: from a normal map, a known ball, or a ball found in the frame. */
static hl_status find_surface(hl_ctx *ctx, estimate_run *r)
{
  const estimate_args *a = r->args;
  if (a->normals)
    return surface_of_normals(ctx, r);
  if (!a->sphere) {
    const double start = hl_inputs_clock_ms();
    const hl_status st = hl_sphere_locate(ctx, &r->frame, &r->camera, a->radius_m,
                                          &a->sphere_settings, &r->sphere, &r->fit);
    r->timing.locate_ms = hl_inputs_clock_ms() - start;
    if (st != HL_OK)
      return hl_inputs_blame(ctx, st, a->frame);
    r->has_sphere = r->has_fit = true;
  }
  const hl_status st = hl_surface_of_sphere(ctx, &r->camera, &r->sphere, MIN_COS_VIEW, &r->surface);
  return hl_inputs_blame(ctx, st, a->sphere ? a->sphere : a->frame);
}

static hl_status estimate_light(hl_ctx *ctx, estimate_run *r)
{
  const double start = hl_inputs_clock_ms();
  hl_status st = hl_light_work_new(ctx, r->surface.n, r->frame.channels, &r->work);
  if (st == HL_OK)
    st = hl_light_estimate(ctx, r->work, &r->frame, &r->surface, &r->args->light_settings,
                           &r->light);
  r->timing.estimate_ms = hl_inputs_clock_ms() - start;
  return hl_inputs_blame(ctx, st, r->args->frame);
}

static const char *base_name(const char *path)
{
  const char *slash = strrchr(path, '/');
  return slash ? slash + 1 : path;
}

/* The frame's name in a list whose columns are parted by spaces; free(), NULL without memory. */
static char *list_name(const char *path)
{
  const char *name = base_name(path);
  const size_t size = strlen(name) + 1;
  char *out = malloc(size);
  if (!out)
    return NULL;
  memcpy(out, name, size);
  for (char *c = out; (c = strpbrk(c, " \t\r\n\v\f"));)
    *c = '_';
  return out;
}

static hl_status write_lp(hl_ctx *ctx, const estimate_run *r)
{
  char *name = list_name(r->args->frame);
  if (!name)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for a file name");
  const char *const names[] = {name};
  const hl_status st = hl_lp_write(ctx, r->outputs.stage[r->lp_at], names, r->light.direction, 1);
  free(name);
  return st;
}

static hl_status print_result(hl_ctx *ctx, const estimate_run *r)
{
  if (!r->args->json) {
    if (r->light.found)
      hl_summary_light(stdout, &r->light, &r->timing);
    return HL_OK;
  }
  char *text = NULL;
  const hl_status st = hl_light_json(ctx, &r->light, &r->timing, &text);
  if (st == HL_OK)
    fputs(text, stdout);
  free(text);
  return st;
}

/* light.json is read for the evidence, and written again last: it holds the time the others took. Text
 * that stdout does not take leaves no files. */
static hl_status write_and_print(hl_ctx *ctx, estimate_run *r)
{
  hl_outputs *o = &r->outputs;
  const double start = hl_inputs_clock_ms();
  const hl_photo photo = {&r->frame,   &r->camera, r->has_sphere ? &r->sphere : NULL,
                          &r->surface, &r->light,  r->has_fit ? &r->fit : NULL,
                          false};
  const hl_curve_sheet sheet = {&r->light, NULL, NULL, NULL};
  hl_status st = hl_outputs_begin(ctx, o);
  if (st == HL_OK && r->curves_at >= 0)
    st = hl_curves_csv_write(ctx, o->stage[r->curves_at], &r->light);
  if (st == HL_OK && r->lp_at >= 0)
    st = write_lp(ctx, r);
  if (st == HL_OK && r->picture_at >= 0)
    st = hl_draw_frame(ctx, r->picture_kind, o->stage[r->picture_at], &photo);
  if (st == HL_OK && r->plot_at >= 0)
    st = hl_draw_curves(ctx, r->plot_kind, o->stage[r->plot_at], &sheet);
  if (st == HL_OK && r->light_at >= 0)
    st = hl_light_json_write(ctx, o->stage[r->light_at], &r->light, &r->timing);
  if (st == HL_OK && r->evidence_at >= 0)
    st =
        hl_evidence_of_frame(ctx, o->stage[r->evidence_at], &photo, r->work, o->stage[r->light_at]);
  r->timing.export_ms = hl_inputs_clock_ms() - start;
  if (st == HL_OK && r->light_at >= 0)
    st = hl_light_json_write(ctx, o->stage[r->light_at], &r->light, &r->timing);
  if (st == HL_OK)
    st = print_result(ctx, r);
  if (st == HL_OK)
    st = hl_outputs_print(ctx);
  if (st == HL_OK)
    st = hl_outputs_commit(ctx, o);
  hl_outputs_end(ctx, o);
  return st;
}

/* The frame was read but gives no light: the document says so and why. */
static hl_status report_nothing(hl_ctx *ctx, estimate_run *r, hl_status why)
{
  hl_light *light = &r->light;
  char text[HL_MESSAGE_MAX];
  snprintf(text, sizeof text, "%s", ctx->msg);
  if (light->reasons.n == 0) {
    snprintf(light->reasons.note[0].why, HL_NOTE_TEXT_MAX, "%.*s", HL_NOTE_TEXT_MAX - 1, text);
    light->reasons.n = 1;
  }
  light->found = light->trusted = false;
  const hl_status st = print_result(ctx, r);
  return st == HL_OK ? hl_fail(ctx, why, "%s", text) : st;
}

static hl_status report(hl_ctx *ctx, estimate_run *r)
{
  const hl_status st = write_and_print(ctx, r);
  if (st != HL_OK || r->light.trusted)
    return st;
  char reasons[HL_MESSAGE_MAX];
  hl_summary_reasons(&r->light.reasons, reasons, sizeof reasons);
  return hl_fail(ctx, HL_ERR_RESIDUAL, "%s: not to be trusted: %s", r->args->frame, reasons);
}

static hl_status run(hl_ctx *ctx, const void *args)
{
  estimate_run *r = calloc(1, sizeof *r);
  if (!r)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for the run");
  r->args = args;
  hl_status st = check_usage(ctx, r->args);
  if (st == HL_OK)
    st = plan_outputs(ctx, r);
  const double start = hl_inputs_clock_ms();
  if (st == HL_OK)
    st = hl_inputs_read(ctx, r->args->frame, r->args->camera, &r->args->frame_settings, &r->camera,
                        &r->frame);
  if (st == HL_OK && r->args->sphere)
    st = read_sphere(ctx, r);
  r->timing.read_ms = hl_inputs_clock_ms() - start;
  if (st == HL_OK) {
    st = find_surface(ctx, r);
    if (st == HL_OK)
      st = estimate_light(ctx, r);
    if (st == HL_OK)
      st = report(ctx, r);
    else if (hl_status_exit(st) == hl_status_exit(HL_ERR_DEGENERATE))
      st = report_nothing(ctx, r, st);
  }
  hl_light_work_free(r->work);
  hl_surface_free(&r->surface);
  hl_frame_free(&r->frame);
  free(r);
  return st;
}

const hl_command hl_command_estimate = {
    .name = "estimate",
    .sentence = "Find a photo's light, how sure it is, and how the ball reflects.",
    .operands = operands,
    .n_operands = sizeof operands / sizeof *operands,
    .options = options,
    .n_options = sizeof options / sizeof *options,
    .notes = "Exit status: 0 done, 1 failed, 2 wrong usage, 3 the answer is not to be trusted.",
    .example = "  $ halflight estimate frame.pfm --camera camera.json --radius-m 0.02 \\\n"
               "      --out out --picture out/photo.png --plot out/curves.png\n"
               "  light          0.318090 -0.423915 -0.848006  camera: x right, ...\n"
               "                 0.318090  0.423915  0.848006  .lp: x right, y up, ...\n"
               "                32.74 deg from the view, azimuth 53.12 deg (0 right, 90 up)\n"
               "                95 % ellipse, half axes 0.0507 and 0.0455 deg\n"
               "  ...",
    .size = sizeof(estimate_args),
    .defaults = defaults,
    .run = run,
};
