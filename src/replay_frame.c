/* One frame of a replay: read, compared with the common pose, estimated, kept. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "halflight/notes.h"
#include "halflight/vec3.h"
#include "replay_work.h"

static const double min_cos_view = 0.1; /* as the estimate command has it */
/* An outline agrees with the common pose up to this many deviations squared of three coordinates, more
 * for more frames, as noise alone passes it once in a thousand sessions; and nothing below this many
 * pixels is called a move. */
static const double chi2_3_999 = 16.27, least_moved_px = 0.1;

struct hl_replay_job {
  hl_light_work *light;
  hl_light_pose_work *pose;
  int max_pixels, channels;
  hl_light best, other;
};

hl_replay_job *hl_replay_job_new(void)
{
  return calloc(1, sizeof(hl_replay_job));
}

void hl_replay_job_free(hl_replay_job *job)
{
  if (!job)
    return;
  hl_light_work_free(job->light);
  hl_light_pose_free(job->pose);
  free(job);
}

/* Workspaces grow to the largest ball and stay. */
static hl_status make_room(hl_ctx *ctx, hl_replay_job *job, int pixels, int channels)
{
  if (job->light && job->max_pixels >= pixels && job->channels == channels)
    return HL_OK;
  hl_light_work_free(job->light);
  hl_light_pose_free(job->pose);
  job->light = NULL;
  job->pose = NULL;
  job->max_pixels = pixels;
  job->channels = channels;
  const hl_status st = hl_light_work_new(ctx, pixels, channels, &job->light);
  return st == HL_OK ? hl_light_pose_new(ctx, pixels, channels, &job->pose) : st;
}

/* The frame's own outline; one that moved further than the outline about the common pose is read is
 * looked for near it. */
static bool own_pose(const hl_replay_run *run, const hl_frame *frame, const hl_replay_ball *ball,
                     hl_sphere *out)
{
  hl_sphere_settings s = hl_sphere_defaults();
  double center[2];
  s.blur_px = ball->blur_px;
  if (hl_sphere_relocate(NULL, frame, &run->camera, &ball->pose, &s, out, NULL) == HL_OK)
    return true;
  if (hl_camera_project(NULL, &run->camera, ball->pose.center_m, center) != HL_OK)
    return false;
  s.hint_x_px = center[0];
  s.hint_y_px = center[1];
  s.hint_radius_px =
      sqrt(run->camera.fx * run->camera.fy) * ball->pose.radius_m / hl_norm(ball->pose.center_m);
  return hl_sphere_locate(NULL, frame, &run->camera, ball->pose.radius_m, &s, out, NULL) == HL_OK;
}

static bool has_moved(const hl_replay_run *run, const hl_replay_ball *ball, const hl_sphere *own,
                      hl_replay_seen *seen)
{
  double difference[3], covariance[3][3];
  const hl_sphere *common = &ball->pose;
  if (!common->has_covariance)
    return false;
  hl_add_scaled(own->center_m, -1, common->center_m, difference);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      const double stated =
          own->n_intrinsics > 0 ? own->held_covariance_m2[i][j] : own->covariance_m2[i][j];
      const double shared =
          common->n_intrinsics > 0 ? common->held_covariance_m2[i][j] : common->covariance_m2[i][j];
      covariance[i][j] = ball->excess * stated + shared;
    }
  seen->moved_px = hl_replay_moved_px(run, common, own);
  return hl_replay_distance2(difference, (const double(*)[3])covariance) >
             chi2_3_999 + 2 * log((double)run->session->n) &&
         seen->moved_px > least_moved_px;
}

static bool rig_light(const hl_light *l, const hl_surface *surface, hl_rig_light *out)
{
  const hl_sphere *ball = &surface->ball;
  const int n = hl_camera_intrinsics_count(&surface->camera);
  const bool follows = ball->n_intrinsics == n && surface->camera.has_covariance;
  out->found = l->found;
  out->trusted = l->found && l->trusted;
  memcpy(out->direction, l->direction, sizeof out->direction);
  memcpy(out->tangent_basis, l->tangent_basis, sizeof out->tangent_basis);
  memcpy(out->covariance_rad2, l->covariance_rad2, sizeof out->covariance_rad2);
  memcpy(out->ellipse_95_rad, l->ellipse_95_rad, sizeof out->ellipse_95_rad);
  memcpy(out->by_center, l->by_center, sizeof out->by_center);
  memcpy(out->by_intrinsics, l->by_intrinsics, sizeof out->by_intrinsics);
  memcpy(out->color, l->color, sizeof out->color);
  out->near = l->near;
  memcpy(out->position_m, l->position_m, sizeof out->position_m);
  memcpy(out->position_covariance_m2, l->position_covariance_m2,
         sizeof out->position_covariance_m2);
  for (int u = 0; u < 2; u++) {
    for (int v = 0; v < 2; v++)
      out->own_rad2[u][v] = l->part_rad2[HL_PART_NOISE][u][v] + l->part_rad2[HL_PART_MODEL][u][v];
    for (int j = 0; follows && j < n; j++)
      for (int k = 0; k < 3; k++)
        out->by_intrinsics[u][j] += l->by_center[u][k] * ball->by_intrinsics[k][j];
  }
  return hl_note_list_set(&out->reasons, &l->reasons);
}

static double spread(const hl_light *l)
{
  return l->covariance_rad2[0][0] + l->covariance_rad2[1][1];
}

/* A trusted answer before one that is not, then the surer. */
static bool better(const hl_light *a, const hl_light *b)
{
  if (a->found != b->found)
    return a->found;
  if (a->trusted != b->trusted)
    return a->trusted;
  return a->found && spread(a) < spread(b);
}

static hl_status estimate(hl_ctx *ctx, hl_replay_job *job, const hl_replay_run *run,
                          const hl_frame *frame, int b, bool common, const hl_surface *surface,
                          hl_replay_frame *out)
{
  hl_replay_seen *seen = &out->seen[b];
  hl_ctx inner = {0};
  hl_status st = make_room(ctx, job, surface->n, frame->channels);
  if (st != HL_OK)
    return st;
  memset(&job->other, 0, sizeof job->other);
  st = hl_light_estimate(&inner, job->light, frame, surface, &run->ball[b].light, &job->other);
  if (run->ball[b].narrowed && (st == HL_ERR_DEGENERATE || !job->other.trusted)) {
    memset(&job->other, 0, sizeof job->other);
    st = hl_light_estimate(&inner, job->light, frame, surface, &run->settings.light, &job->other);
  } else {
    hl_replay_explain(run, &job->other);
  }
  if (st == HL_ERR_ARG || st == HL_ERR_MEMORY)
    return hl_fail(ctx, st, "%s", inner.msg);
  if (st != HL_OK)
    job->other.found = job->other.trusted = false;
  if (!job->other.found && job->other.reasons.n == 0)
    hl_notes_add(&job->other.reasons, "light", "%s", inner.msg);
  if (seen->moved) {
    job->other.trusted = false;
    hl_notes_add(&job->other.reasons, "moved",
                 "the ball or the camera is %.2f px from where the other frames have it; this "
                 "frame's own pose was used",
                 seen->moved_px);
  }
  if (job->other.found) {
    hl_replay_profile(&job->other, seen->profile);
    const bool scored = hl_light_pose_score(job->light, surface, job->pose, &seen->pose);
    if (scored)
      hl_replay_open(&job->other, job->light, job->pose, seen->open);
    seen->scored = scored && common && !seen->moved && !run->settings.no_joint;
  }
  if (b > 0 && !better(&job->other, &job->best))
    return HL_OK;
  job->best = job->other;
  if (!rig_light(&job->best, surface, &out->light))
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for the reasons of a light");
  out->light.ball = b;
  return HL_OK;
}

/* At the common pose, or at the frame's own where that is asked for or the ball moved. */
static hl_status ball_in_frame(hl_ctx *ctx, hl_replay_job *job, const hl_replay_run *run,
                               const hl_frame *frame, int b, hl_replay_frame *out)
{
  const hl_replay_ball *ball = &run->ball[b];
  hl_replay_seen *seen = &out->seen[b];
  hl_sphere own;
  seen->outlined = own_pose(run, frame, ball, &own);
  seen->moved = seen->outlined && !run->settings.frame_by_frame && has_moved(run, ball, &own, seen);
  const bool common = !(seen->moved || (run->settings.frame_by_frame && seen->outlined));
  if (common)
    return estimate(ctx, job, run, frame, b, true, &ball->surface, out);
  hl_surface surface;
  hl_status st = hl_surface_of_sphere(NULL, &run->camera, &own, min_cos_view, &surface);
  if (st != HL_OK)
    return estimate(ctx, job, run, frame, b, true, &ball->surface, out);
  st = estimate(ctx, job, run, frame, b, false, &surface, out);
  hl_surface_free(&surface);
  return st;
}

static hl_status unread(hl_ctx *ctx, hl_replay_frame *out, const char *why)
{
  return hl_note_list_add(&out->light.reasons, "frame", "%s", why)
             ? HL_OK
             : hl_fail(ctx, HL_ERR_MEMORY, "no memory for the reasons of a frame");
}

static hl_status fresh(hl_ctx *ctx, hl_replay_job *job, const hl_replay_run *run, int i,
                       const char *key)
{
  hl_replay_frame *out = &run->frame[i];
  hl_frame frame;
  hl_ctx inner = {0};
  hl_status st = hl_replay_read(&inner, run, i, &frame);
  if (st != HL_OK) {
    return st == HL_ERR_MEMORY ? hl_fail(ctx, st, "%s", inner.msg) : unread(ctx, out, inner.msg);
  }
  memset(&job->best, 0, sizeof job->best);
  for (int b = 0; b < run->n_balls && st == HL_OK; b++)
    st = ball_in_frame(ctx, job, run, &frame, b, out);
  hl_frame_free(&frame);
  return st == HL_OK && run->folder ? hl_replay_keep(ctx, run, i, key, &job->best, out) : st;
}

hl_status hl_replay_one(hl_ctx *ctx, hl_replay_job *job, hl_replay_run *run, int i, bool *reused)
{
  char key[HL_REPLAY_KEY];
  hl_ctx inner = {0};
  *reused = false;
  const hl_status st = hl_replay_key(&inner, run, i, key);
  if (st == HL_ERR_MEMORY)
    return hl_fail(ctx, st, "%s", inner.msg);
  if (st != HL_OK)
    return unread(ctx, &run->frame[i], inner.msg);
  if (run->folder && hl_replay_recall(run, i, key, &run->frame[i])) {
    *reused = true;
    return HL_OK;
  }
  return fresh(ctx, job, run, i, key);
}
