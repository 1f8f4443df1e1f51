/* How much work an estimate is: samples, directions, terms; within a time where one is given.
 *
 * Without a budget everything here follows from the settings and the number of pixels. With one, the
 * look around the sphere of lights, whose passes are counted, is timed, and that tells what a pass over
 * a sample takes on this machine now. Of the stages that follow it is known how many passes they take
 * (passes_of, measured on recorded frames); the richest is chosen that the time left allows on a useful
 * number of cells. All pixels are refined in the end if the time left allows that, too. Where the budget
 * is short of what it takes to go over all pixels a few times, only some are gathered (light_gather.c).
 *
 * What cannot be had in less time than it takes, a few hundred samples and the leanest stage, is worked out
 * all the same, and the answer says that the budget was not held.
 */
#include "light_budget.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "halflight/notes.h"

enum { COARSE = 500, DIRECTIONS = 120, CELLS = 2500, LEAST_CELLS = 400, FEW = 1000 };
/* Within less than the stated time, coarse samples, directions and candidates are fewer. */
static const struct {
  double below_ms;
  int coarse, directions, candidates;
} looks[] = {{4, 120, 24, 1}, {12, 160, 40, 1}, {100, 300, 72, 2}};
enum { LOOKS = sizeof looks / sizeof *looks };
static const double thinned_share = 0.9; /* of the pixels, that must count */
static const double usable = 0.85;       /* of the time: what is timed varies */
/* Below so much time a pixel, gathering and blocks of all would take most of it. */
static const double whole_ms = 8e-4;
static const double glanced_a_ms = 250; /* pixels gathered then, for each ms */
enum { LEAST_GLANCED = 240 };

/* Stages of settling, richest first: what is not tried, passes over each sample for one channel (more
 * channels share part of them), and samples below which a leaner one is the better use of the time. */
typedef struct stage {
  unsigned without;
  bool hurried;
  double passes;
  int least;
} stage;

#define BIT(term) (1U << (term))
#define FAR (BIT(HL_LIGHT_NEAR) | BIT(HL_LIGHT_BACKSCATTER))
#define LEAN (FAR | BIT(HL_LIGHT_COLORED_LOBE) | BIT(HL_LIGHT_AMBIENT) | BIT(HL_LIGHT_OUTLIERS))
static const stage stages[] = {
    {0, false, 200, 1200},
    {FAR, false, 160, 900},
    {FAR | BIT(HL_LIGHT_COLORED_LOBE), false, 130, 600},
    {LEAN, false, 80, 500},
    {LEAN | BIT(HL_LIGHT_BENDS), true, 30, 0},
};
enum { STAGES = sizeof stages / sizeof *stages };
static const double finish_passes = 8;
static const double several_channels = 2; /* times the time of one */

/* Whether a line of left_out is about one of the terms. */
static bool is_of(unsigned terms, const char *what)
{
  if (terms & BIT(HL_LIGHT_BENDS) && strcmp(what, "masking and bent body") == 0)
    return true;
  if (terms & BIT(HL_LIGHT_OUTLIERS) && strcmp(what, "outlier rejection") == 0)
    return true;
  for (int i = 0; i < HL_LIGHT_TERMS; i++)
    if (terms & BIT(i) && strcmp(what, hl_light_term_name((hl_light_term)i)) == 0)
      return true;
  return false;
}

static double now_ms(void)
{
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
}

void hl_light_plan_start(const hl_light_settings *settings, int pixels, hl_light_plan *plan)
{
  memset(plan, 0, sizeof *plan);
  plan->budget_ms = settings->budget_ms;
  plan->surface = pixels;
  if (!(plan->budget_ms > 0))
    return;
  plan->started_ms = now_ms();
  const double glanced = fmax(LEAST_GLANCED, glanced_a_ms * plan->budget_ms);
  if (plan->budget_ms < whole_ms * pixels && glanced < pixels)
    plan->gathered = (int)glanced;
}

static double left_ms(const hl_light_plan *plan)
{
  return usable * plan->budget_ms - (now_ms() - plan->started_ms);
}

void hl_light_plan_look(const hl_light_settings *settings, int pixels, hl_light_plan *plan)
{
  const double budget = plan->budget_ms;
  const int most = settings->pixels > 0 && settings->pixels < pixels ? settings->pixels : pixels;
  plan->pixels = pixels;
  plan->coarse = COARSE;
  plan->directions = DIRECTIONS;
  plan->candidates = HL_CANDIDATES;
  for (int i = LOOKS - 1; i >= 0; i--)
    if (budget > 0 && budget < looks[i].below_ms) {
      plan->coarse = looks[i].coarse;
      plan->directions = looks[i].directions;
      plan->candidates = looks[i].candidates;
    }
  if (budget <= 0 && most <= FEW) { /* a look in proportion */
    plan->coarse = 300;
    plan->directions = 72;
  }
  plan->coarse = plan->coarse < most ? plan->coarse : most;
  plan->cells = most;
  plan->finish = settings->pixels == 0 && pixels > 2 * CELLS;
  if (plan->finish)
    plan->cells = CELLS;
  plan->looked_ms = budget > 0 ? now_ms() : 0;
}

void hl_light_plan_settle(int passes, int channels, hl_light_plan *plan, hl_light_settings *own)
{
  if (!(plan->budget_ms > 0))
    return;
  const double took = now_ms() - plan->looked_ms;
  const double left = left_ms(plan);
  plan->pass_ms = (channels > 1 ? several_channels : 1) * took / ((double)passes * plan->coarse);
  int at = 0;
  double affordable = 0;
  for (; at < STAGES; at++) {
    affordable = left / (plan->pass_ms * stages[at].passes);
    if (affordable >= (stages[at].least < plan->cells ? stages[at].least : plan->cells))
      break;
  }
  at = at < STAGES ? at : STAGES - 1;
  affordable = fmax(affordable, plan->gathered > 0 ? LEAST_GLANCED : LEAST_CELLS);
  if (affordable < plan->cells)
    plan->cells = (int)affordable;
  plan->hurried = stages[at].hurried;
  plan->without = stages[at].without & ~own->with & ~own->without;
  own->without |= plan->without;
}

void hl_light_plan_terms(const hl_light_data *data, hl_light_plan *plan, hl_light_settings *own)
{
  const unsigned far = FAR & ~own->with & ~own->without;
  if (hl_light_effective(data) >= thinned_share * hl_light_pixels(data))
    return;
  plan->thinned = true;
  plan->without |= far;
  own->without |= far;
}

bool hl_light_plan_finish(hl_light_plan *plan)
{
  if (plan->finish && plan->budget_ms > 0)
    plan->finish = left_ms(plan) > plan->pass_ms * finish_passes * plan->pixels;
  return plan->finish;
}

void hl_light_plan_notes(const hl_light_plan *plan, int samples, hl_light *out)
{
  char budget[40] = "";
  char why[80] = "";
  snprintf(why, sizeof why, "not tried: %d samples are too few for %d pixels", plan->cells,
           plan->pixels);
  if (plan->budget_ms > 0)
    snprintf(why, sizeof why, "not tried, budget %g ms", plan->budget_ms);
  if (plan->budget_ms > 0)
    snprintf(budget, sizeof budget, ", budget %g ms", plan->budget_ms);
  for (int i = 0; i < out->left_out.n; i++) {
    hl_note *note = &out->left_out.note[i];
    if (strcmp(note->why, "not asked for") == 0 && is_of(plan->without, note->what))
      snprintf(note->why, sizeof note->why, "%s", why);
  }
  if (plan->gathered > 0)
    hl_notes_add(&out->left_out, "pixels",
                 "%d of %d%s: runs of three neighbours at a steady pace, and the brightest",
                 samples, plan->surface, budget);
  else if (!plan->finish && samples < plan->pixels)
    hl_notes_add(&out->left_out, "pixels",
                 "%d of %d%s: means of blocks where shading is straight%s", samples, plan->pixels,
                 budget, plan->thinned ? ", a share of the rest" : "");
  if (plan->gathered > 0)
    hl_notes_add(&out->left_out, "means over pixels", "taken for their middles%s", budget);
}

void hl_light_plan_end(const hl_light_plan *plan, hl_light *out)
{
  const double took = plan->budget_ms > 0 ? now_ms() - plan->started_ms : 0;
  if (took > plan->budget_ms)
    hl_notes_add(&out->left_out, "budget", "not held: %.3g ms of %g ms, with %d samples", took,
                 plan->budget_ms, out->n_pixels);
}
