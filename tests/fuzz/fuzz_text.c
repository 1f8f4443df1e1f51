/* Plain text: tables, target specs, YAML and Python documents. */
#include <stdlib.h>
#include <string.h>

#include "python_read.h"
#include "readers.h"
#include "yaml_read.h"

hl_status fuzz_samples(hl_ctx *ctx, const fuzz_input *input)
{
  hl_samples samples = {0};
  const hl_status st = hl_samples_read(ctx, input->path, &samples);
  if (st != HL_OK)
    return st;
  hl_ctx inner = {0};
  fuzz_demand(hl_samples_check(&inner, &samples) == HL_OK, "what was read passes the check",
              inner.msg);
  hl_samples_free(&samples);
  return HL_OK;
}

hl_status fuzz_corners(hl_ctx *ctx, const fuzz_input *input)
{
  const hl_target target = {HL_TARGET_CHESSBOARD, 3, 3, 0.03, 0};
  hl_corners corners = hl_corners_of(&target);
  const hl_status st = hl_corners_read(ctx, input->path, &target, &corners);
  if (st != HL_OK)
    return st;
  for (int i = 0; i < corners.n_views; i++)
    for (int k = 0; k < hl_target_corners(&target); k++) {
      const hl_corner *corner = &corners.view[i].corner[k];
      fuzz_demand(corner->sigma >= 0 && corner->sigma - corner->sigma == 0, "a finite sigma", "");
    }
  hl_corners_free(&corners);
  return HL_OK;
}

hl_status fuzz_target(hl_ctx *ctx, const fuzz_input *input)
{
  hl_target target, again;
  char text[HL_TARGET_SPEC_MAX];
  const hl_status st = hl_target_parse(ctx, (const char *)input->bytes, &target);
  if (st != HL_OK)
    return st;
  hl_ctx inner = {0};
  fuzz_demand(hl_target_check(&inner, &target) == HL_OK, "what was read passes the check",
              inner.msg);
  fuzz_demand(hl_target_parse(&inner, hl_target_spec(&target, text), &again) == HL_OK,
              "what was written can be read", inner.msg);
  return HL_OK;
}

hl_status fuzz_yaml(hl_ctx *ctx, const fuzz_input *input)
{
  json_t *root = NULL;
  char *copy = malloc(input->n + 1);
  if (!copy)
    return HL_OK;
  memcpy(copy, input->bytes, input->n + 1);
  const hl_status st = hl_yaml_parse((hl_json_source){ctx, "input"}, copy, input->n, &root);
  if (st == HL_OK)
    json_decref(root);
  free(copy);
  return st;
}

hl_status fuzz_python(hl_ctx *ctx, const fuzz_input *input)
{
  json_t *root = NULL;
  const hl_status st =
      hl_python_parse((hl_json_source){ctx, "input"}, (const char *)input->bytes, input->n, &root);
  if (st == HL_OK)
    json_decref(root);
  return st;
}

/* A curve to put in place of a term's. */
hl_status fuzz_term_curve(hl_ctx *ctx, const fuzz_input *input)
{
  hl_reflectance reflectance = {.channels = 3, .n_terms = 1};
  hl_lobe_term *term = &reflectance.term[0];
  strcpy(term->name, "specular");
  term->cs = term->cv = 1;
  term->n = 2;
  term->t[1] = 1;
  const hl_status st = hl_reflectance_replace(ctx, &reflectance, "specular", input->path);
  if (st == HL_OK) {
    static const double up[3] = {0, 0, 1};
    double out[HL_CHANNELS_MAX];
    hl_reflectance_at(&reflectance, up, up, up, out);
    fuzz_demand(out[0] == out[0], "radiance is a number", "");
  }
  return st;
}
