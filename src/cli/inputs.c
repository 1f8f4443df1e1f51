/* Reading what estimate and locate share. */
#define _XOPEN_SOURCE 700 // NOLINT(bugprone-reserved-identifier)
#include "inputs.h"

#include <stdio.h>
#include <string.h>
#include <time.h>

#include "options.h"

static const hl_field *named(const hl_field_table *table, const char *name)
{
  for (int i = 0; i < table->n; i++)
    if (strcmp(table->fields[i].name, name) == 0)
      return &table->fields[i];
  return NULL;
}

hl_status hl_inputs_transfer(hl_ctx *ctx, const char *text, void *frame_settings)
{
  hl_frame_settings *s = frame_settings;
  if (strcmp(text, "linear") == 0) {
    s->transfer = HL_TRANSFER_LINEAR;
    return HL_OK;
  }
  if (strcmp(text, "srgb") == 0) {
    s->transfer = HL_TRANSFER_SRGB;
    return HL_OK;
  }
  if (strncmp(text, "gamma:", 6) != 0)
    return hl_fail(ctx, HL_ERR_ARG, "--transfer '%.40s' is none of linear, srgb, gamma:G", text);
  const hl_field *gamma = named(hl_frame_fields(), "gamma");
  if (!gamma)
    return hl_fail(ctx, HL_ERR_ARG, "gamma has no settings field");
  hl_field as_typed = *gamma;
  as_typed.name = "--transfer gamma";
  const hl_status st = hl_field_parse(ctx, &as_typed, text + 6, s);
  if (st == HL_OK)
    s->transfer = HL_TRANSFER_GAMMA;
  return st;
}

static hl_status add_term(hl_ctx *ctx, const char *option, const char *text, void *mask)
{
  const char *names[HL_LIGHT_TERMS];
  char all[HL_LIGHT_TERMS * 16] = "";
  unsigned bits;
  memcpy(&bits, mask, sizeof bits);
  for (int i = 0; i < HL_LIGHT_TERMS; i++) {
    names[i] = hl_light_term_name((hl_light_term)i);
    if (strcmp(text, names[i]) == 0) {
      bits |= 1U << i;
      memcpy(mask, &bits, sizeof bits);
      return HL_OK;
    }
    snprintf(all + strlen(all), sizeof all - strlen(all), "%s%s", i > 0 ? ", " : "", names[i]);
  }
  const char *near = hl_options_nearest(text, names, HL_LIGHT_TERMS);
  if (near)
    return hl_fail(ctx, HL_ERR_ARG, "--%s '%.40s' is none of %s; did you mean '%s'?", option, text,
                   all, near);
  return hl_fail(ctx, HL_ERR_ARG, "--%s '%.40s' is none of %s", option, text, all);
}

hl_status hl_inputs_with(hl_ctx *ctx, const char *text, void *mask)
{
  return add_term(ctx, "with", text, mask);
}

hl_status hl_inputs_without(hl_ctx *ctx, const char *text, void *mask)
{
  return add_term(ctx, "without", text, mask);
}

hl_status hl_inputs_circle(hl_ctx *ctx, const char *text, void *sphere_settings)
{
  hl_sphere_settings s;
  double circle[3];
  memcpy(&s, sphere_settings, sizeof s);
  hl_status st = hl_options_numbers(ctx, "circle", text, 3, circle);
  if (st != HL_OK)
    return st;
  s.hint_x_px = circle[0];
  s.hint_y_px = circle[1];
  s.hint_radius_px = circle[2];
  if (!(circle[2] > 0))
    return hl_fail(ctx, HL_ERR_ARG, "--circle %.40s: its radius is %.6g px; one above 0 is needed",
                   text, circle[2]);
  hl_ctx inner = {0};
  st = hl_fields_check(&inner, hl_sphere_fields(), &s);
  if (st != HL_OK)
    return hl_fail(ctx, st, "--circle %.40s: %s", text, inner.msg);
  memcpy(sphere_settings, &s, sizeof s);
  return HL_OK;
}

const hl_field_table *hl_inputs_radius_fields(void)
{
  static const hl_field fields[] = {
      {"radius_m", HL_FIELD_DOUBLE, 0, 1e-6, 1e4, "m", "the ball's radius", NULL},
  };
  static const hl_field_table table = {"radius", fields, 1};
  return &table;
}

hl_status hl_inputs_read(hl_ctx *ctx, const char *frame_path, const char *camera_path,
                         const hl_frame_settings *settings, hl_camera *camera, hl_frame *frame)
{
  hl_camera c;
  hl_frame f;
  hl_status st = hl_fields_check(ctx, hl_frame_fields(), settings);
  if (st == HL_OK)
    st = hl_camera_read(ctx, camera_path, &c);
  if (st == HL_OK)
    st = hl_frame_read(ctx, frame_path, settings, &f);
  if (st != HL_OK)
    return st;
  if (c.width != f.width || c.height != f.height) {
    st = hl_fail(ctx, HL_ERR_FORMAT,
                 "%s: the frame has %d x %d px, the camera of %s %d x %d; a camera calibrated at "
                 "the frame's size is needed",
                 frame_path, f.width, f.height, camera_path, c.width, c.height);
    hl_frame_free(&f);
    return st;
  }
  *camera = c;
  *frame = f;
  return HL_OK;
}

hl_status hl_inputs_blame(hl_ctx *ctx, hl_status status, const char *path)
{
  char text[HL_MESSAGE_MAX];
  if (status == HL_OK || status == HL_ERR_ARG)
    return status;
  snprintf(text, sizeof text, "%s", ctx->msg);
  return hl_fail(ctx, status, "%s: %s", path, text);
}

double hl_inputs_clock_ms(void)
{
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
}
