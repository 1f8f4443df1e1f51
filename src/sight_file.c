/* A ball's sight from the LIGHT.json of its frame and its SPHERE.json. */
#include <math.h>
#include <string.h>

#include "halflight/position.h"
#include "json_read.h"

/* The pose's share of the covariance is what the file says the direction follows the centre by. */
static void take_pose(const hl_sphere *sphere, hl_light *light)
{
  for (int k = 0; k < 2; k++)
    for (int l = 0; l < 2; l++)
      for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
          light->part_rad2[HL_PART_POSE][k][l] +=
              light->by_center[k][i] * sphere->covariance_m2[i][j] * light->by_center[l][j];
  const double(*pose)[2] = light->part_rad2[HL_PART_POSE], (*all)[2] = light->covariance_rad2;
  const double rest[3] = {all[0][0] - pose[0][0], all[0][1] - pose[0][1], all[1][1] - pose[1][1]};
  /* another pose than the estimate's: its share is not in there */
  light->part_stated[HL_PART_POSE] =
      rest[0] >= 0 && rest[2] >= 0 && rest[0] * rest[2] >= rest[1] * rest[1];
}

static hl_status read_light(hl_json_source source, const json_t *root, const hl_sphere *sphere,
                            hl_light *light)
{
  const json_t *list = json_object_get(root, "lights"), *one = json_array_get(list, 0);
  if (!json_is_object(one))
    return hl_fail(source.ctx, HL_ERR_FORMAT,
                   "%s: lights holds no light; the file of a frame that shows one is needed",
                   source.path);
  const char *status = json_string_value(json_object_get(root, "status"));
  light->found = true;
  light->trusted = !status || strcmp(status, "untrusted") != 0;
  hl_status st = hl_json_numbers(source, one, "direction", 3, light->direction);
  if (st == HL_OK)
    st = hl_json_matrix(source, one, "tangent_basis", 2, 3, light->tangent_basis[0]);
  if (st == HL_OK)
    st = hl_json_matrix(source, one, "covariance_rad2", 2, 2, light->covariance_rad2[0]);
  if (st == HL_OK && hl_json_has(one, "by_center_rad_per_m"))
    st = hl_json_matrix(source, one, "by_center_rad_per_m", 2, 3, light->by_center[0]);
  const json_t *parts = json_object_get(one, "ellipse_parts_deg");
  light->near = hl_json_has(one, "position_m");
  if (st == HL_OK && sphere->has_covariance && hl_json_has(parts, "pose"))
    take_pose(sphere, light);
  return st;
}

hl_status hl_sight_read(hl_ctx *ctx, const char *light_path, const char *sphere_path, hl_sight *out)
{
  const hl_json_source source = {ctx, light_path};
  hl_sphere sphere;
  json_t *root = NULL;
  hl_status st = hl_sphere_read(ctx, sphere_path, &sphere);
  if (st == HL_OK)
    st = hl_json_open(source, "halflight-light", 1, &root);
  if (st != HL_OK)
    return st;
  hl_light light = {.found = false};
  st = read_light(source, root, &sphere, &light);
  json_decref(root);
  if (st != HL_OK)
    return st;
  hl_ctx inner = {0};
  st = hl_sight_of_light(&inner, &light, &sphere, out);
  return st == HL_OK ? st : hl_json_blame(source, HL_ERR_FORMAT, inner.msg);
}
