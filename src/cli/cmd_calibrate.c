/* calibrate: a camera from frames of a target, or from corners found before. */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "board_frames.h"
#include "commands.h"
#include "draw_calibration.h"
#include "evidence_charts.h"
#include "halflight/halflight.h"
#include "inputs.h"
#include "options.h"
#include "outputs.h"
#include "summary.h"
#include "summary_calibration.h"

enum { ASKED_MAX = 32 };

/* Pixels, and distances, at which the user asks for the projection's uncertainty. */
typedef struct asked_list {
  int n;
  struct {
    double pixel[2], distance_m;
  } at[ASKED_MAX];
} asked_list;

typedef struct image_size {
  int width, height; /* 0 = not given */
} image_size;

typedef struct frame_work {
  int threads;
} frame_work;

typedef struct calibrate_args {
  hl_words frames;
  const char *corners, *target, *out, *save_corners, *picture;
  image_size size;
  asked_list asked;
  bool json;
  frame_work work;
  hl_frame_settings frame_settings;
  hl_calibration_settings settings;
} calibrate_args;

#define AT(member) offsetof(calibrate_args, member)

static const hl_operand operands[] = {
    {"IMAGE", "frames of the target: PNG, JPEG, TIFF, EXR or PFM", AT(frames), HL_OPERAND_MANY},
};

static const hl_field_table *work_fields(void)
{
  static const hl_field fields[] = {
      {"threads", HL_FIELD_INT, offsetof(frame_work, threads), 0, 1024, "",
       "frames searched side by side; 0 = as many as the machine has", NULL},
  };
  static const hl_field_table table = {"frames", fields, 1};
  return &table;
}

/* A whole number of pixels; *end is where it ends. */
static int read_side(const char *text, char **end)
{
  errno = 0;
  const long side = strtol(text, end, 10);
  return errno == 0 && *end > text && side >= 2 && side <= 65536 ? (int)side : 0;
}

static hl_status parse_size(hl_ctx *ctx, const char *text, void *member)
{
  image_size size = {0};
  char *end = NULL;
  size.width = read_side(text, &end);
  if (size.width > 0 && *end == 'x')
    size.height = read_side(end + 1, &end);
  if (size.height == 0 || *end != '\0')
    return hl_fail(ctx, HL_ERR_ARG,
                   "--image-size '%.40s': WIDTHxHEIGHT in pixels, as 640x480, is needed", text);
  memcpy(member, &size, sizeof size);
  return HL_OK;
}

static hl_status parse_asked(hl_ctx *ctx, const char *text, void *member)
{
  asked_list list;
  double numbers[3] = {0, 0, HUGE_VAL};
  const bool has_distance = strchr(text, ',') != strrchr(text, ',');
  memcpy(&list, member, sizeof list);
  const hl_status st =
      hl_options_numbers(ctx, "uncertainty-at", text, has_distance ? 3 : 2, numbers);
  if (st != HL_OK)
    return st;
  if (!(numbers[2] > 0))
    return hl_fail(ctx, HL_ERR_ARG, "--uncertainty-at '%.40s': a distance above 0 m is needed",
                   text);
  if (list.n >= ASKED_MAX)
    return hl_fail(ctx, HL_ERR_ARG, "--uncertainty-at is given more than %d times", ASKED_MAX);
  memcpy(list.at[list.n].pixel, numbers, sizeof list.at[list.n].pixel);
  list.at[list.n++].distance_m = numbers[2];
  memcpy(member, &list, sizeof list);
  return HL_OK;
}

static const hl_option options[] = {
    {"target", "SPEC", "Board",
     "aprilgrid:COLSxROWS:TAG_M:SPACING_RATIO or chessboard:COLSxROWS:SQUARE_M; always needed",
     AT(target), 0, 0},
    {"corners", "F.vnl", NULL, "corners found before, instead of frames", AT(corners), 0, 0},
    {"image-size", "WxH", NULL, "size of the frames of --corners [px]", AT(size), 0, parse_size},
    {"transfer", "linear|srgb|gamma:G", "Frames",
     "how codes become radiance (default: 8-bit files are sRGB, others linear)", AT(frame_settings),
     0, hl_inputs_transfer},
    {"black", "B", NULL, NULL, AT(frame_settings), hl_frame_fields, 0},
    {"saturation", "S", NULL, NULL, AT(frame_settings), hl_frame_fields, 0},
    {"threads", "N", NULL, NULL, AT(work), work_fields, 0},
    {"model", "auto|pinhole|rational|fisheye", "Camera", NULL, AT(settings), hl_calibration_fields,
     0},
    {"min-views", "N", NULL, NULL, AT(settings), hl_calibration_fields, 0},
    {"outlier-sigmas", "K", NULL, NULL, AT(settings), hl_calibration_fields, 0},
    {"view-ratio", "R", NULL, NULL, AT(settings), hl_calibration_fields, 0},
    {"model-gain", "G", NULL, NULL, AT(settings), hl_calibration_fields, 0},
    {"json", NULL, "Output", "print CAMERA.json on stdout and nothing else", AT(json), 0, 0},
    {"out", "CAMERA.json|DIR/", NULL,
     "write the camera there, or camera.json and what `report` shows into a folder", AT(out), 0, 0},
    {"save-corners", "F.vnl", NULL, "write the corners there", AT(save_corners), 0, 0},
    {"uncertainty-at", "X,Y[,D]", NULL,
     "state how sure the projection is at that pixel, and distance [m]; may be repeated", AT(asked),
     0, parse_asked},
    {"picture", "FILE", NULL, "coverage, residuals and uncertainty: .png, .svg or .pdf",
     AT(picture), 0, 0},
    {"plot", "FILE", NULL, "the same as --picture", AT(picture), 0, 0},
};

static void defaults(void *args)
{
  calibrate_args *a = args;
  a->frame_settings = hl_frame_defaults();
  a->settings = hl_calibration_defaults();
}

/* Everything one run owns. */
typedef struct calibrate_run {
  const calibrate_args *args;
  hl_target target;
  hl_corners corners;
  hl_calibration calibration;
  hl_outputs outputs;
  int camera_at, corners_at, picture_at, evidence_at; /* places in outputs; -1 = not asked for */
  hl_picture_kind picture_kind;
} calibrate_run;

static hl_status check_usage(hl_ctx *ctx, const calibrate_args *a)
{
  if (!a->target)
    return hl_fail(ctx, HL_ERR_ARG,
                   "--target is missing; --target aprilgrid:... or chessboard:... is needed");
  if (a->corners && a->frames.n > 0)
    return hl_fail(ctx, HL_ERR_ARG, "--corners and frames contradict; one of the two is needed");
  if (!a->corners && a->frames.n == 0)
    return hl_fail(ctx, HL_ERR_ARG, "no frames; IMAGE ... or --corners F.vnl is needed");
  if (a->corners && a->size.width == 0)
    return hl_fail(ctx, HL_ERR_ARG,
                   "--image-size is missing; --corners needs the size of the frames, as 640x480");
  if (!a->corners && a->size.width > 0)
    return hl_fail(ctx, HL_ERR_ARG,
                   "--image-size is for --corners only; frames bring their own size");
  return HL_OK;
}

static hl_status plan(hl_ctx *ctx, calibrate_run *r)
{
  const calibrate_args *a = r->args;
  hl_outputs *o = &r->outputs;
  r->camera_at = r->corners_at = r->picture_at = r->evidence_at = -1;
  hl_status st = check_usage(ctx, a);
  if (st == HL_OK)
    st = hl_target_parse(ctx, a->target, &r->target);
  if (st == HL_OK && a->out)
    st = hl_outputs_document(ctx, o, a->out, "camera.json", &r->camera_at, &r->evidence_at);
  if (st == HL_OK && a->save_corners)
    st = hl_outputs_add(ctx, o, NULL, a->save_corners, &r->corners_at);
  if (st == HL_OK && a->picture) {
    st = hl_picture_kind_of(ctx, "picture", a->picture, &r->picture_kind);
    if (st == HL_OK)
      st = hl_outputs_add(ctx, o, NULL, a->picture, &r->picture_at);
  }
  return st;
}

static hl_status get_corners(hl_ctx *ctx, calibrate_run *r)
{
  const calibrate_args *a = r->args;
  if (!a->corners) {
    r->corners = hl_corners_of(&r->target);
    const hl_status st = hl_fields_check(ctx, hl_frame_fields(), &a->frame_settings);
    return st == HL_OK
               ? hl_board_frames(ctx, &a->frames, &a->frame_settings, a->work.threads, &r->corners)
               : st;
  }
  const hl_status st = hl_corners_read(ctx, a->corners, &r->target, &r->corners);
  if (st == HL_OK) {
    r->corners.width = a->size.width;
    r->corners.height = a->size.height;
  }
  return st;
}

static hl_status calibrate(hl_ctx *ctx, calibrate_run *r)
{
  const calibrate_args *a = r->args;
  hl_status st = hl_calibrate(ctx, &r->corners, &a->settings, &r->calibration);
  if (st != HL_OK)
    return a->corners ? hl_inputs_blame(ctx, st, a->corners) : st;
  for (int i = 0; i < a->asked.n && st == HL_OK; i++)
    st = hl_calibration_project(ctx, &r->calibration, a->asked.at[i].pixel,
                                a->asked.at[i].distance_m);
  return st;
}

static hl_status print_result(hl_ctx *ctx, const calibrate_run *r)
{
  if (!r->args->json) {
    hl_summary_calibration(stdout, &r->calibration);
    return HL_OK;
  }
  char *text = NULL;
  const hl_status st = hl_calibration_json(ctx, &r->calibration, &text);
  if (st == HL_OK)
    fputs(text, stdout);
  free(text);
  return st;
}

/* Text that stdout does not take leaves no files. */
static hl_status write_and_print(hl_ctx *ctx, calibrate_run *r)
{
  hl_outputs *o = &r->outputs;
  hl_status st = hl_outputs_begin(ctx, o);
  if (st == HL_OK && r->camera_at >= 0)
    st = hl_calibration_write(ctx, o->stage[r->camera_at], &r->calibration);
  if (st == HL_OK && r->corners_at >= 0)
    st = hl_corners_write(ctx, o->stage[r->corners_at], &r->corners);
  if (st == HL_OK && r->picture_at >= 0)
    st = hl_draw_calibration(ctx, r->picture_kind, o->stage[r->picture_at], &r->calibration,
                             &r->corners);
  if (st == HL_OK && r->evidence_at >= 0)
    st = hl_evidence_of_calibration(ctx, o->stage[r->evidence_at], &r->calibration, &r->corners);
  if (st == HL_OK)
    st = print_result(ctx, r);
  if (st == HL_OK)
    st = hl_outputs_print(ctx);
  if (st == HL_OK)
    st = hl_outputs_commit(ctx, o);
  hl_outputs_end(ctx, o);
  return st;
}

static hl_status report(hl_ctx *ctx, calibrate_run *r)
{
  const hl_status st = write_and_print(ctx, r);
  if (st != HL_OK || r->calibration.trusted)
    return st;
  char reasons[HL_MESSAGE_MAX];
  hl_summary_reasons(&r->calibration.reasons, reasons, sizeof reasons);
  return hl_fail(ctx, HL_ERR_RESIDUAL, "not to be trusted: %s", reasons);
}

static hl_status run(hl_ctx *ctx, const void *args)
{
  calibrate_run *r = calloc(1, sizeof *r);
  if (!r)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for the run");
  r->args = args;
  hl_status st = plan(ctx, r);
  if (st == HL_OK)
    st = get_corners(ctx, r);
  if (st == HL_OK)
    st = calibrate(ctx, r);
  if (st == HL_OK)
    st = report(ctx, r);
  hl_calibration_free(&r->calibration);
  hl_corners_free(&r->corners);
  free(r);
  return st;
}

const hl_command hl_command_calibrate = {
    .name = "calibrate",
    .sentence = "Find a camera's intrinsics, and how sure they are, from a target.",
    .operands = operands,
    .n_operands = sizeof operands / sizeof *operands,
    .options = options,
    .n_options = sizeof options / sizeof *options,
    .notes = "Fifteen views and more: the board tilted by 20 to 45 degrees in several\n"
             "directions, its corners all over the frame. Deviations are one sigma.\n"
             "Exit status: 0 done, 1 failed, 2 wrong usage, 3 the answer is not to be trusted.",
    .example = "  $ halflight calibrate --corners corners.vnl --image-size 640x480 \\\n"
               "      --target aprilgrid:6x6:0.03:0.3 --out calibrated.json --picture fit.png\n"
               "  camera        pinhole, 640 x 480 px\n"
               "  focal length  700.03 +- 0.25, 702.01 +- 0.26 px\n"
               "  centre        322.67 +- 0.28, 237.18 +- 0.26 px\n"
               "  ...",
    .size = sizeof(calibrate_args),
    .defaults = defaults,
    .run = run,
};
