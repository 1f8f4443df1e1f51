/* What one estimate works on: the pixels at three sizes, scratch, and the fitted frame. Private. */
#ifndef HL_LIGHT_WORK_H
#define HL_LIGHT_WORK_H

#include "light_refine.h"

enum { HL_COARSE_MAX = 2048, HL_TILES_MAX = 4096, HL_CANDIDATES = 3 };

typedef struct hl_ranked {
  double key;
  int index;
} hl_ranked;

/* Numbers of the gathered pixels that decide whether there is anything to estimate. */
typedef struct hl_light_brightness {
  double level;        /* median of the lit pixels, the unit of everything after */
  double p2, p50, p98; /* of the mean over the channels, in units of level */
  int lit;             /* pixels above 2 % of the 90th percentile */
  int clipped;         /* pixels with a clipped channel */
} hl_light_brightness;

struct hl_light_work {
  int max_pixels, channels;
  void *pool;
  hl_light_data all;    /* every pixel, every channel */
  hl_light_data grey;   /* every pixel, mean of the channels; geometry shared with `all` */
  hl_light_data coarse; /* the brightest and a regular few of `grey` */
  hl_light_brightness brightness;
  hl_model_work model;
  hl_ranked *ranked;                    /* shape (max_pixels) */
  hl_model_pixel *fit;                  /* shape (max_pixels): one channel at a time */
  double (*score)[HL_NONLINEAR_MAX];    /* shape (max_pixels): sum over channels of w r d */
  double (*noise)[HL_NONLINEAR_MAX];    /* likewise, of the residual's noise */
  int *index;                           /* shape (max_pixels): place in the surface */
  uint8_t *outlier;                     /* shape (max_pixels): 1 = left out */
  double *area[HL_CHANNELS_MAX];        /* shape (max_pixels): taken off `all`'s values */
  float *predicted, *measured, *weight; /* shape (max_pixels) */
  hl_refined refined, best;
};

/* Whether gathered pixels i - 1, i, i + 1 are neighbours in a row of the frame, none of them clipped. */
static inline bool hl_light_in_a_row(const struct hl_light_work *work, const hl_surface *surface,
                                     int i)
{
  const int at = surface->pixel[work->index[i]];
  return surface->pixel[work->index[i - 1]] == at - 1 &&
         surface->pixel[work->index[i + 1]] == at + 1 && !work->all.clipped[i - 1] &&
         !work->all.clipped[i] && !work->all.clipped[i + 1];
}

/* How uncertain a sample is taken to be: variance = (relative y)^2 + absolute^2, in units of level.
 */
typedef struct hl_light_noise {
  double relative, absolute;
} hl_light_noise;

/* light_gather.c: frame and surface into work; HL_ERR_ARG where they do not fit each other. */
hl_status hl_light_gather(hl_ctx *ctx, struct hl_light_work *work, const hl_frame *frame,
                          const hl_surface *surface);
void hl_light_weigh(hl_light_data *data, hl_light_noise noise, const uint8_t *outlier);

/* light_search.c: directions worth refining, best first. */
typedef struct hl_light_candidate {
  double s[3];
  double cost; /* on all pixels, relative weights */
} hl_light_candidate;
int hl_light_search(struct hl_light_work *work, const hl_light_settings *settings, hl_lobe lobe,
                    hl_light_candidate out[HL_CANDIDATES]);

/* light_area.c: bring the pixels' means to what their middles show, by the fit at work->best. */
void hl_light_bring_to_middle(struct hl_light_work *work, const hl_light_model *model,
                              const hl_surface *surface, int threads);

/* light_settle.c: which terms the frame needs, and the direction with them. */
typedef struct hl_light_variant {
  hl_light_model model;
  double s[3];
  double exponent;
  double cost; /* infinite: not tried */
  bool converged;
} hl_light_variant;

typedef enum hl_variant {
  HL_VARIANT_MATTE,
  HL_VARIANT_PLAIN,
  HL_VARIANT_FORESHORTENED,
  HL_VARIANT_PLAIN_BENT, /* masking and a body that bends away from Lambert's */
  HL_VARIANT_FORESHORTENED_BENT,
  HL_VARIANT_AMBIENT, /* the kept one of those above with a constant, to see what that saves */
  HL_VARIANTS
} hl_variant;

typedef struct hl_light_settled {
  hl_light_variant variant[HL_VARIANTS];
  hl_variant kept;
  int iterations;
  int outliers;
  double coarse_s[3];                        /* the answer under relative weights */
  bool ambient;                              /* every variant has the constant */
  double noise_cost;                         /* what noise alone would leave */
  double bent_gain, ambient_gain, lobe_gain; /* share of the cost each saved */
  double kind_ratio; /* cost of the other kind of lobe over the kept one's */
  double dark_share; /* of the pixels: only they can show an ambient light */
} hl_light_settled;
/* work->best is left at the answer; HL_ERR_DEGENERATE where no model can be fitted. */
hl_status hl_light_settle(hl_ctx *ctx, struct hl_light_work *work, const hl_surface *surface,
                          const hl_light_settings *settings, const double start[2][3],
                          hl_light_settled *out);

/* light_uncertainty.c */
typedef struct hl_light_spread {
  double noise[2][2], model[2][2];                    /* in work->best's tangents */
  double inverse[HL_NONLINEAR_MAX][HL_NONLINEAR_MAX]; /* of the information matrix H */
  double structure; /* misfit correlated over the ball: clustered over white variance */
  double condition;
  double highlight_share;
  double rms, relative_error, explained;
} hl_light_spread;
void hl_light_uncertainty(struct hl_light_work *work, const hl_surface *surface,
                          const hl_light_model *model, const hl_light_settled *settled, int threads,
                          hl_light_spread *out);

/* light_geometry.c: how the direction moves, in work->best's tangents, as the ball's centre [1/m] and,
 * where the camera states a covariance, as its intrinsics do, the centre held. */
typedef struct hl_light_response {
  double by_center[2][3];
  double by_intrinsics[2][HL_INTRINSICS_MAX];
} hl_light_response;
void hl_light_respond(struct hl_light_work *work, const hl_light_model *model,
                      const hl_surface *surface, const hl_light_spread *spread, int threads,
                      hl_light_response *out);
/* Whether the ball's centre is known to follow the surface's camera. */
bool hl_surface_follows(const hl_surface *surface);
/* Fills the parts of the pose and of the camera, as far as they are stated. */
void hl_light_geometry(struct hl_light_work *work, const hl_light_model *model,
                       const hl_surface *surface, const hl_light_spread *spread, int threads,
                       hl_light *out);

/* light_curves.c */
void hl_light_curves(struct hl_light_work *work, const hl_light_model *model, int threads,
                     hl_light *out);

/* light_notes.c */
void hl_light_notes(const struct hl_light_work *work, const hl_light_settled *settled,
                    const hl_light_spread *spread, const hl_surface *surface, hl_light *out);
/* Fills reasons and returns true where the frame cannot tell a direction at all. */
bool hl_light_hopeless(const struct hl_light_work *work, const hl_frame *frame, hl_light *out);

#endif
