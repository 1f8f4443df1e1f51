/* Two calibrations of one camera compared; the mathematics are in the drift_*.c beside this file. */
#include "halflight/drift.h"

#include <math.h>
#include <string.h>

#include "drift_parts.h"
#include "drift_projection.h"
#include "drift_sessions.h"
#include "halflight/notes.h"

static const double degrees = 180 / 3.14159265358979323846;

hl_drift_settings hl_drift_defaults(void)
{
  return (hl_drift_settings){.false_alarm = 0.01, .distance_m = 0};
}

static const hl_field fields[] = {
    {"false_alarm", HL_FIELD_DOUBLE, offsetof(hl_drift_settings, false_alarm), 1e-12, 0.5, "",
     "how often a camera that has not changed may be called drifted", NULL},
    {"distance_m", HL_FIELD_DOUBLE, offsetof(hl_drift_settings, distance_m), 0, 1e6, "m",
     "distance of the points whose projections are compared, 0 for directions", NULL},
};

const hl_field_table *hl_drift_fields(void)
{
  static const hl_field_table table = {"drift", fields, (int)(sizeof fields / sizeof fields[0])};
  return &table;
}

static void diagonal(hl_part *part, double value)
{
  for (int i = 0; i < part->n; i++)
    part->metric[i][i] = value;
}

int hl_drift_parts(const hl_camera *camera, bool with_mount, hl_part part[HL_DRIFT_CAUSES_MAX])
{
  const int n = camera->n_distortion;
  const hl_part parts[HL_DRIFT_CAUSES_MAX] = {
      {.what = "intrinsics", .part = "focal length", .unit = "px", .first = 0, .n = 2},
      {.what = "intrinsics", .part = "centre", .unit = "px", .first = 2, .n = 2},
      {.what = "intrinsics", .part = "distortion", .unit = "px", .first = 4, .n = n},
      {.what = "mount", .part = "rotation", .unit = "deg", .first = 4 + n, .n = 3},
      {.what = "mount", .part = "translation", .unit = "m", .first = 7 + n, .n = 3},
  };
  memcpy(part, parts, sizeof parts);
  diagonal(&part[0], 0.5);
  diagonal(&part[1], 1);
  hl_drift_effect(camera, 4, n, part[2].metric);
  diagonal(&part[3], degrees * degrees);
  diagonal(&part[4], 1);
  return with_mount ? 5 : 3;
}

static hl_status check(hl_ctx *ctx, const hl_calibration *reference, const hl_calibration *current,
                       const hl_drift_settings *settings)
{
  const hl_camera *a = &reference->camera, *b = &current->camera;
  hl_status st = hl_fields_check(ctx, hl_drift_fields(), settings);
  if (st == HL_OK && (a->width != b->width || a->height != b->height))
    st =
        hl_fail(ctx, HL_ERR_FORMAT,
                "the reference's frame is %d x %d px, the current one %d x %d; calibrations at one "
                "frame size are needed",
                a->width, a->height, b->width, b->height);
  return st;
}

static hl_status compare_alike(hl_ctx *ctx, const hl_drift_side *reference,
                               const hl_drift_side *current, hl_drift *out)
{
  hl_evidence evidence;
  hl_part part[HL_DRIFT_CAUSES_MAX];
  bool with_mount = false;
  const hl_status st = hl_drift_sessions(ctx, reference, current, out->false_alarm, &evidence,
                                         &with_mount, &out->notes);
  if (st != HL_OK)
    return st;
  const int n = hl_drift_parts(&reference->calibration->camera, with_mount, part);
  hl_parts_judge(&evidence, part, n, out);
  return HL_OK;
}

static hl_status compare_unlike(hl_ctx *ctx, const hl_drift_side *reference,
                                const hl_drift_side *current, hl_drift *out)
{
  hl_notes_add(&out->notes, "parts",
               "cannot be told apart between different lens models; the projections are compared, "
               "and a lens that one of the models does not fit looks like drift");
  hl_notes_add(&out->notes, "mount",
               "not compared: different lens models place the camera itself differently");
  return hl_drift_unlike(ctx, reference, current, out);
}

hl_status hl_drift_cameras(hl_ctx *ctx, const hl_calibration *reference,
                           const hl_calibration *current, const hl_drift_settings *settings,
                           hl_drift *out)
{
  const hl_drift_settings s = settings ? *settings : hl_drift_defaults();
  hl_drift d = {.false_alarm = s.false_alarm,
                .width = reference->camera.width,
                .height = reference->camera.height};
  hl_drift_side before, after;
  hl_status st = check(ctx, reference, current, &s);
  if (st == HL_OK)
    st = hl_drift_side_of(ctx, "reference", reference, &before, &d.notes);
  if (st == HL_OK)
    st = hl_drift_side_of(ctx, "current", current, &after, &d.notes);
  if (st == HL_OK)
    st = reference->camera.model == current->camera.model
             ? compare_alike(ctx, &before, &after, &d)
             : compare_unlike(ctx, &before, &after, &d);
  if (st == HL_OK)
    st = hl_drift_projections(ctx, &before, &after, s.distance_m, &d);
  if (st == HL_OK)
    *out = d;
  return st;
}
