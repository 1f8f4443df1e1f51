/* One chart a result. */
#include "evidence_charts.h"

#include <string.h>

#include "draw_calibration.h"
#include "drift_rig.h"
#include "evidence.h"

/* What a drawing takes, behind one pointer. */
typedef struct subject {
  const void *result, *beside;
  const char *verdict;
} subject;

static hl_status write_one(hl_ctx *ctx, const char *path, const char *of,
                           const hl_evidence_picture *picture)
{
  hl_evidence evidence = {0};
  hl_status st = hl_evidence_begin(ctx, &evidence, of, path);
  if (st == HL_OK)
    st = hl_evidence_add(ctx, &evidence, picture);
  if (st == HL_OK)
    st = hl_evidence_write(ctx, &evidence, path);
  hl_evidence_free(&evidence);
  return st;
}

static hl_status draw_bench(hl_ctx *ctx, hl_picture_kind kind, const char *path, const void *data)
{
  return hl_draw_bench(ctx, kind, path, data);
}

hl_status hl_evidence_of_bench(hl_ctx *ctx, const char *path, const hl_bench_table *table)
{
  const hl_evidence_picture picture = {
      "bench",
      "Error against time",
      "Median error of the light against the median time of the estimate, both logarithmic. Blue "
      "discs: halflight; vermillion squares: other rules; grey line: no method is both faster and "
      "better.",
      true,
      HL_PICTURE_SVG,
      draw_bench,
      table};
  return write_one(ctx, path, "bench.json", &picture);
}

static hl_status draw_calibration(hl_ctx *ctx, hl_picture_kind kind, const char *path,
                                  const void *data)
{
  const subject *s = data;
  return hl_draw_calibration(ctx, kind, path, s->result, s->beside);
}

hl_status hl_evidence_of_calibration(hl_ctx *ctx, const char *path,
                                     const hl_calibration *calibration, const hl_corners *corners)
{
  const subject s = {calibration, corners, NULL};
  const hl_evidence_picture picture = {
      "calibration",
      "Corners, certainty, views",
      "Left: where the corners were, and what is left of each, enlarged. Right: the projection's "
      "deviation over the frame, in bands. Below: every view's rms. Vermillion: left out.",
      true,
      HL_PICTURE_PNG,
      draw_calibration,
      &s};
  return write_one(ctx, path, "camera.json", &picture);
}

static hl_status draw_drift(hl_ctx *ctx, hl_picture_kind kind, const char *path, const void *data)
{
  const subject *s = data;
  return hl_draw_drift(ctx, kind, path, s->result, s->verdict);
}

hl_status hl_evidence_of_drift(hl_ctx *ctx, const char *path, const hl_drift *drift,
                               const char *verdict)
{
  const subject s = {drift, NULL, verdict};
  const hl_evidence_picture picture = {"drift",
                                       "Difference of the projections",
                                       "How far a point's image lies from where the reference "
                                       "camera puts it, over the frame or at the "
                                       "board's corners.",
                                       true,
                                       HL_PICTURE_SVG,
                                       draw_drift,
                                       &s};
  return write_one(ctx, path, "drift.json", &picture);
}

static hl_status draw_fit(hl_ctx *ctx, hl_picture_kind kind, const char *path, const void *data)
{
  const subject *s = data;
  return hl_draw_fit(ctx, kind, path, s->result, s->beside);
}

/* A PNG: the cloud of data would make an SVG of megabytes. */
hl_status hl_evidence_of_fit(hl_ctx *ctx, const char *path, const hl_fit *fit,
                             const hl_samples *samples)
{
  const subject s = {fit, samples, NULL};
  const hl_evidence_picture picture = {"fit",
                                       "Curves among their data",
                                       "A panel a term: the curve against the cosine from its "
                                       "direction, among what each sample leaves "
                                       "for it once the other terms are taken off.",
                                       true,
                                       HL_PICTURE_PNG,
                                       draw_fit,
                                       &s};
  return write_one(ctx, path, "fit.json", &picture);
}

static hl_status draw_rig(hl_ctx *ctx, hl_picture_kind kind, const char *path, const void *data)
{
  const subject *s = data;
  return hl_draw_rig_drift(ctx, kind, path, s->result, s->beside, s->verdict);
}

hl_status hl_evidence_of_rig_drift(hl_ctx *ctx, const char *path, const hl_rig_drift *drift,
                                   const hl_lights *reference, const char *verdict)
{
  const subject s = {drift, reference, verdict};
  const hl_evidence_picture picture = {"drift",
                                       "What moved in the rig",
                                       "The lights as the camera sees their dome from the ball. "
                                       "Arrows: lights that moved; rings: lights "
                                       "whose brightness changed.",
                                       true,
                                       HL_PICTURE_SVG,
                                       draw_rig,
                                       &s};
  return write_one(ctx, path, "drift.json", &picture);
}
