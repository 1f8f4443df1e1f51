/* What one estimate works on: the pixels at three sizes, scratch, and the fitted frame. Private. */
#ifndef HL_LIGHT_WORK_H
#define HL_LIGHT_WORK_H

#include "light_refine.h"

enum { HL_COARSE_MAX = 2048, HL_TILES_MAX = 4096, HL_CANDIDATES = 3, HL_CELL_LEVELS = 4 };

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

/* First and last column and row. */
typedef struct hl_light_box {
  int x0, x1, y0, y1;
} hl_light_box;

/* What is worked on, and what lies beside it. */
typedef struct hl_light_samples {
  hl_light_data all, grey;
  int *index;
  uint8_t *outlier;
  double *area[HL_CHANNELS_MAX];
} hl_light_samples;

struct hl_light_work {
  int max_pixels, channels;
  void *pool;
  hl_light_data all;      /* every pixel, every channel */
  hl_light_data grey;     /* every pixel, mean of the channels; geometry shared with `all` */
  hl_light_data coarse;   /* the brightest and a regular few of `grey` */
  hl_light_samples aside; /* the other of pixels and cells; shape (max_pixels) */
  bool on_cells;          /* `all` and its like are cells */
  bool glanced;           /* not all of the surface's pixels are gathered */
  bool hurried;           /* what is refined is refined once */
  bool blocks;            /* the pixels' blocks are known: place, bend */
  hl_light_box box;       /* of the gathered pixels */
  uint64_t *place;        /* shape (2 max_pixels): Morton key and pixel, ascending; scratch */
  float (
      *bend)[HL_CELL_LEVELS]; /* shape (max_pixels): of the block of each size that begins there */
  float *mean;                /* shape (max_pixels): of that block */
  int *owner;                 /* shape (max_pixels): cell of each pixel; -1 = left out */
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
  hl_refined refined, best, restore;
  hl_light_model kept; /* of the last estimate */
};

/* Whether gathered pixels i - 1, i, i + 1 are neighbours in a row of the frame, none of them clipped. */
static inline bool hl_light_in_a_row(const struct hl_light_work *work, const hl_surface *surface,
                                     int i)
{
  const int at = surface->pixel[work->index[i]];
  const uint8_t *side = work->all.side;
  if (side && (side[i - 1] > 1 || side[i] > 1 || side[i + 1] > 1))
    return false;
  return surface->pixel[work->index[i - 1]] == at - 1 &&
         surface->pixel[work->index[i + 1]] == at + 1 && !work->all.clipped[i - 1] &&
         !work->all.clipped[i] && !work->all.clipped[i + 1];
}

/* How uncertain a sample is taken to be: variance = (relative y)^2 + absolute^2, in units of level.
 */
typedef struct hl_light_noise {
  double relative, absolute;
} hl_light_noise;

/* light_gather.c: frame and surface into work, at most so many pixels (0 = all); HL_ERR_ARG where they do
 * not fit each other. */
hl_status hl_light_gather(hl_ctx *ctx, struct hl_light_work *work, const hl_frame *frame,
                          const hl_surface *surface, int most);
/* Largest key first, to a float's precision, ties in place; `scratch` has n places. */
void hl_light_sort(hl_ranked *ranked, hl_ranked *scratch, int n);
void hl_light_weigh(hl_light_data *data, hl_light_noise noise, const uint8_t *outlier);

/* light_pixels.c: cells of pixels. */
/* By the upper 32 bits, ascending, ties in place; `scratch` has n places. */
void hl_light_sort_places(uint64_t *place, uint64_t *scratch, int n);
/* Blocks of the gathered pixels that can be cells. O(n). */
void hl_light_find_blocks(struct hl_light_work *work, const hl_surface *surface);
/* At most `most` samples of `full`, the pixels' all or grey; `samples`, where not NULL, receives their
 * places, and work->owner theirs. O(n). */
void hl_light_take_cells(struct hl_light_work *work, int most, const hl_light_data *full,
                         hl_light_data *out, hl_light_samples *samples);
/* light_samples.c */
/* Work on at most `most` cells from here on. */
void hl_light_to_cells(struct hl_light_work *work, int most);
/* From pixels to cells, and back. */
void hl_light_exchange(struct hl_light_work *work);

/* light_search.c */
typedef struct hl_light_candidate {
  double s[3];
  double cost; /* relative weights */
} hl_light_candidate;
/* The pixels' cells to look around with, at most so many; before hl_light_to_cells. */
void hl_light_choose_coarse(struct hl_light_work *work, int most);
/* The best few of so many directions and the brightest spots, well apart, on the coarse samples, in as many
 * passes; before hl_light_to_cells. Returns how many. */
int hl_light_look_around(struct hl_light_work *work, const hl_light_settings *settings,
                         int directions, hl_light_candidate out[HL_CANDIDATES], int *passes);
/* From them, where to start with a plain and with a foreshortened lobe; false: no direction explains the
 * frame. */
bool hl_light_start(struct hl_light_work *work, const hl_light_settings *settings,
                    const hl_light_candidate *found, int count, double start[2][3]);

/* light_area.c: bring the pixels' means to what their middles show, by the fit at work->best. */
void hl_light_bring_to_middle(struct hl_light_work *work, const hl_light_model *model,
                              const hl_surface *surface, int threads);

/* light_shape.c, light_terms.c, light_settle.c: which terms the frame needs, and the direction with them.
 */
typedef struct hl_light_variant {
  hl_light_model model;
  double s[3];
  double exponent, nearness;
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

/* What came of trying a term. */
typedef struct hl_term_verdict {
  double gain;       /* share of the cost that it saves */
  double least;      /* that it must save */
  bool screened;     /* the gain is predicted, too small to try */
  const char *unfit; /* why it was not judged, static; NULL: it was */
} hl_term_verdict;

typedef struct hl_light_settled {
  hl_light_variant variant[HL_VARIANTS];
  hl_variant kept;
  int iterations;
  int outliers;
  int sought;           /* samples that the outliers were sought among: cells, or pixels */
  int concentrated;     /* of them, that hl_light_concentrate found: 0 = it was not needed */
  double compared_s[3]; /* the kept one's as the others' were had */
  double compared_cost; /* likewise: before pixels were left out, on cells where there are any */
  unsigned on;          /* bit t: every variant has term t */
  hl_term_verdict term[HL_LIGHT_TERMS];
  double nearness;             /* where a near light's variants start */
  double noise_cost;           /* what noise alone would leave */
  double bent_gain, lobe_gain; /* share of the cost each saved */
  double kind_ratio;           /* cost of the other kind of lobe over the kept one's */
  double dark_share;           /* of the pixels: only they can show an ambient light */
} hl_light_settled;
/* The weights of everything after the search. */
extern const hl_light_noise hl_light_final_noise;
/* Share of the cost that a richer model saves; none where what is left is beyond any camera. */
double hl_light_gain(const struct hl_light_work *work, double without, double with);
/* What noise alone would make a model with so many more columns a channel save, some times over. */
double hl_light_noise_gain(const struct hl_light_work *work, int columns);
void hl_light_switch_on(unsigned on, hl_light_model *model);
/* Each round follows with the breaks; to compare variants one is enough. */
hl_status hl_light_refine_variant(struct hl_light_work *work, const hl_light_settings *settings,
                                  const double s[3], int rounds, hl_light_variant *variant);
/* Lobe and bends with the terms out->on; out->kept is the one chosen. */
void hl_light_shape(struct hl_light_work *work, const hl_light_settings *settings,
                    const double start[2][3], hl_light_settled *out);
/* Looks for pixels that pull the fit at work->best towards them, as a label does, marks them in
 * work->outlier and returns how many; work->best is then the fit without them. */
int hl_light_concentrate(struct hl_light_work *work, const hl_light_settings *settings,
                         const hl_light_settled *settled);
/* Once that found some: marks anew what deviates by far more than the median. Returns how many. */
int hl_light_mark_beyond(struct hl_light_work *work, const hl_light_model *model);
/* Marks in work->outlier the pixels whose residual no part of the model's stated error explains, by the
 * fit at work->best. Returns how many. */
int hl_light_mark_outliers(struct hl_light_work *work, const hl_light_model *model, double sigmas);

/* work->best is left at the answer; HL_ERR_DEGENERATE where no model can be fitted. */
hl_status hl_light_settle(hl_ctx *ctx, struct hl_light_work *work, const hl_surface *surface,
                          const hl_light_settings *settings, const double start[2][3],
                          hl_light_settled *out);

/* light_finish.c: from cells to all pixels; work->best is left at the answer. */
hl_status hl_light_finish(hl_ctx *ctx, struct hl_light_work *work,
                          const hl_light_settings *settings, hl_light_settled *out);

/* Mean of the channels, by the fit at work->best and measured, of every pixel worked on. */
void hl_light_predict_pixels(struct hl_light_work *work, const hl_light_model *model);

/* Fitted, measured and used, from what was worked on to the surface's n pixels. */
void hl_light_spread_over(struct hl_light_work *work, int surface_n);

/* light_uncertainty.c */
typedef struct hl_light_spread {
  double noise[2][2], model[2][2];                    /* in work->best's tangents */
  double inverse[HL_NONLINEAR_MAX][HL_NONLINEAR_MAX]; /* of the information matrix H */
  double joint[HL_NONLINEAR_MAX][HL_NONLINEAR_MAX];   /* noise and model, of all that is fitted */
  double structure; /* misfit correlated over the ball: clustered over white variance */
  double condition;
  double highlight_share;
  double rms, relative_error, explained;
} hl_light_spread;
void hl_light_uncertainty(struct hl_light_work *work, const hl_surface *surface,
                          const hl_light_model *model, const hl_light_settled *settled, int threads,
                          hl_light_spread *out);

/* Corner of H^-1 M H^-1 that belongs to the direction, n x n. */
void hl_light_sandwich(double h[HL_NONLINEAR_MAX][HL_NONLINEAR_MAX],
                       double m[HL_NONLINEAR_MAX][HL_NONLINEAR_MAX], int n, double out[2][2]);

/* light_misfit.c: adds the model's share to out->model and fills out->structure, from work->score, out->inverse
 * and the white covariance; `tiles` receives the outer products of the scores of small tiles. */
void hl_light_misfit(const struct hl_light_work *work, const hl_surface *surface,
                     const hl_light_settled *settled, int q, double white[2][2],
                     double tiles[HL_NONLINEAR_MAX][HL_NONLINEAR_MAX], hl_light_spread *out);
/* Largest eigenvalue of a relative to b, both 2 x 2 symmetric. */
double hl_light_relative_size(double a[2][2], double b[2][2]);

/* Inverse of a symmetric positive definite n x n, n <= HL_NONLINEAR_MAX; a zero pivot is lifted to 1e-12 of its own. */
void hl_light_invert(const double a[HL_NONLINEAR_MAX][HL_NONLINEAR_MAX], int n,
                     double out[HL_NONLINEAR_MAX][HL_NONLINEAR_MAX]);

/* light_bound.c: puts 1 / the pixels' own noise in place of the fit's weights, from the residual of
 * work->best. */
void hl_light_noise_weights(struct hl_light_work *work, const hl_light_model *model,
                            const hl_surface *surface);
/* Fills bound_rad2 and efficiency from part_rad2; the weights are the noise's own afterwards. */
void hl_light_bound(struct hl_light_work *work, const hl_light_model *model,
                    const hl_surface *surface, int threads, hl_light *out);

/* light_geometry.c: how the direction moves, in work->best's tangents, as the ball's centre [1/m] and,
 * where the camera states a covariance, as its intrinsics do, the centre held. */
typedef struct hl_light_response {
  double by_center[2][3];
  double nearness_by_center[3]; /* of a near light: how its nearness moves [1/m] */
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

/* light_colored.c: what the fit at work->best would cost more, were all channels' lobes of one shape; 0
 * where there are no two channels or no lobe. */
double hl_light_one_shape(struct hl_light_work *work, const hl_light_model *model, int threads);

/* light_position.c: a near light's position and covariance; nothing of a distant one's. */
void hl_light_position(struct hl_light_work *work, const hl_light_model *model,
                       const hl_surface *surface, const hl_light_spread *spread, int threads,
                       hl_light *out);

/* light_curves.c */
void hl_light_curves(struct hl_light_work *work, const hl_light_model *model, int threads,
                     hl_light *out);

/* light_notes.c */
void hl_light_notes(const struct hl_light_work *work, const hl_light_settled *settled,
                    const hl_light_spread *spread, const hl_surface *surface,
                    const hl_light_settings *settings, hl_light *out);
/* light_reasons.c: fills reasons and trusted; everything else of `out` is known. */
void hl_light_judge(const struct hl_light_work *work, const hl_light_settled *settled,
                    const hl_light_spread *spread, hl_light *out);
/* light.c: angle from the highlight out to which pixels are clipped, all but the last few; 0: none. */
double hl_light_clipped_to(const struct hl_light_work *work);
/* Fills reasons and returns true where the frame cannot tell a direction at all. */
bool hl_light_hopeless(const struct hl_light_work *work, const hl_frame *frame, hl_light *out);

#endif
