/* What a rig's lights stand on, in words: the shape, how closely, and which lights are off it. */
#include <stdio.h>
#include <string.h>

#include "summary.h"

enum { TEXT_MAX = 400, NAMED_MAX = 8 };

static const double degrees = 57.29577951308232;

/* "0.41 deg", "3.2 mm" */
static void write_distance(const hl_dome *d, double value, char *out, size_t size)
{
  snprintf(out, size, d->positions ? "%.3g mm" : "%.3g deg",
           d->positions ? 1e3 * value : degrees * value);
}

static void write_rings(const hl_dome_fit *f, char *out, size_t size)
{
  size_t n =
      (size_t)snprintf(out, size, "%s about an axis, at", f->n_rings > 1 ? "rings" : "a ring");
  for (int k = 0; k < f->n_rings && n < size; k++)
    n += (size_t)snprintf(out + n, size - n, "%s %.1f", k > 0 ? "," : "",
                          degrees * f->half_angle_rad[k]);
  if (n < size)
    snprintf(out + n, size - n, " deg%s", f->pole ? " and on it" : "");
}

static void write_shape(const hl_dome *d, const hl_dome_fit *f, char *out, size_t size)
{
  if (f->shape == HL_DOME_GRID)
    snprintf(out, size, "a plane grid of %d x %d", f->size[0], f->size[1]);
  else if (f->shape == HL_DOME_RINGS && !d->positions)
    write_rings(f, out, size);
  else
    snprintf(out, size, "a %s of radius %.4g m", f->shape == HL_DOME_RINGS ? "circle" : "sphere",
             f->radius_m);
}

static void write_outliers(const hl_lights *l, char *out, size_t size)
{
  size_t n = 0;
  int named = 0;
  for (int i = 0; i < l->n && n < size; i++) {
    const hl_rig_light *one = &l->light[i];
    char by[40];
    if (!one->off_dome)
      continue;
    if (named++ == NAMED_MAX) {
      snprintf(out + n, size - n, ", ...");
      return;
    }
    write_distance(&l->dome, one->dome_off, by, sizeof by);
    n += (size_t)snprintf(out + n, size - n, "%s%.60s by %s", named > 1 ? ", " : "",
                          one->label[0] ? one->label : one->file, by);
  }
}

void hl_summary_dome_text(const hl_lights *lights, char *out, size_t size)
{
  const hl_dome *d = &lights->dome;
  const hl_dome_fit *f = &d->fit[d->shape];
  char shape[200], rms[40];
  if (d->shape == HL_DOME_NONE) {
    snprintf(out, size, "%s",
             d->positions ? "no sphere, circle or plane grid that the positions would show"
                          : "no rings or plane grid that the directions would show");
    return;
  }
  write_shape(d, f, shape, sizeof shape);
  write_distance(d, f->rms, rms, sizeof rms);
  snprintf(out, size, "%s; %d of %d lights on it, rms %s", shape, f->n_on, d->n, rms);
}

bool hl_summary_off_dome(const hl_lights *lights, char *out, size_t size)
{
  const hl_dome *d = &lights->dome;
  if (d->shape == HL_DOME_NONE || d->fit[d->shape].n_off == 0)
    return false;
  write_outliers(lights, out, size);
  return true;
}

void hl_summary_dome(FILE *out, const hl_lights *lights)
{
  char text[TEXT_MAX];
  hl_summary_dome_text(lights, text, sizeof text);
  hl_summary_line(out, "dome", text);
  if (hl_summary_off_dome(lights, text, sizeof text))
    hl_summary_line(out, "off it", text);
}
