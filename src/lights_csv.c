/* The lights as a table, a row a frame; where no direction was found the row's numbers are empty. */
#include <stdlib.h>
#include <string.h>

#include "halflight/export.h"
#include "halflight/lights.h"
#include "text.h"

#define DEG_PER_RAD 57.295779513082320877

enum { DIGITS = 12 };

/* RFC 4180: quoted where it holds a comma, a quote or a line break, quotes doubled. */
static void add_field(hl_text *text, const char *field)
{
  if (!strpbrk(field, ",\"\r\n")) {
    hl_text_add(text, field);
    return;
  }
  hl_text_add(text, "\"");
  for (const char *c = field; *c; c++) {
    const char one[2] = {*c, '\0'};
    hl_text_add(text, *c == '"' ? "\"\"" : one);
  }
  hl_text_add(text, "\"");
}

static void add_numbers(hl_text *text, const double *values, int n, bool known)
{
  for (int i = 0; i < n; i++) {
    hl_text_add(text, ",");
    if (known)
      hl_text_number(text, values[i], DIGITS);
  }
}

static void add_light(hl_text *text, const hl_dome *dome, const hl_rig_light *l)
{
  const double off = dome->positions ? l->dome_off : DEG_PER_RAD * l->dome_off;
  const double ellipse[2] = {DEG_PER_RAD * l->ellipse_95_rad[0],
                             DEG_PER_RAD * l->ellipse_95_rad[1]};
  hl_text_number(text, l->frame, DIGITS);
  hl_text_add(text, ",");
  add_field(text, l->file);
  hl_text_add(text, ",");
  add_field(text, l->label);
  hl_text_add(text, l->trusted ? ",yes," : ",no,");
  hl_text_number(text, l->ball, DIGITS);
  add_numbers(text, l->direction, 3, l->found);
  add_numbers(text, ellipse, 2, l->found);
  add_numbers(text, l->color, 3, l->found);
  add_numbers(text, l->intensity, 3, l->found);
  add_numbers(text, &l->intensity_sigma, 1, l->found && l->intensity_sigma > 0);
  add_numbers(text, l->position_m, 3, l->found && l->near);
  add_numbers(text, &l->exposure_us, 1, l->exposure_us > 0);
  add_numbers(text, &l->gain, 1, l->gain > 0);
  const bool shaped = l->found && dome->shape != HL_DOME_NONE;
  hl_text_add(text, !shaped ? "," : l->off_dome ? ",yes" : ",no");
  add_numbers(text, &off, 1, shaped);
  hl_text_add(text, "\n");
}

hl_status hl_lights_csv_write(hl_ctx *ctx, const char *path, const hl_lights *lights)
{
  hl_text text = {0};
  hl_text_add(&text, "frame,file,label,trusted,ball,x,y,z,ellipse_95_major_deg,"
                     "ellipse_95_minor_deg,color_r,color_g,color_b,intensity_r,intensity_g,"
                     "intensity_b,intensity_sigma,position_x_m,position_y_m,position_z_m,"
                     "exposure_us,gain,off_dome,");
  hl_text_add(&text, lights->dome.positions ? "dome_off_m\n" : "dome_off_deg\n");
  for (int i = 0; i < lights->n; i++)
    add_light(&text, &lights->dome, &lights->light[i]);
  const hl_status st =
      text.failed ? hl_fail(ctx, HL_ERR_MEMORY, "%s: no memory for %d lights", path, lights->n)
                  : hl_file_write(ctx, path, text.bytes, text.n);
  free(text.bytes);
  return st;
}
