/* Which parts of a camera moved: the same question whatever the evidence. */
#ifndef HL_DRIFT_PARTS_H
#define HL_DRIFT_PARTS_H

#include "halflight/drift.h"
#include "triangle.h"

enum { HL_CHANGES_MAX = HL_INTRINSICS_MAX + HL_POSE_SIZE };

/* x delta = z + noise of unit deviation, delta the changes of intrinsics and mount. */
typedef struct hl_evidence {
  int n; /* changes, and rows */
  double x[HL_CHANGES_MAX][HL_CHANGES_MAX];
  double z[HL_CHANGES_MAX];
  double noise_dof; /* residuals the noise itself is known from; HUGE_VAL: exactly */
} hl_evidence;

/* One part of the changes. */
typedef struct hl_part {
  const char *what, *part, *unit;                      /* as in hl_drift_cause */
  int first, n;                                        /* its changes */
  double metric[HL_DISTORTION_MAX][HL_DISTORTION_MAX]; /* figure^2 = delta' metric delta */
} hl_part;

/* The parts in the order of the changes; how many: 5 with the mount, 3 without. drift.c. */
int hl_drift_parts(const hl_camera *camera, bool with_mount, hl_part part[HL_DRIFT_CAUSES_MAX]);

/* The evidence of a triangle's last unknowns, from `first` on, in units of `scale`. */
void hl_evidence_of(const hl_triangle *triangle, int first, const double *scale, double noise_dof,
                    hl_evidence *out);

/* The verdict, its significance and the causes, at out->false_alarm. */
void hl_parts_judge(const hl_evidence *evidence, const hl_part *part, int n_parts, hl_drift *out);

#endif
