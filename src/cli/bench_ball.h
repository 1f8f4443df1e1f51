/* Lit balls drawn in memory, with everything about them known. */
#ifndef HL_CLI_BENCH_BALL_H
#define HL_CLI_BENCH_BALL_H

#include "halflight/halflight.h"

typedef enum hl_bench_lobe {
  HL_BENCH_MATTE,
  HL_BENCH_GGX,      /* a^4 / (cos^2 (a^2 - 1) + 1)^2 over n.v, a = lobe_deg in radians */
  HL_BENCH_LINEAR,   /* n.h */
  HL_BENCH_QUADRATIC /* (n.h)^2 */
} hl_bench_lobe;

typedef enum hl_bench_flaw {
  HL_BENCH_CLEAN,
  HL_BENCH_LABEL,  /* a darker patch of the body */
  HL_BENCH_DUST,   /* single pixels of another albedo */
  HL_BENCH_SECOND, /* another light, a third as strong */
  HL_BENCH_DEAD    /* one channel reads nothing */
} hl_bench_flaw;

/* NOLINTNEXTLINE(clang-analyzer-optin.performance.Padding): in the order it is read */
typedef struct hl_bench_ball {
  const char *group;
  double value; /* what the group varies */
  bool determinable;
  hl_bench_lobe lobe;
  hl_bench_flaw flaw;
  double lobe_deg, radius_px, light_deg;
  double gloss;   /* lobe's height over the body's 0.4 */
  double scale;   /* multiplies all radiance */
  double noise;   /* deviation as a share of the body's height */
  double clipped; /* share of the lobe's height that saturation cuts off */
  int bits;       /* 0 = float */
  bool cut;       /* with bits: what is below black is recorded as black */
  double focal_px;
  bool corner;  /* in the frame's corner under strong distortion */
  double share; /* of the pixels that the flaw takes */
} hl_bench_ball;

/* Draw it; the caller frees frame and surface. `light` is the truth. HL_ERR_MEMORY, or what
 * hl_surface_of_sphere says. */
hl_status hl_bench_ball_draw(hl_ctx *ctx, const hl_bench_ball *ball, uint64_t seed, hl_frame *frame,
                             hl_surface *surface, double light[3]);

#endif
