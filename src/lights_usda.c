/*
 * Lights as OpenUSD text (UsdLux). The stage has x right, y up and z backward, so (x, -y, -z) of the
 * camera's frame: the camera stands at the origin and looks along -z, as USD's cameras do, which is
 * the frame of .lp too.
 *
 * A DistantLight shines along its own -z, so its own z points to the light. Transforms act on row
 * vectors: row i of the matrix is where axis i goes, row 3 the place.
 *
 * With `normalize` a DistantLight of intensity E gives the irradiance E to a surface that faces it,
 * and a SphereLight of intensity L at distance D gives L / (4 D^2) (UsdLux, LightAPI's sizeFactor);
 * so a near light has 4 D^2 E.
 */
#include <stdio.h>

#include "halflight/vec3.h"
#include "lights_formats.h"

enum { DIGITS = 12 };

#define LAMP_RADIUS_M 0.001 /* a near light is a point in the model; renderers want a size */

static void put_tuple(hl_text *out, const double *values, int n)
{
  hl_text_add(out, "(");
  for (int k = 0; k < n; k++) {
    hl_text_add(out, k > 0 ? ", " : "");
    hl_text_number(out, values[k], DIGITS);
  }
  hl_text_add(out, ")");
}

static void to_stage(const double ours[3], double stage[3])
{
  stage[0] = ours[0];
  stage[1] = 0 - ours[1];
  stage[2] = 0 - ours[2];
}

static void put_turn(hl_text *out, const double direction[3])
{
  double row[4][4] = {{0}};
  to_stage(direction, row[2]);
  hl_tangent_basis(row[2], row[0], row[1]);
  row[3][3] = 1;
  hl_text_add(out, "        matrix4d xformOp:transform = (");
  for (int i = 0; i < 4; i++) {
    hl_text_add(out, i > 0 ? ", " : " ");
    put_tuple(out, row[i], 4);
  }
  hl_text_add(out, " )\n        uniform token[] xformOpOrder = [\"xformOp:transform\"]\n    }\n");
}

static void put_place(hl_text *out, const double position_m[3])
{
  double place[3];
  to_stage(position_m, place);
  hl_text_add(out, "        float inputs:radius = ");
  hl_text_number(out, LAMP_RADIUS_M, DIGITS);
  hl_text_add(out, "\n        bool treatAsPoint = 1\n        double3 xformOp:translate = ");
  put_tuple(out, place, 3);
  hl_text_add(out, "\n        uniform token[] xformOpOrder = [\"xformOp:translate\"]\n    }\n");
}

static void put_light(const hl_lights *lights, const hl_rig_light *light, int n, hl_text *out)
{
  char name[32];
  const bool near = light->near && light->ball >= 0 && light->ball < lights->n_balls;
  double brightest = 0, color[3], away[3];
  for (int k = 0; k < 3; k++)
    brightest = light->intensity[k] > brightest ? light->intensity[k] : brightest;
  for (int k = 0; k < 3; k++)
    color[k] = brightest > 0 ? light->intensity[k] / brightest : 0;
  double intensity = brightest;
  if (near) {
    hl_add_scaled(light->position_m, -1, lights->ball[light->ball].center_m, away);
    intensity *= 4 * hl_dot(away, away);
  }
  snprintf(name, sizeof name, "light_%03d", n);
  hl_text_add(out, near ? "\n    def SphereLight \"" : "\n    def DistantLight \"");
  hl_text_add(out, name);
  hl_text_add(out, "\"\n    {\n        custom string halflight:file = ");
  hl_lights_quote(out, light->file);
  hl_text_add(out, "\n        color3f inputs:color = ");
  put_tuple(out, color, 3);
  hl_text_add(out, "\n        float inputs:intensity = ");
  hl_text_number(out, intensity, DIGITS);
  hl_text_add(out, "\n        bool inputs:normalize = 1\n");
  if (near) {
    put_place(out, light->position_m);
    return;
  }
  hl_text_add(out, "        float inputs:angle = 0\n");
  put_turn(out, light->direction);
}

void hl_lights_usda_put(const hl_lights *lights, hl_text *out)
{
  int n = 0;
  hl_text_add(out, "#usda 1.0\n(\n    defaultPrim = \"Rig\"\n"
                   "    doc = \"One light for each frame; the camera is at the origin and looks "
                   "along -z.\"\n    metersPerUnit = 1\n    upAxis = \"Y\"\n)\n\n"
                   "def Xform \"Rig\"\n{");
  for (int i = 0; i < lights->n; i++)
    if (lights->light[i].found)
      put_light(lights, &lights->light[i], ++n, out);
  hl_text_add(out, "}\n");
}
