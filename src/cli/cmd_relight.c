/* relight: a fitted reflectance under another light, edited where asked for. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <jansson.h>

#include "commands.h"
#include "draw_relit.h"
#include "halflight/halflight.h"
#include "inputs.h"
#include "options.h"
#include "outputs.h"
#include "relight_edits.h"
#include "summary.h"

enum { DEFAULT_RADIUS_PX = 100, SIDE_MAX = 16384 };

typedef struct direction {
  bool given;
  double at[3];
} direction;

typedef struct drawing_settings {
  int sphere_px;
  double white;
} drawing_settings;

typedef struct relight_args {
  const char *reflectance, *normals, *mesh, *camera, *sphere, *compare, *comparison, *out;
  direction light, view;
  int size[2];
  hl_relight_edits edits;
  bool fit_exposure, json;
  drawing_settings drawing;
} relight_args;

#define AT(member) offsetof(relight_args, member)

static const hl_field_table *drawing_fields(void)
{
  static const hl_field fields[] = {
      {"sphere_px", HL_FIELD_INT, offsetof(drawing_settings, sphere_px), 1, 8192, "px",
       "draw a ball of this radius that fills an image of twice that (default where no other "
       "surface is given: 100)",
       NULL},
      {"white", HL_FIELD_DOUBLE, offsetof(drawing_settings, white), 1e-30, 1e31, "",
       "radiance that becomes white in a .png and in the comparison (default: 99.5 % of the "
       "samples lie below it)",
       NULL},
  };
  static const hl_field_table table = {"drawing", fields, 2};
  return &table;
}

static hl_status parse_direction(hl_ctx *ctx, const char *option, const char *text, void *member)
{
  direction d = {.given = true};
  const hl_status st = hl_options_numbers(ctx, option, text, 3, d.at);
  if (st != HL_OK)
    return st;
  const double length = hypot(hypot(d.at[0], d.at[1]), d.at[2]);
  if (!(length > 0 && isfinite(length)))
    return hl_fail(ctx, HL_ERR_ARG, "--%s '%.40s' is no direction; x,y,z not all 0 is needed",
                   option, text);
  for (int i = 0; i < 3; i++)
    d.at[i] /= length;
  memcpy(member, &d, sizeof d);
  return HL_OK;
}

static hl_status parse_light(hl_ctx *ctx, const char *text, void *member)
{
  return parse_direction(ctx, "light", text, member);
}

static hl_status parse_view(hl_ctx *ctx, const char *text, void *member)
{
  return parse_direction(ctx, "view", text, member);
}

static hl_status parse_size(hl_ctx *ctx, const char *text, void *member)
{
  int size[2];
  char rest;
  /* NOLINTNEXTLINE(cert-err34-c): the bounds below catch what overflows */
  if (sscanf(text, "%dx%d%c", &size[0], &size[1], &rest) != 2 || size[0] < 1 || size[1] < 1 ||
      size[0] > SIDE_MAX || size[1] > SIDE_MAX)
    return hl_fail(ctx, HL_ERR_ARG, "--size '%.40s': WIDTHxHEIGHT of 1 to %d px is needed", text,
                   SIDE_MAX);
  memcpy(member, size, sizeof size);
  return HL_OK;
}

static const hl_operand operands[] = {
    {"REFLECTANCE", "what estimate or fit wrote: LIGHT.json or FIT.json", AT(reflectance),
     HL_OPERAND_NEEDED},
};

static const hl_option options[] = {
    {"light", "X,Y,Z", "Light", "direction from the surface to the light; always needed", AT(light),
     0, parse_light},
    {"sphere-px", "R", "Surface", NULL, AT(drawing), drawing_fields, 0},
    {"normals", "N.pfm", NULL, "draw this normal map", AT(normals), 0, 0},
    {"mesh", "M.obj", NULL, "draw this triangle mesh; no shadows are cast", AT(mesh), 0, 0},
    {"size", "WxH", NULL, "image of a mesh (default: 512x512)", AT(size), 0, parse_size},
    {"camera", "CAMERA.json", NULL, "draw a ball as this camera sees it (with --sphere)",
     AT(camera), 0, 0},
    {"sphere", "SPHERE.json", NULL, "that ball's pose", AT(sphere), 0, 0},
    {"view", "X,Y,Z", NULL,
     "direction to the viewer (default: straight from the front); not with --camera", AT(view), 0,
     parse_view},
    {"scale", "TERM=F", "Editing (each as often as wanted, in order)",
     "multiply a term's curve by F", AT(edits), 0, hl_relight_edits_scale},
    {"aim", "TERM=CS,CV", NULL, "aim a term along CS s + CV v", AT(edits), 0, hl_relight_edits_aim},
    {"replace", "TERM=CURVE.csv", NULL, "give a term this curve: rows t,value or t,r,g,b",
     AT(edits), 0, hl_relight_edits_replace},
    {"compare", "IMAGE", "Ground truth", "a photo of the same under that light", AT(compare), 0, 0},
    {"fit-exposure", NULL, NULL, "scale the photo so that it fits best before comparing",
     AT(fit_exposure), 0, 0},
    {"comparison", "FILE", NULL,
     "relit, photo and 3 x their difference side by side: .png, .svg or .pdf", AT(comparison), 0,
     0},
    {"out", "IMAGE", "Output", "the image: .pfm (linear) or .png (8-bit sRGB); always needed",
     AT(out), 0, 0},
    {"white", "W", NULL, NULL, AT(drawing), drawing_fields, 0},
    {"json", NULL, NULL, "print what was done as JSON on stdout and nothing else", AT(json), 0, 0},
};

typedef struct relight_run {
  const relight_args *args;
  hl_reflectance reflectance;
  hl_surface surface;
  hl_frame relit, photo, difference;
  hl_relit_error error;
  double white;
  hl_outputs outputs;
  int out_at, comparison_at; /* -1 = not asked for */
  hl_picture_kind comparison_kind;
} relight_run;

static bool ends_with(const char *text, const char *end)
{
  const size_t n = strlen(text), m = strlen(end);
  return n > m && strcmp(text + n - m, end) == 0;
}

static hl_status check_usage(hl_ctx *ctx, const relight_args *a)
{
  const int surfaces = (a->drawing.sphere_px > 0) + (a->normals != NULL) + (a->mesh != NULL) +
                       (a->camera != NULL || a->sphere != NULL);
  if (!a->light.given)
    return hl_fail(ctx, HL_ERR_ARG, "--light is missing; --light X,Y,Z is needed");
  if (!a->out)
    return hl_fail(ctx, HL_ERR_ARG, "--out is missing; --out IMAGE.pfm or IMAGE.png is needed");
  if (!ends_with(a->out, ".pfm") && !ends_with(a->out, ".png"))
    return hl_fail(ctx, HL_ERR_ARG, "--out %s: a name that ends in .pfm or .png is needed", a->out);
  if (surfaces > 1)
    return hl_fail(ctx, HL_ERR_ARG,
                   "--sphere-px, --normals, --mesh and --camera contradict; one of them says what "
                   "is drawn");
  if (!a->camera != !a->sphere)
    return hl_fail(ctx, HL_ERR_ARG, "--%s is missing; --camera and --sphere go together",
                   a->camera ? "sphere" : "camera");
  if (a->camera && a->view.given)
    return hl_fail(ctx, HL_ERR_ARG,
                   "--view and --camera contradict; the camera says where it looks from");
  if (a->size[0] && !a->mesh)
    return hl_fail(ctx, HL_ERR_ARG, "--size is the image of a --mesh; none is given");
  if (!a->compare && (a->comparison || a->fit_exposure))
    return hl_fail(ctx, HL_ERR_ARG, "--%s needs --compare IMAGE",
                   a->comparison ? "comparison" : "fit-exposure");
  return HL_OK;
}

static hl_status plan_outputs(hl_ctx *ctx, relight_run *r)
{
  const relight_args *a = r->args;
  r->comparison_at = -1;
  hl_status st = hl_outputs_add(ctx, &r->outputs, NULL, a->out, &r->out_at);
  if (st == HL_OK && a->comparison) {
    st = hl_picture_kind_of(ctx, "comparison", a->comparison, &r->comparison_kind);
    if (st == HL_OK)
      st = hl_outputs_add(ctx, &r->outputs, NULL, a->comparison, &r->comparison_at);
  }
  return st;
}

static hl_status normals_of_file(hl_ctx *ctx, const char *path, hl_frame *normals)
{
  hl_frame_settings settings = hl_frame_defaults();
  settings.transfer = HL_TRANSFER_LINEAR;
  return hl_frame_read(ctx, path, &settings, normals);
}

static hl_status normals_of_mesh(hl_ctx *ctx, const relight_args *a, const hl_viewing *viewing,
                                 hl_frame *normals)
{
  hl_mesh mesh = {0};
  hl_status st = hl_mesh_read(ctx, a->mesh, &mesh);
  if (st == HL_OK)
    st = hl_inputs_blame(ctx,
                         hl_normals_of_mesh(ctx, &mesh, viewing, a->size[0] ? a->size[0] : 512,
                                            a->size[0] ? a->size[1] : 512, normals),
                         a->mesh);
  hl_mesh_free(&mesh);
  return st;
}

static const double LEAST_COS_VIEW = 1e-3; /* a drawing shows a surface up to its rim */

static hl_status surface_of_camera(hl_ctx *ctx, relight_run *r)
{
  hl_camera camera;
  hl_sphere sphere;
  hl_status st = HL_OK;
  if (!r->reflectance.camera_frame)
    return hl_fail(ctx, HL_ERR_ARG,
                   "--camera draws in the camera's frame, %s is in that of its samples; "
                   "--sphere-px, --normals or --mesh is needed",
                   r->args->reflectance);
  st = hl_camera_read(ctx, r->args->camera, &camera);
  if (st == HL_OK)
    st = hl_sphere_read(ctx, r->args->sphere, &sphere);
  if (st == HL_OK)
    st = hl_inputs_blame(ctx,
                         hl_surface_of_sphere(ctx, &camera, &sphere, LEAST_COS_VIEW, &r->surface),
                         r->args->sphere);
  return st;
}

static hl_status find_surface(hl_ctx *ctx, relight_run *r)
{
  const relight_args *a = r->args;
  hl_viewing viewing;
  hl_frame normals = {0};
  if (a->camera)
    return surface_of_camera(ctx, r);
  hl_status st = hl_viewing_along(ctx, a->view.given ? a->view.at : NULL,
                                  r->reflectance.camera_frame, &viewing);
  if (st != HL_OK)
    return st;
  if (a->normals)
    st = normals_of_file(ctx, a->normals, &normals);
  else if (a->mesh)
    st = normals_of_mesh(ctx, a, &viewing, &normals);
  else
    st = hl_normals_of_ball(ctx, a->drawing.sphere_px ? a->drawing.sphere_px : DEFAULT_RADIUS_PX,
                            &viewing, &normals);
  if (st == HL_OK)
    st = hl_inputs_blame(
        ctx, hl_surface_of_parallel_view(ctx, &normals, viewing.view, LEAST_COS_VIEW, &r->surface),
        a->normals ? a->normals
        : a->mesh  ? a->mesh
                   : "the ball");
  hl_frame_free(&normals);
  return st;
}

static hl_status compare(hl_ctx *ctx, relight_run *r)
{
  const relight_args *a = r->args;
  if (!a->compare)
    return HL_OK;
  hl_status st = hl_frame_read(ctx, a->compare, NULL, &r->photo);
  if (st == HL_OK)
    st = hl_inputs_blame(ctx,
                         hl_relit_compare(ctx, &r->relit, &r->surface, a->light.at, &r->photo,
                                          a->fit_exposure, &r->error, &r->difference),
                         a->compare);
  return st;
}

static hl_status write_images(hl_ctx *ctx, const relight_run *r)
{
  const hl_outputs *o = &r->outputs;
  hl_status st = HL_OK;
  if (ends_with(r->args->out, ".pfm"))
    st = hl_pfm_write(ctx, o->stage[r->out_at], r->relit.radiance, r->relit.width, r->relit.height,
                      r->relit.channels);
  else
    st = hl_draw_relit(ctx, o->stage[r->out_at], &r->relit, r->white);
  if (st == HL_OK && r->comparison_at >= 0)
    st = hl_draw_comparison(ctx, r->comparison_kind, o->stage[r->comparison_at], &r->relit,
                            &r->photo, &r->difference, &r->error, r->white);
  return st;
}

static json_t *document(const relight_run *r)
{
  const relight_args *a = r->args;
  json_t *notes = json_array();
  for (int i = 0; i < r->reflectance.notes.n; i++)
    json_array_append_new(notes, json_pack("{s:s, s:s}", "what", r->reflectance.notes.note[i].what,
                                           "why", r->reflectance.notes.note[i].why));
  json_t *root =
      json_pack("{s:s, s:i, s:i, s:i, s:i, s:[f, f, f], s:s, s:f, s:o}", "format",
                "halflight-relit", "version", 1, "width", r->relit.width, "height", r->relit.height,
                "pixels", r->surface.n, "light", a->light.at[0], a->light.at[1], a->light.at[2],
                "cast_shadows", "off", "white", r->white, "notes", notes);
  if (root && a->compare)
    json_object_set_new(root, "compared",
                        json_pack("{s:f, s:f, s:f, s:i}", "relative_error", r->error.relative_error,
                                  "rms", r->error.rms, "photo_scale", r->error.scale, "pixels",
                                  r->error.n_pixels));
  return root;
}

static hl_status print_json(hl_ctx *ctx, const relight_run *r)
{
  json_t *root = document(r);
  char *text = root ? json_dumps(root, JSON_INDENT(1)) : NULL;
  json_decref(root);
  if (!text)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for the JSON document");
  puts(text);
  free(text);
  return HL_OK;
}

static void print_summary(const relight_run *r)
{
  char text[200];
  snprintf(text, sizeof text, "%d x %d px, %d of them on the surface, %s", r->relit.width,
           r->relit.height, r->surface.n, "no cast shadows");
  hl_summary_line(stdout, "drawn", text);
  if (ends_with(r->args->out, ".png")) {
    snprintf(text, sizeof text, "radiance %.4g", r->white);
    hl_summary_line(stdout, "white", text);
  }
  if (r->args->compare) {
    snprintf(text, sizeof text, "mean error %.2f %% over %d pixels, photo times %.4g",
             100 * r->error.relative_error, r->error.n_pixels, r->error.scale);
    hl_summary_line(stdout, "compared", text);
  }
  hl_summary_notes(stdout, "note", &r->reflectance.notes);
}

static hl_status draw_and_write(hl_ctx *ctx, relight_run *r)
{
  hl_outputs *o = &r->outputs;
  hl_status st = hl_relight(ctx, &r->reflectance, &r->surface, r->args->light.at, &r->relit);
  if (st == HL_OK)
    st = compare(ctx, r);
  if (st != HL_OK)
    return st;
  r->white =
      r->args->drawing.white > 0 ? r->args->drawing.white : hl_relit_white(&r->relit, &r->surface);
  st = hl_outputs_begin(ctx, o);
  if (st == HL_OK)
    st = write_images(ctx, r);
  if (st == HL_OK && r->args->json)
    st = print_json(ctx, r);
  else if (st == HL_OK)
    print_summary(r);
  if (st == HL_OK)
    st = hl_outputs_print(ctx);
  if (st == HL_OK)
    st = hl_outputs_commit(ctx, o);
  hl_outputs_end(ctx, o);
  return st;
}

static hl_status run(hl_ctx *ctx, const void *args)
{
  relight_run *r = calloc(1, sizeof *r);
  if (!r)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for the run");
  r->args = args;
  hl_status st = check_usage(ctx, r->args);
  if (st == HL_OK)
    st = plan_outputs(ctx, r);
  if (st == HL_OK)
    st = hl_reflectance_read(ctx, r->args->reflectance, &r->reflectance);
  if (st == HL_OK)
    st = hl_relight_edits_apply(ctx, &r->args->edits, &r->reflectance);
  if (st == HL_OK)
    st = find_surface(ctx, r);
  if (st == HL_OK)
    st = draw_and_write(ctx, r);
  hl_frame_free(&r->relit);
  hl_frame_free(&r->photo);
  hl_frame_free(&r->difference);
  hl_surface_free(&r->surface);
  free(r);
  return st;
}

const hl_command hl_command_relight = {
    .name = "relight",
    .sentence = "Draw a fitted reflectance under another light, edited if wanted.",
    .operands = operands,
    .n_operands = sizeof operands / sizeof *operands,
    .options = options,
    .n_options = sizeof options / sizeof *options,
    .notes = "Directions: of a FIT.json in its samples' frame (x right, y up, z to the\n"
             "viewer), of a LIGHT.json in the camera's (x right, y down, z forward).\n"
             "Exit status: 0 done, 1 failed, 2 wrong usage.",
    .example = "  $ halflight relight out/light.json --light=-1,-1,-1 --sphere-px 100 \\\n"
               "      --aim specular=1,0.3 --out relit.png\n"
               "  drawn         200 x 200 px, 31428 of them on the surface, ...\n  ...",
    .size = sizeof(relight_args),
    .run = run,
};
