/* Which kind of reflectance a ball has, from a few frames spread over the session.
 *
 * One frame alone tries every shape and term (light_shape.c, light_terms.c). The ball is the same in all of
 * them: where SAMPLE frames agree on the kind of lobe, the others are fitted with that kind alone, and what
 * none of the sample needed is not tried. A frame whose answer is then not to be trusted is fitted anew with
 * everything, so that a narrowed search costs time at most.
 */
#include <stdlib.h>
#include <string.h>

#include "halflight/notes.h"
#include "light_work.h"
#include "replay_work.h"

enum { SAMPLE = 8, LEAST_SESSION = 16, LEAST_VOTES = 5 };

typedef struct vote {
  bool counts, bent, ambient;
  hl_lobe lobe;
} vote;

static void vote_of(const hl_light *l, const struct hl_light_work *work, vote *out)
{
  out->counts = l->found && l->trusted;
  out->lobe = l->lobe;
  out->bent = work->kept.body > 1;
  out->ambient = work->kept.ambient;
}

static hl_status sample_one(hl_ctx *ctx, const hl_replay_run *run, int i, vote *out)
{
  hl_frame frame;
  hl_light *light = malloc(sizeof *light);
  hl_status st = HL_OK;
  if (!light)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for a light");
  if (hl_replay_read(NULL, run, i, &frame) != HL_OK) {
    free(light);
    return HL_OK;
  }
  for (int b = 0; b < run->n_balls && st == HL_OK; b++) {
    const hl_surface *surface = &run->ball[b].surface;
    hl_light_work *work = NULL;
    st = hl_light_work_new(ctx, surface->n, frame.channels, &work);
    if (st == HL_OK &&
        hl_light_estimate(NULL, work, &frame, surface, &run->settings.light, light) == HL_OK)
      vote_of(light, work, &out[b]);
    hl_light_work_free(work);
  }
  hl_frame_free(&frame);
  free(light);
  return st;
}

static void narrow(const vote *votes, int stride, hl_replay_ball *ball)
{
  hl_light_settings *s = &ball->light;
  int n = 0, bent = 0, ambient = 0, of[3] = {0};
  for (int k = 0; k < SAMPLE; k++) {
    const vote *v = &votes[k * stride];
    n += v->counts;
    bent += v->counts && v->bent;
    ambient += v->counts && v->ambient;
    of[v->lobe] += v->counts;
  }
  if (n < LEAST_VOTES)
    return;
  const unsigned given = s->with | s->without;
  for (int lobe = HL_LOBE_PLAIN; lobe <= HL_LOBE_FORESHORTENED; lobe++)
    if (s->lobe == HL_LOBE_AUTO && 4 * of[lobe] > 3 * n)
      s->lobe = (hl_lobe)lobe;
  if (bent == 0)
    s->without |= 1u << HL_LIGHT_BENDS & ~given;
  if (ambient == 0)
    s->without |= 1u << HL_LIGHT_AMBIENT & ~given;
  ball->narrowed = true;
}

hl_status hl_replay_kind(hl_ctx *ctx, hl_replay_run *run)
{
  const int total = run->session->n;
  vote votes[SAMPLE][HL_BALLS_MAX];
  memset(votes, 0, sizeof votes);
  for (int b = 0; b < run->n_balls; b++)
    run->ball[b].light = run->settings.light;
  if (total < LEAST_SESSION)
    return HL_OK;
#pragma omp parallel for schedule(dynamic) num_threads(run->jobs)
  for (int k = 0; k < SAMPLE; k++) {
    hl_ctx inner = {0};
    const hl_status st = sample_one(&inner, run, k * (total - 1) / (SAMPLE - 1), votes[k]);
    if (st == HL_OK)
      continue;
    pthread_mutex_lock(&run->guard);
    run->fault = inner;
    pthread_mutex_unlock(&run->guard);
  }
  if (run->fault.status != HL_OK)
    return hl_fail(ctx, run->fault.status, "%s", run->fault.msg);
  for (int b = 0; b < run->n_balls; b++)
    narrow(&votes[0][b], HL_BALLS_MAX, &run->ball[b]);
  return HL_OK;
}

void hl_replay_explain(const hl_replay_run *run, hl_light *light)
{
  const hl_light_settings *asked = &run->settings.light;
  for (int i = 0; i < light->left_out.n; i++) {
    hl_note *note = &light->left_out.note[i];
    const bool bends = strcmp(note->what, "masking and bent body") == 0;
    const bool ambient = strcmp(note->what, hl_light_term_name(HL_LIGHT_AMBIENT)) == 0;
    const bool lobe =
        strcmp(note->what, "plain lobe") == 0 || strcmp(note->what, "foreshortened lobe") == 0;
    if (strcmp(note->why, "not asked for") == 0 &&
        ((lobe && asked->lobe == HL_LOBE_AUTO) ||
         (bends && !(asked->without >> HL_LIGHT_BENDS & 1)) ||
         (ambient && !(asked->without >> HL_LIGHT_AMBIENT & 1))))
      strcpy(note->why, "not tried: a sample of the session's frames does without");
  }
}
