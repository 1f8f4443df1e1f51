/* drift: whether a camera is still the camera it was, or a rig the rig. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "commands.h"
#include "draw.h"
#include "drift_rig.h"
#include "evidence_charts.h"
#include "halflight/halflight.h"
#include "inputs.h"
#include "options.h"
#include "outputs.h"
#include "summary_drift.h"

typedef struct drift_args {
  const char *reference, *current;
  const char *board, *target, *board_pose, *save_board_pose, *picture, *out;
  bool json;
  hl_drift_settings settings;
} drift_args;

#define AT(member) offsetof(drift_args, member)

static const hl_operand operands[] = {
    {"REFERENCE", "as it was: CAMERA.json with a covariance, or a replayed session", AT(reference),
     HL_OPERAND_NEEDED},
    {"CURRENT", "as it is: calibrated, or replayed, again; or --board", AT(current),
     HL_OPERAND_OPTIONAL},
};

static const hl_option options[] = {
    {"board", "FRAME", "Fixed board",
     "a new frame of a board that has not moved (or a .vnl of its corners)", AT(board), 0, 0},
    {"target", "SPEC", NULL,
     "that board (default: the one of POSE.json, or the camera was calibrated with)", AT(target), 0,
     0},
    {"board-pose", "POSE.json", NULL, "where it was; compare with it", AT(board_pose), 0, 0},
    {"save-board-pose", "POSE.json", NULL, "FRAME is the reference: write where the board is",
     AT(save_board_pose), 0, 0},
    {"false-alarm", "A", "Verdict", NULL, AT(settings), hl_drift_fields, 0},
    {"distance-m", "D", NULL, NULL, AT(settings), hl_drift_fields, 0},
    {"json", NULL, "Output", "print the document on stdout and nothing else", AT(json), 0, 0},
    {"out", "DIR", NULL, "write drift.json, and evidence.json for `report`, there", AT(out), 0, 0},
    {"plot", "FILE", NULL, "the same as --picture", AT(picture), 0, 0},
    {"picture", "FILE", NULL, "projection difference, or lights that moved: .png, .svg or .pdf",
     AT(picture), 0, 0},
};

static void defaults(void *args)
{
  ((drift_args *)args)->settings = hl_drift_defaults();
}

typedef struct drift_run {
  const drift_args *args;
  hl_calibration reference, current;
  hl_corners corners;
  hl_board_pose pose;
  hl_drift drift;
  hl_outputs outputs;
  int pose_at, picture_at, drift_at, evidence_at; /* places in outputs; -1 = not asked for */
  hl_picture_kind picture_kind;
} drift_run;

/* ---- what was asked ---- */

static hl_status check_usage(hl_ctx *ctx, const drift_args *a)
{
  if (a->current && a->board)
    return hl_fail(ctx, HL_ERR_ARG, "CURRENT and --board are two comparisons; one is needed");
  if (!a->current && !a->board)
    return hl_fail(ctx, HL_ERR_ARG,
                   "CURRENT is missing: halflight drift REFERENCE CURRENT, or REFERENCE --board "
                   "FRAME --board-pose POSE.json");
  if (a->current && (a->target || a->board_pose || a->save_board_pose))
    return hl_fail(ctx, HL_ERR_ARG, "--%s belongs to --board FRAME",
                   a->target       ? "target"
                   : a->board_pose ? "board-pose"
                                   : "save-board-pose");
  if (a->board && !a->board_pose == !a->save_board_pose)
    return hl_fail(ctx, HL_ERR_ARG,
                   "--board needs one of --board-pose POSE.json, to compare with, and "
                   "--save-board-pose POSE.json, to begin with");
  if (a->save_board_pose && a->picture)
    return hl_fail(ctx, HL_ERR_ARG, "--save-board-pose compares nothing that --picture could show");
  if (a->save_board_pose && a->out)
    return hl_fail(ctx, HL_ERR_ARG, "--save-board-pose compares nothing that --out could hold");
  return HL_OK;
}

static hl_status plan(hl_ctx *ctx, drift_run *r)
{
  const drift_args *a = r->args;
  hl_status st = check_usage(ctx, a);
  r->pose_at = r->picture_at = r->drift_at = r->evidence_at = -1;
  if (st == HL_OK && a->save_board_pose)
    st = hl_outputs_add(ctx, &r->outputs, NULL, a->save_board_pose, &r->pose_at);
  if (st == HL_OK && a->picture) {
    st = hl_picture_kind_of(ctx, "picture", a->picture, &r->picture_kind);
    if (st == HL_OK)
      st = hl_outputs_add(ctx, &r->outputs, NULL, a->picture, &r->picture_at);
  }
  if (st == HL_OK && a->out)
    st = hl_drift_plan(ctx, &r->outputs, a->out, &r->drift_at, &r->evidence_at);
  return st;
}

/* ---- what is read ---- */

static bool is_vnl(const char *path)
{
  const size_t n = strlen(path);
  return n > 4 && strcmp(path + n - 4, ".vnl") == 0;
}

static hl_status read_corners(hl_ctx *ctx, const hl_target *target, drift_run *r)
{
  const char *path = r->args->board;
  hl_status st = hl_corners_read(ctx, path, target, &r->corners);
  if (st == HL_OK && r->corners.n_views != 1)
    st = hl_fail(ctx, HL_ERR_FORMAT, "%s holds %d views; that of the fixed board alone is needed",
                 path, r->corners.n_views);
  return st;
}

static hl_status detect_corners(hl_ctx *ctx, const hl_target *target, drift_run *r)
{
  const char *path = r->args->board;
  const hl_frame_settings settings = hl_frame_defaults();
  hl_frame frame;
  hl_status st = hl_frame_read(ctx, path, &settings, &frame);
  if (st != HL_OK)
    return st;
  r->corners = hl_corners_of(target);
  st = hl_corners_detect(ctx, &r->corners, &frame, path, NULL);
  hl_frame_free(&frame);
  return st;
}

static hl_status find_target(hl_ctx *ctx, const drift_run *r, hl_target *out)
{
  const drift_args *a = r->args;
  if (a->target)
    return hl_target_parse(ctx, a->target, out);
  *out = a->board_pose ? r->pose.target : r->reference.target;
  if (out->columns > 0)
    return HL_OK;
  return hl_fail(ctx, HL_ERR_ARG, "%s states no target; --target SPEC is needed", a->reference);
}

static hl_status read_inputs(hl_ctx *ctx, drift_run *r)
{
  const drift_args *a = r->args;
  hl_target target;
  hl_status st = hl_calibration_read(ctx, a->reference, &r->reference);
  if (st == HL_OK && a->current)
    return hl_calibration_read(ctx, a->current, &r->current);
  if (st == HL_OK && a->board_pose)
    st = hl_board_pose_read(ctx, a->board_pose, &r->pose);
  if (st == HL_OK)
    st = find_target(ctx, r, &target);
  if (st == HL_OK)
    st = is_vnl(a->board) ? read_corners(ctx, &target, r) : detect_corners(ctx, &target, r);
  return st;
}

/* ---- the comparison ---- */

static hl_status compare(hl_ctx *ctx, drift_run *r)
{
  const drift_args *a = r->args;
  if (a->current)
    return hl_drift_cameras(ctx, &r->reference, &r->current, &a->settings, &r->drift);
  if (a->save_board_pose)
    return hl_board_pose_fit(ctx, &r->reference, &r->corners, 0, &r->pose);
  return hl_drift_board(ctx, &r->reference, &r->pose, &r->corners, 0, &a->settings, &r->drift);
}

/* Exit status 3 says drifted and nothing else; what could not be compared is a failure. */
static hl_status as_failure(hl_ctx *ctx, hl_status status)
{
  char text[HL_MESSAGE_MAX];
  if (hl_status_exit(status) != hl_status_exit(HL_ERR_RESIDUAL))
    return status;
  snprintf(text, sizeof text, "%s", ctx->msg);
  return hl_fail(ctx, HL_ERR_FORMAT, "%s", text);
}

static hl_status print_result(hl_ctx *ctx, const drift_run *r)
{
  const bool saved = r->args->save_board_pose;
  if (!r->args->json) {
    if (saved)
      hl_summary_board_pose(stdout, &r->pose);
    else
      hl_summary_drift(stdout, &r->drift, &r->reference.camera);
    return HL_OK;
  }
  char *text = NULL;
  const hl_status st =
      saved ? hl_board_pose_json(ctx, &r->pose, &text) : hl_drift_json(ctx, &r->drift, &text);
  if (st == HL_OK)
    fputs(text, stdout);
  free(text);
  return st;
}

static hl_status write_document(hl_ctx *ctx, const drift_run *r)
{
  char *text = NULL;
  hl_status st = hl_drift_json(ctx, &r->drift, &text);
  if (st == HL_OK)
    st = hl_file_write(ctx, r->outputs.stage[r->drift_at], text, strlen(text));
  free(text);
  return st;
}

/* Text that stdout does not take leaves no files. */
static hl_status write_and_print(hl_ctx *ctx, drift_run *r)
{
  hl_outputs *o = &r->outputs;
  char verdict[HL_MESSAGE_MAX];
  hl_summary_verdict(&r->drift, verdict, sizeof verdict);
  hl_status st = hl_outputs_begin(ctx, o);
  if (st == HL_OK && r->pose_at >= 0)
    st = hl_board_pose_write(ctx, o->stage[r->pose_at], &r->pose);
  if (st == HL_OK && r->picture_at >= 0)
    st = hl_draw_drift(ctx, r->picture_kind, o->stage[r->picture_at], &r->drift, verdict);
  if (st == HL_OK && r->drift_at >= 0)
    st = write_document(ctx, r);
  if (st == HL_OK && r->evidence_at >= 0)
    st = hl_evidence_of_drift(ctx, o->stage[r->evidence_at], &r->drift, verdict);
  if (st == HL_OK)
    st = print_result(ctx, r);
  if (st == HL_OK)
    st = hl_outputs_print(ctx);
  if (st == HL_OK)
    st = hl_outputs_commit(ctx, o);
  hl_outputs_end(ctx, o);
  return st == HL_OK && r->drift.drifted ? hl_fail(ctx, HL_ERR_RESIDUAL, "%s", verdict) : st;
}

/* Two sessions are compared elsewhere; one of them with a camera, not at all. */
static hl_status run_rig(hl_ctx *ctx, const drift_args *a)
{
  if (!a->current || a->board)
    return hl_fail(ctx, HL_ERR_ARG, "%s is a session; another one to compare it with is needed",
                   a->reference);
  if (!hl_drift_rig_is(a->reference) || !hl_drift_rig_is(a->current))
    return hl_fail(ctx, HL_ERR_ARG, "%s is a session and %s is none; two of a kind are needed",
                   hl_drift_rig_is(a->reference) ? a->reference : a->current,
                   hl_drift_rig_is(a->reference) ? a->current : a->reference);
  const hl_drift_rig_args args = {.reference = a->reference,
                                  .current = a->current,
                                  .picture = a->picture,
                                  .out = a->out,
                                  .json = a->json,
                                  .settings = {.false_alarm = a->settings.false_alarm}};
  const hl_status st = check_usage(ctx, a);
  return st == HL_OK ? hl_drift_rig_run(ctx, &args) : st;
}

static hl_status run(hl_ctx *ctx, const void *args)
{
  const drift_args *a = args;
  if (hl_drift_rig_is(a->reference) || (a->current && hl_drift_rig_is(a->current)))
    return run_rig(ctx, a);
  drift_run *r = calloc(1, sizeof *r);
  if (!r)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for the run");
  r->args = args;
  hl_status st = plan(ctx, r);
  if (st == HL_OK)
    st = as_failure(ctx, read_inputs(ctx, r));
  if (st == HL_OK)
    st = as_failure(ctx, compare(ctx, r));
  if (st == HL_OK)
    st = write_and_print(ctx, r);
  hl_corners_free(&r->corners);
  hl_calibration_free(&r->current);
  hl_calibration_free(&r->reference);
  free(r);
  return st;
}

const hl_command hl_command_drift = {
    .name = "drift",
    .sentence = "Tell whether a camera or a rig has changed, and what moved.",
    .operands = operands,
    .n_operands = sizeof operands / sizeof *operands,
    .options = options,
    .n_options = sizeof options / sizeof *options,
    .notes = "Two calibrations: intrinsics are compared by their stated uncertainty, and the\n"
             "mount where both saw boards of the same file names that stood still. A fixed\n"
             "board: save its pose once, then compare each new frame of it with that pose.\n"
             "Two folders that replay wrote (or their lights.json): each light's direction and\n"
             "intensity, the ball, the camera's mount and intrinsics, and the exposure.\n"
             "The document's `change' and `deviation' are in px, coefficients, rad and m.\n"
             "Exit status: 0 the same, 1 failed, 2 wrong usage, 3 drifted.",
    .example = "  $ halflight drift reference.json today.json --picture drift.png\n"
               "  verdict       DRIFTED: where nothing moved, as large a difference has\n"
               "                probability 2e-224 (alarm below 0.01)\n"
               "  moved         focal length by 3.5 px (+0.5 %): fx +3.50 +- 0.14 px, ...\n"
               "  ...\n"
               "  $ halflight drift reference.json --board fixed.vnl \\\n"
               "      --target chessboard:9x7:0.03 --save-board-pose board.json\n"
               "  board         first corner at -0.120000 -0.090000 0.500000 m (x right, y down,\n"
               "                z forward)\n"
               "  ...\n"
               "  $ halflight drift reference.json --board fixed.vnl --board-pose board.json\n"
               "  verdict       same: where nothing moved, as large a difference has probability\n"
               "                1 (alarm below 0.01)\n"
               "  ...",
    .size = sizeof(drift_args),
    .defaults = defaults,
    .run = run,
};
