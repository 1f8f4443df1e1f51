/* The methods of the comparison, ours within several budgets and what others do. */
#include "bench_scene.h"

#include <stdlib.h>
#include <string.h>

/* The bends and the outliers are not noted by their terms' names. */
static unsigned used_of(const hl_notes *used)
{
  unsigned on = 0;
  for (int i = 0; i < used->n; i++) {
    const char *what = used->note[i].what;
    for (int t = 0; t < HL_LIGHT_TERMS; t++)
      if (strcmp(what, hl_light_term_name((hl_light_term)t)) == 0)
        on |= 1U << t;
    if (strcmp(what, "masking and bent body") == 0)
      on |= 1U << HL_LIGHT_BENDS;
    if (strcmp(what, "outlier rejection") == 0)
      on |= 1U << HL_LIGHT_OUTLIERS;
  }
  return on;
}

static bool estimate(const hl_bench_scene *s, const hl_light_settings *settings, double light[3],
                     hl_bench_said *said)
{
  hl_light *out = calloc(1, sizeof *out);
  const bool found =
      out && hl_light_estimate(NULL, s->work, &s->frame, &s->surface, settings, out) == HL_OK &&
      out->found;
  if (found) {
    memcpy(light, out->direction, sizeof out->direction);
    said->trusted = out->trusted;
    said->used = used_of(&out->used);
  }
  free(out);
  return found;
}

#define METHOD(name)                                                                               \
  static bool name(const hl_bench_scene *s, const hl_bench_method *m, double light[3],             \
                   hl_bench_said *said)

METHOD(by_pixels)
{
  hl_light_settings settings = hl_light_defaults();
  settings.threads = 1;
  settings.pixels = (int)m->budget;
  return estimate(s, &settings, light, said);
}

METHOD(by_time)
{
  hl_light_settings settings = hl_light_defaults();
  settings.threads = 1;
  settings.budget_ms = m->budget;
  return estimate(s, &settings, light, said);
}

METHOD(by_lobe)
{
  hl_light_settings settings = hl_light_defaults();
  settings.threads = 1;
  settings.lobe = m->budget > 0 ? HL_LOBE_FORESHORTENED : HL_LOBE_PLAIN;
  return estimate(s, &settings, light, said);
}

METHOD(by_basis)
{
  hl_light_settings settings = hl_light_defaults();
  settings.threads = 1;
  settings.intervals = (int)m->budget;
  return estimate(s, &settings, light, said);
}

METHOD(without_term)
{
  hl_light_settings settings = hl_light_defaults();
  settings.threads = 1;
  settings.without = 1U << (unsigned)m->budget;
  return estimate(s, &settings, light, said);
}

#define RULE(name, call)                                                                           \
  METHOD(name)                                                                                     \
  {                                                                                                \
    (void)m;                                                                                       \
    (void)said;                                                                                    \
    return call;                                                                                   \
  }

RULE(brightest_parallel, hl_rule_brightest(s, false, light))
RULE(brightest_rays, hl_rule_brightest(s, true, light))
RULE(centroid_parallel, hl_rule_centroid(s, false, light))
RULE(centroid_rays, hl_rule_centroid(s, true, light))
RULE(lambert, hl_rule_lambert(s, light))
RULE(relight, hl_rule_relight(s, light))
RULE(alicevision_bright, hl_rule_alicevision_bright(s, light))
RULE(alicevision_white, hl_rule_alicevision_white(s, light))

const hl_bench_method hl_bench_methods[] = {
    {"all pixels", "pixels", true, 0, by_pixels},
    {"16k pixels", "pixels", true, 16000, by_pixels},
    {"8k pixels", "pixels", true, 8000, by_pixels},
    {"4k pixels", "pixels", true, 4000, by_pixels},
    {"2k pixels", "pixels", true, 2000, by_pixels},
    {"1k pixels", "pixels", true, 1000, by_pixels},
    {"100 ms", "time", true, 100, by_time},
    {"50 ms", "time", true, 50, by_time},
    {"20 ms", "time", true, 20, by_time},
    {"10 ms", "time", true, 10, by_time},
    {"5 ms", "time", true, 5, by_time},
    {"2 ms", "time", true, 2, by_time},
    {"1 ms", "time", true, 1, by_time},
    {"24 intervals", "basis", true, 24, by_basis},
    {"16 intervals", "basis", true, 16, by_basis},
    {"10 intervals", "basis", true, 10, by_basis},
    {"6 intervals", "basis", true, 6, by_basis},
    {"without ambient", "term", true, HL_LIGHT_AMBIENT, without_term},
    {"without near", "term", true, HL_LIGHT_NEAR, without_term},
    {"without backscatter", "term", true, HL_LIGHT_BACKSCATTER, without_term},
    {"without outliers", "term", true, HL_LIGHT_OUTLIERS, without_term},
    {"without bends", "term", true, HL_LIGHT_BENDS, without_term},
    {"plain lobe only", "lobe", true, 0, by_lobe},
    {"foreshortened lobe only", "lobe", true, 1, by_lobe},
    {"brightest pixel, parallel", "brightest", false, 0, brightest_parallel},
    {"brightest pixel, rays", "brightest", false, 0, brightest_rays},
    {"highlight centroid, parallel", "centroid", false, 0, centroid_parallel},
    {"highlight centroid, rays", "centroid", false, 0, centroid_rays},
    {"Lambert least squares", "lambert", false, 0, lambert},
    {"relight's rule", "relight", false, 0, relight},
    {"AliceVision, brightest point", "alicevision", false, 0, alicevision_bright},
    {"AliceVision, white sphere", "alicevision", false, 0, alicevision_white},
    {"R's ppr, one ridge", "ppr", false, 0, NULL}, /* last: it is left out where R is not there */
};
const int hl_bench_methods_count = sizeof hl_bench_methods / sizeof *hl_bench_methods;
