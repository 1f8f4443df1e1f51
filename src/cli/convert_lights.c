/* convert: lights from one program's file to another's. */
#include "convert_lights.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "inputs.h"

/* "intensities, covariances" of what the format has no place for; "" where nothing is lost. */
static void list_lost(unsigned lost, char *out, size_t room)
{
  static const struct {
    hl_lights_part part;
    const char *name;
  } parts[] = {{HL_LIGHTS_NAMES, "names"},
               {HL_LIGHTS_INTENSITIES, "intensities"},
               {HL_LIGHTS_POSITIONS, "positions"},
               {HL_LIGHTS_COVARIANCES, "covariances"}};
  size_t n = 0;
  out[0] = '\0';
  for (size_t i = 0; i < sizeof parts / sizeof parts[0]; i++)
    if (lost & parts[i].part && n < room)
      n += (size_t)snprintf(out + n, room - n, "%s%s", n > 0 ? ", " : "", parts[i].name);
}

/* The text on stdout and what it lacks on stderr; or, beside a file, a summary on stdout. */
static void print_result(const hl_lights *lights, hl_lights_format format, const char *text,
                         bool printed)
{
  const char *name = hl_lights_format_name((int)format);
  char lost[80];
  int found = 0;
  for (int i = 0; i < lights->n; i++)
    found += lights->light[i].found;
  list_lost(hl_lights_lost(lights, format), lost, sizeof lost);
  if (printed) {
    fputs(text, stdout);
    if (lost[0])
      fprintf(stderr, "halflight: convert: left out: %s; %s has no place for it\n", lost, name);
    return;
  }
  printf("%-14s%s, %d of %d with a direction\n", "lights", name, found, lights->n);
  if (lost[0])
    printf("%-14s%s: %s has no place for it\n", "left out", lost, name);
  for (int i = 0; i < lights->n; i++)
    if (!lights->light[i].found)
      printf("%-14s%s: no direction was found\n", "", lights->light[i].file);
    else if (!lights->light[i].trusted)
      printf("%-14s%s: not to be trusted\n", "note", lights->light[i].file);
}

hl_status hl_convert_lights(hl_ctx *ctx, const char *in, hl_lights_format format, const char *out,
                            hl_outputs *outputs)
{
  hl_lights *lights = calloc(1, sizeof *lights);
  if (!lights)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for the lights");
  char *text = NULL;
  int at = 0;
  hl_status st = hl_lights_import(ctx, in, lights);
  if (st == HL_OK && out)
    st = hl_outputs_add(ctx, outputs, NULL, out, &at);
  if (st == HL_OK && hl_lights_text(ctx, lights, format, &text) != HL_OK) /* the file's fault */
    st = hl_inputs_blame(ctx, HL_ERR_FORMAT, in);
  if (st == HL_OK)
    st = hl_outputs_begin(ctx, outputs);
  if (st == HL_OK && out)
    st = hl_file_write(ctx, outputs->stage[at], text, strlen(text));
  if (st == HL_OK) {
    print_result(lights, format, text, !out);
    st = hl_outputs_print(ctx);
  }
  if (st == HL_OK)
    st = hl_outputs_commit(ctx, outputs);
  hl_outputs_end(ctx, outputs);
  free(text);
  hl_lights_free(lights);
  free(lights);
  return st;
}
