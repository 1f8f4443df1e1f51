/* Corners of a board seen in one view, and the pose that explains them. */
#ifndef HL_SIGHTINGS_H
#define HL_SIGHTINGS_H

#include "arrow.h"
#include "halflight/camera.h"
#include "halflight/corners.h"
#include "halflight/pose.h"

/* One corner, where the target has it and where it was seen. */
typedef struct hl_sighting {
  double board_m[3];
  double pixel[2];
  double weight; /* 1 / relative standard deviation */
  bool used;
  int index; /* in the target */
} hl_sighting;

/* The corners seen in a view of a target; `out` has room for view->seen. Returns how many. */
int hl_sightings_of(const hl_target *target, const hl_view *view, hl_sighting *out);

int hl_sightings_used(const hl_sighting *sighting, int n);

/* Seen minus predicted [px], times the weight; false where the corner is not in front. */
bool hl_sighting_residual(const hl_camera *camera, const hl_pose *pose, const hl_sighting *s,
                          double out[2]);

/* Sum of squared residuals of those used; HUGE_VAL where one is not in front of the camera. */
double hl_sightings_cost(const hl_camera *camera, const hl_pose *pose, const hl_sighting *sighting,
                         int n);

/* Add their rows; arrow NULL: the intrinsics are held. False where one is not in front. */
bool hl_sightings_rows(const hl_camera *camera, const hl_pose *pose, const hl_sighting *sighting,
                       int n, hl_arrow *arrow, hl_arrow_view *out);

/* Least squares for the pose alone, from where it stands; returns its cost, HUGE_VAL where the pose
 * cannot be fitted (it stays). */
double hl_sightings_refine(const hl_camera *camera, const hl_sighting *sighting, int n,
                           hl_pose *pose);

/*
 * The pose from nothing: of the two that explain a plane seen from afar, refined, the better one.
 * HL_ERR_DEGENERATE (fewer than 4 corners, or corners in a row); HL_ERR_UNAVAILABLE; HL_ERR_MEMORY.
 */
hl_status hl_sightings_pose(hl_ctx *ctx, const hl_camera *camera, const hl_sighting *sighting,
                            int n, hl_pose *out, double *cost);

#endif
