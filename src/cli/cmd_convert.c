/* convert: a camera, or lights, from one program's file to another's. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "commands.h"
#include "convert_lights.h"
#include "halflight/halflight.h"
#include "inputs.h"
#include "options.h"
#include "outputs.h"

enum { FORMAT_UNSTATED = -1 };

typedef struct convert_args {
  const char *in, *out;
  int to; /* a camera's format, then those of lights, as kinds[] has them; or FORMAT_UNSTATED */
} convert_args;

#define AT(member) offsetof(convert_args, member)

/* The name of a camera's or, after them, of a lights' format; NULL past the last. */
static const char *format_name(int format)
{
  int cameras = 0;
  while (hl_camera_format_name(cameras))
    cameras++;
  return format < cameras ? hl_camera_format_name(format) : hl_lights_format_name(format - cameras);
}

/* A format's place among its own kind; -1 where it is of the other. */
static int place(int format, bool lights)
{
  int cameras = 0;
  while (hl_camera_format_name(cameras))
    cameras++;
  return lights ? (format >= cameras ? format - cameras : -1) : format < cameras ? format : -1;
}

static const struct {
  const char *ending;
  bool lights;
  int format; /* hl_camera_format or hl_lights_format */
} endings[] = {
    {".json", false, HL_CAMERA_JSON},
    {".yml", false, HL_CAMERA_OPENCV},
    {".yaml", false, HL_CAMERA_KALIBR},
    {".cameramodel", false, HL_CAMERA_MRCAL},
    {".lp", true, HL_LIGHTS_LP},
    {".dome", true, HL_LIGHTS_DOME},
    {".json", true, HL_LIGHTS_ALICEVISION},
    {".usda", true, HL_LIGHTS_USDA},
};

enum { N_ENDINGS = sizeof endings / sizeof endings[0] };

static hl_status parse_to(hl_ctx *ctx, const char *text, void *member)
{
  char known[128] = "";
  for (int i = 0; format_name(i); i++) {
    if (strcmp(text, format_name(i)) == 0) {
      memcpy(member, &i, sizeof i);
      return HL_OK;
    }
    if (i > 0)
      strncat(known, ", ", sizeof known - strlen(known) - 1);
    strncat(known, format_name(i), sizeof known - strlen(known) - 1);
  }
  return hl_fail(ctx, HL_ERR_ARG, "--to '%.40s' is none of: %s", text, known);
}

static const hl_operand operands[] = {
    {"FILE",
     "a camera: CAMERA.json, OpenCV or Kalibr YAML, mrcal .cameramodel; or lights: .lp, relight's "
     ".dome, AliceVision's JSON, lights.json, light.json",
     AT(in), HL_OPERAND_NEEDED},
};

static const hl_option options[] = {
    {"to", "FORMAT", "Output",
     "json, opencv, kalibr or mrcal of a camera; lp, dome, alicevision or usda of lights (default: "
     "by the file's ending: .json, .yml is opencv, .yaml kalibr, .cameramodel mrcal; .lp, .dome, "
     ".json is alicevision, .usda; json or lp on stdout)",
     AT(to), 0, parse_to},
    {"out", "FILE", NULL, "write it there (default: print it on stdout)", AT(out), 0, 0},
};

static void defaults(void *args)
{
  convert_args *a = args;
  a->to = FORMAT_UNSTATED;
}

static hl_status choose_format(hl_ctx *ctx, const convert_args *a, bool lights, int *out)
{
  const size_t n = a->out ? strlen(a->out) : 0;
  *out = a->to == FORMAT_UNSTATED ? 0 : place(a->to, lights);
  if (*out < 0)
    return hl_fail(ctx, HL_ERR_ARG, "%s: %s; --to %s is for %s", a->in,
                   lights ? "lights" : "a camera, or nothing that is known as lights",
                   format_name(a->to), lights ? "a camera" : "lights");
  if (a->to != FORMAT_UNSTATED || !a->out)
    return HL_OK;
  for (int i = 0; i < N_ENDINGS; i++) {
    const size_t m = strlen(endings[i].ending);
    if (endings[i].lights == lights && n > m && strcmp(a->out + n - m, endings[i].ending) == 0) {
      *out = endings[i].format;
      return HL_OK;
    }
  }
  return hl_fail(ctx, HL_ERR_ARG, "--out %.200s: --to, or a name that ends in %s is needed", a->out,
                 lights ? ".lp, .dome, .json or .usda" : ".json, .yml, .yaml or .cameramodel");
}

/* "covariance, rms_px" of what the format has no place for; "" where nothing is lost. */
static void list_lost(const hl_camera *camera, hl_camera_format format, char *out, size_t room)
{
  static const struct {
    hl_camera_part part;
    const char *name;
  } parts[] = {{HL_CAMERA_COVARIANCE, "covariance"},
               {HL_CAMERA_RMS, "rms_px"},
               {HL_CAMERA_OBSERVATIONS, "observations"}};
  const unsigned lost = hl_camera_lost(camera, format);
  size_t n = 0;
  out[0] = '\0';
  for (size_t i = 0; i < sizeof parts / sizeof parts[0]; i++)
    if (lost & parts[i].part && n < room)
      n += (size_t)snprintf(out + n, room - n, "%s%s", n > 0 ? ", " : "", parts[i].name);
}

/* The text on stdout and what it lacks on stderr; or, beside a file, a summary on stdout. */
static void print_result(const convert_args *a, const hl_camera *camera, hl_camera_format format,
                         const char *text)
{
  const char *name = hl_camera_format_name((int)format);
  char lost[64];
  list_lost(camera, format, lost, sizeof lost);
  if (!a->out) {
    fputs(text, stdout);
    if (lost[0])
      fprintf(stderr, "halflight: convert: left out: %s; %s has no place for it\n", lost, name);
    return;
  }
  printf("%-14s%s, %s lens, %d x %d px\n", "camera", name, hl_lens_name((int)camera->model),
         camera->width, camera->height);
  printf("%-14sfx %.7g, fy %.7g, cx %.7g, cy %.7g px\n", "", camera->fx, camera->fy, camera->cx,
         camera->cy);
  if (lost[0])
    printf("%-14s%s: %s has no place for it\n", "left out", lost, name);
}

static hl_status write_and_print(hl_ctx *ctx, const convert_args *a, const hl_camera *camera,
                                 hl_camera_format format, hl_outputs *o)
{
  char *text = NULL;
  int at = 0;
  hl_status st = a->out ? hl_outputs_add(ctx, o, NULL, a->out, &at) : HL_OK;
  if (st == HL_OK)
    st = hl_inputs_blame(ctx, hl_camera_text(ctx, camera, format, &text), a->in);
  if (st == HL_OK)
    st = hl_outputs_begin(ctx, o);
  if (st == HL_OK && a->out)
    st = hl_file_write(ctx, o->stage[at], text, strlen(text));
  if (st == HL_OK) {
    print_result(a, camera, format, text);
    st = hl_outputs_print(ctx);
  }
  if (st == HL_OK)
    st = hl_outputs_commit(ctx, o);
  hl_outputs_end(ctx, o);
  free(text);
  return st;
}

static hl_status run(hl_ctx *ctx, const void *args)
{
  const convert_args *a = args;
  hl_camera camera;
  int format = 0;
  bool lights = false;
  hl_status st = hl_lights_file_is(ctx, a->in, &lights);
  if (st == HL_OK)
    st = choose_format(ctx, a, lights, &format);
  if (st == HL_OK && !lights)
    st = hl_camera_read(ctx, a->in, &camera);
  hl_outputs *o = calloc(1, sizeof *o);
  if (st == HL_OK && !o)
    st = hl_fail(ctx, HL_ERR_MEMORY, "no memory for the run");
  if (st == HL_OK)
    st = lights ? hl_convert_lights(ctx, a->in, (hl_lights_format)format, a->out, o)
                : write_and_print(ctx, a, &camera, (hl_camera_format)format, o);
  free(o);
  return st;
}

const hl_command hl_command_convert = {
    .name = "convert",
    .sentence = "Convert a camera or lights to or from the files of other tools.",
    .operands = operands,
    .n_operands = sizeof operands / sizeof *operands,
    .options = options,
    .n_options = sizeof options / sizeof *options,
    .notes = "Every number of a camera survives. What a format has no place for (a covariance\n"
             "in any but json) is left out and said so. A lens it has no words for is refused:\n"
             "kalibr has fisheye, and pinhole with k3 = 0; mrcal has pinhole and rational;\n"
             "opencv has all, a fisheye with `fisheye_model: 1`.\n\n"
             "Lights are turned into the frame of each tool: lp, dome and usda have x right, y\n"
             "up, z towards the camera; alicevision has x right, y down, z forward. usda is\n"
             "written and not read.\n\n"
             "Exit status: 0 done, 1 failed, 2 wrong usage.",
    .example = "  $ halflight convert camera.json --out camera.yml\n"
               "  camera        opencv, pinhole lens, 160 x 120 px\n"
               "                fx 400, fy 400, cx 79.5, cy 59.5 px",
    .size = sizeof(convert_args),
    .defaults = defaults,
    .run = run,
};
