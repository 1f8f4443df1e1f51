/* The gathered pixels of a scene, for tests of the light's private parts. */
#ifndef HALFLIGHT_TESTS_LIGHT_DATA_H
#define HALFLIGHT_TESTS_LIGHT_DATA_H

#include "../src/light_work.h"
#include "light_scene.h"

typedef struct lit_data {
  hl_surface surface;
  hl_frame frame;
  hl_light_work *work; /* work->all, weighted */
} lit_data;

static inline lit_data lit_gather(const lit_scene *s, test_random *random)
{
  const hl_light_noise noise = {0.02, 0.01};
  lit_data d = {.surface = lit_surface(s)};
  d.frame = lit_frame(s, &d.surface, random);
  if (hl_light_work_new(NULL, d.surface.n, s->channels, &d.work) != HL_OK ||
      hl_light_gather(NULL, d.work, &d.frame, &d.surface, 0) != HL_OK)
    abort();
  hl_light_weigh(&d.work->all, noise, NULL);
  return d;
}

static inline void lit_data_free(lit_data *d)
{
  hl_light_work_free(d->work);
  lit_frame_free(&d->frame);
  hl_surface_free(&d->surface);
}

/* s moved by a and b along the point's tangents. */
static inline void lit_moved(const hl_model_point *at, double a, double b, double out[3])
{
  hl_add_scaled(at->s, a, at->t[0], out);
  hl_add_scaled(out, b, at->t[1], out);
  hl_unit(out, out);
}

#endif
