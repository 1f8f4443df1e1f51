/* What the parts of a comparison of two sessions share. Private. */
#ifndef HL_RIG_WORK_H
#define HL_RIG_WORK_H

#include "halflight/rig_drift.h"
#include "rig_turn.h"

typedef struct hl_rig_run {
  const hl_lights *reference, *current;
  int n;
  hl_rig_pair *pair;
  hl_rig_turn turn;
  bool one_camera, intrinsics;
  double rate; /* of one test */
  hl_rig_drift *out;
} hl_rig_run;

/* A cause to be judged; the run has room for all. */
hl_rig_cause *hl_rig_add(hl_rig_run *r, hl_rig_part part, const char *name, int reference,
                         int current);

/* Its figure and threshold, and whether it moved, from a statistic that is chi-squared of `dof`. */
void hl_rig_judge(const hl_rig_run *r, hl_rig_cause *c, double figure, double statistic,
                  double dof);

/* d' A^-1 d of n numbers. A change that A does not explain at all counts as without bound. */
double hl_rig_square(const double *a, const double *d, int n);

/* rig_sphere.c; `turned`: the mount is named. */
void hl_rig_compare_spheres(hl_rig_run *r, bool turned);

/* rig_intensity.c */
bool hl_rig_has_intensity(const hl_rig_light *a, const hl_rig_light *b);
hl_status hl_rig_compare_intensities(hl_ctx *ctx, hl_rig_run *r);

#endif
