/* position: where a near light is, from several balls or one ball in several places. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "halflight/halflight.h"
#include "options.h"
#include "outputs.h"
#include "summary.h"

static const double degrees = 180 / 3.14159265358979323846;

typedef struct position_args {
  hl_words files;
  const char *out;
  bool json;
} position_args;

#define AT(member) offsetof(position_args, member)

static const hl_operand operands[] = {
    {"LIGHT.json SPHERE.json",
     "what estimate wrote of a ball, and the pose it had; two pairs or more", AT(files),
     HL_OPERAND_MANY},
};

static const hl_option options[] = {
    {"json", NULL, "Output", "print POSITION.json on stdout and nothing else", AT(json), 0, 0},
    {"out", "POSITION.json", NULL, "write the position there", AT(out), 0, 0},
};

typedef struct position_run {
  const position_args *args;
  hl_sight sight[HL_SIGHTS_MAX];
  const char *name[HL_SIGHTS_MAX];
  hl_position position;
  hl_outputs outputs;
  int out_at; /* place in outputs; -1 = not asked for */
} position_run;

static hl_status plan(hl_ctx *ctx, position_run *r)
{
  const int n = r->args->files.n;
  r->out_at = -1;
  if (n % 2 != 0)
    return hl_fail(ctx, HL_ERR_ARG,
                   "%d files; each LIGHT.json with its SPHERE.json after it is needed", n);
  if (n < 4 || n > 2 * HL_SIGHTS_MAX)
    return hl_fail(ctx, HL_ERR_ARG, "%d pairs of LIGHT.json and SPHERE.json; 2 to %d are needed",
                   n / 2, HL_SIGHTS_MAX);
  return r->args->out ? hl_outputs_add(ctx, &r->outputs, NULL, r->args->out, &r->out_at) : HL_OK;
}

static hl_status read_sights(hl_ctx *ctx, position_run *r)
{
  hl_status st = HL_OK;
  for (int i = 0; st == HL_OK && i < r->args->files.n / 2; i++) {
    const char *const *pair = r->args->files.word + 2 * (size_t)i;
    r->name[i] = pair[0];
    st = hl_sight_read(ctx, pair[0], pair[1], &r->sight[i]);
  }
  return st;
}

static void print_distance(const hl_position *p)
{
  char text[160];
  if (p->found)
    snprintf(text, sizeof text, "%.4g m from the balls' middle, 95 %% within %.4g and %.4g m",
             p->distance_m, p->distance_95_m[0], p->distance_95_m[1]);
  else if (p->least_distance_m < HUGE_VAL)
    snprintf(text, sizeof text, "at least %.4g m from the balls' middle (95 %%)",
             p->least_distance_m);
  else
    snprintf(text, sizeof text, "none");
  hl_summary_line(stdout, "distance", text);
}

static void print_summary(const position_run *r)
{
  const hl_position *p = &r->position;
  char text[160];
  if (p->found) {
    snprintf(text, sizeof text, "(%.6g, %.6g, %.6g) m, +- (%.2g, %.2g, %.2g)", p->position_m[0],
             p->position_m[1], p->position_m[2], sqrt(p->covariance_m2[0][0]),
             sqrt(p->covariance_m2[1][1]), sqrt(p->covariance_m2[2][2]));
    hl_summary_line(stdout, "position", text);
  }
  print_distance(p);
  for (int i = 0; i < p->n; i++) {
    snprintf(text, sizeof text, "%.60s: %.3g deg off, chi-squared %.3g%s", r->name[i],
             degrees * p->sight[i].off_rad, p->sight[i].chi_squared,
             p->sight[i].used ? "" : ", left out");
    hl_summary_line(stdout, i == 0 ? "sights" : "", text);
  }
  if (p->dof > 0) {
    snprintf(text, sizeof text, "chi-squared %.3g on %d degrees of freedom, probability %.2g",
             p->chi_squared, p->dof, p->probability);
    hl_summary_line(stdout, "agreement", text);
  }
  hl_summary_notes(stdout, "not trusted", &p->reasons);
}

static hl_status write_and_print(hl_ctx *ctx, position_run *r)
{
  hl_outputs *o = &r->outputs;
  char *text = NULL;
  hl_status st = hl_position_json(ctx, &r->position, r->name, &text);
  if (st == HL_OK)
    st = hl_outputs_begin(ctx, o);
  if (st == HL_OK && r->args->out)
    st = hl_file_write(ctx, o->stage[r->out_at], text, strlen(text));
  if (st == HL_OK) {
    if (r->args->json)
      fputs(text, stdout);
    else
      print_summary(r);
    st = hl_outputs_print(ctx);
  }
  if (st == HL_OK)
    st = hl_outputs_commit(ctx, o);
  hl_outputs_end(ctx, o);
  free(text);
  return st;
}

/* An answer that is not to be trusted is written all the same, with the verdict in it. */
static hl_status solve(hl_ctx *ctx, position_run *r)
{
  hl_ctx inner = {0};
  const hl_status verdict =
      hl_position_of_sights(&inner, r->sight, r->args->files.n / 2, &r->position);
  if (verdict != HL_OK && verdict != HL_ERR_DEGENERATE)
    return hl_fail(ctx, verdict, "%s", inner.msg);
  const hl_status st = write_and_print(ctx, r);
  if (st != HL_OK)
    return st;
  if (verdict != HL_OK)
    return hl_fail(ctx, verdict, "%s", inner.msg);
  if (r->position.trusted)
    return HL_OK;
  char why[HL_MESSAGE_MAX];
  hl_summary_reasons(&r->position.reasons, why, sizeof why);
  return hl_fail(ctx, HL_ERR_RESIDUAL, "not to be trusted: %s", why);
}

static hl_status run(hl_ctx *ctx, const void *args)
{
  position_run *r = calloc(1, sizeof *r);
  if (!r)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for the run");
  r->args = args;
  hl_status st = plan(ctx, r);
  if (st == HL_OK)
    st = read_sights(ctx, r);
  if (st == HL_OK)
    st = solve(ctx, r);
  free(r);
  return st;
}

const hl_command hl_command_position = {
    .name = "position",
    .sentence = "Place a near light by the directions that several balls show.",
    .operands = operands,
    .n_operands = sizeof operands / sizeof *operands,
    .options = options,
    .n_options = sizeof options / sizeof *options,
    .notes = "Several balls in one frame, or one ball in several places; the camera stays.\n"
             "Where an estimate placed the light near, its direction is from the ball's\n"
             "centre; else from the highlight, with half the ball's radius of doubt. Estimate\n"
             "with --with near where the light is known to be.\n\n"
             "Exit status: 0 done, 1 failed, 2 wrong usage, 3 not to be trusted (too far, or\n"
             "the balls contradict each other).",
    .example = "  $ halflight position left-light.json left.json right-light.json right.json\n"
               "  position      (0, 0, -0.4) m, +- (0.00077, 0.00074, 0.0026)\n"
               "  distance      1 m from the balls' middle, 95 % within 0.995 and 1.005 m\n"
               "  ...",
    .size = sizeof(position_args),
    .run = run,
};
