/* brdf: a fitted reflectance as a table that other viewers and renderers read. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "commands.h"
#include "halflight/halflight.h"
#include "inputs.h"
#include "options.h"
#include "outputs.h"
#include "summary.h"

typedef struct brdf_args {
  const char *reflectance, *out;
  hl_brdf_settings settings;
} brdf_args;

#define AT(member) offsetof(brdf_args, member)

static const hl_operand operands[] = {
    {"REFLECTANCE", "what estimate or fit wrote: LIGHT.json or FIT.json", AT(reflectance),
     HL_OPERAND_NEEDED},
};

static const hl_option options[] = {
    {"out", "NAME.binary", "Output", "the table, in the MERL database's format; always needed",
     AT(out), 0, 0},
    {"irradiance", "E", "Scale", NULL, AT(settings), hl_brdf_fields, 0},
    {"albedo", "A", NULL, NULL, AT(settings), hl_brdf_fields, 0},
};

static void defaults(void *args)
{
  brdf_args *a = args;
  a->settings = hl_brdf_defaults();
}

static void print_summary(const hl_brdf_settings *settings, const hl_brdf_summary *s)
{
  char text[200];
  hl_summary_line(stdout, "table",
                  "90 x 90 x 180 cells over theta_half, theta_diff, phi_diff; BRDF [1/sr] is the "
                  "stored value times 1/1500, 1.15/1500, 1.66/1500");
  snprintf(text, sizeof text, "the light's irradiance is taken as %.6g (%s); a photo does not say",
           s->irradiance, settings->albedo > 0 ? "by --albedo" : "--irradiance");
  hl_summary_line(stdout, "scale", text);
  snprintf(text, sizeof text, "%.4g %.4g %.4g (red, green, blue; light along the normal)",
           s->albedo[0], s->albedo[1], s->albedo[2]);
  hl_summary_line(stdout, "albedo", text);
  hl_summary_notes(stdout, "note", &s->notes);
}

typedef struct brdf_run {
  hl_reflectance reflectance;
  hl_merl merl;
  hl_brdf_summary summary;
  hl_outputs outputs;
  int out_at;
} brdf_run;

static hl_status write_and_print(hl_ctx *ctx, const brdf_args *a, brdf_run *r)
{
  hl_outputs *o = &r->outputs;
  hl_status st = hl_outputs_begin(ctx, o);
  if (st == HL_OK)
    st = hl_merl_write(ctx, o->stage[r->out_at], &r->merl);
  if (st == HL_OK) {
    print_summary(&a->settings, &r->summary);
    st = hl_outputs_print(ctx);
  }
  if (st == HL_OK)
    st = hl_outputs_commit(ctx, o);
  hl_outputs_end(ctx, o);
  return st;
}

static hl_status run(hl_ctx *ctx, const void *args)
{
  const brdf_args *a = args;
  brdf_run *r = calloc(1, sizeof *r);
  if (!r)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for the run");
  hl_status st = HL_OK;
  if (!a->out)
    st = hl_fail(ctx, HL_ERR_ARG, "--out is missing; --out NAME.binary is needed");
  if (st == HL_OK)
    st = hl_outputs_add(ctx, &r->outputs, NULL, a->out, &r->out_at);
  if (st == HL_OK)
    st = hl_reflectance_read(ctx, a->reflectance, &r->reflectance);
  if (st == HL_OK)
    st = hl_inputs_blame(ctx,
                         hl_brdf_table(ctx, &r->reflectance, &a->settings, &r->merl, &r->summary),
                         a->reflectance);
  if (st == HL_OK)
    st = write_and_print(ctx, a, r);
  hl_merl_free(&r->merl);
  free(r);
  return st;
}

const hl_command hl_command_brdf = {
    .name = "brdf",
    .sentence = "Write a fitted reflectance as a BRDF table for other programs.",
    .operands = operands,
    .n_operands = sizeof operands / sizeof *operands,
    .options = options,
    .n_options = sizeof options / sizeof *options,
    .notes = "The table holds the isotropic reciprocal BRDF whose radiance is nearest to the\n"
             "fit's; how near is printed.\n"
             "Exit status: 0 done, 1 failed, 2 wrong usage, 3 no BRDF follows from the fit.",
    .example = "  $ halflight brdf out/light.json --albedo 0.5 --out ball.binary\n"
               "  table         90 x 90 x 180 cells over theta_half, theta_diff, phi_diff; BRDF\n"
               "                [1/sr] is the stored value times 1/1500, 1.15/1500, 1.66/1500\n"
               "  ...",
    .size = sizeof(brdf_args),
    .defaults = defaults,
    .run = run,
};
