/* capture: frames from a camera, or from a recorded session that plays as one, into a session. */
#define _XOPEN_SOURCE 700 // NOLINT(bugprone-reserved-identifier)
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "commands.h"
#include "halflight/capture.h"
#include "inputs.h"
#include "options.h"
#include "outputs.h"
#include "progress.h"

typedef struct capture_numbers {
  int frames;
  double exposure_us, gain, frame_duration_us, focus; /* below their bounds = not given */
} capture_numbers;

typedef struct capture_args {
  hl_words labels;
  const char *camera_id, *raw, *camera, *recorded, *out, *white_balance;
  bool list, full_speed, label;
  double radius_m;
  capture_numbers numbers;
} capture_args;

#define AT(member) offsetof(capture_args, member)

static const hl_field_table *number_fields(void)
{
  static const hl_field fields[] = {
      {"frames", HL_FIELD_INT, offsetof(capture_numbers, frames), 1, 1000000, "",
       "frames the session is to hold; always needed", NULL},
      {"exposure_us", HL_FIELD_DOUBLE, offsetof(capture_numbers, exposure_us), 1, 1e9, "us",
       "exposure time; always needed", NULL},
      {"gain", HL_FIELD_DOUBLE, offsetof(capture_numbers, gain), 0.01, 1e4, "",
       "analogue gain; always needed", NULL},
      {"frame_duration_us", HL_FIELD_DOUBLE, offsetof(capture_numbers, frame_duration_us), 1, 1e9,
       "us", "time from a frame to the next", NULL},
      {"focus", HL_FIELD_DOUBLE, offsetof(capture_numbers, focus), 0, 100, "dioptres",
       "distance of focus; 0 is infinity", NULL},
  };
  static const hl_field_table table = {"capture", fields, sizeof fields / sizeof *fields};
  return &table;
}

static const hl_operand operands[] = {
    {"LABEL", "name of the light of each frame, in order: as many as --frames, or none", AT(labels),
     HL_OPERAND_MANY},
};

static const hl_option options[] = {
    {"list", NULL, "Camera", "print the cameras and end", AT(list), 0, 0},
    {"camera-id", "ID", NULL, "which camera (default: the first)", AT(camera_id), 0, 0},
    {"recorded", "SESSION/", NULL, "play this session as the camera", AT(recorded), 0, 0},
    {"full-speed", NULL, NULL, "with --recorded: do not wait between its frames", AT(full_speed), 0,
     0},
    {"raw", "green|demosaiced|off", NULL,
     "the raw frames' green planes, or demosaiced, or processed frames (default: off; what the "
     "recorded session holds)",
     AT(raw), 0, 0},
    {"exposure-us", "E", "Locked", NULL, AT(numbers), number_fields, 0},
    {"gain", "G", NULL, NULL, AT(numbers), number_fields, 0},
    {"white-balance", "R,B", NULL, "gains of red and blue; needed unless the frames are raw",
     AT(white_balance), 0, 0},
    {"frame-duration-us", "T", NULL, NULL, AT(numbers), number_fields, 0},
    {"focus", "D", NULL, NULL, AT(numbers), number_fields, 0},
    {"frames", "N", "Session", NULL, AT(numbers), number_fields, 0},
    {"label", NULL, NULL, "before the words that are the LABELs; they are without it too",
     AT(label), 0, 0},
    {"camera", "CAMERA", NULL, "the calibrated camera, copied into the session", AT(camera), 0, 0},
    {"radius-m", "R", NULL, "the ball's radius", AT(radius_m), hl_inputs_radius_fields, 0},
    {"out", "SESSION/", NULL,
     "the session's folder; where it holds one, the frames it lacks are taken", AT(out), 0, 0},
};

static void defaults(void *args)
{
  capture_args *a = args;
  a->numbers.focus = -1;
}

/* Set by the signal, read between frames. */
static volatile sig_atomic_t interrupted;

static void on_signal(int signal_number)
{
  (void)signal_number;
  interrupted = 1;
}

static bool go_on(void *user, int done, int total)
{
  (void)user;
  hl_progress(done, total, "frames");
  return !interrupted;
}

static void catch_signals(void (*handler)(int))
{
  struct sigaction action;
  memset(&action, 0, sizeof action);
  action.sa_handler = handler;
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, NULL);
  sigaction(SIGTERM, &action, NULL);
}

static hl_status parse_pixels(hl_ctx *ctx, const char *text, bool recorded, hl_session_pixels *out)
{
  static const char *const words[] = {"", "green", "demosaiced", "off"};
  *out = recorded ? HL_PIXELS_UNSTATED : HL_PIXELS_PROCESSED;
  if (!text)
    return HL_OK;
  for (int i = 1; i < 4; i++)
    if (strcmp(text, words[i]) == 0) {
      *out = (hl_session_pixels)i;
      return HL_OK;
    }
  return hl_fail(ctx, HL_ERR_ARG, "--raw '%.40s' is none of green, demosaiced, off", text);
}

static hl_status needed(hl_ctx *ctx, bool given, const char *option)
{
  return given ? HL_OK : hl_fail(ctx, HL_ERR_ARG, "%s is missing; it is always needed", option);
}

static hl_status make_plan(hl_ctx *ctx, const capture_args *a, hl_capture_plan *plan)
{
  const capture_numbers *n = &a->numbers;
  hl_status st = needed(ctx, a->out != NULL, "--out SESSION/");
  if (st == HL_OK)
    st = needed(ctx, n->frames > 0, "--frames N");
  if (st == HL_OK)
    st = needed(ctx, n->exposure_us > 0, "--exposure-us E");
  if (st == HL_OK)
    st = needed(ctx, n->gain > 0, "--gain G");
  if (st == HL_OK && a->labels.n > 0 && a->labels.n != n->frames)
    st = hl_fail(ctx, HL_ERR_ARG, "%d labels for %d frames; one a frame, or none, is needed",
                 a->labels.n, n->frames);
  if (st == HL_OK)
    st = parse_pixels(ctx, a->raw, a->recorded != NULL, &plan->pixels);
  if (st == HL_OK && a->white_balance)
    st = hl_options_numbers(ctx, "white-balance", a->white_balance, 2, plan->locked.white_balance);
  if (st != HL_OK)
    return st;
  const double *balance = plan->locked.white_balance;
  if (a->white_balance && !(balance[0] > 0 && balance[1] > 0))
    return hl_fail(ctx, HL_ERR_ARG, "--white-balance %.40s: two gains above 0 are needed",
                   a->white_balance);
  if (plan->pixels == HL_PIXELS_PROCESSED && !a->white_balance)
    return hl_fail(ctx, HL_ERR_ARG,
                   "--white-balance R,B is missing; processed frames need it, raw ones do not");
  plan->folder = a->out;
  plan->n_frames = n->frames;
  plan->labels = a->labels.n > 0 ? a->labels.word : NULL;
  plan->camera_id = a->camera_id;
  plan->locked.exposure_us = n->exposure_us;
  plan->locked.gain = n->gain;
  plan->locked.frame_duration_us = n->frame_duration_us;
  plan->locked.focus_dioptre = n->focus;
  plan->radius_m = a->radius_m;
  plan->go_on = go_on;
  return HL_OK;
}

static hl_status make_source(hl_ctx *ctx, const capture_args *a, hl_capture_source *source)
{
  return a->recorded ? hl_capture_recorded(ctx, a->recorded, a->full_speed, source)
                     : hl_capture_libcamera(ctx, source);
}

static hl_status print_list(hl_ctx *ctx, const hl_capture_source *source)
{
  hl_capture_camera *cameras = NULL;
  int n = 0;
  const hl_status st = source->list(ctx, source->state, &cameras, &n);
  if (st == HL_OK && n == 0)
    printf("no camera\n");
  for (int i = 0; st == HL_OK && i < n; i++)
    printf("%s%s%s\n", cameras[i].id, cameras[i].model[0] ? "  " : "", cameras[i].model);
  free(cameras);
  return st;
}

static void print_result(const hl_capture_plan *plan, const hl_capture_result *r)
{
  static const char *const names[] = {"exposure", "gain", "white balance", "frame duration",
                                      "focus"};
  for (unsigned i = 0; i < sizeof names / sizeof *names; i++)
    if (r->lacks >> i & 1u)
      fprintf(stderr,
              "halflight: capture: warning: the driver has no control of %s; the frames are marked "
              "untrusted\n",
              names[i]);
  printf("%d of %d frames in %s, %d of them now\n", r->held, plan->n_frames, plan->folder,
         r->recorded);
}

static hl_status record(hl_ctx *ctx, const hl_capture_source *source, hl_capture_plan *plan,
                        const char *camera_path)
{
  hl_camera camera;
  hl_capture_result result;
  if (camera_path) {
    const hl_status st = hl_camera_read(ctx, camera_path, &camera);
    if (st != HL_OK)
      return st;
    plan->camera = &camera;
  }
  interrupted = 0;
  catch_signals(on_signal);
  const hl_status st = hl_capture_run(ctx, source, plan, &result);
  catch_signals(SIG_DFL);
  hl_progress(1, 1, "frames");
  if (st == HL_OK || result.recorded > 0)
    print_result(plan, &result);
  if (st == HL_OK && result.held < plan->n_frames)
    return hl_fail(ctx, HL_ERR_IO,
                   "interrupted; %d of %d frames are in %.120s; the same command "
                   "takes the rest",
                   result.held, plan->n_frames, plan->folder);
  return st;
}

static hl_status run(hl_ctx *ctx, const void *args)
{
  const capture_args *a = args;
  hl_capture_plan plan = {0};
  hl_capture_source source = {0};
  hl_status st = HL_OK;
  if (a->full_speed && !a->recorded)
    st = hl_fail(ctx, HL_ERR_ARG, "--full-speed is for --recorded SESSION/ alone");
  if (st == HL_OK && !a->list)
    st = make_plan(ctx, a, &plan);
  if (st == HL_OK)
    st = make_source(ctx, a, &source);
  if (st != HL_OK)
    return st;
  st = a->list ? print_list(ctx, &source) : record(ctx, &source, &plan, a->camera);
  source.close(source.state);
  return st;
}

const hl_command hl_command_capture = {
    .name = "capture",
    .sentence = "Record frames from a camera into a session, everything locked.",
    .operands = operands,
    .n_operands = sizeof operands / sizeof *operands,
    .options = options,
    .n_options = sizeof options / sizeof *options,
    .notes = "Ctrl-C ends after the present frame; the same command takes the frames that the\n"
             "session lacks.\n"
             "Exit status: 0 done, 1 failed, interrupted or frames are missing, 2 wrong usage.",
    .example = "  $ halflight capture --recorded recorded --frames 1 --exposure-us 8000 \\\n"
               "      --gain 1 --label left --camera camera.json --radius-m 0.02 --out session\n"
               "  1 of 1 frames in session, 1 of them now",
    .size = sizeof(capture_args),
    .defaults = defaults,
    .run = run,
};
