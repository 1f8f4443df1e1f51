/**
 * A ball of a measured material under one light: as a frame, and as the samples that fits are made to.
 *
 * Everything here is radiance, BRDF x cos, for a light of irradiance 1 at normal incidence. Where the
 * table was not measured a pixel is marked unusable (as a file: not a number), and there is no sample.
 */
#ifndef HALFLIGHT_MERL_BALL_H
#define HALFLIGHT_MERL_BALL_H

#include "halflight/merl.h"
#include "halflight/samples.h"

#ifdef __cplusplus
extern "C" {
#endif

/** How to draw a ball of a measured material. */
typedef struct hl_merl_ball_settings {
  hl_merl_lookup lookup;
  int oversample;       /* through a camera: so many by so many rays a pixel */
  double background;    /* through a camera: radiance behind the ball */
  double min_cos_light; /* samples have n.s above it ... */
  double min_cos_view;  /* ... and n.v above this: at grazing angles tables are at their worst */
} hl_merl_ball_settings;

/** The defaults; they pass their own check. */
HL_API hl_merl_ball_settings hl_merl_ball_defaults(void);
/** Name, unit, bounds and text of every setting. */
HL_API const hl_field_table *hl_merl_ball_fields(void);

/** Owner of its frame and samples; hl_merl_ball_free releases them. */
typedef struct hl_merl_ball {
  hl_frame frame;     /* three channels; 0 in attached shadow, unusable where not measured */
  hl_samples samples; /* at pixel centres, three channels */
  int n_pixels;       /* that show the ball */
  int n_unmeasured;   /* of them: unusable */
} hl_merl_ball;

/** Release frame and samples; NULL is accepted. */
HL_API void hl_merl_ball_free(hl_merl_ball *ball);

/**
 * Seen from afar along v = (0,0,1), x right, y up: an image of 2R x 2R pixels that the ball fills,
 * each the radiance at its centre, 0 beside the ball; samples without views.
 *
 * @param light    towards the light, in that frame, any length but 0
 * @param settings NULL means hl_merl_ball_defaults()
 * @return HL_OK; HL_ERR_ARG (radius_px outside [1, 1024], light, settings); HL_ERR_DEGENERATE (no
 *         sample: the light is behind the ball, or nothing of what it lights was measured);
 *         HL_ERR_MEMORY
 */
HL_API hl_status hl_merl_ball_from_afar(hl_ctx *ctx, const hl_merl *merl, int radius_px,
                                        const double light[3],
                                        const hl_merl_ball_settings *settings, hl_merl_ball *out);

/**
 * Through a camera: a frame of the camera's size, each pixel the mean over its area, and samples with
 * views; light, normals and views in the camera's frame (x right, y down, z forward: a light on the
 * camera's side has z < 0).
 *
 * @return as above; HL_ERR_ARG (camera or ball that their checks refuse); HL_ERR_DEGENERATE too where
 *         no pixel shows the ball
 */
HL_API hl_status hl_merl_ball_through_camera(hl_ctx *ctx, const hl_merl *merl,
                                             const hl_camera *camera, const hl_sphere *sphere,
                                             const double light[3],
                                             const hl_merl_ball_settings *settings,
                                             hl_merl_ball *out);

#ifdef __cplusplus
}
#endif
#endif
