/* The cases, each one number away from a plain scene: a ball of 40 px radius with a lobe of 12
 * degrees, lit 45 degrees from the view, half a percent of noise. Seeds are fixed and each case is
 * worked on by one thread, so that the table is the same for any number of them. */
#include "bench_stability.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "halflight/vec3.h"

static const double DEGREES = 180 / 3.14159265358979323846;
static const double MOST_DEVIATIONS = 5;
static const double MARGIN_DEG = 0.2;
static const double LEAST_OK = 0.8;
static const double FAST_MOST_PX = 100;

static hl_bench_ball plain(const char *group, double value, bool determinable)
{
  return (hl_bench_ball){.group = group,
                         .value = value,
                         .determinable = determinable,
                         .lobe = HL_BENCH_GGX,
                         .lobe_deg = 12,
                         .radius_px = 40,
                         .light_deg = 45,
                         .gloss = 0.8,
                         .scale = 1,
                         .noise = 0.005,
                         .focal_px = 1000};
}

/* Cases of a group that varies one member; `from` .. `to` are the places in `values` of those that
 * determine the light. */
#define VARY(name, member, from, to, ...)                                                          \
  do {                                                                                             \
    static const double values[] = {__VA_ARGS__};                                                  \
    for (int k = 0; k < (int)(sizeof values / sizeof *values); k++) {                              \
      hl_bench_ball b = plain(name, values[k], k >= (from) && k <= (to));                          \
      b.member = values[k];                                                                        \
      list[n++] = b;                                                                               \
    }                                                                                              \
  } while (0)

static int list_scenes(hl_bench_ball *list)
{
  int n = 0;
  VARY("lobe width [deg]", lobe_deg, 0, 99, 0.05, 0.2, 1, 4, 12, 25, 40, 57);
  VARY("ball radius [px]", radius_px, 1, 99, 6, 10, 20, 80, 200, 600, 2000);
  VARY("light from view [deg]", light_deg, 1, 7, 0, 5, 15, 30, 60, 90, 105, 120, 135, 150);
  VARY("lobe over body", gloss, 0, 99, 0.4, 4, 4e1, 4e3, 4e5, 4e7);
  VARY("focal length [px]", focal_px, 0, 99, 100, 300, 1e4, 1e5, 1e6);
  static const hl_bench_lobe shapes[] = {HL_BENCH_MATTE, HL_BENCH_LINEAR, HL_BENCH_QUADRATIC};
  static const char *const names[] = {"no lobe", "lobe exactly linear", "lobe exactly quadratic"};
  for (int k = 0; k < 3; k++) {
    hl_bench_ball b = plain(names[k], k, k == 0);
    b.lobe = shapes[k];
    list[n++] = b;
  }
  hl_bench_ball corner = plain("frame's corner, k1 = -0.25", -0.25, true);
  corner.corner = true;
  list[n++] = corner;
  return n;
}

static int list_sensors(hl_bench_ball *list)
{
  int n = 0;
  VARY("radiance scale", scale, 1, 6, 1e-41, 1e-30, 1e-20, 1e-10, 1e10, 1e20, 1e30);
  VARY("noise [of body]", noise, 0, 4, 0, 1e-4, 0.01, 0.03, 0.1, 0.3);
  VARY("clipped [of lobe]", clipped, 0, 2, 0.1, 0.25, 0.5, 0.75, 0.95);
  static const int bits[] = {1, 2, 4, 6, 8, 10, 12, 16};
  for (int k = 0; k < 8; k++) {
    hl_bench_ball b = plain("bits", bits[k], bits[k] >= 6);
    b.bits = bits[k];
    list[n++] = b;
  }
  hl_bench_ball cut = plain("bits, cut at black", 12, true);
  cut.bits = 12;
  cut.cut = true;
  list[n++] = cut;
  hl_bench_ball dead = plain("channels dead", 1, true);
  dead.flaw = HL_BENCH_DEAD;
  list[n++] = dead;
  static const char *const names[] = {"label [of ball]", "dust [of ball]", "second light"};
  static const double shares[] = {0.05, 0.3};
  for (int f = 0; f < 3; f++)
    for (int k = 0; k < (f < 2 ? 2 : 1); k++) {
      hl_bench_ball b = plain(names[f], f < 2 ? shares[k] : 0.33, f < 2);
      b.flaw = (hl_bench_flaw)(HL_BENCH_LABEL + f);
      b.share = shares[k];
      list[n++] = b;
    }
  return n;
}

/* Error, alone and in deviations that the answer states along it. */
static void judge(const double truth[3], const hl_light *light, hl_stability *out)
{
  double cross[3];
  hl_cross(truth, light->direction, cross);
  const double error = atan2(hl_norm(cross), hl_dot(truth, light->direction));
  const double(*c)[2] = light->covariance_rad2;
  const double x = hl_dot(truth, light->tangent_basis[0]),
               y = hl_dot(truth, light->tangent_basis[1]);
  const double determinant = c[0][0] * c[1][1] - c[0][1] * c[1][0];
  const double square = (c[1][1] * x * x - 2 * c[0][1] * x * y + c[0][0] * y * y) / determinant;
  out->error_deg = error * DEGREES;
  out->deviations = determinant > 0 ? sqrt(square) : HUGE_VAL;
  out->condition = light->condition;
  out->iterations = light->iterations;
  out->verdict = light->trusted ? HL_VERDICT_OK : HL_VERDICT_UNTRUSTED;
  out->broken = !isfinite(error) || (light->trusted && !isfinite(out->deviations));
  if (!light->trusted && light->reasons.n > 0)
    memcpy(out->reason, light->reasons.note[0].why, sizeof out->reason);
}

static hl_status run_case(hl_ctx *ctx, hl_stability *out)
{
  hl_frame frame = {0};
  hl_surface surface = {0};
  hl_light_work *work = NULL;
  double truth[3];
  hl_light *light = calloc(1, sizeof *light);
  if (!light)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for a light");
  hl_light_settings settings = hl_light_defaults();
  settings.threads = 1;
  hl_status st = hl_bench_ball_draw(ctx, &out->ball, out->seed, &frame, &surface, truth);
  if (st == HL_OK)
    st = hl_light_work_new(ctx, surface.n, frame.channels, &work);
  if (st == HL_OK)
    st = hl_light_estimate(ctx, work, &frame, &surface, &settings, light);
  out->status = st;
  out->verdict = HL_VERDICT_REFUSED;
  if (st == HL_OK)
    judge(truth, light, out);
  else if (ctx)
    memcpy(out->reason, ctx->msg, sizeof out->reason - 1);
  hl_light_work_free(work);
  hl_frame_free(&frame);
  hl_surface_free(&surface);
  free(light);
  return st == HL_ERR_MEMORY ? st : HL_OK;
}

hl_status hl_stability_run(hl_ctx *ctx, bool fast, hl_stability *out, int *n)
{
  hl_bench_ball list[HL_STABILITY_MAX];
  int listed = list_scenes(list);
  listed += list_sensors(list + listed);
  *n = 0;
  for (int i = 0; i < listed; i++)
    if (!fast || list[i].radius_px <= FAST_MOST_PX)
      out[(*n)++] = (hl_stability){.ball = list[i], .seed = (uint64_t)i + 1};
  const int total = *n;
  int lacking = 0;
#ifdef _OPENMP
#pragma omp parallel for schedule(dynamic, 1) reduction(+ : lacking)
#endif
  for (int i = 0; i < total; i++) {
    hl_ctx own = {0};
    lacking += run_case(&own, out + i) != HL_OK;
  }
  return lacking ? hl_fail(ctx, HL_ERR_MEMORY, "no memory for %d of %d cases", lacking, total)
                 : HL_OK;
}

/* ---- what is said of them ---- */

typedef struct tally {
  int verdict[3], determinable, determinable_ok, wrong, broken;
  double most;
  const hl_stability *worst;
} tally;

static tally count(const hl_stability *cases, int n)
{
  tally t = {0};
  for (int i = 0; i < n; i++) {
    const hl_stability *c = cases + i;
    const bool ok = c->verdict == HL_VERDICT_OK;
    t.verdict[c->verdict]++;
    t.broken += c->broken;
    t.determinable += c->ball.determinable;
    t.determinable_ok += c->ball.determinable && ok;
    if (!ok)
      continue;
    const double allowed = MOST_DEVIATIONS * c->error_deg / c->deviations + MARGIN_DEG;
    if (c->error_deg > allowed) {
      t.wrong++;
      if (!t.worst || c->error_deg > t.worst->error_deg)
        t.worst = c;
    }
    t.most = fmax(t.most, c->deviations);
  }
  return t;
}

/* Whether large balls are among them. */
static bool whole(const hl_stability *cases, int n)
{
  for (int i = 0; i < n; i++)
    if (cases[i].ball.radius_px > FAST_MOST_PX)
      return true;
  return false;
}

void hl_stability_print(FILE *out, const hl_stability *cases, int n)
{
  static const char *const verdicts[] = {"ok", "untrusted", "refused"};
  const tally t = count(cases, n);
  fprintf(out,
          "# Stability\n\n"
          "Printed by `halflight bench --stability%s`.\n\n"
          "%d cases: %d ok, %d untrusted, %d refused; of %d determinable ones %d are ok; largest "
          "error of an ok answer %.1f of its own deviations; %d beyond %g deviations plus %g "
          "deg.\n\n"
          "| Varied | Value | Determinable | Status | Error [deg] | Deviations | Condition | "
          "Iterations | First reason |\n|---|---|---|---|---|---|---|---|---|\n",
          whole(cases, n) ? "" : " --fast", n, t.verdict[0], t.verdict[1], t.verdict[2],
          t.determinable, t.determinable_ok, t.most, t.wrong, MOST_DEVIATIONS, MARGIN_DEG);
  for (int i = 0; i < n; i++) {
    const hl_stability *c = cases + i;
    fprintf(out, "| %s | %g | %s | %s | ", c->ball.group, c->ball.value,
            c->ball.determinable ? "yes" : "no", verdicts[c->verdict]);
    if (c->verdict == HL_VERDICT_REFUSED)
      fprintf(out, "| | | | %s |\n", c->reason);
    else
      fprintf(out, "%.4f | %.2f | %.3g | %d | %s |\n", c->error_deg, c->deviations, c->condition,
              c->iterations, c->reason);
  }
}

hl_status hl_stability_check(hl_ctx *ctx, const hl_stability *cases, int n)
{
  const tally t = count(cases, n);
  if (t.broken)
    return hl_fail(ctx, HL_ERR_RESIDUAL, "%d of %d cases give a number that is none", t.broken, n);
  if (t.wrong)
    return hl_fail(
        ctx, HL_ERR_RESIDUAL,
        "%d answers called ok are off by more than %g deviations plus %g deg, worst '%s' "
        "%g by %.3g deg",
        t.wrong, MOST_DEVIATIONS, MARGIN_DEG, t.worst->ball.group, t.worst->ball.value,
        t.worst->error_deg);
  if (t.determinable_ok < LEAST_OK * t.determinable)
    return hl_fail(ctx, HL_ERR_RESIDUAL, "%d of %d determinable cases are called ok; %g %% needed",
                   t.determinable_ok, t.determinable, 100 * LEAST_OK);
  return HL_OK;
}
