/* What the parts of a replay share. Private. */
#ifndef HL_REPLAY_WORK_H
#define HL_REPLAY_WORK_H

#include <pthread.h>

#include "halflight/replay.h"
#include "halflight/surface.h"
#include "light_pose.h"

enum { HL_REPLAY_KNOTS = 7, HL_REPLAY_PAIRS = 28, HL_REPLAY_KEY = 65 };

/* One ball in one frame. */
typedef struct hl_replay_seen {
  bool outlined; /* its own outline was read */
  bool moved;    /* it disagrees with the common pose, and the frame's own was used */
  bool scored;   /* `pose` holds what the shading says */
  double moved_px;
  hl_light_pose pose;
  double profile[3][HL_REPLAY_KNOTS]; /* reflected radiance at fixed angles; 0 = not shown */
  /* upper triangles, row by row: covariance of what this frame's pixels leave open of it */
  double open[3][HL_REPLAY_PAIRS];
} hl_replay_seen;

typedef struct hl_replay_frame {
  hl_rig_light light;   /* of the best ball; without texts */
  hl_replay_seen *seen; /* shape (n_balls), within the run's `seen` */
} hl_replay_frame;

/* A ball's pose from the outlines of several frames. */
typedef struct hl_replay_ball {
  hl_sphere pose;
  bool given;     /* by a file of the session */
  int n_outlines; /* that agree */
  double blur_px; /* median of the outlines; 0: not known */
  double excess;  /* their scatter over what they state, variance, at least 1 */
  hl_surface surface;
  hl_light_settings light; /* with the reflectance that its frames have */
  bool narrowed;           /* `light` tries less than the settings do */
} hl_replay_ball;

typedef struct hl_replay_run {
  const hl_session *session;
  hl_replay_settings settings;
  const hl_replay_watch *watch;
  const char *folder; /* NULL: nothing is kept */
  hl_camera camera;
  int n_balls;
  hl_replay_ball ball[HL_BALLS_MAX];
  hl_replay_frame *frame; /* shape (session->n) */
  hl_replay_seen *seen;   /* shape (session->n, n_balls) */
  char *conditions;       /* text of all that a frame's result depends on but the frame */
  int jobs;
  pthread_mutex_t guard; /* of what follows, and of the watch */
  int done, reused, failed;
  bool stopped;
  hl_ctx fault; /* of a job that had to give up: disk full, no memory */
} hl_replay_run;

/* replay_pose.c: from the outlines; HL_ERR_DEGENERATE where no frame shows a ball, as hl_replay. */
hl_status hl_replay_pose(hl_ctx *ctx, hl_replay_run *run);
/* How far, in pixels, and in deviations squared, a frame's own pose is from the common one. */
double hl_replay_moved_px(const hl_replay_run *run, const hl_sphere *common, const hl_sphere *own);
double hl_replay_distance2(const double difference[3], const double covariance[3][3]);
/* Of a symmetric positive definite matrix; false: it is none. */
bool hl_replay_invert(const double a[3][3], double out[3][3]);
/* Read a frame of the camera's size. */
hl_status hl_replay_read(hl_ctx *ctx, const hl_replay_run *run, int i, hl_frame *out);
hl_sphere_settings hl_replay_near(const hl_session_ball *ball);

/* replay_frame.c: one frame from its file to its result. */
typedef struct hl_replay_job hl_replay_job;
hl_replay_job *hl_replay_job_new(void);
void hl_replay_job_free(hl_replay_job *job);
/* HL_OK, also for a frame without a light; HL_ERR_IO where the result cannot be kept; HL_ERR_MEMORY.
 * `reused` says whether an earlier result was found. */
hl_status hl_replay_one(hl_ctx *ctx, hl_replay_job *job, hl_replay_run *run, int i, bool *reused);

/* replay_kind.c: which terms the frames need, from a few of them; fills each ball's `light`. */
hl_status hl_replay_kind(hl_ctx *ctx, hl_replay_run *run);
/* Says why it was not tried where a note says that it was not asked for. */
void hl_replay_explain(const hl_replay_run *run, hl_light *light);

/* replay_record.c: a frame's result on the disk. */
hl_status hl_replay_conditions(hl_ctx *ctx, hl_replay_run *run);
hl_status hl_replay_folder(hl_ctx *ctx, const hl_replay_run *run);
/* The frame file's and the conditions' hash. HL_ERR_IO. */
hl_status hl_replay_key(hl_ctx *ctx, const hl_replay_run *run, int i, char key[HL_REPLAY_KEY]);
bool hl_replay_recall(const hl_replay_run *run, int i, const char *key, hl_replay_frame *out);
hl_status hl_replay_keep(hl_ctx *ctx, const hl_replay_run *run, int i, const char *key,
                         const hl_light *light, const hl_replay_frame *frame);

/* replay_joint.c: the pose from the shading too; moves `out`'s balls and lights. */
void hl_replay_joint(const hl_replay_run *run, hl_lights *out);
/* covariance_rad2 and its ellipse from the parts. */
void hl_replay_add_parts(const hl_lights *lights, hl_rig_light *light);

/* replay_intensity.c */
void hl_replay_profile(const hl_light *light, double profile[3][HL_REPLAY_KNOTS]);
/* After hl_light_pose_score. */
void hl_replay_open(const hl_light *light, const hl_light_work *work,
                    const hl_light_pose_work *pose, double open[3][HL_REPLAY_PAIRS]);
hl_status hl_replay_intensity(hl_ctx *ctx, const hl_replay_run *run, hl_lights *out);

#endif
