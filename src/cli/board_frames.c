/* Frames are read and searched side by side, each into a set of its own; the sets are joined in
 * the frames' order, so that the result does not depend on who was first. */
#include "board_frames.h"

#include <stdlib.h>
#include <string.h>

#include "halflight/corners.h"
#include "inputs.h"
#include "progress.h"

#ifdef _OPENMP
#include <omp.h>
#endif

/* One frame's share. */
typedef struct found {
  hl_ctx ctx;
  hl_status status;
  hl_corners corners;
} found;

static void look(const char *path, const hl_frame_settings *settings, found *out)
{
  hl_frame frame;
  out->status = hl_frame_read(&out->ctx, path, settings, &frame);
  if (out->status != HL_OK)
    return;
  out->status = hl_corners_detect(&out->ctx, &out->corners, &frame, path, NULL);
  hl_frame_free(&frame);
  if (out->status != HL_OK)
    hl_inputs_blame(&out->ctx, out->status, path);
}

static void look_everywhere(const hl_words *frames, const hl_frame_settings *settings, int threads,
                            found *share)
{
  int done = 0;
#ifdef _OPENMP
  const int workers = threads > 0 ? threads : omp_get_max_threads();
#pragma omp parallel for schedule(dynamic, 1) num_threads(workers) if (workers > 1)
#else
  (void)threads;
#endif
  for (int i = 0; i < frames->n; i++) {
    look(frames->word[i], settings, &share[i]);
#ifdef _OPENMP
#pragma omp critical
#endif
    hl_progress(++done, frames->n, "frames");
  }
}

/* The only view of a frame's own set goes to the end of the whole. */
static hl_status append(hl_ctx *ctx, const hl_corners *one, const char *first, hl_corners *out)
{
  const hl_view *view = &one->view[0];
  hl_view *added;
  if (out->n_views > 0 && (one->width != out->width || one->height != out->height))
    return hl_fail(ctx, HL_ERR_FORMAT,
                   "%.100s has %d x %d px, %.100s %d x %d: frames of one camera have one size",
                   view->name, one->width, one->height, first, out->width, out->height);
  const hl_status st = hl_corners_add(ctx, out, view->name, &added);
  if (st != HL_OK)
    return st;
  hl_corner *corner = added->corner;
  memcpy(corner, view->corner, (size_t)hl_target_corners(&out->target) * sizeof *corner);
  *added = *view;
  added->corner = corner;
  out->width = one->width;
  out->height = one->height;
  return HL_OK;
}

hl_status hl_board_frames(hl_ctx *ctx, const hl_words *frames, const hl_frame_settings *settings,
                          int threads, hl_corners *out)
{
  found *share = calloc(frames->n > 0 ? (size_t)frames->n : 1, sizeof *share);
  hl_status st = HL_OK;
  if (!share)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for %d frames", frames->n);
  for (int i = 0; i < frames->n; i++)
    share[i].corners = hl_corners_of(&out->target);
  look_everywhere(frames, settings, threads, share);
  for (int i = 0; i < frames->n && st == HL_OK; i++) {
    if (share[i].status != HL_OK)
      st = hl_fail(ctx, share[i].status, "%s", share[i].ctx.msg);
    else
      st = append(ctx, &share[i].corners, frames->word[0], out);
  }
  for (int i = 0; i < frames->n; i++)
    hl_corners_free(&share[i].corners);
  free(share);
  return st;
}
