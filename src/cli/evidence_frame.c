/* One frame's evidence. */
#include "evidence_frame.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "draw_curves.h"
#include "draw_evidence.h"
#include "evidence.h"

static hl_status add_photo(hl_ctx *ctx, hl_evidence *evidence, const hl_photo *photo)
{
  hl_photo bare = *photo;
  bare.bare = true;
  const int factor = hl_photo_ellipse_factor(&bare);
  hl_evidence_picture picture = {.name = "photo",
                                 .title = "The photo, and where the light was found",
                                 .kind = HL_PICTURE_PNG,
                                 .draw = hl_draw_frame,
                                 .data = &bare};
  char ellipse[80] = "The 95 % ellipse is too small to be drawn.";
  if (factor == 1)
    snprintf(ellipse, sizeof ellipse, "Orange: the 95 %% ellipse.");
  else if (factor > 1)
    snprintf(ellipse, sizeof ellipse, "Orange: the 95 %% ellipse, %d times enlarged.", factor);
  snprintf(picture.alt, sizeof picture.alt,
           "%sWhite cross: where the surface's normal is the half-angle between light "
           "and camera. Yellow arrow: the way to the light. %s",
           photo->sphere ? "Blue: the ball's outline. " : "", ellipse);
  return hl_evidence_add(ctx, evidence, &picture);
}

static hl_status add_pixels(hl_ctx *ctx, hl_evidence *evidence, hl_pixels *pixels)
{
  static const struct {
    const char *name, *title, *alt;
  } panels[] = {
      {"normals", "Normals",
       "The surface's normals: red to the right, green up, blue towards the camera."},
      {"measured", "Photo", "What the camera measured, mean of the channels."},
      {"fitted", "Fit", "What the model predicts, at the photo's exposure."},
      {"residual", "Residual \303\2273",
       "Photo less fit, three times as large, at the photo's exposure. Orange: the photo is "
       "brighter; blue: the "
       "fit is. Clipped pixels show nothing where the fit is brighter, as they may be."},
      {"mask", "Masks", ""},
  };
  int used = 0, clipped = 0, left_out = 0;
  hl_pixels_count(pixels, &used, &clipped, &left_out);
  for (int i = 0; i < (int)(sizeof panels / sizeof *panels); i++) {
    hl_evidence_picture picture = {.name = panels[i].name,
                                   .title = panels[i].title,
                                   .kind = HL_PICTURE_PNG,
                                   .draw = hl_draw_pixels,
                                   .data = pixels};
    pixels->panel = (hl_panel)i;
    if (pixels->panel == HL_PANEL_MASK)
      snprintf(picture.alt, sizeof picture.alt,
               "Grey: %d pixels used. Orange: %d with a clipped channel, known to be at least this "
               "bright. Blue: %d left out.",
               used, clipped, left_out);
    else
      snprintf(picture.alt, sizeof picture.alt, "%s", panels[i].alt);
    const hl_status st = hl_evidence_add(ctx, evidence, &picture);
    if (st != HL_OK)
      return st;
  }
  return HL_OK;
}

static bool has_curve(const hl_light *light, const char *lobe)
{
  for (int i = 0; i < light->n_curves; i++)
    if (light->curves[i].n > 0 && strcmp(light->curves[i].lobe, lobe) == 0)
      return true;
  return false;
}

static hl_status add_curves(hl_ctx *ctx, hl_evidence *evidence, const hl_photo *photo,
                            const hl_reflectance *reflectance, hl_curve_cloud *cloud)
{
  static const char *const lobes[] = {"specular", "diffuse"};
  static const char *const titles[] = {"Specular lobe", "Diffuse term"};
  for (int i = 0; i < 2; i++) {
    if (!has_curve(photo->light, lobes[i]))
      continue;
    hl_curve_cloud_of(photo->frame, photo->surface, photo->light, reflectance, lobes[i], cloud);
    const hl_curve_sheet sheet = {photo->light, lobes[i], cloud, cloud};
    hl_evidence_picture picture = {.name = lobes[i],
                                   .title = titles[i],
                                   .chart = true,
                                   .kind = HL_PICTURE_SVG,
                                   .draw = hl_draw_curves,
                                   .data = &sheet};
    snprintf(picture.alt, sizeof picture.alt, "Radiance against the angle %s, a line a channel%s.",
             i == 0 ? "between normal and half-angle" : "between normal and light",
             cloud->n > 0 ? ", and dots: what each of a sample of pixels leaves for the curve once "
                            "the other term is taken off"
                          : "");
    const hl_status st = hl_evidence_add(ctx, evidence, &picture);
    if (st != HL_OK)
      return st;
  }
  return HL_OK;
}

hl_status hl_evidence_of_frame(hl_ctx *ctx, const char *path, const hl_photo *photo,
                               const hl_light_work *work, const char *light_json)
{
  hl_evidence evidence = {0};
  hl_pixels pixels = {.frame = photo->frame, .surface = photo->surface};
  hl_reflectance *reflectance = calloc(1, sizeof *reflectance);
  hl_curve_cloud *cloud = calloc(1, sizeof *cloud);
  hl_light_fitted(work, &pixels.predicted, &pixels.measured, &pixels.weight);
  if (!reflectance || !cloud) {
    free(cloud);
    free(reflectance);
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for the pictures");
  }
  hl_status st = hl_evidence_begin(ctx, &evidence, "light.json", path);
  if (st == HL_OK)
    st = hl_evidence_used(ctx, &evidence, &photo->light->used);
  if (st == HL_OK)
    st = add_photo(ctx, &evidence, photo);
  if (st == HL_OK)
    st = add_pixels(ctx, &evidence, &pixels);
  if (st == HL_OK && photo->light->n_curves > 0) {
    st = hl_reflectance_read(ctx, light_json, reflectance);
    if (st == HL_OK)
      st = add_curves(ctx, &evidence, photo, reflectance, cloud);
  }
  if (st == HL_OK)
    st = hl_evidence_write(ctx, &evidence, path);
  hl_evidence_free(&evidence);
  free(cloud);
  free(reflectance);
  return st;
}
