/* With I the measured radiance, F the model's and g f the model's term at a pixel, the datum of the curve
 * f is f + (I - F) / g. g follows from the term itself, evaluated alone, over its curve; a body's term
 * bends with the view and keeps g = 1. */
#include "curve_cloud.h"

#include <math.h>
#include <string.h>

#include "halflight/vec3.h"

static const double RIGHT_ANGLE = 1.57079632679489662;

static double curve_at(const hl_curve *c, double angle)
{
  int k = 1;
  while (k < c->n - 1 && c->angle_rad[k] < angle)
    k++;
  const double span = c->angle_rad[k] - c->angle_rad[k - 1];
  const double share = span > 0 ? (angle - c->angle_rad[k - 1]) / span : 0;
  return c->value[k - 1] + fmin(fmax(share, 0), 1) * (c->value[k] - c->value[k - 1]);
}

static const hl_curve *curve_of(const hl_light *light, const char *lobe, int channel)
{
  int seen = 0;
  for (int i = 0; i < light->n_curves; i++)
    if (strcmp(light->curves[i].lobe, lobe) == 0 && light->curves[i].n > 1 && seen++ == channel)
      return &light->curves[i];
  return NULL;
}

/* The angle that the lobe's curves are functions of; negative where the pixel says nothing. */
static double angle_at(const hl_surface *surface, const hl_light *light, const char *lobe, int i)
{
  const double *n = surface->normal + 3 * (size_t)i, *v = surface->view + 3 * (size_t)i;
  double axis[3];
  if (!(hl_dot(n, light->direction) > 0) || !(hl_dot(n, v) > 0))
    return -1;
  if (strcmp(lobe, "diffuse") == 0)
    return hl_angle(n, light->direction);
  hl_add_scaled(light->direction, 1, v, axis);
  hl_unit(axis, axis);
  return hl_angle(n, axis);
}

static int bin_of(double angle)
{
  const int bin = (int)(HL_CLOUD_BINS * angle / RIGHT_ANGLE);
  return bin < HL_CLOUD_BINS ? bin : HL_CLOUD_BINS - 1;
}

static bool is_clean(const hl_frame *frame, int pixel)
{
  for (int c = 0; c < frame->channels; c++)
    if (frame->state[(size_t)pixel * (size_t)frame->channels + (size_t)c] != HL_SAMPLE_OK)
      return false;
  return true;
}

typedef struct cloud_work {
  const hl_frame *frame;
  const hl_surface *surface;
  const hl_light *light;
  const hl_reflectance *all;
  hl_reflectance alone; /* the lobe's term and no other */
  const hl_curve *curve[HL_CHANNELS_MAX];
  bool body;
} cloud_work;

static void add(const cloud_work *w, int i, double angle, hl_curve_cloud *out)
{
  const double *n = w->surface->normal + 3 * (size_t)i, *v = w->surface->view + 3 * (size_t)i;
  const float *measured =
      w->frame->radiance + (size_t)w->surface->pixel[i] * (size_t)w->frame->channels;
  double whole[HL_CHANNELS_MAX], term[HL_CHANNELS_MAX];
  hl_reflectance_at(w->all, n, w->light->direction, v, whole);
  hl_reflectance_at(&w->alone, n, w->light->direction, v, term);
  for (int c = 0; c < w->frame->channels; c++) {
    const double own = w->curve[c] ? curve_at(w->curve[c], angle) : 0;
    const double plain = w->alone.term[0].foreshortened ? 1 / hl_dot(n, v) : 1;
    const double g = w->body ? 1 : own > 0 && term[c] > 0 ? term[c] / own : plain;
    out->value[out->n][c] = own + ((double)measured[c] - whole[c] - w->light->ambient[c]) / g;
  }
  out->angle_rad[out->n++] = angle;
}

static bool prepare(cloud_work *w, const char *lobe)
{
  w->body = strcmp(lobe, "diffuse") == 0;
  w->alone = *w->all;
  w->alone.n_terms = 0;
  for (int i = 0; i < w->all->n_terms; i++)
    if (strcmp(w->all->term[i].name, lobe) == 0) {
      w->alone.term[0] = w->all->term[i];
      w->alone.n_terms = 1;
    }
  bool good = w->alone.n_terms == 1 && !w->light->near && w->light->found;
  for (int c = 0; c < w->frame->channels && good; c++) {
    w->curve[c] = curve_of(w->light, lobe, c);
    good = w->curve[c] != NULL;
  }
  return good;
}

void hl_curve_cloud_of(const hl_frame *frame, const hl_surface *surface, const hl_light *light,
                       const hl_reflectance *reflectance, const char *lobe, hl_curve_cloud *out)
{
  cloud_work w = {.frame = frame, .surface = surface, .light = light, .all = reflectance};
  int total[HL_CLOUD_BINS] = {0}, seen[HL_CLOUD_BINS] = {0}, taken[HL_CLOUD_BINS] = {0};
  out->n = 0;
  if (!prepare(&w, lobe))
    return;
  for (int i = 0; i < surface->n; i++) {
    const double angle = angle_at(surface, light, lobe, i);
    if (angle >= 0 && is_clean(frame, surface->pixel[i]))
      total[bin_of(angle)]++;
  }
  for (int i = 0; i < surface->n; i++) {
    const double angle = angle_at(surface, light, lobe, i);
    if (!(angle >= 0) || !is_clean(frame, surface->pixel[i]))
      continue;
    const int bin = bin_of(angle), stride = total[bin] / HL_CLOUD_A_BIN + 1;
    if (seen[bin]++ % stride == 0 && taken[bin] < HL_CLOUD_A_BIN) {
      taken[bin]++;
      add(&w, i, angle, out);
    }
  }
}
