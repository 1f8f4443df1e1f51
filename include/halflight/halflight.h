/**
 * halflight: where the light is, from one photo of a glossy ball.
 *
 * The way of a frame:
 *   hl_frame_read -> hl_sphere_locate (or hl_sphere_read) -> hl_surface_of_sphere
 *   -> hl_light_estimate -> hl_light_json_write, hl_curves_csv_write, hl_lp_write
 */
#ifndef HALFLIGHT_HALFLIGHT_H
#define HALFLIGHT_HALFLIGHT_H

#include "halflight/brdf.h"
#include "halflight/calibration.h"
#include "halflight/camera.h"
#include "halflight/capture.h"
#include "halflight/corners.h"
#include "halflight/dome.h"
#include "halflight/drift.h"
#include "halflight/export.h"
#include "halflight/fit.h"
#include "halflight/frame.h"
#include "halflight/info.h"
#include "halflight/interchange.h"
#include "halflight/light.h"
#include "halflight/lights.h"
#include "halflight/merl.h"
#include "halflight/merl_ball.h"
#include "halflight/parametric.h"
#include "halflight/pose.h"
#include "halflight/position.h"
#include "halflight/reflectance.h"
#include "halflight/relight.h"
#include "halflight/replay.h"
#include "halflight/rig_drift.h"
#include "halflight/samples.h"
#include "halflight/session.h"
#include "halflight/settings.h"
#include "halflight/sphere.h"
#include "halflight/status.h"
#include "halflight/surface.h"
#include "halflight/target.h"

#endif
