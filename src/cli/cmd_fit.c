/* fit: samples of a curved surface to curves along directions, and what they may claim. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "commands.h"
#include "draw.h"
#include "evidence_charts.h"
#include "halflight/halflight.h"
#include "inputs.h"
#include "options.h"
#include "outputs.h"
#include "summary.h"

typedef struct vectors {
  int n;
  double v[3 * HL_TERMS_MAX];
} vectors;

typedef struct fit_args {
  const char *samples, *model, *out, *plot;
  vectors light, directions;
  bool json, free_curves;
  hl_fit_settings settings;
} fit_args;

#define AT(member) offsetof(fit_args, member)

static hl_status parse_light(hl_ctx *ctx, const char *text, void *member)
{
  vectors *light = member;
  light->n = 1;
  return hl_options_numbers(ctx, "light", text, 3, light->v);
}

/* x,y,z;x,y,z */
static hl_status parse_directions(hl_ctx *ctx, const char *text, void *member)
{
  vectors out = {0};
  for (const char *at = text; at;) {
    char one[120];
    const size_t length = strcspn(at, ";");
    if (length >= sizeof one || out.n >= HL_TERMS_MAX)
      return hl_fail(ctx, HL_ERR_ARG, "--directions '%.40s': 1 to %d of x,y,z with ; between", text,
                     HL_TERMS_MAX);
    memcpy(one, at, length);
    one[length] = '\0';
    const hl_status st = hl_options_numbers(ctx, "directions", one, 3, out.v + 3 * (size_t)out.n);
    if (st != HL_OK)
      return st;
    out.n++;
    at = at[length] ? at + length + 1 : NULL;
  }
  memcpy(member, &out, sizeof out);
  return HL_OK;
}

static const hl_operand operands[] = {
    {"SAMPLES.csv", "columns nx,ny,nz,value or nx,ny,nz,r,g,b, with vx,vy,vz or without",
     AT(samples), HL_OPERAND_NEEDED},
};

static const hl_option options[] = {
    {"model", "MODEL", "Model",
     "ridge (one curve), dichromatic (a linear part and a lobe), additive (curves along known "
     "directions), pursuit (along unknown ones), or to compare with torrance-sparrow, blinn-phong",
     AT(model), 0, 0},
    {"light", "X,Y,Z", NULL, "direction towards the light, where it is known", AT(light), 0,
     parse_light},
    {"directions", "X,Y,Z;X,Y,Z", NULL,
     "of an additive model (default: the light and the half vector)", AT(directions), 0,
     parse_directions},
    {"terms", "K", NULL, NULL, AT(settings), hl_fit_fields, 0},
    {"max-terms", "M", NULL, NULL, AT(settings), hl_fit_fields, 0},
    {"lobe", "auto|plain|foreshortened", NULL, NULL, AT(settings), hl_fit_fields, 0},
    {"domain", "linear|log", NULL, NULL, AT(settings), hl_fit_fields, 0},
    {"smoother", "spline|loess", "Curves", NULL, AT(settings), hl_fit_fields, 0},
    {"free-curves", NULL, NULL, "curves need be neither monotone nor non-negative nor through zero",
     AT(free_curves), 0, 0},
    {"starts", "N", "Search", NULL, AT(settings), hl_fit_fields, 0},
    {"seed", "N", NULL, NULL, AT(settings), hl_fit_fields, 0},
    {"folds", "N", NULL, NULL, AT(settings), hl_fit_fields, 0},
    {"threads", "N", NULL, NULL, AT(settings), hl_fit_fields, 0},
    {"json", NULL, "Output", "print FIT.json on stdout and nothing else", AT(json), 0, 0},
    {"out", "FIT.json|DIR/", NULL,
     "write the fit there, or fit.json and what `report` shows into a folder", AT(out), 0, 0},
    {"plot", "FILE", NULL, "curves among their data: .png, .svg or .pdf", AT(plot), 0, 0},
};

static void defaults(void *args)
{
  fit_args *a = args;
  a->settings = hl_fit_defaults();
}

typedef struct fit_run {
  const fit_args *args;
  hl_fit_model model;
  hl_fit_settings settings;
  hl_samples samples;
  hl_fit fit;
  hl_outputs outputs;
  int fit_at, plot_at, evidence_at; /* places in outputs; -1 = not asked for */
  hl_picture_kind plot_kind;
} fit_run;

static hl_status read_model(hl_ctx *ctx, const char *text, hl_fit_model *out)
{
  static const char *const names[] = {"ridge",   "dichromatic",      "additive",
                                      "pursuit", "torrance-sparrow", "blinn-phong"};
  const int n = (int)(sizeof names / sizeof *names);
  if (!text)
    return hl_fail(ctx, HL_ERR_ARG,
                   "--model is missing; --model ridge, dichromatic, additive or pursuit is needed");
  for (int i = 0; i < n; i++)
    if (strcmp(text, names[i]) == 0) {
      *out = (hl_fit_model)i;
      return HL_OK;
    }
  const char *near = hl_options_nearest(text, names, n);
  if (near)
    return hl_fail(ctx, HL_ERR_ARG, "--model '%.40s' is unknown; did you mean '%s'?", text, near);
  return hl_fail(ctx, HL_ERR_ARG,
                 "--model '%.40s' is none of ridge, dichromatic, additive, pursuit, "
                 "torrance-sparrow, blinn-phong",
                 text);
}

static bool is_parametric(hl_fit_model model)
{
  return model == HL_FIT_TORRANCE_SPARROW || model == HL_FIT_BLINN_PHONG;
}

static hl_status plan(hl_ctx *ctx, fit_run *r)
{
  const fit_args *a = r->args;
  r->fit_at = r->plot_at = r->evidence_at = -1;
  r->settings = a->settings;
  r->settings.free_curves = a->free_curves;
  hl_status st = read_model(ctx, a->model, &r->model);
  if (st == HL_OK && r->model == HL_FIT_ADDITIVE && a->directions.n == 0 && a->light.n == 0)
    st = hl_fail(ctx, HL_ERR_ARG,
                 "--model additive needs --directions X,Y,Z;X,Y,Z, or --light for s and h");
  if (st == HL_OK && is_parametric(r->model) && a->light.n == 0)
    st = hl_fail(ctx, HL_ERR_ARG,
                 "--model %s needs --light X,Y,Z: its lobe is about the half vector", a->model);
  if (st == HL_OK && r->model != HL_FIT_ADDITIVE && a->directions.n > 0)
    st = hl_fail(ctx, HL_ERR_ARG,
                 "--directions and --model %s contradict; it is the additive model that takes "
                 "directions",
                 a->model);
  if (st == HL_OK && a->out)
    st = hl_outputs_document(ctx, &r->outputs, a->out, "fit.json", &r->fit_at, &r->evidence_at);
  if (st == HL_OK && a->plot) {
    st = hl_picture_kind_of(ctx, "plot", a->plot, &r->plot_kind);
    if (st == HL_OK)
      st = hl_outputs_add(ctx, &r->outputs, NULL, a->plot, &r->plot_at);
  }
  return st;
}

static hl_status fit_samples(hl_ctx *ctx, fit_run *r)
{
  const fit_args *a = r->args;
  const hl_fit_known known = {a->light.n > 0 ? a->light.v : NULL, a->directions.n,
                              a->directions.n > 0 ? a->directions.v : NULL};
  const double start = hl_inputs_clock_ms();
  hl_status st = hl_samples_read(ctx, a->samples, &r->samples);
  const double read = hl_inputs_clock_ms();
  if (st != HL_OK)
    return st;
  st = is_parametric(r->model)
           ? hl_fit_parametric(ctx, &r->samples, r->model, a->light.v, &r->fit)
           : hl_fit_samples(ctx, &r->samples, r->model, &known, &r->settings, &r->fit);
  r->fit.read_ms = read - start;
  r->fit.estimate_ms = hl_inputs_clock_ms() - read;
  return hl_inputs_blame(ctx, st, a->samples);
}

static hl_status print_result(hl_ctx *ctx, const fit_run *r)
{
  if (!r->args->json) {
    hl_summary_fit(stdout, &r->fit);
    return HL_OK;
  }
  char *text = NULL;
  const hl_status st = hl_fit_json(ctx, &r->fit, &text);
  if (st == HL_OK)
    fputs(text, stdout);
  free(text);
  return st;
}

static hl_status write_fit(hl_ctx *ctx, const fit_run *r)
{
  char *text = NULL;
  hl_status st = hl_fit_json(ctx, &r->fit, &text);
  if (st == HL_OK)
    st = hl_file_write(ctx, r->outputs.stage[r->fit_at], text, strlen(text));
  free(text);
  return st;
}

/* Text that stdout does not take leaves no files. */
static hl_status write_and_print(hl_ctx *ctx, fit_run *r)
{
  hl_outputs *o = &r->outputs;
  hl_status st = hl_outputs_begin(ctx, o);
  if (st == HL_OK && r->fit_at >= 0)
    st = write_fit(ctx, r);
  if (st == HL_OK && r->plot_at >= 0)
    st = hl_draw_fit(ctx, r->plot_kind, o->stage[r->plot_at], &r->fit, &r->samples);
  if (st == HL_OK && r->evidence_at >= 0)
    st = hl_evidence_of_fit(ctx, o->stage[r->evidence_at], &r->fit, &r->samples);
  if (st == HL_OK)
    st = print_result(ctx, r);
  if (st == HL_OK)
    st = hl_outputs_print(ctx);
  if (st == HL_OK)
    st = hl_outputs_commit(ctx, o);
  hl_outputs_end(ctx, o);
  return st;
}

/* The samples were read but determine no fit: the document says so and why. */
static hl_status report_nothing(hl_ctx *ctx, fit_run *r, hl_status why)
{
  hl_fit *fit = &r->fit;
  char text[HL_MESSAGE_MAX];
  snprintf(text, sizeof text, "%s", ctx->msg);
  memset(fit, 0, sizeof *fit);
  fit->model = r->model;
  fit->channels = r->samples.channels;
  fit->view[2] = 1;
  fit->verdict = HL_NOT_GUARANTEED;
  fit->relative_error = fit->unexplained_variance = fit->condition = NAN;
  fit->coplanarity = fit->direction_sigma_rad = NAN;
  fit->reasons.n = 1;
  snprintf(fit->reasons.note[0].what, sizeof fit->reasons.note[0].what, "no fit");
  snprintf(fit->reasons.note[0].why, HL_NOTE_TEXT_MAX, "%.*s", HL_NOTE_TEXT_MAX - 1, text);
  const hl_status st = r->args->json ? print_result(ctx, r) : HL_OK;
  return st == HL_OK ? hl_fail(ctx, why, "%s", text) : st;
}

static hl_status report(hl_ctx *ctx, fit_run *r)
{
  const hl_status st = write_and_print(ctx, r);
  if (st != HL_OK || r->fit.trusted)
    return st;
  char reasons[HL_MESSAGE_MAX];
  hl_summary_reasons(&r->fit.reasons, reasons, sizeof reasons);
  return hl_fail(ctx, HL_ERR_RESIDUAL, "%s: not to be trusted: %s", r->args->samples, reasons);
}

static hl_status run(hl_ctx *ctx, const void *args)
{
  fit_run *r = calloc(1, sizeof *r);
  if (!r)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for the run");
  r->args = args;
  hl_status st = plan(ctx, r);
  if (st == HL_OK) {
    st = fit_samples(ctx, r);
    if (st == HL_OK)
      st = report(ctx, r);
    else if (st == HL_ERR_DEGENERATE)
      st = report_nothing(ctx, r, st);
  }
  hl_samples_free(&r->samples);
  free(r);
  return st;
}

const hl_command hl_command_fit = {
    .name = "fit",
    .sentence = "Fit reflectance as curves along directions, and judge the answer.",
    .operands = operands,
    .n_operands = sizeof operands / sizeof *operands,
    .options = options,
    .n_options = sizeof options / sizeof *options,
    .notes = "Directions are in the samples' frame; a curve's argument is the cosine a.n.\n"
             "Exit status: 0 done, 1 failed, 2 wrong usage, 3 the answer is not to be trusted.",
    .example = "  $ halflight fit samples.csv --model dichromatic --light 1,1,1 \\\n"
               "      --out fit.json --plot curves.png\n"
               "  light          0.577350  0.577350  0.577350  given\n"
               "  terms          0.577350  0.577350  0.577350  linear about s\n"
               "                strength 1 0.5 0.2, gain 32.6 % of the variance\n"
               "                 0.325058  0.325058  0.888074  lobe about h\n"
               "                strength 0.9903 0.9903 0.9903, gain 21.5 % of the variance\n"
               "  ...",
    .size = sizeof(fit_args),
    .defaults = defaults,
    .run = run,
};
