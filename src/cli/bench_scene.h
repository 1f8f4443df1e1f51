/* A recorded frame whose light is known, and what is measured on it. */
#ifndef HL_CLI_BENCH_SCENE_H
#define HL_CLI_BENCH_SCENE_H

#include "halflight/halflight.h"

typedef struct hl_bench_scene {
  char name[64];
  hl_camera camera;
  hl_sphere sphere;
  hl_frame frame;
  hl_surface surface;
  double light[3];  /* the truth */
  double circle[3]; /* the ball's image: centre x, y, radius [px] */
  float *grey;      /* shape (height, width): mean of the channels */
  hl_light_work *work;
} hl_bench_scene;

/* Read camera.json, sphere.json, truth.json and frame.* of a folder. The caller closes it, also after
 * a failure. HL_ERR_IO, HL_ERR_FORMAT, HL_ERR_MEMORY, HL_ERR_UNAVAILABLE (a kind of frame). */
hl_status hl_bench_scene_open(hl_ctx *ctx, const char *folder, hl_bench_scene *out);
void hl_bench_scene_close(hl_bench_scene *scene);

/* What an answer says of itself. */
typedef struct hl_bench_said {
  bool trusted;
  unsigned used; /* bit t: the term t */
} hl_bench_said;

typedef struct hl_bench_method {
  const char *name;
  const char *family; /* methods that differ by a budget only share it */
  bool ours;
  double budget; /* pixels, ms, intervals, or the term left out; 0 = none */
  /* false: it finds no light here. `said` starts as trusted, with no terms. NULL: hl_ppr_run. */
  bool (*run)(const hl_bench_scene *scene, const struct hl_bench_method *method, double light[3],
              hl_bench_said *said);
} hl_bench_method;

extern const hl_bench_method hl_bench_methods[];
extern const int hl_bench_methods_count;

/* Methods of others, each as its authors describe it. */
bool hl_rule_brightest(const hl_bench_scene *s, bool perspective, double light[3]);
bool hl_rule_centroid(const hl_bench_scene *s, bool perspective, double light[3]);
bool hl_rule_lambert(const hl_bench_scene *s, double light[3]);
bool hl_rule_relight(const hl_bench_scene *s, double light[3]);
bool hl_rule_alicevision_bright(const hl_bench_scene *s, double light[3]);
bool hl_rule_alicevision_white(const hl_bench_scene *s, double light[3]);

#endif
